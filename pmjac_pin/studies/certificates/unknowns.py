"""Unknowns: the passive joints as coordinates around a pose, and the norm of a step of them.

One number for each passive degree of freedom: an angle, a slide along a fixed direction, or a
component of a rotation vector x, by which a ball turns to R exp[x]. A free body slides along
the axes that it has at the pose, which stand still, and turns so.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from pmjac_pin.kinematics.tree import Link
from pmjac_pin.values.arrays import Array


class Unknowns:
    """The passive degrees of freedom, in the order of `Mechanism.passive`.

    Attributes
    ----------
    places : mapping of int to int
        Each one's place among them, by its column of v.
    groups : ndarray, shape (g, unknowns)
        1 for those that are measured together, by the Euclidean norm: the slides of a joint, or
        its turns.
    """

    __slots__ = ("_slides", "groups", "places")

    def __init__(self, links: Iterable[Link], passive: Sequence[int]) -> None:
        self.places = {column: place for place, column in enumerate(passive)}
        groups: list[tuple[int, ...]] = []
        self._slides: list[int] = []
        for link in links:
            if link.column not in self.places:
                continue
            start, slides = self.places[link.column], link.kind.slides
            parts = range(start, start + link.kind.nv)
            self._slides += parts[:slides]
            groups += [tuple(part) for part in (parts[:slides], parts[slides:]) if part]
        self.groups = np.zeros((len(groups), len(passive)))
        for marks, group in zip(self.groups, groups, strict=True):
            marks[list(group)] = 1.0

    def scale(self, length: float) -> Array:
        """Return what each unknown moves by in a step of norm 1: 1 rad, or the length in m."""
        scale = np.ones(len(self.places))
        scale[self._slides] = length
        return scale
