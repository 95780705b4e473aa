"""Many poses at once, beside a loop over single calls, in the same run: closed, and with J_eq.

The single calls are those by Pinocchio and singular values, as before a program is recorded.

Targets are drawn around home; both sides take the same ones in turn, the loop a part of them.
Ratios are what counts.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

import numpy as np
from recording import unrecorded

import pmjac_pin as pj

NAMES = ("five_bar", "three_rps", "delta_rods", "delta", "stewart_gough")
MANY, SINGLE = 20_000, 100
SPREAD = 0.03  # rad, or of the length
ROUNDS = 3


def targets(mechanism: pj.Mechanism, count: int) -> np.ndarray:
    slides = np.array([mechanism.units[name] == "m" for name in mechanism.actuated])
    size = SPREAD * np.where(slides, mechanism.characteristic_length, 1.0)
    way = np.random.default_rng(0).uniform(-1.0, 1.0, (count, size.size))
    return mechanism.home.actuated + size * way


def one_by_one(mechanism: pj.Mechanism, values: np.ndarray) -> np.ndarray:
    closed = (mechanism.close(one, enforce_limits=False) for one in values)
    return np.array([pose.jacobian().J_eq for pose in closed])


def at_once(many: pj.Batch, values: np.ndarray) -> np.ndarray:
    return many.jacobian(many.close(values, enforce_limits=False).q).J_eq


def seconds(of: Callable[[], object]) -> float:
    start = time.perf_counter()
    of()
    return time.perf_counter() - start


def compare(mechanism: pj.Mechanism) -> tuple[float, float]:
    """Seconds a pose, one by one and at once."""
    many, values = pj.batch(mechanism), targets(mechanism, MANY)
    alone, few = unrecorded(pj.load(mechanism.name)), values[:20]
    np.testing.assert_allclose(at_once(many, few), one_by_one(alone, few), atol=1e-9)
    single, batched = [], []
    for _ in range(ROUNDS):
        single.append(seconds(lambda: one_by_one(alone, values[:SINGLE])) / SINGLE)
        batched.append(seconds(lambda: at_once(many, values)) / MANY)
    return statistics.median(single), statistics.median(batched)


def main() -> None:
    runs_on = pj.batch(pj.load("four_bar")).runs_on
    print(
        f"{runs_on:16s}{'one by one':>12s}{'at once':>12s}{'ratio':>8s}   µs a pose, closed, J_eq"
    )
    for name in NAMES:
        single, batched = compare(pj.load(name))
        print(f"{name:16s}{1e6 * single:12.1f}{1e6 * batched:12.1f}{single / batched:8.1f}")


if __name__ == "__main__":
    main()
