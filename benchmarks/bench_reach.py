"""Reach beside close: one inverse kinematics as a multiple of one direct kinematics, in one run.

Between poses a tenth of a radian or of the characteristic length apart, from one to the other: the
motors are told to `close`, the tool's pose to `reach`, which ends at the same motor values.
"""

from __future__ import annotations

import itertools
import statistics
import time
from collections.abc import Callable
from functools import partial

import numpy as np

import pmjac_pin as pj

MACHINES = ("serial_2r", "five_bar", "planar_3rrr", "three_rps", "delta", "head_6rss", "ur5")
POSES, ROUNDS = 20, 7
SPREAD = 0.1


def poses(mechanism: pj.Mechanism) -> list[pj.Configuration]:
    rng, found = np.random.default_rng(0), [mechanism.home]
    slides = [mechanism.units[name] == "m" for name in mechanism.actuated]
    size = SPREAD * np.where(slides, mechanism.characteristic_length, 1.0)
    while len(found) <= POSES:
        step = size * rng.uniform(-1.0, 1.0, size.size)
        try:
            values = mechanism.home.actuated + step
            found.append(mechanism.close(values, guess=found[-1], enforce_limits=False))
        except pj.ClosureError:
            continue
    return found


def seconds(call: Callable[[], object]) -> float:
    began = time.perf_counter()
    call()
    return time.perf_counter() - began


Pairs = list[tuple[pj.Configuration, pj.Configuration]]


def close_all(mechanism: pj.Mechanism, pairs: Pairs) -> None:
    for one, other in pairs:
        mechanism.close(other.actuated, guess=one, enforce_limits=False)


def reach_all(mechanism: pj.Mechanism, pairs: Pairs) -> None:
    for one, other in pairs:
        there = pj.reach(mechanism, other.tool_pose(), guess=one, limits=False)
        if not np.abs(there.actuated - other.actuated).max() < 1e-9:
            raise SystemExit(f"{mechanism.name}: {there}")


def main() -> None:
    print(f"{'machine':<14}{'close':>12}{'reach':>12}{'reach / close':>16}")
    for name in MACHINES:
        mechanism = pj.load(name)
        found = poses(mechanism)
        pairs = list(itertools.pairwise(found))
        closed, reached = partial(close_all, mechanism, pairs), partial(reach_all, mechanism, pairs)
        closed()
        reached()
        times = [(seconds(closed), seconds(reached)) for _ in range(ROUNDS)]
        close = statistics.median(one for one, _ in times) / POSES
        reach = statistics.median(other for _, other in times) / POSES
        ratio = statistics.median(other / one for one, other in times)
        print(f"{name:<14}{1e6 * close:>9.0f} µs{1e6 * reach:>9.0f} µs{ratio:>16.1f}")


if __name__ == "__main__":
    main()
