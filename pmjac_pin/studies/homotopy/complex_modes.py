"""ComplexModes: all isolated solutions of the loop equations at given motor values."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.configuration import Configuration
from pmjac_pin.studies.evidence import Evidence


@dataclass(frozen=True, eq=False)
class ComplexModes:
    """All isolated complex solutions of the loop equations at given motor values.

    Attributes
    ----------
    real : tuple of Configuration
        The real ones, sorted as `AssemblyModes` are; joints may be beyond their limits.
    solutions : ndarray, shape (count, n)
        All of them, complex ones too: the values of `unknowns`. A quaternion's other sign is the
        same pose.
    unknowns : tuple of str
        Cosines and sines of the passive joints, slides in characteristic lengths, quaternions.
    count : int
        How many.
    certified : int
        How many of them are proven to be near exact solutions, all different, and real or not
        as they are told here.
    at_infinity : int
        Paths that went beyond all bounds, or ended farther than 100 characteristic lengths away.
    singular : int
        Paths that ended at a solution where K* is singular, or were lost: not counted above.
    generic : tuple of int
        For each real one, the solution of the random machine whose path ended there.
    evidence : Evidence
        What it rests on that these are all.
    key : int
        Of the homotopy that they come from.
    """

    real: tuple[Configuration, ...]
    solutions: NDArray[np.complex128]
    unknowns: tuple[str, ...]
    count: int
    certified: int
    at_infinity: int
    singular: int
    generic: tuple[int, ...]
    evidence: Evidence
    key: int

    def __repr__(self) -> str:
        return f"ComplexModes({self.count} solutions, {len(self.real)} real, {self.evidence})"
