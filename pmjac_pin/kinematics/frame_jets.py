"""Frames as jets: axes and origins with derivatives, which ride along or follow from twists."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pmjac_pin.algebra import Algebra, Number
from pmjac_pin.algebra.jets import Columns, Jet
from pmjac_pin.kinematics.places import Pose
from pmjac_pin.values.arrays import Array


class Freedom(NamedTuple):
    """How one freedom moves what it carries: it turns about `axis` at `origin`, or slides along it.

    Attributes
    ----------
    column : int
    axis : number, (3, 1, b)
    origin : number, or None
        None where it slides.
    pitch : float
        Of a screw, m/rad.
    """

    column: int
    axis: Number
    origin: Number
    pitch: float


class Riding:
    """A frame whose derivatives ride along: its axes and origin as jets."""

    __slots__ = ("_algebra", "_columns", "_pose")

    def __init__(self, algebra: Algebra, pose: Pose, columns: Columns) -> None:
        self._algebra, self._pose, self._columns = algebra, pose, columns

    def origin(self) -> Jet:
        """Return p."""
        return self._split(self._pose.p)

    def carried(self, directions: Array) -> Jet:
        """Return R d for each row d, components (3, m)."""
        algebra = self._algebra
        whole = algebra.directed(directions, algebra.stack(self._pose[:3]))
        return self._split(algebra.swapped(whole))

    def _split(self, whole: Number) -> Jet:
        if not self._columns:
            return Jet(self._algebra, whole, None, ())
        return Jet(self._algebra, whole[..., :1, :], whole[..., 1:, :], self._columns)


class Twisted:
    """A frame that freedoms move by twists: its axes and origin as jets."""

    __slots__ = ("_algebra", "_pose", "_sliding", "_turning", "_turns")

    def __init__(self, algebra: Algebra, pose: Pose, freedoms: Sequence[Freedom]) -> None:
        self._algebra, self._pose = algebra, pose
        self._turns = [one for one in freedoms if one.origin is not None]
        self._sliding = [one for one in freedoms if one.origin is None]
        self._turning: Number = None
        if self._turns:
            self._turning = algebra.join([one.axis for one in self._turns])

    def origin(self) -> Jet:
        """Return p, moved by v = ω × (p − o)."""
        parts = [one.axis for one in self._sliding]
        if self._turns:
            parts.insert(0, self._velocity())
        columns = tuple(one.column for one in (*self._turns, *self._sliding))
        return Jet(
            self._algebra, self._pose.p, self._algebra.join(parts) if parts else None, columns
        )

    def carried(self, directions: Array) -> Jet:
        """Return R d for each row d, components (3, m), moved by ω × R d."""
        algebra = self._algebra
        axes = algebra.swapped(algebra.directed(directions, algebra.stack(self._pose[:3])))
        if not self._turns:
            return Jet(algebra, axes, None, ())
        rates = algebra.cross(self._turning[:, None], axes)
        return Jet(algebra, axes, rates, tuple(one.column for one in self._turns))

    def _velocity(self) -> Number:
        algebra = self._algebra
        arms = algebra.join([self._pose.p - one.origin for one in self._turns])
        velocity = algebra.cross(self._turning, arms)
        if not any(one.pitch for one in self._turns):
            return velocity
        screws = [algebra.times(one.pitch * np.eye(3), one.axis) for one in self._turns]
        return velocity + algebra.join(screws)
