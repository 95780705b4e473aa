"""Settling: what a search found beside what is known otherwise to be all modes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.configuration import Configuration
from pmjac_pin.modes.assembly_modes import Completeness
from pmjac_pin.modes.closed_pose import closed_pose
from pmjac_pin.modes.proof import Proof
from pmjac_pin.modes.recognition import Recognition
from pmjac_pin.parts import Parts

if TYPE_CHECKING:
    from pmjac_pin.homotopy.parameter_homotopy import ComplexModes
    from pmjac_pin.mechanism import Mechanism

Array = NDArray[np.float64]


class Census(Protocol):
    """All modes at given motor values, known otherwise than by a search.

    Attributes
    ----------
    complete : Completeness or None
        What it rests on that these are all; None where they may not be.
    """

    @property
    def complete(self) -> Completeness | None: ...  # noqa: D102

    def rows(self) -> list[Array]:
        """Return the modes as rows of q."""
        ...

    def matched(self, found: Sequence[Configuration]) -> list[int]:
        """Return for each found mode which row it is, −1 for none."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class ProofCensus:
    """The modes that interval arithmetic has proven."""

    parts: Parts
    proof: Proof

    @property
    def complete(self) -> Completeness | None:
        """A proof, if it is settled."""
        if not self.proof.complete:
            return None
        return Completeness("proof", f"proof: {self.proof.statement}", 0.0, 1.0)

    def rows(self) -> list[Array]:
        """Return the middles of the enclosures."""
        return list(self.proof.q)

    def matched(self, found: Sequence[Configuration]) -> list[int]:
        """Return in whose neighbourhood each found mode is."""
        columns = self.parts.coordinates.columns(self.proof.names)
        if not self.proof.names:
            return list(range(len(found)))
        values = [self.parts.coordinates.values(one.q)[columns] for one in found]
        rows = np.array(values).reshape(len(found), columns.size)
        return [-1 if index is None else index for index in self.proof.match(rows)]


class HomotopyCensus:
    """The real ones of all complex solutions, within the joints' limits or not."""

    def __init__(self, mechanism: Mechanism, modes: ComplexModes, limits: bool) -> None:
        rows = [closed_pose(mechanism, mode.q, limits) for mode in modes.real]
        self._modes = [mode for mode in rows if mode is not None]
        self._complete = modes.complete if modes.complete.kind == "tolerance" else None

    @property
    def complete(self) -> Completeness | None:
        """A tolerance, if no path was lost."""
        return self._complete

    def rows(self) -> list[Array]:
        """Return the real solutions."""
        return [mode.q for mode in self._modes]

    def matched(self, found: Sequence[Configuration]) -> list[int]:
        """Return which real solution has all bodies where each found mode has them."""
        recognition = Recognition(self._modes)
        places = [recognition.index(mode) for mode in found]
        return [-1 if index is None else index for index in places]


def missing(census: Census, found: Sequence[Configuration]) -> list[Array]:
    """Return the modes of a complete census that are not among the found ones."""
    if census.complete is None:
        return []
    met = set(census.matched(found))
    return [row for index, row in enumerate(census.rows()) if index not in met]


def settled(census: Census, found: Sequence[Configuration]) -> Completeness | None:
    """Return what the census rests on, where it says that the found modes are all; else None."""
    if census.complete is None:
        return None
    same = sorted(census.matched(found)) == list(range(len(census.rows())))
    return census.complete if same else None
