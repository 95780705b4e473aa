"""Other dimensions: `with_parameters` beside loading the file again, alternating, medians of each.

Lengths are drawn within 5 % of the defaults. "closing" is the share of `with_parameters` in which
loops are closed: home, and the poses beside it that tell the ranks. Beside that, ten poses closed
with each design, and the share of closing in both. All are seconds of the processor's, so that
others who work beside it count little.

Then sweeps over all parameters: designs whose poses are found together, what is recorded for them
included, beside as many that are built one by one, for some numbers of poses a design.

python benchmarks/bench_parameters.py
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

import numpy as np
from scipy.optimize import differential_evolution

import pmjac_pin as pj
from pmjac_pin.closing import assembly, blueprint, generic_ranks
from pmjac_pin.studies.sweep import work

NAMES = ("four_bar", "five_bar", "three_rps", "stewart_gough", "delta")
ROUNDS, POSES, SHARE = 15, 10, 0.05
POSES_OF_DESIGNS, SWEEPS, MOVED = (1, 10, 100, 1000), 3, 0.03  # the last in m or rad
CLOSING = (
    (blueprint, "followed"),
    (assembly, "assemble_pose"),
    (generic_ranks, "nearby"),
    (generic_ranks, "reach_of_joints"),
)


class Clock:
    """How long some functions take, seen from within."""

    def __init__(self) -> None:
        self.seconds = 0.0
        for module, name in CLOSING:
            setattr(module, name, self._timed(getattr(module, name)))

    def _timed(self, function: Callable) -> Callable:
        def timed(*given, **named):
            start = time.thread_time()
            try:
                return function(*given, **named)
            finally:
                self.seconds += time.thread_time() - start

        return timed

    def taken(self, call: Callable) -> tuple[float, float, object]:
        """Return how long a call takes, how long of that in these functions, and what it says."""
        self.seconds, start = 0.0, time.thread_time()
        found = call()
        return time.thread_time() - start, self.seconds, found


def designs(mechanism: pj.Mechanism, rng: np.random.Generator) -> dict[str, float]:
    """Return values beside the defaults."""
    return {
        name: one.default * (1.0 + SHARE * rng.uniform(-1.0, 1.0))
        for name, one in mechanism.spec.parameters.items()
    }


def ready(mechanism: pj.Mechanism) -> pj.Mechanism:
    """Return a mechanism whose ranks are known, as its first pose needs them."""
    assert mechanism.problem.partition.size
    return mechanism


def poses(mechanism: pj.Mechanism) -> pj.Configuration:
    """Close loops along a path of the motors."""
    start = guess = mechanism.home
    for step in range(1, POSES + 1):
        guess = mechanism.close(start.actuated + 0.01 * step, guess=guess)
    return guess


def programs(mechanism: pj.Mechanism) -> object:
    """Record what many poses need."""
    return mechanism.recorded.walking, mechanism.recorded.measures


def row(name: str, clock: Clock) -> str:
    """Return a line of the table."""
    mechanism, rng = pj.load(name), np.random.default_rng(0)
    again, sibling, closing, walking, first, beside = [], [], [], [], [], []
    for _ in range(ROUNDS):
        values = designs(mechanism, rng)
        again.append(clock.taken(lambda: ready(pj.load(name, values)))[0])  # noqa: B023
        whole, closed, machine = clock.taken(
            lambda: ready(mechanism.with_parameters(values))  # noqa: B023
        )
        sibling.append(whole)
        closing.append(closed)
        walking.append(clock.taken(lambda: poses(machine))[0])  # noqa: B023
        alone = pj.load(name, values)
        first.append(clock.taken(lambda: programs(alone))[0])  # noqa: B023
        beside.append(clock.taken(lambda: programs(machine))[0])  # noqa: B023
    ratio = statistics.median(a / b for a, b in zip(again, sibling, strict=True))
    inside = sum(closing) / sum(sibling)
    scan = (sum(closing) + sum(walking)) / (sum(sibling) + sum(walking))
    recorded = statistics.median(a / b for a, b in zip(first[2:], beside[2:], strict=True))
    columns = again, sibling, walking, first, beside
    times = [1e3 * statistics.median(one) for one in columns]
    return (
        f"{name:14} {times[0]:8.1f} {times[1]:8.1f} {ratio:8.2f} {inside:8.0%}"
        f" {times[2]:9.1f} {scan:8.0%} {times[3]:8.0f} {times[4]:8.0f} {recorded:8.2f}"
    )


def swept(mechanism: pj.Mechanism, designs: int, poses: int, *, together: bool) -> float:
    """Return seconds for each design of a sweep, whatever was recorded before forgotten."""
    rng, enough = np.random.default_rng(0), work._enough_designs
    table = [one.default for one in mechanism.spec.parameters.values()]
    table = table * (1.0 + SHARE * rng.uniform(-1.0, 1.0, (designs, len(table))))
    motors = mechanism.home.actuated + MOVED * rng.uniform(
        -1.0, 1.0, (designs * poses, len(mechanism.actuated))
    )
    samples = dict(zip(mechanism.parameters, np.repeat(table, poses, axis=0).T, strict=True))
    samples |= dict(zip(mechanism.actuated, motors.T, strict=True))
    work._designs_of.cache_clear()
    work._machine_at.cache_clear()
    work._enough_designs = enough if together else lambda _: np.inf
    try:
        start = time.process_time()
        pj.sweep(mechanism, samples=samples, workers=1)
        return (time.process_time() - start) / designs
    finally:
        work._enough_designs = enough


def sweeps(name: str) -> str:
    """Return a line of the second table."""
    mechanism, told = pj.load(name), f"{name:14}"
    for poses in POSES_OF_DESIGNS:
        one_by_one, together = [], []
        for _ in range(SWEEPS):
            one_by_one.append(swept(mechanism, max(3, 60 // poses), poses, together=False))
            together.append(swept(mechanism, max(100, 2000 // poses), poses, together=True))
        ratio = statistics.median(a / b for a, b in zip(one_by_one, together, strict=True))
        times = [1e3 * statistics.median(one) for one in (one_by_one, together)]
        told += f" {times[0]:8.2f} {times[1]:7.3f} {ratio:6.0f}"
    return told


def optimum() -> tuple[int, float, pj.Mechanism]:
    """Make a four-bar's coupler point go straight; return designs, seconds and the best."""
    mechanism = pj.load("four_bar")
    motors, lengths = np.linspace(0.9, 1.5, POSES), mechanism.parameters

    def bent(given: np.ndarray) -> float:
        machine = mechanism.with_parameters(dict(zip(lengths, given, strict=True)))
        pose, points = machine.home, []
        for angle in motors:
            pose = machine.close([angle], guess=pose)
            points.append(pose.tool_pose().translation[:2])
        length, width = np.linalg.svd(np.array(points) - np.mean(points, axis=0))[1]
        return float(width / length)

    begin = time.perf_counter()
    bounds = [(0.9 * length, 1.1 * length) for length in lengths.values()]
    found = differential_evolution(
        bent, bounds, popsize=10, maxiter=24, seed=0, tol=0.0, polish=False
    )
    best = mechanism.with_parameters(dict(zip(lengths, found.x, strict=True)))
    return found.nfev, time.perf_counter() - begin, best


def main() -> None:
    """Print the tables."""
    clock = Clock()
    heads = ("load", "sibling", "load", "", " 10 poses", "of both", "record", "beside", "record")
    units = ("ms", "ms", "/ sibl.", "closing", "       ms", "closing", "ms", "ms", "/ beside")
    for line in (heads, units):
        print(f"{'':14} " + " ".join(f"{word:>8}" for word in line))
    for name in NAMES:
        print(row(name, clock))
    print("\nSweeps: ms a design one by one, together, and times sooner, by poses a design")
    print(f"{'':14} " + " ".join(f"{poses:>23}" for poses in POSES_OF_DESIGNS))
    for name in NAMES:
        print(sweeps(name))
    count, seconds, best = optimum()
    told = ", ".join(f"{name} = {value:.3f}" for name, value in best.parameters.items())
    print(f"\nscipy, four_bar: {count} designs of {POSES} poses, {seconds:.1f} s: {told}")


if __name__ == "__main__":
    main()
