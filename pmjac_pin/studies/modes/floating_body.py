"""A floating body held at points alone, taken out of the unknowns.

A free body is where three of its points are, and points that keep their distances put it nowhere
else: three point loops become |Pᵢ − Pⱼ|² = Lᵢⱼ². A body in a plane is where two of its points are,
at their distance, and every further one is at

    P_k = P₁ + α_k (P₂ − P₁) + β_k n × (P₂ − P₁),

with n the plane's normal; what holds it must be as high as its points, along n. So the unknowns
that are left are the legs' own. These rows hold exactly where the loops close exactly; where the
loops gape by no more than ε, a row is off by the tolerance given here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from scipy.spatial.transform import Rotation

from pmjac_pin.algebra import Number
from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.algebra.jets import Jet, Jets
from pmjac_pin.kinematics.tree import Poses
from pmjac_pin.model.frames import Frame
from pmjac_pin.model.linkage import Edge
from pmjac_pin.model.rows import Gap, Rows, Tilt
from pmjac_pin.studies.modes.interval_loops import Between
from pmjac_pin.values.arrays import Array

_IN_LINE = 1e-6  # of the longest side: three points less apart than this are in line
_TOLERANCE_SLACK = 1.01  # for the rounding of tolerances


@dataclass(frozen=True, slots=True, eq=False)
class Held:
    """A point of a floating body and what holds it there.

    Attributes
    ----------
    own, other : Frame
        The loop's frame on the body, and the one on what holds it.
    hinge : ndarray, shape (3,), or None
        The axis of a hinge there, with the same components in both frames; None for a ball.
    """

    own: Frame
    other: Frame
    hinge: Array | None
    name: str


def held(own: Frame, other: Frame, blocks: Sequence[Rows], name: str) -> Held | None:
    """Return how a loop with these blocks holds a floating body; None if not at a point."""
    match blocks:
        case [Gap()]:
            return Held(own, other, None, name)
        case [Gap(), Tilt(hinge)]:
            return Held(own, other, hinge, name)
        case _:
            return None


@dataclass(frozen=True, slots=True, eq=False)
class FloatingTriangle:
    """Three points of a free body keep their distances: 3 rows, m²."""

    holds: tuple[Held, ...]
    squares: tuple[Intervals, ...]
    closed: float

    @classmethod
    def of(cls, edge: Edge, holds: Sequence[Held], closed: float) -> FloatingTriangle | None:
        """Return the rows of a free joint's body, None where it is held in another way."""
        if len(holds) != 3 or any(hold.hinge is not None for hold in holds):
            return None
        points = [_on_body(edge, hold) for hold in holds]
        sides = [points[j] - points[i] for i, j in _PAIRS]
        one, other = sides[0].middle, sides[1].middle
        longest = max(float(np.linalg.norm(side.middle)) for side in sides)
        if float(np.linalg.norm(np.cross(one, other))) <= _IN_LINE * longest**2:
            return None
        return cls(tuple(holds), tuple(side.square().sum(0) for side in sides), closed)

    @property
    def names(self) -> tuple[str, ...]:
        """One for each pair of points."""
        return tuple(f"{self.holds[i].name}-{self.holds[j].name} distance²" for i, j in _PAIRS)

    @property
    def tolerance(self) -> tuple[float, ...]:
        """(L + 2ε)² − L², m²."""
        return tuple(_of_square(square, self.closed) for square in self.squares)

    @property
    def spans(self) -> tuple[tuple[Frame, Frame, float], ...]:
        """How far apart what holds the body can be."""
        return tuple(
            (self.holds[i].other, self.holds[j].other, _longest(square))
            for (i, j), square in zip(_PAIRS, self.squares, strict=True)
        )

    def __call__(self, poses: Poses) -> tuple[list[Jet], list[Number]]:
        """Return |Pᵢ − Pⱼ|² − Lᵢⱼ²."""
        jets = Jets(poses.algebra)
        points = [poses.riding(0, hold.other).origin() for hold in self.holds]
        rows = [
            jets.squared(points[j] - points[i]) - _still(jets, square)
            for (i, j), square in zip(_PAIRS, self.squares, strict=True)
        ]
        return [jets.stack(rows)], []


_PAIRS = ((0, 1), (1, 2), (2, 0))


@dataclass(frozen=True, slots=True, eq=False)
class FloatingInPlane:
    """Points of a body that moves in a plane: a distance, two rows a further point, and heights.

    Attributes
    ----------
    plane : Frame
        Its z is the plane's normal.
    square : Intervals
        |P₂ − P₁|².
    shares : tuple of (Intervals, Intervals)
        α_k and β_k of the points after the second.
    heights : tuple of Intervals
        Of all points over the plane.
    hinges : tuple of (Held, ndarray)
        Those with an axis, and this turned round where it points against the normal.
    """

    plane: Frame
    holds: tuple[Held, ...]
    square: Intervals
    shares: tuple[tuple[Intervals, Intervals], ...]
    heights: tuple[Intervals, ...]
    hinges: tuple[tuple[Held, Array], ...]
    closed: float
    tilted: float

    @classmethod
    def of(
        cls, edge: Edge, plane: Frame, holds: Sequence[Held], closed: float, tilted: float
    ) -> FloatingInPlane | None:
        """Return the rows of a planar joint's body, None where it is held in another way."""
        if len(holds) < 2:
            return None
        points = [_on_body(edge, hold) for hold in holds]
        side = (points[1] - points[0])[:2]
        square = side.square().sum(0)
        sizes = [float(np.linalg.norm(p.middle[:2] - points[0].middle[:2])) for p in points]
        if sizes[1] <= _IN_LINE * max(sizes):
            return None
        shares = []
        for other in points[2:]:
            away = other - points[0]
            along = away[0] * side[0] + away[1] * side[1]
            across = away[1] * side[0] - away[0] * side[1]
            shares.append((along / square, across / square))
        heights = tuple(p[2] for p in points)
        hinges = []
        for hold in holds:
            if hold.hinge is not None:
                x, y, z = edge.after.rotation @ hold.own.placement.rotation @ hold.hinge
                if max(abs(x), abs(y)) > tilted:
                    return None
                hinges.append((hold, hold.hinge * np.sign(z)))
        return cls(
            plane, tuple(holds), square, tuple(shares), heights, tuple(hinges), closed, tilted
        )

    @property
    def names(self) -> tuple[str, ...]:
        """One for each row."""
        labels = [hold.name for hold in self.holds]
        further = [f"{label} {way}" for label in labels[2:] for way in ("along", "across")]
        heights = [f"{label} height" for label in labels]
        tilts = [f"{hold.name} tilt {k}" for hold, _ in self.hinges for k in (1, 2)]
        return (f"{labels[0]}-{labels[1]} distance²", *further, *heights, *tilts)

    @property
    def tolerance(self) -> tuple[float, ...]:
        """(L + 2ε)² − L²; 2ε (1 + |α| + |β|); ε; what hinge and body may tilt together."""
        further: list[float] = []
        for along, across in self.shares:
            share = 1.0 + float(along.magnitude) + float(across.magnitude)
            further += 2 * [_TOLERANCE_SLACK * 2.0 * self.closed * share]
        heights = [_TOLERANCE_SLACK * self.closed] * len(self.holds)
        tilts = [2.0 * self.tilted] * (2 * len(self.hinges))
        return (_of_square(self.square, self.closed), *further, *heights, *tilts)

    @property
    def spans(self) -> tuple[tuple[Frame, Frame, float], ...]:
        """How far apart what holds the body can be; out of the plane it is nowhere."""
        first, second = self.holds[0], self.holds[1]
        rise = float((self.heights[1] - self.heights[0]).magnitude)
        return ((first.other, second.other, _longest(self.square) + rise),)

    def __call__(self, poses: Poses) -> tuple[list[Jet], list[Number]]:
        """Return the rows."""
        jets = Jets(poses.algebra)
        plane = poses.riding(0, self.plane)
        axes, middle = plane.carried(np.eye(3)), plane.origin()
        others = [poses.riding(0, hold.other) for hold in self.holds]
        points = [other.origin() for other in others]
        flat = [jets.dot(axes[:, :2], (point - points[0])[:, None]) for point in points]
        side_x, side_y = flat[1][0], flat[1][1]
        rows = [jets.squared(flat[1]) - _still(jets, self.square)]
        for (along, across), there in zip(self.shares, flat[2:], strict=True):
            share, part = _still(jets, along), _still(jets, across)
            rows.append(there[0] - side_x * share + side_y * part)
            rows.append(there[1] - side_y * share - side_x * part)
        for point, height in zip(points, self.heights, strict=True):
            rows.append(jets.dot(axes[:, 2], point - middle) - _still(jets, height))
        up: list[Number] = []
        for hold, direction in self.hinges:
            hinge = others[self.holds.index(hold)].carried(direction[None])
            seen = jets.dot(axes, hinge)
            rows += [seen[0], seen[1]]
            up.append(seen[2].value)
        return [jets.stack(rows)], up


def _still(jets: Jets, number: Intervals) -> Jet:
    """Return an interval as a scalar that does not change."""
    boxes: Between = jets.base  # type: ignore[assignment]
    return Jet(boxes, boxes.between(number), None, ())


def placed(edge: Edge, holds: Sequence[Held], frames: Sequence[pin.SE3]) -> pin.SE3:
    """Return the pose of a floating body, in the world, that its points are best at.

    Parameters
    ----------
    edge : Edge
        The floating joint.
    holds : sequence of Held
    frames : sequence of SE3
        What holds it, in the world; then the plane where the joint has one.
    """
    own = np.array([hold.own.placement.translation for hold in holds])
    there = np.array([frame.translation for frame in frames[: len(holds)]])
    before, after = own - own.mean(axis=0), there - there.mean(axis=0)
    if len(frames) > len(holds):
        normal = edge.after.rotation.T[:, 2] * np.abs(before).max()
        before = np.vstack([before, normal])
        after = np.vstack([after, frames[-1].rotation[:, 2] * np.abs(before).max()])
    rotation = Rotation.align_vectors(after, before)[0].as_matrix()
    return pin.SE3(rotation, there.mean(axis=0) - rotation @ own.mean(axis=0))


def _on_body(edge: Edge, hold: Held) -> Intervals:
    """Return a point where the joint's motion is seen from: after · place, shape (3,)."""
    place = Intervals.exact(hold.own.placement.translation[:, None])
    return place.after(edge.after.rotation)[:, 0] + Intervals.exact(edge.after.translation)


def _of_square(square: Intervals, closed: float) -> float:
    return _TOLERANCE_SLACK * 4.0 * closed * (_longest(square) + closed)


def _longest(square: Intervals) -> float:
    return float(np.sqrt(square.magnitude)) * _TOLERANCE_SLACK
