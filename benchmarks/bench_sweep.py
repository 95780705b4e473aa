"""What a pose costs however many there are: at once in memory, and in a sweep into a store.

    python benchmarks/bench_sweep.py [N]

N is a million unless told; ten million take some minutes. The cost of a pose beside that among
100,000 is what counts: of closing, J_eq and its singular values, in seconds of the processor, on
one thread, once with new arrays for the results, which lie where those before have left memory, and
once with those of a call before (`out=`). Both come in turn, for as many poses together, and the
median of the pairs is told: what else goes on beside a virtual machine changes its pace by half
from one second to the next. Calls before are not counted: where memory is touched for the first
time that the host has yet to give, a page of 4 KB takes 7 µs, as long as some tens of poses. What a
call costs whatever its size shows at a thousand poses of the quickest machine. And that the sweep
stays within its memory.
"""

from __future__ import annotations

import resource
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import pmjac_pin as pj

NAME, SLOWER, MEASURES = "five_bar", "three_rps", ("J_eq", "smallest")
SPREAD = 0.03  # rad, or m
BESIDE, POSES, FEWEST_PAIRS = 10**5, 6 * 10**6, 3
CHUNK = 100_000
CAP = 2e9  # bytes
PAPER = 10**8


def peak() -> float:
    """Bytes that this process, or the largest of those it started, had at most."""
    whose = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    return 1024.0 * max(resource.getrusage(one).ru_maxrss for one in whose)


def seconds(of: Callable[[], object], clock: Callable[[], float] = time.process_time) -> float:
    start = clock()
    of()
    return clock() - start


def swept(count: int, out: Path) -> float:
    """Seconds that a sweep of a grid takes in one process."""
    mechanism = pj.load(NAME)
    near = np.linspace(-SPREAD, SPREAD, round(count**0.5))
    first, second = mechanism.home.actuated
    over = {"theta1": first + near, "theta2": second + near}
    return seconds(
        lambda: pj.sweep(mechanism, over, measures=MEASURES, out=out, chunk=CHUNK, workers=1),
        time.perf_counter,
    )


class Trial:
    """So many poses at once: seconds a pose with results in new arrays, and in those before."""

    def __init__(self, many: pj.Batch, count: int) -> None:
        home = many.mechanism.home.actuated
        values = home + np.random.default_rng(0).uniform(-SPREAD, SPREAD, (count, home.size))
        known = many.ellipsoids_at(values, threads=1)
        self.count = count
        self.ways: list[Callable[[], object]] = [
            lambda: many.ellipsoids_at(values, threads=1),
            lambda: many.ellipsoids_at(values, threads=1, out=known),
        ]
        for way in self.ways:
            way()

    def cost(self, way: int, poses: int) -> float:
        """Return the cost of a pose among calls for so many poses together.

        No call's results are kept while the next one runs: they would lie in memory never touched.
        """
        calls, find = max(1, poses // self.count), self.ways[way]

        def find_all() -> None:
            for _ in range(calls):
                find()

        return seconds(find_all) / (calls * self.count)


def sizes(most: int) -> list[int]:
    return [10**k for k in range(3, 9) if 10**k <= most]


def side_by_side(one: Trial, beside: Trial, way: int) -> tuple[float, float]:
    """Return the cost of a pose, and its ratio to that of another trial: medians of pairs."""
    poses = max(one.count, beside.count)
    pairs = []
    for number in range(max(FEWEST_PAIRS, POSES // poses)):
        if number % 2:
            cost, other = one.cost(way, poses), beside.cost(way, poses)
        else:
            other, cost = beside.cost(way, poses), one.cost(way, poses)
        pairs.append((cost, cost / other))
    costs, ratios = zip(*pairs, strict=True)
    return statistics.median(costs), statistics.median(ratios)


def flatness(many: pj.Batch, name: str, most: int) -> None:
    """Print what a pose costs for each N, and that beside its cost among `BESIDE`, in turn."""
    beside = Trial(many, BESIDE)
    print(f"{name}: closed, with J_eq and radii, in new arrays and in those before")
    for count in sizes(most):
        one = Trial(many, count)
        columns = ""
        for way in (0, 1):
            cost, ratio = side_by_side(one, beside, way)
            columns += f"{1e6 * cost:8.3f} µs × {ratio:.2f}"
        print(f"{count:>9d}{columns}", flush=True)


def main() -> None:
    most = int(float(sys.argv[1])) if len(sys.argv) > 1 else 10**6
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder, "map.zarr")
        taken, count = swept(most, out), round(most**0.5) ** 2
        stored = sum(file.stat().st_size for file in out.rglob("*") if file.is_file())
    cost, share = taken / count, stored / count
    within = "within" if peak() <= CAP else "BEYOND"
    print(
        f"sweep of {count} poses of {NAME}, {', '.join(MEASURES)}: {taken:.0f} s, "
        f"{1e6 * cost:.1f} µs and {share:.0f} bytes a pose, "
        f"{peak() / 1e9:.2f} GB of memory, {within} {CAP / 1e9:.0f} GB"
    )
    print(
        f"on paper {PAPER:.0e}: {PAPER * cost / 60:.0f} min in one process, "
        f"{PAPER * share / 1e9:.1f} GB in the store, the same memory: chunks of {CHUNK} poses are "
        "written and forgotten\n"
    )
    for name in (NAME, SLOWER):
        flatness(pj.batch(pj.load(name)), name, most)
    print(f"{peak() / 1e9:.2f} GB of memory with all results in it")


if __name__ == "__main__":
    main()
