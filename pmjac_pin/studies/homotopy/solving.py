"""Solving: which ends of paths are solutions of the machine at the end, and which are far away."""

from __future__ import annotations

import numpy as np

from pmjac_pin.studies.homotopy.curve import SAME
from pmjac_pin.studies.homotopy.machines import Machine
from pmjac_pin.studies.homotopy.paths import PathEnds
from pmjac_pin.studies.homotopy.polynomial_loops import PolynomialLoops
from pmjac_pin.values.arrays import Complex, Index, Mask

_MET = 1e-7  # rows left out that hold
_TOLERATED = 100.0  # tolerances that they may be off: the kept rows hold exactly, at their cost
_NEAR = 100.0  # characteristic lengths, cosines ...: real poses are nearer


def solutions_of(loops: PolynomialLoops, machine: Machine, ends: PathEnds) -> Index:
    """Return which ends solve all rows of the machine, of twins and of equal ones the first."""
    arrived = np.flatnonzero(ends.arrived)
    kept: list[int] = []
    for index in _solving(loops, machine, ends.points, arrived):
        x = ends.points[index]
        twins, size = loops.twins(x), SAME * (1.0 + np.abs(x).max(initial=0.0))
        others = [ends.points[other] for other in kept]
        if not any(np.abs(twin - other).max() <= size for twin in twins for other in others):
            kept.append(int(index))
    return np.array(kept, dtype=np.intp)


def near(x: Complex) -> Mask:
    """Tell which solutions (m, n) are not far away."""
    return np.asarray(np.abs(x).max(axis=1, initial=0.0) <= _NEAR)


def _solving(loops: PolynomialLoops, machine: Machine, x: Complex, rows: Index) -> Index:
    """Return which of some rows of x solve all rows of η, beside the size of their terms."""
    size = (1.0 + np.abs(x[rows]).max(axis=1, initial=0.0)) ** 2
    enough = max(_MET, _TOLERATED * loops.tolerance)
    return np.asarray(rows[loops.unmet(x[rows], machine.p) <= enough * size])
