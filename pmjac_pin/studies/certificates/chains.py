"""Chains: a frame seen from a body, enclosed at a pose as far as a model's placements are known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from pmjac_pin.algebra.balls import (
    OUTWARDS,
    PLACEMENT_WIDTH,
    BallArray,
    Balls,
    exactly,
    norm,
    rotation_width,
    upper,
    widened,
)
from pmjac_pin.kinematics.places import Pose, through
from pmjac_pin.kinematics.tree import Freedom, Link, Poses, Tree, Twisted
from pmjac_pin.model.frames import Frame
from pmjac_pin.studies.certificates.paths import Path
from pmjac_pin.studies.certificates.unknowns import Unknowns

BALLS = Balls()


class Width(NamedTuple):
    """How far a placement may be from the stored one: a length, and that of its rotation."""

    distance: float
    tilt: float

    @classmethod
    def of(cls, placement: pin.SE3) -> Width:
        """Return the width of a stored placement."""
        distance = upper(norm(exactly(placement.translation)))
        return cls(distance, rotation_width(placement.rotation))


@dataclass(slots=True, eq=False)
class Known:
    """How far a pose may be from that of the stored placements.

    Attributes
    ----------
    tilt, shift : float
        Of the rotation, in the spectral norm, and of the position, m.
    """

    tilt: float = 0.0
    shift: float = 0.0

    def slide(self, distance: float) -> None:
        """Go on by an exact translation in the present axes."""
        self.shift = OUTWARDS * (self.shift + self.tilt * distance)

    def move(self, width: Width) -> None:
        """Go on by a placement: tilts of a product of rotations add up."""
        self.slide(width.distance)
        self.shift = OUTWARDS * (self.shift + PLACEMENT_WIDTH * width.distance)
        self.tilt = OUTWARDS * (self.tilt * (1.0 + width.tilt) + width.tilt)

    def pose(self, stored: Pose) -> Pose:
        """Return a pose wide enough for the true one."""
        x, y, z = (widened(column, self.tilt) for column in stored[:3])
        return Pose(x, y, z, widened(stored.p, self.shift))


@dataclass(slots=True, eq=False)
class Seen:
    """A frame seen from the chain's base, moved by the unknowns, and the way there.

    Attributes
    ----------
    frame : Twisted
    points : list of BallArray, (3, 1, 1)
        The base's origin, that of each unknown turn, the frame's.
    turns : list of int
        The groups that turn.
    slides : list of list of int
        The groups that slide between one point and the next.
    """

    frame: Twisted
    points: list[BallArray]
    turns: list[int] = field(default_factory=list)
    slides: list[list[int]] = field(default_factory=lambda: [[]])

    def path(self) -> Path:
        """Return the path from the base to the frame."""
        return _path(self.points, self.turns, self.slides)

    def path_from(self, other: Seen) -> Path:
        """Return the path from another chain's frame back to the common base and to this one."""
        middle = other.slides[0] + self.slides[0]
        return _path(
            other.points[:0:-1] + self.points[1:],
            other.turns[::-1] + self.turns,
            [*other.slides[:0:-1], middle, *self.slides[1:]],
        )


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

    def seen(self, poses: Poses) -> Seen:
        """Enclose the frame and its motions, seen from the base."""
        known, freedoms = Known(), list[Freedom]()
        points, turns, slides = [BALLS.constant(np.zeros(3))], list[int](), [list[int]()]
        for link, before, after in self._links:
            known.move(before)
            for slide in poses.motion(link).slides:
                known.slide(upper(abs(slide[0, 0])))
            unknown = self._unknowns.of_joint.get(link.edge.child)
            if unknown is not None:
                own = self._own(link, known, poses)
                freedoms += own
                slides[-1] += [] if unknown.slide is None else [unknown.slide]
                if unknown.turn is not None:
                    points.append(own[-1].origin)
                    turns.append(unknown.turn)
                    slides.append([])
            known.move(after)
        known.move(self._end)
        pose, _ = poses.body(self._base, self._frame.joint)
        way = poses.tree.way(self._base, self._frame)
        pose = known.pose(through(BALLS, pose, way))
        return Seen(Twisted(BALLS, pose, freedoms), [*points, pose.p], turns, slides)

    def _own(self, link: Link, known: Known, poses: Poses) -> list[Freedom]:
        """Return a joint's freedoms, wide enough for the true ones."""
        return [
            one._replace(
                axis=widened(one.axis, known.tilt),
                origin=None if one.origin is None else widened(one.origin, known.shift),
            )
            for one in poses.own_freedoms(self._base, link.edge.child)
        ]


def _path(
    points: Sequence[BallArray], turns: Sequence[int], slides: Sequence[Sequence[int]]
) -> Path:
    ways = [upper(norm((end - start).ravel())) for start, end in pairwise(points)]
    return Path(tuple(turns), tuple(ways), tuple(map(tuple, slides)))
