"""Anatomy: the points, bodies and sizes of a mechanism that its picture is made from."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin

from pmjac_pin.closing.machine_size import shifted_model
from pmjac_pin.configuration import Configuration
from pmjac_pin.files.visuals import read_visuals
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.frames import find_frame
from pmjac_pin.model.joint_kinds import kind_of
from pmjac_pin.model.loop_between_frames import LoopBetweenFrames
from pmjac_pin.model.loop_spec import JointLoop
from pmjac_pin.pictures.bodies import Bodies, Point, PointsOfBodies
from pmjac_pin.values.arrays import Array

COINCIDENT = 1e-6  # of the mechanism's size: points nearer than this are one


@dataclass(frozen=True, eq=False)
class LoopAnchors:
    """A loop's two anchors, and what holds them.

    Attributes
    ----------
    loop : LoopBetweenFrames
    first, second : Point
    length : float
        Of the rod between them, m; 0 without.
    axes : tuple of two ndarrays of shape (3,), or None
        The axis that each of them carries, in the frame of its body's joint.
    """

    loop: LoopBetweenFrames
    first: Point
    second: Point
    length: float
    axes: tuple[Array, Array] | None


class Anatomy:
    """What of a mechanism's picture never changes.

    Attributes
    ----------
    mechanism : Mechanism
    model : pin.Model
        Beside the origin, wherever the mechanism stands: pictures have few digits.
    bodies : Bodies
    home : ndarray, shape (njoints, 4, 4)
        oMi at home.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.model = shifted_model(mechanism.model, -mechanism.place)
        self.bodies = Bodies(self.model)
        self.home = self.bodies.placements(mechanism.home.q)
        self.visuals = read_visuals(mechanism.urdf) if mechanism.urdf else []

    def tool_pose(self, configuration: Configuration) -> pin.SE3:
        """Return the tool's pose in the picture."""
        pose = configuration.tool_pose()
        return pin.SE3(pose.rotation, pose.translation - self.mechanism.place)

    @property
    def joints(self) -> range:
        """Pinocchio's indices of the joints that move."""
        return range(1, self.model.njoints)

    @cached_property
    def motors(self) -> frozenset[int]:
        """Pinocchio's indices of the motors."""
        return frozenset(self.model.getJointId(name) for name in self.mechanism.spec.actuated)

    @cached_property
    def anchors(self) -> list[LoopAnchors]:
        """The loops between frames."""
        values = self.mechanism.parameters
        return [
            LoopAnchors(
                loop,
                self.point(loop.frames[0]),
                self.point(loop.frames[1]),
                loop.rod(values),
                self._axes(loop),
            )
            for loop in self.mechanism.spec.loops
            if not isinstance(loop, JointLoop)
        ]

    @cached_property
    def drawn_by_visuals(self) -> frozenset[int]:
        """The bodies whose visuals are all drawn, by Pinocchio's indices of their joints."""
        drawn: set[int] = set()
        wanting: set[int] = set()
        for visual in self.visuals:
            body = find_frame(self.model, visual.link).joint
            (drawn if visual.pieces else wanting).add(body)
        return frozenset(drawn - wanting)

    @cached_property
    def tool(self) -> list[Point]:
        """The frame that is the tool, or the three that span it."""
        return [self.point(name) for name in self.mechanism.spec.tool.names]

    @cached_property
    def size(self) -> float:
        """Radius in m about the middle of the mechanism's points and visuals at home, or 1."""
        points = np.concatenate([self._joint_points(), self._visual_points()])
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
        radius = float(np.linalg.norm(points - middle, axis=1).max())
        return radius if radius > 0.0 else 1.0

    def point(self, frame: str) -> Point:
        """Return the origin of a frame."""
        found = find_frame(self.model, frame)
        return Point(found.joint, found.placement.translation.copy())

    def _axes(self, loop: LoopBetweenFrames) -> tuple[Array, Array] | None:
        if loop.lines is None:
            return None
        first, second = (
            find_frame(self.model, frame).placement.rotation @ np.array(axis)
            for frame, axis in zip(loop.frames, loop.lines, strict=True)
        )
        return first, second

    def slides(self, joint: int) -> bool:
        """Tell whether a joint slides along one axis."""
        return joint in self.bodies.axes and self.bodies.axes[joint].slides

    def ball(self, joint: int) -> bool:
        """Tell whether a joint turns in several ways about one point."""
        kind = kind_of(self.model.joints[joint])
        return kind is not None and kind.ball

    def root(self, joint: int) -> Point:
        """Return where a joint is fixed on the body before it."""
        place = self.model.jointPlacements[joint].translation.copy()
        return Point(int(self.model.parents[joint]), place)

    def settled(self, point: Point) -> Point:
        """Return the same point on the earliest body that it is fixed to.

        A point on the axis of a joint that turns belongs to the body before it as well.
        """
        body, place = point.body, point.place
        while body and self._rests(body, place):
            place = self.model.jointPlacements[body].act(place)
            body = int(self.model.parents[body])
        return Point(body, place)

    def coincide(self, one: Point, other: Point) -> bool:
        """Tell whether two settled points are one."""
        distance = np.abs(one.place - other.place).max()
        return one.body == other.body and bool(distance <= COINCIDENT * self.size)

    def _rests(self, joint: int, place: Array) -> bool:
        if joint in self.bodies.axes:
            axis = self.bodies.axes[joint]
            if axis.slides:
                return False
            place = place - (axis.direction @ place) * axis.direction
        elif not self.ball(joint):
            return False
        return bool(np.abs(place).max() <= COINCIDENT * self.size)

    def body_name(self, body: int) -> str:
        """Return the link that moves with a joint, or the joint's own name."""
        for frame in self._links(body):
            if frame.placement.isIdentity(1e-12):
                return str(frame.name)
        return str(self.model.names[body]) if body else "ground"

    def link_points(self, body: int) -> Array:
        """Return the points that a bar drawing of a body joins, (k, 3) in its frame, all apart.

        Its joints, anchors and tool; of a body with one of these only, its fixed frames too.
        """
        points = self._own_points(body)
        if len(points) < 2:
            points = self._apart(
                [*points, *(frame.placement.translation for frame in self._links(body))]
            )
        return points

    def held_points(self, body: int) -> Array:
        """Return where other bodies hold a body, (k, 3) in its frame: its joints and anchors."""
        roots = [self.root(joint) for joint in self.joints if not self._loose(joint)]
        return self._points_on(body, [*roots, *self._ends])

    def _own_points(self, body: int) -> Array:
        roots = [self.root(joint) for joint in self.joints]
        return self._points_on(body, [*roots, *self._ends, *self.tool])

    @property
    def _ends(self) -> list[Point]:
        return [point for anchor in self.anchors for point in (anchor.first, anchor.second)]

    def _points_on(self, body: int, points: list[Point]) -> Array:
        places = [np.zeros(3)] if body and not self._loose(body) else []
        return self._apart([*places, *(point.place for point in points if point.body == body)])

    def _apart(self, places: list[Array]) -> Array:
        found: list[Array] = []
        for place in places:
            near = (np.abs(place - other).max() <= COINCIDENT * self.size for other in found)
            if not any(near):
                found.append(place)
        return np.array(found).reshape(-1, 3)

    def _loose(self, body: int) -> bool:
        kind = kind_of(self.model.joints[body])
        return kind is not None and kind.loose

    def _links(self, body: int) -> Iterator[pin.Frame]:
        for frame in self.model.frames:
            if frame.type == pin.FrameType.BODY and frame.parentJoint == body:
                yield frame

    def _joint_points(self) -> Array:
        roots = [self.root(joint) for joint in self.joints if not self._loose(joint)]
        own = [Point(joint, np.zeros(3)) for joint in self.joints if not self._loose(joint)]
        links = [
            Point(body, frame.placement.translation)
            for body in self.joints
            for frame in self._links(body)
        ]
        return PointsOfBodies.of([*roots, *own, *self._ends, *self.tool, *links]).at(self.home)

    def _visual_points(self) -> Array:
        """Return where the visuals end along their own axes at home, shape (k, 3)."""
        ends = np.hstack([np.eye(3), -np.eye(3)])
        found = [np.zeros((0, 3))]
        for visual in self.visuals:
            frame = find_frame(self.model, visual.link)
            for shape, transform in visual.pieces:
                placed = self.home[frame.joint] @ frame.placement.homogeneous @ transform
                half = np.array(shape.half_extents)[:, None]
                found.append((placed[:3, :3] @ (half * ends) + placed[:3, 3:]).T)
        return np.concatenate(found)
