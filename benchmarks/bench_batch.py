"""Many poses at once, beside a loop over single calls, in the same run.

Both close, give J_eq, and the singular values of its linear and angular rows. In the column of
measures, those of K* and the tool's pose come as well. Targets are drawn around home; both sides
take the same ones in turn, the loop a part of them. Then two threads beside one, over as many poses
and over ten times as many. Ratios are what counts: what one thread takes is counted in seconds of
the processor, so that others' work is not; two threads need two cores that nobody else works on,
and fill results that are there. The single calls are those by Pinocchio and singular values, as
before a program is recorded. Compiled programs are made before, and kept in the user's cache.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

import numpy as np
from humanoid import humanoid
from recording import unrecorded

import pmjac_pin as pj

NAMES = ("five_bar", "three_rps", "delta_rods", "delta", "stewart_gough", "humanoid")
MANY, SINGLE, FOR_THREADS = 40_000, 100, 400_000
SPREAD = 0.03  # rad, or of the length
ROUNDS = 5


def machine(name: str) -> pj.Mechanism:
    return humanoid() if name == "humanoid" else pj.load(name)


def targets(mechanism: pj.Mechanism, count: int) -> np.ndarray:
    slides = np.array([mechanism.units[name] == "m" for name in mechanism.actuated])
    size = SPREAD * np.where(slides, mechanism.characteristic_length, 1.0)
    way = np.random.default_rng(0).uniform(-1.0, 1.0, (count, size.size))
    return mechanism.home.actuated + size * way


def one_by_one(mechanism: pj.Mechanism, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    J_eq, radii = [], []
    for one in values:
        found = mechanism.close(one, enforce_limits=False).jacobian()
        J_eq.append(found.J_eq)
        blocks = (found.Jv_eq, found.Jw_eq)
        radii.append([np.linalg.svd(block, compute_uv=False) for block in blocks])
    return np.array(J_eq), np.array(radii)


def at_once(many: pj.Batch, values: np.ndarray, threads: int = 1) -> pj.ManyEllipsoids:
    return many.ellipsoids_at(values, enforce_limits=False, threads=threads)[1]


def filled_again(many: pj.Batch, values: np.ndarray) -> Callable[[int], object]:
    """Return the same into the results of a call before, by some threads."""
    out = many.ellipsoids_at(values, enforce_limits=False)
    return lambda threads: many.ellipsoids_at(
        values, enforce_limits=False, threads=threads, out=out
    )


def with_measures(many: pj.Batch, values: np.ndarray) -> pj.ManyMeasures:
    return many.measures_at(values, enforce_limits=False, threads=1)[1]


def seconds(of: Callable[[], object], clock: Callable[[], float] = time.process_time) -> float:
    start = clock()
    of()
    return clock() - start


def check(mechanism: pj.Mechanism, many: pj.Batch, values: np.ndarray) -> None:
    (J_eq, radii), found = one_by_one(mechanism, values), at_once(many, values)
    size = np.abs(J_eq).max()
    np.testing.assert_allclose(found.J_eq, J_eq, atol=1e-9 * size)
    told = np.stack([found.velocity_radii, found.angular_radii], axis=1)[..., : radii.shape[-1]]
    np.testing.assert_allclose(told, radii, atol=1e-9 * size)


def compiled(mechanism: pj.Mechanism) -> pj.Batch | None:
    """The same by compiled programs, None where no compiler runs."""
    try:
        return pj.batch(mechanism, compiled=True)
    except pj.MissingDependencyError:
        return None


def gain(many: pj.Batch, count: int) -> float:
    """Two threads' gain over one."""
    again, gains = filled_again(many, targets(many.mechanism, count)), []
    for _ in range(ROUNDS * FOR_THREADS // count):
        one, two = (seconds(lambda n=n: again(n), time.perf_counter) for n in (1, 2))
        gains.append(one / two)
    return statistics.median(gains)


def compare(mechanism: pj.Mechanism) -> tuple[float, float, float, float]:
    """Seconds a pose, one by one, at once, with measures, compiled."""
    many, values = pj.batch(mechanism), targets(mechanism, MANY)
    alone, fast = unrecorded(machine(mechanism.name)), compiled(mechanism)
    check(alone, many, values[:20])
    single, batched, more, sooner = [], [], [], [np.nan]
    for _ in range(ROUNDS):
        single.append(seconds(lambda: one_by_one(alone, values[:SINGLE])) / SINGLE)
        batched.append(seconds(lambda: at_once(many, values)) / MANY)
        more.append(seconds(lambda: with_measures(many, values)) / MANY)
        if fast is not None:
            sooner.append(seconds(lambda: at_once(fast, values)) / MANY)
    one, once, told, fast_one = (
        statistics.median(times) for times in (single, batched, more, sooner[1:] or sooner)
    )
    return one, once, told, fast_one


def main() -> None:
    runs_on = pj.batch(pj.load("four_bar")).runs_on
    columns = "".join(
        f"{title:>12s}"
        for title in ("one by one", "at once", "ratio", "measures", "ratio", "compiled", "ratio")
    )
    print(f"{runs_on:16s}{columns}{'2 threads':>12s}{'of more':>12s}   µs a pose")
    for name in NAMES:
        mechanism = machine(name)
        single, batched, more, sooner = compare(mechanism)
        numbers = [1e6 * single]
        for times in (batched, more, sooner):
            numbers += [1e6 * times, single / times]
        columns = "".join(f"{number:12.2f}" for number in numbers)
        gains = [gain(pj.batch(mechanism), count) for count in (MANY, FOR_THREADS)]
        columns += "".join(f"{f'× {one:.2f}':>12s}" for one in gains)
        print(f"{name:16s}{columns}", flush=True)


if __name__ == "__main__":
    main()
