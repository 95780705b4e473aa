"""Loop closures: their anchors and axes, the rods between them, and what is open."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pmjac_pin.files.shapes import Cylinder, Sphere, scaled
from pmjac_pin.model.joint_form import shifted
from pmjac_pin.model.loop_between_frames import Opening
from pmjac_pin.pictures.anatomy import Anatomy, LoopAnchors
from pmjac_pin.pictures.bodies import PointsOfBodies
from pmjac_pin.values.arrays import Array
from pmjac_pin.viewer.items import Carried, Part, stretched_between
from pmjac_pin.viewer.layers import SPECK, Attached, Drawing, DrawnPose, Lines
from pmjac_pin.viewer.palette import FIRST_ANCHOR, GAP, ROD, SECOND_ANCHOR

# Shares of the mechanism's size.
FIRST_RADIUS, SECOND_RADIUS = 0.03, 0.045
FIRST_AXIS, SECOND_AXIS = 0.08, 0.065  # half the length: the first one's, thinner, looks out
AXIS_RADII = (0.006, 0.011)
ROD_RADIUS, SLIDE_RADIUS, GAP_RADIUS = 0.015, 0.006, 0.008


def anchor_layer(anatomy: Anatomy) -> Attached:
    """Return a ball at each anchor; the second one's is larger and lets the first one shine."""
    return Attached.of(_ball_pieces(anatomy))


def axis_layer(anatomy: Anatomy) -> Attached:
    """Return a pin through each anchor that carries an axis; closed hinges have theirs in line."""
    return Attached.of(_pins(anatomy))


def rod_layer(anatomy: Anatomy) -> Lines:
    """Return the rods of distance loops, and what sliding loops slide along."""
    held = [
        (Part(f"loops/{number}/rod", Cylinder(), ROD), anchors, radius)
        for number, anchors in enumerate(anatomy.anchors, start=1)
        if (radius := _rod_radius(anchors))
    ]
    return Lines(
        parts=[part for part, _, _ in held],
        starts=PointsOfBodies.of([anchors.first for _, anchors, _ in held]),
        ends=PointsOfBodies.of([anchors.second for _, anchors, _ in held]),
        radii=anatomy.size * np.array([radius for _, _, radius in held]),
        smallest=SPECK * anatomy.size,
    )


def gap_layer(anatomy: Anatomy) -> Gaps:
    """Return what is open at each loop."""
    anchors = anatomy.anchors
    unlimited = [anchor.axes[1] if anchor.axes else np.zeros(3) for anchor in anchors]
    return Gaps(
        parts=[Part(f"loops/{n}/gap", Cylinder(), GAP) for n in range(1, len(anchors) + 1)],
        firsts=PointsOfBodies.of([anchor.first for anchor in anchors]),
        seconds=PointsOfBodies.of([anchor.second for anchor in anchors]),
        axes=np.array(unlimited).reshape(-1, 3),
        weights=np.array([_WEIGHTS[anchor.loop.opening] for anchor in anchors]).reshape(-1, 2),
        lengths=np.array([anchor.length for anchor in anchors]),
        radius=GAP_RADIUS * anatomy.size,
        smallest=SPECK * anatomy.size,
    )


@dataclass(frozen=True, eq=False)
class Gaps:
    """Lines along what a loop leaves open of the way d from its first anchor to its second.

    With b the axis of the second: d − (b·d) b of a slide, (b·d) b of a plane, of a rod what its
    length does not span, of all others d.

    Attributes
    ----------
    parts : sequence of Part
    firsts, seconds : Points
    axes : ndarray, shape (k, 3)
        b, in the frame of the second anchor's body.
    weights : ndarray, shape (k, 2)
        Those of d and of (b·d) b.
    lengths : ndarray, shape (k,)
        Of the rods, m.
    radius : float
    smallest : float
        What is shorter is hidden.
    """

    parts: Sequence[Part]
    firsts: PointsOfBodies
    seconds: PointsOfBodies
    axes: Array
    weights: Array
    lengths: Array
    radius: float
    smallest: float

    def draw(self, pose: DrawnPose) -> Drawing:
        """Stretch the lines."""
        starts = self.firsts.at(pose.placements)
        way = self.seconds.at(pose.placements) - starts
        rotations = pose.placements[self.seconds.bodies, :3, :3]
        b = (rotations @ self.axes[:, :, None])[:, :, 0]
        along = (way * b).sum(axis=1)[:, None] * b
        ends = starts + self.weights[:, :1] * way + self.weights[:, 1:] * along
        distances = np.maximum(np.linalg.norm(way, axis=1), self.smallest)
        starts = starts + way * (self.lengths / distances)[:, None]
        radii = np.full(len(starts), self.radius)
        return Drawing(*stretched_between(starts, ends, radii, self.smallest))


def _ball_pieces(anatomy: Anatomy) -> Iterator[Carried]:
    for number, anchors in enumerate(anatomy.anchors, start=1):
        for name, point, radius, colour in (
            ("first", anchors.first, FIRST_RADIUS, FIRST_ANCHOR),
            ("second", anchors.second, SECOND_RADIUS, SECOND_ANCHOR),
        ):
            place = shifted(point.place) @ scaled(radius * anatomy.size)
            yield Part(f"loops/{number}/{name}", Sphere(), colour), point.body, place


def _pins(anatomy: Anatomy) -> Iterator[Carried]:
    for number, anchors in enumerate(anatomy.anchors, start=1):
        if anchors.axes is None:
            continue
        points, halves = (anchors.first, anchors.second), (FIRST_AXIS, SECOND_AXIS)
        places = np.array([point.place for point in points])
        reach = anatomy.size * np.array(halves)[:, None] * np.array(anchors.axes)
        radii = anatomy.size * np.array(AXIS_RADII)
        transforms, _ = stretched_between(places - reach, places + reach, radii, 0.0)
        names, colours = ("first_axis", "second_axis"), (FIRST_ANCHOR, SECOND_ANCHOR)
        for name, colour, point, place in zip(names, colours, points, transforms, strict=True):
            yield Part(f"loops/{number}/{name}", Cylinder(), colour), point.body, place


def _rod_radius(anchors: LoopAnchors) -> float:
    if anchors.loop.opening == "along":
        return SLIDE_RADIUS
    return ROD_RADIUS if anchors.length > 0.0 else 0.0


#: The weights of d and of (b·d) b in the gap of a loop that lets this of d be.
_WEIGHTS: Mapping[Opening, tuple[float, float]] = {
    "nothing": (1.0, 0.0),
    "along": (1.0, -1.0),
    "across": (0.0, 1.0),
}
