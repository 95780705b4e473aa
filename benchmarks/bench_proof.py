"""Time to a proof that all assembly modes are found, and to both search and proof, in one run."""

from __future__ import annotations

import sys
import time

import pmjac_pin as pj

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


def main() -> int:
    print(f"{'mechanism':14}{'unknowns':>9}{'modes':>6}{'boxes':>8}{'proof, s':>10}{'all, s':>11}")
    for name, motors in CASES:
        mechanism = pj.load(name)
        proofs = [pj.prove(mechanism, motors, limits=False) for _ in range(3)]
        proof = min(proofs, key=lambda one: one.seconds)
        start = time.perf_counter()
        try:
            found = f"{len(pj.assembly_modes(mechanism, motors, rng=0, limits=False))}"
        except pj.ArgumentError:
            found = "no end"
        search = time.perf_counter() - start
        count = f"{len(proof.enclosures)}" if proof else "?"
        agree = "" if count == found else f"  assembly_modes found {found}"
        print(
            f"{name:14}{len(proof.names):9}{count:>6}{proof.boxes:8}{proof.seconds:10.3f}"
            f"{search:11.3f}{agree}"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
