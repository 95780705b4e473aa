"""Chains: the joints from one body to a frame, enclosed at a pose, with all their motions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
import pinocchio as pin
from flint import arb
from numpy.typing import NDArray

from pmjac_pin.model.frames import Frame
from pmjac_pin.model.linkage import Edge
from pmjac_pin.studies.certificates.intervals import (
    OUTWARDS,
    PLACEMENT_WIDTH,
    ZERO,
    Intervals,
    about_z,
    cross,
    exactly,
    norm,
    of_quaternion,
    rotation_width,
    upper,
    widened,
)
from pmjac_pin.studies.certificates.paths import Path
from pmjac_pin.studies.certificates.unknowns import Unknowns

Array = NDArray[np.float64]


def _nothing() -> Intervals:
    return np.array([ZERO] * 3, dtype=object)


@dataclass(frozen=True, slots=True, eq=False)
class Place:
    """A placement as it is stored, and how far from that it may be.

    Attributes
    ----------
    rotation, translation : Intervals, shapes (3, 3) and (3,)
    distance : float
        At least the translation's length, m.
    tilt, shift : float
        Widths of the rotation, in the spectral norm, and of the translation, m.
    """

    rotation: Intervals
    translation: Intervals
    distance: float
    tilt: float
    shift: float

    @classmethod
    def of(cls, placement: pin.SE3) -> Place:
        """Return a stored placement with its widths."""
        translation = exactly(placement.translation)
        distance = upper(norm(translation))
        return cls(
            exactly(placement.rotation),
            translation,
            distance,
            rotation_width(placement.rotation),
            PLACEMENT_WIDTH * distance,
        )


@dataclass(frozen=True, slots=True, eq=False)
class Link:
    """A joint of a chain: its entries of q, its places on both bodies, its unknowns."""

    joint: int
    kind: str
    entries: slice
    before: Place
    after: Place


@dataclass(slots=True, eq=False)
class Pose:
    """A frame seen from the chain's base, and what each unknown moves.

    Attributes
    ----------
    rotation, position : Intervals, shapes (3, 3) and (3,)
        By the stored placements.
    tilt, shift : float
        How far the true ones may be from that: in the spectral norm, and in m.
    angular, linear : dict of int to Intervals (3,)
        Of each unknown: the angular velocity, and the velocity of the frame's origin.
    points : list of Intervals (3,)
        The base's origin, that of each unknown turn, the frame's.
    turns : list of int
        The groups that turn.
    slides : list of list of int
        The groups that slide between one point and the next.
    """

    rotation: Intervals = field(default_factory=lambda: exactly(np.eye(3)))
    position: Intervals = field(default_factory=_nothing)
    tilt: float = 0.0
    shift: float = 0.0
    angular: dict[int, Intervals] = field(default_factory=dict)
    linear: dict[int, Intervals] = field(default_factory=dict)
    points: list[Intervals] = field(default_factory=lambda: [_nothing()])
    turns: list[int] = field(default_factory=list)
    slides: list[list[int]] = field(default_factory=lambda: [[]])

    def axes(self) -> Intervals:
        """Return the axes, one a column, wide enough for the true ones."""
        return widened(self.rotation, self.tilt)

    def origin(self) -> Intervals:
        """Return the origin, wide enough for the true one."""
        return widened(self.position, self.shift)

    def slide(self, by: Intervals, distance: float, width: float) -> None:
        """Go on by a translation in the present axes."""
        self.position = self.position + self.rotation @ by
        self.shift = OUTWARDS * (self.shift + self.tilt * distance + width)

    def move(self, place: Place) -> None:
        """Go on by a placement: tilts of a product of rotations add up."""
        self.slide(place.translation, place.distance, place.shift)
        self.rotation = self.rotation @ place.rotation
        self.tilt = OUTWARDS * (self.tilt * (1.0 + place.tilt) + place.tilt)

    def path(self) -> Path:
        """Return the path from the base to the frame."""
        return _path(self.points, self.turns, self.slides)

    def path_from(self, other: Pose) -> Path:
        """Return the path from another chain's frame back to the common base and to this one."""
        middle = other.slides[0] + self.slides[0]
        return _path(
            other.points[:0:-1] + self.points[1:],
            other.turns[::-1] + self.turns,
            [*other.slides[:0:-1], middle, *self.slides[1:]],
        )


class Chain:
    """The joints from a base to a frame, each a placement, a motion and a placement."""

    __slots__ = ("_end", "_links", "_unknowns")

    def __init__(self, links: Sequence[Link], end: Place, unknowns: Unknowns) -> None:
        self._links = tuple(links)
        self._end = end
        self._unknowns = unknowns

    def pose(self, q: Array) -> Pose:
        """Enclose the frame's pose and motions at q, seen from the base."""
        pose = Pose()
        origins: dict[int, Intervals] = {}
        for link in self._links:
            self._pass(link, q[link.entries], pose, origins)
        pose.move(self._end)
        pose.points.append(pose.origin())
        for column, axis in pose.angular.items():
            pose.linear[column] = cross(axis, pose.points[-1] - origins[column])
        return pose

    def _pass(self, link: Link, entries: Array, pose: Pose, origins: dict[int, Intervals]) -> None:
        """Go on to the body behind a joint."""
        pose.move(link.before)
        turn, shift = _motion(link.kind, entries)
        unknowns = self._unknowns.of_joint.get(link.joint)
        if shift is not None:
            pose.slide(shift, upper(norm(shift)), 0.0)
            if unknowns is not None and unknowns.slide is not None:
                columns = self._unknowns.groups[unknowns.slide].columns
                axes = pose.axes()[:, 2:] if link.kind == "prismatic" else pose.axes()
                pose.linear |= {column: axes[:, k] for k, column in enumerate(columns)}
                pose.slides[-1].append(unknowns.slide)
        if turn is not None:
            pose.rotation = pose.rotation @ turn
            if unknowns is not None and unknowns.turn is not None:
                columns = self._unknowns.groups[unknowns.turn].columns
                axes = pose.axes() if len(columns) == 3 else pose.axes()[:, 2:]
                pose.angular |= {column: axes[:, k] for k, column in enumerate(columns)}
                pose.points.append(pose.origin())
                origins |= dict.fromkeys(columns, pose.points[-1])
                pose.turns.append(unknowns.turn)
                pose.slides.append([])
        pose.move(link.after)


def chains_of(
    model: pin.Model,
    edges: Mapping[int, Edge],
    unknowns: Unknowns,
    first: Frame,
    second: Frame,
) -> tuple[Chain, Chain]:
    """Return the chains to two frames from the last body that carries both."""
    one, other = (list(model.supports[frame.joint]) for frame in (first, second))
    shared = sum(a == b for a, b in zip(one, other, strict=False))

    def chain(joints: list[int], frame: Frame) -> Chain:
        links = [_link(model, edges[joint], joint) for joint in joints[shared:]]
        return Chain(links, Place.of(frame.placement), unknowns)

    return chain(one, first), chain(other, second)


def _link(model: pin.Model, edge: Edge, joint: int) -> Link:
    kind = model.joints[joint]
    entries = slice(kind.idx_q, kind.idx_q + kind.nq)
    return Link(joint, edge.kind, entries, Place.of(edge.before), Place.of(edge.after))


def _motion(kind: str, entries: Array) -> tuple[Intervals | None, Intervals | None]:
    """Return a joint's rotation and translation, None where it has none."""
    match kind:
        case "revolute":
            angle = arb(float(entries[0]))
            return about_z(angle.cos(), angle.sin()), None
        case "continuous":
            return _unit_turn(entries), None
        case "prismatic":
            return None, exactly([0.0, 0.0, entries[0]])
        case "spherical":
            return of_quaternion(entries), None
        case "planar":
            return _unit_turn(entries[2:]), exactly([*entries[:2], 0.0])
    return of_quaternion(entries[3:]), exactly(entries[:3])


def _unit_turn(entries: Array) -> Intervals:
    """Return the turn by a (cos, sin), which is divided by its length."""
    cosine, sine = exactly(entries)
    length = (cosine * cosine + sine * sine).sqrt()
    return about_z(cosine / length, sine / length)


def _path(
    points: Sequence[Intervals], turns: Sequence[int], slides: Sequence[Sequence[int]]
) -> Path:
    ways = [upper(norm(end - start)) for start, end in pairwise(points)]
    return Path(tuple(turns), tuple(ways), tuple(map(tuple, slides)))
