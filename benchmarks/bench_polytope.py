"""Polytopes of a serial arm beside pycapacity's, where the extra `peers` is installed.

Both find corners and faces of the same, in the same run: what a UR5's tool reaches within the
limits of its motors' rates, and what forces their efforts hold.
"""

from __future__ import annotations

import statistics
import time
import warnings
from collections.abc import Callable
from functools import partial

import numpy as np

import pmjac_pin as pj

POSES, ROUNDS = 20, 7


def theirs() -> tuple[Callable[..., object], Callable[..., object]] | None:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # it imports what NumPy calls deprecated
            from pycapacity import robot  # noqa: PLC0415
    except ImportError:
        return None
    return robot.velocity_polytope, robot.force_polytope


def measured(
    find: Callable[[pj.EquivalentJacobian], object], jacobians: list[pj.EquivalentJacobian]
) -> float:
    start = time.process_time()
    for jacobian in jacobians:
        find(jacobian)
    return 1e6 * (time.process_time() - start) / len(jacobians)


def by_peer(find: Callable[..., object], most: np.ndarray, jacobian: pj.EquivalentJacobian) -> None:
    find(jacobian.Jv_eq, most, -most)


def main() -> None:
    arm, rng = pj.load("ur5"), np.random.default_rng(0)
    poses = [arm.close(rng.uniform(-1.5, 1.5, 6)) for _ in range(POSES)]
    jacobians = [pose.jacobian() for pose in poses]
    partition = arm.problem.partition
    rates, efforts = (
        limits[partition.actuated] for limits in (partition.rate_limits, partition.effort_limits)
    )
    ours = (
        lambda jacobian: jacobian.velocity_polytope("model"),
        lambda jacobian: jacobian.force_polytope("model"),
    )
    peers = theirs()
    print(f"{'µs, ur5':14s}{'ours':>10s}{'pycapacity':>12s}{'ratio':>8s}")
    for k, (name, limits) in enumerate((("velocity", rates), ("force", efforts))):
        ways = [ours[k]] if peers is None else [ours[k], partial(by_peer, peers[k], limits)]
        times: list[list[float]] = [[] for _ in ways]
        for _ in range(ROUNDS):
            for way, found in zip(ways, times, strict=True):
                found.append(measured(way, jacobians))
        here, *other = map(statistics.median, times)
        beside = f"{other[0]:12.0f}{other[0] / here:8.1f}" if other else "not installed".rjust(20)
        print(f"{name:14s}{here:10.0f}{beside}")


if __name__ == "__main__":
    main()
