"""Grids walked from neighbour to neighbour, beside independent starts from home, in the same run.

Two motors of a mechanism go over a square around home, far into what is out of reach; one thread,
in seconds of the processor, in turn. Ratios are what counts.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

import numpy as np

import pmjac_pin as pj

SPANS = {"five_bar": 1.5, "planar_3rpr": 0.5, "stewart_gough": 0.5}  # rad, or of the length
SIZES = (101, 300)
ROUNDS = 3


def axes(mechanism: pj.Mechanism, span: float, count: int) -> dict[str, np.ndarray]:
    way = np.linspace(-span, span, count)
    return {
        name: value + way * (mechanism.characteristic_length if unit == "m" else 1.0)
        for name, unit, value in zip(
            mechanism.actuated[:2],
            (mechanism.units[name] for name in mechanism.actuated),
            mechanism.home.actuated,
            strict=False,
        )
    }


def seconds(of: Callable[[], object]) -> float:
    start = time.process_time()
    of()
    return time.process_time() - start


def compare(many: pj.Batch, over: dict[str, np.ndarray]) -> tuple[list[float], list[float]]:
    """Microseconds a cell, and which share is closed, walked and apart."""
    found = many.grid(over, enforce_limits=False, threads=1)
    cells = found.actuated.reshape(-1, len(many.mechanism.actuated))

    def apart() -> pj.ManyClosed:
        return many.close(cells, enforce_limits=False, threads=1)

    taken: list[tuple[float, float]] = []
    for _ in range(ROUNDS):
        walked = seconds(lambda: many.grid(over, enforce_limits=False, threads=1))
        taken.append((walked, seconds(apart)))
    closed = [float((one.status == pj.Status.CLOSED).mean()) for one in (found, apart())]
    return [1e6 * statistics.median(one) / len(cells) for one in zip(*taken, strict=True)], closed


def main() -> None:
    columns = f"{'walked':>10s}{'apart':>10s}{'ratio':>8s}{'closed':>10s}{'closed':>10s}"
    print(f"{'grid':24s}{columns}   µs a cell")
    for name, span in SPANS.items():
        mechanism = pj.load(name)
        for count in SIZES:
            (walked, apart), closed = compare(pj.batch(mechanism), axes(mechanism, span, count))
            print(
                f"{f'{name}, {count}²':24s}{walked:10.1f}{apart:10.1f}{apart / walked:8.1f}"
                f"{closed[0]:10.1%}{closed[1]:10.1%}"
            )


if __name__ == "__main__":
    main()
