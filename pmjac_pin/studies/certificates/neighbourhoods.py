"""Neighbourhoods: poses of a tree over all passive joint values up to a distance from a pose.

A joint that turns is at its turn there, times a turn by up to the distance. So boxes hold no sine
or cosine of their own, and are as narrow to first order as rotations about one axis are.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from pmjac_pin.algebra import Number
from pmjac_pin.algebra.balls import OUTWARDS, enclosing
from pmjac_pin.algebra.boxes import Boxes
from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.kinematics.places import Pose
from pmjac_pin.kinematics.tree import Link, Poses
from pmjac_pin.model.joint_kind import JointMotion
from pmjac_pin.values.arrays import Array


class Neighbourhoods(Poses):
    """Where bodies are over nested neighbourhoods of a pose, with derivatives that ride along.

    The derivatives are by slides along the axes that a joint has at the pose, and by turns about
    those that it has moved to.

    Parameters
    ----------
    algebra : Boxes
    at : Poses
        The pose, in balls.
    unknown : collection of int
        Columns of the unknowns.
    turns, slides : ndarray, shape (b,)
        How far unknown joints turn and slide, rad and m.
    """

    __slots__ = ("at", "slides", "turns")

    def __init__(
        self, algebra: Boxes, at: Poses, unknown: Collection[int], turns: Array, slides: Array
    ) -> None:
        super().__init__(at.tree, algebra, self._enclosed, unknown)
        self.at, self.turns, self.slides = at, turns, slides

    def _enclosed(self, link: Link) -> JointMotion:
        slides, turn = self.at.motion(link)
        return JointMotion(tuple(map(enclosing, slides)), tuple(map(enclosing, turn)))

    def _reached(self, pose: Pose, link: Link) -> Pose:
        """Return all poses that a joint's slides and then its turns reach."""
        kind, p = link.kind, pose.p
        for axis in kind.along:
            far = abs(link.edge.pitch) * self.turns if kind.screw else self.slides
            p = _wider(p, pose[axis].magnitude * far)
        x, y, z = _turned_columns(pose, kind.about, self.turns)
        return Pose(x, y, z, p)


def _turned_columns(
    pose: Pose, about: tuple[int, ...], angles: Array
) -> tuple[Number, Number, Number]:
    """Return the columns of R · turn for all turns by up to some angles α about these axes.

    About any axis n, cos α + (1 − cos α) nnᵀ + sin α [n] differs from 1 by at most 1 − cos α ≤ α²/2
    on its diagonal, and elsewhere by sin α |nₖ| + (1 − cos α) |nᵢ nⱼ|, with |nᵢ nⱼ| ≤ ½; about z
    by sin α.
    """
    x, y, z, _ = pose
    if not about:
        return x, y, z
    bent, aside = np.minimum(0.5 * angles**2, 2.0), np.minimum(angles, 1.0)
    a, b, c = x.magnitude, y.magnitude, z.magnitude
    if len(about) == 1:
        return _wider(x, a * bent + b * aside), _wider(y, b * bent + a * aside), z
    aside = aside + 0.5 * bent
    return (
        _wider(x, a * bent + (b + c) * aside),
        _wider(y, b * bent + (c + a) * aside),
        _wider(z, c * bent + (a + b) * aside),
    )


def _wider(x: Intervals, by: Array) -> Intervals:
    """Return intervals that reach further by this much and its rounding."""
    return x.widened(OUTWARDS * by)
