"""Stick figure: a pose of a mechanism as points, bars and plates, for a drawing on paper."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.spatial import ConvexHull

from pmjac_pin.configuration import Configuration
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.pictures.anatomy import Anatomy
from pmjac_pin.pictures.bodies import Point, PointsOfBodies
from pmjac_pin.values.arrays import Array

StrokeKind = Literal[
    "ground", "link", "rail", "motor rail", "rod", "joint", "motor", "slider", "ball", "anchor"
]

_THIN = 1e-6  # of the mechanism's size: thinner bodies are plates or bars
TOOL_LENGTH = 0.16  # of the mechanism's size


@dataclass(frozen=True, slots=True, eq=False)
class Stroke:
    """A bar (2 points), a plate (its 3 and more corners) or a mark (1 point), in the world, m."""

    kind: StrokeKind
    points: Array

    @property
    def is_plate(self) -> bool:
        """Whether this is a plate."""
        return len(self.points) > 2

    @property
    def normal(self) -> Array:
        """Unit normal of a plate, shape (3,)."""
        normal: Array = np.linalg.svd(self.points - self.points.mean(axis=0))[2][2]
        return normal


@dataclass(frozen=True, slots=True, eq=False)
class StickFigure:
    """A pose as it is drawn.

    Attributes
    ----------
    strokes : tuple of Stroke
    tool : ndarray, shape (4, 3)
        The tool's origin and the ends of its three axes.
    """

    strokes: tuple[Stroke, ...]
    tool: Array

    @property
    def points(self) -> Array:
        """All points, shape (k, 3)."""
        return np.concatenate([*(stroke.points for stroke in self.strokes), self.tool])


class StickFigures:
    """Makes the stick figures of one mechanism: what never changes is looked up once."""

    def __init__(self, mechanism: Mechanism) -> None:
        self._anatomy = anatomy = Anatomy(mechanism)
        self._drawn = [
            (kind, PointsOfBodies.of(points)) for kind, points in _drawn_strokes(anatomy)
        ]

    def __call__(self, configuration: Configuration) -> StickFigure:
        """Return a pose as it is drawn."""
        placements = self._anatomy.bodies.placements(configuration.q)
        pose, length = self._anatomy.tool_pose(configuration), TOOL_LENGTH * self._anatomy.size
        ends = pose.translation + length * pose.rotation.T
        return StickFigure(
            tuple(Stroke(kind, points.at(placements)) for kind, points in self._drawn),
            np.vstack([pose.translation, ends]),
        )


def _drawn_strokes(anatomy: Anatomy) -> Iterator[tuple[StrokeKind, list[Point]]]:
    """Yield what is drawn, as points fixed to bodies: first what lies below."""
    for body in range(anatomy.model.njoints):
        kind: StrokeKind = "link" if body else "ground"
        for corners in _outlines(anatomy.link_points(body), _THIN * anatomy.size):
            yield kind, [Point(body, corner) for corner in corners]
    for joint in filter(anatomy.slides, anatomy.joints):
        rail: StrokeKind = "motor rail" if joint in anatomy.motors else "rail"
        yield rail, [anatomy.root(joint), Point(joint, np.zeros(3))]
    for anchors in anatomy.anchors:
        if anchors.length:
            yield "rod", [anchors.first, anchors.second]
    for joint in anatomy.joints:
        if mark := _joint_mark(anatomy, joint):
            yield mark, [Point(joint, np.zeros(3))]
    for anchors in anatomy.anchors:
        ends = [anchors.first, anchors.second] if anchors.length else [anchors.first]
        for end in ends:
            yield "anchor", [end]


def _joint_mark(anatomy: Anatomy, joint: int) -> StrokeKind | None:
    if anatomy.ball(joint):
        return "ball"
    if joint not in anatomy.bodies.axes:
        return None
    if not anatomy.bodies.axes[joint].turns:
        return "slider"
    return "motor" if joint in anatomy.motors else "joint"


def _outlines(points: Array, smallest: float) -> Iterator[Array]:
    """Yield the bars or the plate of a body that holds these points, shape (k, 3).

    Two points, or points on a line, are joined by a bar, points in a plane are the corners of a
    plate or within it, all others hang together by bars to their mean.
    """
    if len(points) < 2:
        return
    middle = points.mean(axis=0)
    axes = np.linalg.svd(points - middle)[2]
    along = (points - middle) @ axes.T
    spread = np.ptp(along, axis=0)
    if spread[1] <= smallest:
        yield points[[np.argmin(along[:, 0]), np.argmax(along[:, 0])]]
    elif spread[2] <= smallest:
        yield points[ConvexHull(along[:, :2]).vertices]
    else:
        yield from (np.array([middle, point]) for point in points)
