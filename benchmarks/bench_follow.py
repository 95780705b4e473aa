"""A certified step of a followed path beside a plain one, in the same run.

The same curved path of the motors about home, followed plainly and with proof, in turns; both
without what happens on the way but for limits and losses, which both look for. The cost of a step
is that of the whole call over its steps. Beside it `close` along the same points.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

import numpy as np

import pmjac_pin as pj

MACHINES = ("four_bar", "five_bar", "three_rps", "delta", "stewart_gough")
SIZE, END, ROUNDS = 0.02, 2.0 * np.pi, 5


def seconds(call: Callable[[], object]) -> float:
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def main() -> None:
    print(f"{'':16} steps  plain [µs/step]  certified  ratio  close [µs/point]")
    for name in MACHINES:
        machine = pj.load(name)
        home = machine.home.actuated
        shifts = np.arange(len(home))

        def path(t: float, home: np.ndarray = home, shifts: np.ndarray = shifts) -> np.ndarray:
            return home + SIZE * (np.sin(3.0 * t + shifts) - np.sin(shifts))

        def followed(certified: bool, machine: pj.Mechanism = machine) -> pj.Trajectory:
            return pj.follow(machine, path, times=(0.0, END), certified=certified)

        plain = followed(False)
        assert plain.reached
        assert followed(True).reached
        count = len(plain.steps) - 1
        points = plain.actuated

        def closed(machine: pj.Mechanism = machine, points: np.ndarray = points) -> None:
            pose = machine.home
            for values in points:
                pose = machine.close(values, pose)

        times = [
            (seconds(lambda: followed(False)), seconds(lambda: followed(True)), seconds(closed))
            for _ in range(ROUNDS)
        ]
        one, proven, direct = (
            statistics.median(column) / count * 1e6 for column in zip(*times, strict=True)
        )
        ratio = statistics.median(b / a for a, b, _ in times)
        print(f"{name:16} {count:5} {one:16.0f} {proven:10.0f} {ratio:6.1f} {direct:17.0f}")


if __name__ == "__main__":
    main()
