"""Chains: a frame seen from a body, as wide as a model's placements are known."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from pmjac_pin.algebra.balls import (
    OUTWARDS,
    PLACEMENT_WIDTH,
    Balls,
    euclidean_norm,
    exactly,
    rotation_width,
    upper,
    widened,
)
from pmjac_pin.algebra.boxes import Boxes
from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.algebra.jets import Columns
from pmjac_pin.kinematics.frame_jets import Riding, Twisted
from pmjac_pin.kinematics.places import Pose, through
from pmjac_pin.kinematics.tree import Poses, Tree
from pmjac_pin.model.frames import Frame
from pmjac_pin.studies.certificates.neighbourhoods import Neighbourhoods
from pmjac_pin.studies.certificates.unknowns import Unknowns
from pmjac_pin.values.arrays import Array

BALLS = Balls()


class WideBoxes(Boxes):
    """Boxes in which a model's directions are as wide as they are in balls."""

    __slots__ = ()

    def directed(self, directions: Array, x: Intervals) -> Intervals:
        """Return directions @ x for axes x, or their rates, of length 1 at most."""
        return self.times(directions, x).widened(rotation_width(directions))


WIDE_BOXES = WideBoxes()


class Width(NamedTuple):
    """How far a placement may be from the stored one: a length, and that of its rotation."""

    distance: float
    tilt: float

    @classmethod
    def of(cls, placement: pin.SE3) -> Width:
        """Return the width of a stored placement."""
        distance = upper(euclidean_norm(exactly(placement.translation)))
        return cls(distance, rotation_width(placement.rotation))


@dataclass(slots=True, eq=False)
class Known:
    """How far a pose may be from that of the stored placements.

    A derivative of the pose by a turn of one of its joints is a product of the same matrices but
    one, whose derivative has norm 1, and so no farther from that of the stored placements.

    Attributes
    ----------
    tilt : float
        Of the rotation, in the spectral norm.
    shift : ndarray, shape (b,)
        Of the position, m.
    """

    tilt: float
    shift: Array

    def slide(self, distance: float | Array) -> None:
        """Go on by an exact translation in the present axes."""
        self.shift = OUTWARDS * (self.shift + self.tilt * distance)

    def move(self, width: Width) -> None:
        """Go on by a placement: tilts of a product of rotations add up."""
        self.slide(width.distance)
        self.shift = OUTWARDS * (self.shift + PLACEMENT_WIDTH * width.distance)
        self.tilt = OUTWARDS * (self.tilt * (1.0 + width.tilt) + width.tilt)


class Chain:
    """The joints from a base to a frame."""

    __slots__ = ("_base", "_end", "_frame", "_links", "_unknowns")

    def __init__(self, tree: Tree, base: int, frame: Frame, unknowns: Unknowns) -> None:
        self._base, self._frame, self._unknowns = base, frame, unknowns
        self._links = [
            (link, Width.of(link.edge.before), Width.of(link.edge.after))
            for link in tree.chain(base, frame.joint)
        ]
        self._end = Width.of(frame.placement)

    def at(self, poses: Poses) -> Twisted:
        """Return the frame at a pose in balls, moved by nothing."""
        pose, _ = self._pose(poses)
        known = self._known(poses, np.zeros(1))
        x, y, z = (widened(column, known.tilt) for column in pose[:3])
        return Twisted(BALLS, Pose(x, y, z, widened(pose.p, float(known.shift[0]))), ())

    def around(self, poses: Neighbourhoods) -> Riding:
        """Return the frame over neighbourhoods of a pose, with its derivatives."""
        pose, columns = self._pose(poses)
        known = self._known(poses.at, poses.slides, poses.turns)
        x, y, z = (column.widened(known.tilt) for column in pose[:3])
        widths = np.stack([known.shift, *self._rate_widths(columns, known)])
        return Riding(WIDE_BOXES, Pose(x, y, z, pose.p.widened(widths)), columns)

    def _pose(self, poses: Poses) -> tuple[Pose, Columns]:
        pose, columns = poses.body(self._base, self._frame.joint)
        way = poses.tree.way(self._base, self._frame)
        return through(poses.algebra, pose, way), columns

    def _known(self, at: Poses, slides: Array, turns: Array | float = 0.0) -> Known:
        """Return how far the frame may be from the stored one, joints up to this far away."""
        known = Known(0.0, np.zeros(slides.shape))
        for link, before, after in self._links:
            known.move(before)
            for slide in at.motion(link).slides:
                known.slide(upper(abs(slide[0, 0])))
            if link.column in self._unknowns.places and link.kind.along:
                known.slide(turns * abs(link.edge.pitch) if link.kind.screw else slides)
            known.move(after)
        known.move(self._end)
        return known

    def _rate_widths(self, columns: Columns, known: Known) -> list[Array]:
        """Return how far derivatives of the position may be off: m for a turn, 1 for a slide."""
        widths: dict[int, Array] = {}
        for link, _, _ in self._links:
            turn = OUTWARDS * (known.shift + known.tilt * abs(link.edge.pitch))
            slide = np.full(turn.shape, known.tilt)
            for k in range(link.kind.nv):
                widths[link.column + k] = slide if k < link.kind.slides else turn
        return [widths[column] for column in columns]
