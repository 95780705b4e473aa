"""One J_eq, its ellipsoid and one direct kinematics, beside the same by hand, in the same run.

Once by the recorded program that the kernel runs, and once without it, as before it is recorded
and where no kernel was built. Ratios of medians are what counts: all are timed in turn.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable

import numpy as np
from hand_written import Hand
from recording import recorded, unrecorded

import pmjac_pin as pj
from pmjac_pin.closing.path_kernel import path_kernel

NAMES = ("four_bar", "five_bar", "three_rps", "stewart_gough")
DISTANCE = 0.03  # m or rad, of all motors
BUDGET = 0.8, 1.8, 2.2  # largest ratios: with the kernel; of jacobian() and of close() without
ROUNDS, SECONDS = 60, 0.002  # how often each is timed, and for how long


def microseconds(*functions: Callable[[], object]) -> list[float]:
    """Return the median time of each, taken in turn so that a slow machine is slow for all."""
    numbers = [max(1, round(SECONDS / seconds(function, 3))) for function in functions]
    rounds = [
        [seconds(function, n) for function, n in zip(functions, numbers, strict=True)]
        for _ in range(ROUNDS)
    ]
    return [1e6 * statistics.median(times) for times in zip(*rounds, strict=True)]


def seconds(function: Callable[[], object], number: int) -> float:
    start = time.thread_time()  # whoever else works beside it counts little
    for _ in range(number):
        function()
    return (time.thread_time() - start) / number


def compare(name: str) -> list[tuple[str, list[float]]]:
    fast, slow = recorded(pj.load(name)), unrecorded(pj.load(name))
    hand, q = Hand(fast), fast.home.q
    starts = [mechanism.configuration(q) for mechanism in (fast, slow)]
    target = starts[0].actuated + DISTANCE
    by_hand, closed = hand.jacobian(q)[0], hand.close(q, target)
    for mechanism, start in zip((fast, slow), starts, strict=True):
        np.testing.assert_allclose(mechanism.configuration(q).jacobian().J_eq, by_hand, atol=1e-11)
        np.testing.assert_allclose(mechanism.close(target, start).q, closed, atol=1e-10)
    jacobians = microseconds(
        lambda: hand.jacobian(q),
        lambda: fast.configuration(q).jacobian(),
        lambda: slow.configuration(q).jacobian(),
    )
    ellipsoids = microseconds(
        lambda: np.linalg.svd(hand.jacobian(q)[0][:3]),
        lambda: fast.configuration(q).jacobian().velocity_ellipsoid(),
        lambda: slow.configuration(q).jacobian().velocity_ellipsoid(),
    )
    closes = microseconds(
        lambda: hand.close(q, target),
        lambda: fast.close(target, starts[0]),
        lambda: slow.close(target, starts[1]),
    )
    return [
        ("configuration(q).jacobian()", jacobians),
        ("….velocity_ellipsoid()", ellipsoids),
        (f"close(), {DISTANCE} away", closes),
    ]


def main() -> int:
    if path_kernel() is None:
        print("No kernel was built: both columns are without it.")
    print(f"{'µs, and times by hand':44}{'by hand':>9}{'kernel':>9}{'':8}{'without':>9}")
    for name in NAMES:
        for what, (hand, kernel, without) in compare(name):
            print(
                f"{name + ': ' + what:44}{hand:9.1f}{kernel:9.1f}{kernel / hand:8.2f}"
                f"{without:9.1f}{without / hand:8.2f}"
            )
    print("The budget is {} with the kernel; {} and {} without.".format(*BUDGET))
    return 0


if __name__ == "__main__":
    sys.exit(main())
