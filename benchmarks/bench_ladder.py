"""Loops that follow one another: ladders of four-bars, from a fresh process on.

python benchmarks/bench_ladder.py

What a process takes to load a ladder, to find its first pose, and to close it 0.03 rad away for the
first time; then what closing takes again, beside hand-written Newton without any guard, in turn:
without a recorded program, and with it. Medians over processes and within each, in seconds of the
processor with one thread of BLAS, as the library asks for; Newton by hand only loses by more.
"""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from typing import TypeVar

import numpy as np
from hand_written import Hand
from ladder import ladder
from recording import recorded, unrecorded

COUNTS, PROCESSES, ROUNDS = (8, 16, 32, 64), 5, 30
DISTANCE = 0.03  # rad, of the motor
ALONE = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
#: Of what is printed, each with how many of its unit a second has.
COLUMNS = {
    "load, s": 1.0,
    "home, s": 1.0,
    "close, s": 1.0,
    "again, ms": 1e3,
    "by hand, ms": 1e3,
    "x hand": 1.0,
    "record, s": 1.0,
    "program, ms": 1e3,
    "x hand ": 1.0,
    "corrections": 1.0,
}
Found = TypeVar("Found")


def timed(of: Callable[[], Found]) -> tuple[Found, float]:
    start = time.process_time()
    found = of()
    return found, time.process_time() - start


def beside(close: Callable[[], object], by_hand: Callable[[], object]) -> tuple[float, float]:
    """Return the median seconds of both, taken in turn."""
    taken = [(timed(close)[1], timed(by_hand)[1]) for _ in range(ROUNDS)]
    return statistics.median(one for one, _ in taken), statistics.median(one for _, one in taken)


def measured(count: int) -> list[float]:
    """Return what COLUMNS say, in a process where nothing was done before."""
    mechanism, load = timed(lambda: ladder(count))
    home, first = timed(lambda: mechanism.home)
    unrecorded(mechanism)
    target = home.actuated + DISTANCE
    closed, close = timed(lambda: mechanism.close(target))
    hand = Hand(mechanism)
    hand.rows = np.flatnonzero(np.arange(3 * count) % 3 != 2)  # those in the plane
    by_hand = hand.close(home.q, target)
    np.testing.assert_allclose(closed.q, by_hand, atol=1e-10)
    again, beside_it = beside(lambda: mechanism.close(target), lambda: hand.close(home.q, target))
    known = recorded(mechanism)
    same, record = timed(lambda: known.close(target))
    np.testing.assert_allclose(same.q, by_hand, atol=1e-10)
    kernel, there = beside(lambda: known.close(target), lambda: hand.close(home.q, target))
    walked = [load, first, close, again, beside_it, again / beside_it]
    return [*walked, record, kernel, kernel / there, closed.iterations]


def main() -> None:
    """Print the table."""
    print(f"{'four-bars':9}" + "".join(f"{column:>13}" for column in COLUMNS))
    for count in COUNTS:
        command = [sys.executable, __file__, str(count)]
        told = [
            json.loads(subprocess.run(command, check=True, capture_output=True, env=ALONE).stdout)
            for _ in range(PROCESSES)
        ]
        medians = map(statistics.median, zip(*told, strict=True))
        numbers = [unit * one for unit, one in zip(COLUMNS.values(), medians, strict=True)]
        print(f"{count:9d}" + "".join(f"{number:13.3g}" for number in numbers))


if __name__ == "__main__":
    if len(sys.argv) > 1:
        print(json.dumps(measured(int(sys.argv[1]))))
    else:
        main()
