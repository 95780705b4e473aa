"""Configurations through pickles, beside closing one: the first of a machine, and those after it.

python benchmarks/bench_pickle.py

Of each machine: what unpickling the first configuration takes, what another takes in a pickle of
its own, as process pools send them, and what one takes in a pickle of many; each in ms and in
`close`, by Pinocchio and by the recorded program. Then the same for pickling.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"

import pickle
import time
from collections.abc import Callable
from statistics import median

import numpy as np
from recording import recorded, unrecorded

import pmjac_pin as pj
from pmjac_pin.closing import blueprint
from pmjac_pin.mechanism_value import _MECHANISMS

NAMES = (
    "four_bar",
    "five_bar",
    "three_rps",
    "planar_3rrr",
    "humanoid_ankle",
    "stewart_gough",
    "delta_rods",
    "delta",
)
MANY, ROUNDS = 100, 40
STEP = 0.03  # m or rad, of each motor


def forget() -> None:
    """Let the next configuration be the first of its machine."""
    _MECHANISMS.clear()
    blueprint._BLUEPRINTS.clear()


def milliseconds(calls: dict[str, Callable[[], object]]) -> dict[str, float]:
    """Return the median of what each call takes, in turns."""
    taken: dict[str, list[float]] = {name: [] for name in calls}
    for _ in range(ROUNDS):
        for name, call in calls.items():
            call()
            start = time.process_time()
            call()
            taken[name].append(1e3 * (time.process_time() - start))
    return {name: median(times) for name, times in taken.items()}


def measured(name: str) -> tuple[dict[str, float], int]:
    """Return what calls take for one machine, and the bytes of a pickle."""
    plain, known = unrecorded(pj.load(name)), recorded(pj.load(name))
    target = plain.home.actuated + STEP
    pose = plain.close(target, enforce_limits=False)
    sent = pickle.dumps(pose)
    many = pickle.dumps([plain.configuration(pose.q) for _ in range(MANY)])
    unrecorded(pickle.loads(sent).mechanism)
    kept = _MECHANISMS._kept

    def first() -> object:
        forget()
        return pickle.loads(sent)

    def again() -> object:
        _MECHANISMS._kept = kept
        return pickle.loads(sent)

    def together() -> object:
        _MECHANISMS._kept = kept
        return pickle.loads(many)

    def pickled_first() -> object:
        plain.__dict__.pop("_sealed", None)
        return pickle.dumps(pose)

    taken = milliseconds(
        {
            "close": lambda: plain.close(target, enforce_limits=False),
            "recorded": lambda: known.close(target, enforce_limits=False),
            "first": first,
            "again": again,
            "of many": together,
            "pickled": pickled_first,
            "pickled again": lambda: pickle.dumps(pose),
        }
    )
    taken["of many"] /= MANY
    return taken, len(sent)


def main() -> None:
    """Print the table."""
    steps = ("first", "again", "of many", "pickled", "pickled again")
    print("ms, and in brackets how many `close`: by Pinocchio, by the recorded program")
    print(f"{'':16}{'kB':>5}{'close':>7}{'rec.':>7}" + "".join(f"{step:>22}" for step in steps))
    ratios: dict[str, list[float]] = {step: [] for step in steps}
    for name in NAMES:
        taken, size = measured(name)
        line = f"{name:16}{size / 1e3:5.0f}{taken['close']:7.3f}{taken['recorded']:7.3f}"
        for step in steps:
            plain, known = (taken[step] / taken[close] for close in ("close", "recorded"))
            line += f"{f'{taken[step]:.3f} ({plain:.2f}, {known:.1f})':>22}"
            ratios[step].append(plain)
        print(line)
    print("\nmedian, in `close` by Pinocchio:", end=" ")
    print(", ".join(f"{step} {np.median(values):.2f}" for step, values in ratios.items()))


if __name__ == "__main__":
    main()
