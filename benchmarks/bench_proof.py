"""Time to a proof that all assembly modes are found, beside the same without its kernel.

The two alternate in one run: the median of each counts, by the processor's clock. `first` is the
first proof of a mechanism, which records its equations; `all` is search and proof.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from statistics import median
from unittest.mock import patch

import pmjac_pin as pj
from pmjac_pin.studies.modes import box_problem

CASES = (
    ("four_bar", (0.9,)),
    ("five_bar", (2.1874829, 0.95410976)),
    ("watt_six_bar", (0.9,)),
    ("planar_3rpr", (0.34, 0.34, 0.34)),
    ("planar_3rrr", (1.0, 1.0, 1.0)),
    ("three_rps", (2 / 3, 3 / 5, 3 / 4)),
    ("three_rps", (0.5, 1.0, 2.0)),
    ("three_rps", (3.0, 3.0, 3.0)),
    ("three_rps", (5.0, 1.0, 1.0)),
    ("bricard", (0.0,)),
    ("agile_eye", (0.0, 0.0, 0.0)),
    ("ankle", (0.0, 0.0)),
)
TIMES = 7
HEAD = ("unknowns", "modes", "boxes", "without, ms", "first, ms", "proof, ms", "faster", "all, ms")


def timed(mechanism: pj.Mechanism, motors: Sequence[float]) -> tuple[float, pj.Proof]:
    """Return how long a proof takes, ms, and the proof."""
    start = time.process_time()
    proof = pj.prove(mechanism, motors, limits=False)
    return 1e3 * (time.process_time() - start), proof


def main() -> int:
    print(f"{'mechanism':14}" + "".join(f"{name:>12}" for name in HEAD))
    timed(pj.load("slider_crank"), [0.9])  # what is imported when it is asked for
    for name, motors in CASES:
        mechanism = pj.load(name)
        first, proof = timed(mechanism, motors)
        ours, theirs = [], []
        for _ in range(TIMES):
            with patch.object(box_problem, "RecordedLoops", lambda _program, loops: loops):
                took, without = timed(mechanism, motors)
            theirs.append(took)
            ours.append(timed(mechanism, motors)[0])
            assert len(without.enclosures) == len(proof.enclosures)
        start = time.process_time()
        try:
            found = f"{len(pj.assembly_modes(mechanism, motors, rng=0, limits=False))}"
        except pj.ArgumentError:
            found = "no end"
        whole = 1e3 * (time.process_time() - start)
        count = f"{len(proof.enclosures)}" if proof else "?"
        without_kernel, by_kernel = median(theirs), median(ours)
        ratio = without_kernel / by_kernel
        numbers = (without_kernel, first, by_kernel, ratio, whole)
        agree = "" if count == found else f"  assembly_modes found {found}"
        print(
            f"{name:14}{len(proof.names):12}{count:>12}{proof.boxes:12}"
            + "".join(f"{number:12.1f}" for number in numbers)
            + agree
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
