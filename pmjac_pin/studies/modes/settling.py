"""Settling: what a search found beside what is known otherwise to be all modes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.homotopy.complex_modes import ComplexModes
from pmjac_pin.studies.modes.closed_pose import closed_pose, open_by
from pmjac_pin.studies.modes.proof import Proof
from pmjac_pin.studies.modes.recognition import Recognition
from pmjac_pin.values.arrays import Array


@dataclass(frozen=True, slots=True, eq=False)
class ProofCensus:
    """The modes that interval arithmetic has proven.

    It counts values of joints: two of its rows may be one mode, a leg's universal joint being
    turned over, or the two being nearer than modes are told apart.
    """

    mechanism: Mechanism
    proof: Proof

    @property
    def whole(self) -> bool:
        """Whether it is settled."""
        return bool(self.proof)

    def evidence(self, count: int) -> Evidence:
        """Return a proof; it says where joint values are more than modes."""
        evidence = self.proof.evidence
        if count == len(self.proof.q):
            return evidence
        same = f"{count} modes, all bodies of some being where those of others are, to 1e-5"
        return replace(evidence, statement=f"{evidence.statement}: {same}")

    def rows(self) -> list[Array]:
        """Return the middles of the enclosures."""
        return list(self.proof.q)

    def found_as(self, found: Sequence[Configuration]) -> list[int | None]:
        """Return which found mode is in each one's neighbourhood, or has its bodies there."""
        places: list[int | None] = [None] * len(self.proof.q)
        for index, row in enumerate(self._enclosures(found)):
            if row is not None:
                places[row] = index
        recognition = Recognition(found)
        for row, q in enumerate(self.proof.q):
            if places[row] is None and (pose := closed_pose(self.mechanism, q, limits=False)):
                places[row] = recognition.index(pose)
        return places

    def _enclosures(self, found: Sequence[Configuration]) -> Sequence[int | None]:
        """Return in whose neighbourhood each found mode is."""
        if not self.proof.names:
            return range(len(found))
        coordinates = self.mechanism.coordinates
        columns = coordinates.columns(self.proof.names)
        rows = np.array([coordinates.values(one.q)[columns] for one in found])
        return self.proof.match(rows.reshape(len(found), columns.size))


class HomotopyCensus:
    """The real ones of all complex solutions, within the joints' limits or not.

    Those that rounding keeps open are among its rows, and are no mode that can be found.
    """

    def __init__(self, mechanism: Mechanism, modes: ComplexModes, limits: bool) -> None:
        poses = [(mode.q, closed_pose(mechanism, mode.q, limits)) for mode in modes.real]
        self._modes = [mode for _, mode in poses if mode is not None]
        self._open = [q for q, mode in poses if mode is None and open_by(mechanism, q)]
        self._evidence = modes.evidence

    @property
    def whole(self) -> bool:
        """Whether no path was lost."""
        return self._evidence.kind == "tolerance"

    def evidence(self, count: int) -> Evidence:
        """Return a tolerance."""
        return self._evidence

    def rows(self) -> list[Array]:
        """Return the real solutions."""
        return [*(mode.q for mode in self._modes), *self._open]

    def found_as(self, found: Sequence[Configuration]) -> list[int | None]:
        """Return which found mode has all bodies where each real solution has them."""
        recognition = Recognition(found)
        return [*map(recognition.index, self._modes), *([None] * len(self._open))]


#: All modes at given motor values, known otherwise than by a search; of use where they are `whole`.
Census: TypeAlias = ProofCensus | HomotopyCensus


def missing(census: Census, found: Sequence[Configuration]) -> list[Array]:
    """Return the modes of a census that are not among the found ones."""
    places = census.found_as(found)
    return [row for row, place in zip(census.rows(), places, strict=True) if place is None]


def settled(census: Census, found: Sequence[Configuration], but: int = 0) -> Evidence | None:
    """Return what the census rests on, where it says that the found modes are all; else None.

    All but so many that it has and that are not among them.
    """
    places = census.found_as(found)
    if places.count(None) != but or {*places} - {None} != {*range(len(found))}:
        return None
    return census.evidence(len(found) + but)
