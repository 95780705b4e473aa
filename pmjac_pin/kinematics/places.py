"""Poses [R p] over any number type, and placements that multiply them from the right."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from pmjac_pin.algebra import Algebra, Number
from pmjac_pin.algebra.arrays import Numbers


class Pose(NamedTuple):
    """The columns of [R p]."""

    x: Number
    y: Number
    z: Number
    p: Number


@dataclass(frozen=True, slots=True, eq=False)
class Place:
    """A placement: constants, of one pose or of all.

    Attributes
    ----------
    axes : tuple of (int, bool), or None
        For each column of the rotation which axis it is, and whether turned round; None where it
        is no permutation. Nothing is multiplied, and so nothing rounded, where it is one.
    rows : ndarray
        What the columns x, y, z are multiplied with: Rᵀ and tᵀ, or what of tᵀ is not zero.
    used : tuple of int
        The axes along which the translation is, where only that is multiplied.
    """

    axes: tuple[tuple[int, bool], ...] | None
    rows: Numbers
    used: tuple[int, ...]

    @classmethod
    def of(cls, placement: pin.SE3) -> Place:
        """Return a placement of Pinocchio's, or a `Placement` of recorded numbers."""
        rotation, translation = placement.rotation, placement.translation
        axes, used = _permutation(rotation), np.flatnonzero(translation)
        if axes is not None:
            rows = translation[None, used]
        else:
            rows = np.vstack([rotation.T, translation]) if used.size else rotation.T.copy()
        return cls(axes, rows, tuple(used.tolist()))

    @property
    def pure(self) -> bool:
        """It permutes axes and no more."""
        return self.axes is not None and not self.used

    def __call__(self, algebra: Algebra, pose: Pose) -> Pose:
        """Return pose · place."""
        p = pose.p
        if self.axes is None:
            turned = algebra.times(self.rows, algebra.stack(pose[:3]))
            return Pose(turned[0], turned[1], turned[2], p + turned[3] if self.used else p)
        if self.used:
            columns = algebra.stack([pose[k] for k in self.used])
            p = p + algebra.times(self.rows, columns)[0]
        x, y, z = (-pose[k] if over else pose[k] for k, over in self.axes)
        return Pose(x, y, z, p)


def standing(algebra: Algebra) -> Pose:
    """Return the pose [I 0]."""
    x, y, z, p = (algebra.constant(column) for column in np.eye(4)[:, :3])
    return Pose(x, y, z, p)


def steps(*placements: pin.SE3) -> tuple[Place, ...]:
    """Return the placements whose product is theirs, taken together where that rounds nothing."""
    found: list[pin.SE3] = []
    for placement in placements:
        if found and (Place.of(found[-1]).pure or Place.of(placement).pure):
            found[-1] = found[-1] * placement
        else:
            found.append(placement)
    places = map(Place.of, found)
    return tuple(place for place in places if not (place.pure and place.axes == _UNTURNED))


def through(algebra: Algebra, pose: Pose, places: Sequence[Place]) -> Pose:
    """Return pose · place · place ⋯."""
    for place in places:
        pose = place(algebra, pose)
    return pose


_UNTURNED = ((0, False), (1, False), (2, False))


def _permutation(given: Numbers) -> tuple[tuple[int, bool], ...] | None:
    try:
        rotation = np.asarray(given, dtype=float)
    except TypeError:  # a recorded number is none of 0, 1 and -1
        return None
    sizes = np.abs(rotation)
    if not ((sizes == 0.0) | (sizes == 1.0)).all() or not (sizes.sum(axis=0) == 1.0).all():
        return None
    which = sizes.argmax(axis=0).tolist()
    return tuple((k, bool(rotation[k, column] < 0.0)) for column, k in enumerate(which))
