"""Settling: what a search found beside what a proof says there is."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.modes.assembly_modes import Completeness
from pmjac_pin.modes.proof import Proof
from pmjac_pin.parts import Parts


def missing(parts: Parts, proof: Proof, found: Sequence[Configuration]) -> list[int]:
    """Return the proven modes that are not among the found ones, by their index."""
    met = set(_matched(parts, proof, found))
    return [index for index in range(len(proof.enclosures)) if index not in met]


def settled(
    parts: Parts, proof: Proof, found: Sequence[Configuration], otherwise: Completeness
) -> Completeness:
    """Return the proof as completeness, where it says that the found modes are all."""
    matched = _matched(parts, proof, found)
    if proof.complete and sorted(matched) == list(range(len(proof.enclosures))):
        return Completeness("proof", f"proof: {proof.statement}", 0.0, 1.0)
    return otherwise


def _matched(parts: Parts, proof: Proof, found: Sequence[Configuration]) -> list[int]:
    """Return for each found mode the index of its enclosure, −1 for none."""
    columns = parts.coordinates.columns(proof.names)
    if not proof.names:
        return list(range(len(found)))
    values = np.array([parts.coordinates.values(one.q)[columns] for one in found])
    return [
        -1 if index is None else index
        for index in proof.match(values.reshape(len(found), columns.size))
    ]
