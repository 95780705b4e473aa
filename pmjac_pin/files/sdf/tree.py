"""SdfTree: the links and joints of an SDFormat model, as a URDF and loop closures.

The frame of a URDF link is that of the joint above it, where SDFormat places the two freely. So
where they differ there are two URDF links fixed to each other: `JOINT_on_LINK` at the joint, and
one with the link's name at its frame.
"""

from __future__ import annotations

from collections.abc import Container
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pinocchio as pin

from pmjac_pin.errors import ModelFileError
from pmjac_pin.files.anchors import loop_of_kind
from pmjac_pin.files.sdf.frames import WORLD
from pmjac_pin.files.sdf.joints import AXIS_TAGS, SdfAxis, SdfJoint
from pmjac_pin.files.sdf.model import SdfModel
from pmjac_pin.files.sdf.plugins import PointTie
from pmjac_pin.files.spanning_tree import Branch
from pmjac_pin.files.tree_urdf import MovingAxis, TreeUrdf
from pmjac_pin.model.loop_spec import Loop, SphericalLoop

#: What closes the loop of a joint that is cut, where that has another name.
_AS_CUT = {"ball": "spherical", "revolute2": "universal", "screw": "fixed"}
_SAME_PLACE = 1e-12  # m or rad: rounding of one frame's placement in another
_PERPENDICULAR = 1e-6  # a universal joint's loop assumes axes that are perpendicular


class SdfTree:
    """What becomes of an SDFormat model, joint by joint.

    Parameters
    ----------
    model : SdfModel
    counted : container of str, optional
        Joints whose turns count, so that they must not be ``continuous``.

    Attributes
    ----------
    urdf : TreeUrdf
    loops : list of Loop
    spherical : list of str
    helical : dict of str to float
        The screws' pitches, m/rad.
    home : dict of str to float
        The nearest to zero, for joints whose limits leave zero out.
    moving : list of str
        Joints of one degree of freedom.
    """

    def __init__(self, model: SdfModel, counted: Container[str] = ()) -> None:
        self._model, self._links, self._counted = model, model.links, counted
        self._joints = {joint.name for joint in model.joints}
        taken = {*model.links, *model.frames, *self._joints}
        self.urdf = TreeUrdf(model.name, WORLD, model.links[WORLD], taken)
        self.loops: list[Loop] = []
        self.spherical: list[str] = []
        self.helical: dict[str, float] = {}
        self.home: dict[str, float] = {}
        self.moving: list[str] = []

    def add(self, joint: SdfJoint, branch: Branch) -> None:
        """Add a joint of the tree and the link that it carries."""
        if joint.kind == "fixed":
            self.urdf.joint(
                joint.name,
                "fixed",
                (branch.above, self.urdf.link(branch.below, self._links[branch.below])),
            )
        elif joint.kind == "ball":
            body = self._body(joint, branch.below)
            self.urdf.joint(joint.name, "floating", (branch.above, body))
            self.spherical.append(joint.name)
        elif len(joint.axes) == 1:
            ends = (branch.above, self._body(joint, branch.below))
            self._single(joint, ends, _seen(joint.axes[0], branch.turned))
        else:
            self._add_cross(joint, branch)

    def cut(self, joint: SdfJoint) -> None:
        """Add a loop in a joint's stead."""
        first, second = (
            self.urdf.fixed(link, self._at(joint, link), joint.placement)
            for link in (joint.parent, joint.child)
        )
        if joint.kind == "screw":  # its turns count: it moves a hub, which is welded to the link
            hub = self.urdf.link(self.urdf.unused(f"{joint.name}_hub"), joint.placement)
            self._single(joint, (first, hub), joint.axes[0])
            first = hub
        self.loops.append(_loop(joint, (first, second)))

    def tie(self, tie: PointTie, number: int) -> None:
        """Add a loop that holds a point of one link at a point of another."""
        first, second = (
            self.urdf.fixed(
                link,
                self.urdf.unused(f"tie{number}_on_{link}"),
                self._links[link] * pin.SE3(np.eye(3), point),
            )
            for link, point in zip(tie.links, tie.points, strict=True)
        )
        self.loops.append(SphericalLoop(frames=(first, second)))

    def add_frame(self, name: str) -> None:
        """Add a <frame> to the link that carries it, by another name if that one is taken."""
        link, placement = self._model.frames[name]
        shared = name in self._links or name in self._joints
        self.urdf.fixed(link, self.urdf.unused(name) if shared else name, placement)

    def _at(self, joint: SdfJoint, link: str) -> str:
        return self.urdf.unused(f"{joint.name}_on_{link}")

    def _body(self, joint: SdfJoint, link: str) -> str:
        """Add a link of the URDF at the joint's frame, and the model's link fixed to it."""
        offset = self._links[link].actInv(joint.placement)
        if offset.isIdentity(_SAME_PLACE):
            return self.urdf.link(link, joint.placement)
        body = self.urdf.link(self._at(joint, link), joint.placement)
        self.urdf.fixed(body, link, self._links[link])
        return body

    def _single(self, joint: SdfJoint, ends: tuple[str, str], axis: SdfAxis) -> None:
        """Add a joint of one degree of freedom."""
        kind = joint.kind
        if kind == "screw":
            kind, self.helical[joint.name] = "revolute", joint.pitch
        self._moving(joint.name, kind, ends, axis)

    def _moving(self, name: str, kind: str, ends: tuple[str, str], axis: SdfAxis) -> None:
        self.moving.append(name)
        kind = "revolute" if kind == "continuous" and name in self._counted else kind
        limits = None if kind == "continuous" else axis.limits
        self.urdf.joint(name, kind, ends, MovingAxis(axis.direction, limits))
        if limits is not None and not limits[0] <= 0.0 <= limits[1]:
            self.home[name] = min(limits, key=abs)

    def _add_cross(self, joint: SdfJoint, branch: Branch) -> None:
        """Add a universal joint as two revolute ones, with the cross between them."""
        cross = self.urdf.link(self.urdf.unused(f"{joint.name}_cross"), joint.placement)
        links = (branch.above, cross, self._body(joint, branch.below))
        axes = list(zip(AXIS_TAGS, joint.axes, strict=True))
        for (tag, axis), ends in zip(
            axes[::-1] if branch.turned else axes, pairwise(links), strict=True
        ):
            name = self.urdf.unused(f"{joint.name}_{tag}")
            self._moving(name, "revolute", ends, _seen(axis, branch.turned))


def _seen(axis: SdfAxis, turned: bool) -> SdfAxis:
    """Return the axis along which a joint moves, turned round or not."""
    return replace(axis, direction=-axis.direction) if turned else axis


def _loop(joint: SdfJoint, frames: tuple[str, str]) -> Loop:
    directions = [(float(x), float(y), float(z)) for x, y, z in (a.direction for a in joint.axes)]
    if len(directions) > 1:
        _check_perpendicular(joint)
    return loop_of_kind(_AS_CUT.get(joint.kind, joint.kind), frames, directions)


def _check_perpendicular(joint: SdfJoint) -> None:
    if abs(float(joint.axes[0].direction @ joint.axes[1].direction)) > _PERPENDICULAR:
        todo = "list it before the other joint that has its child, which is then cut instead"
        wrong = "its axes are not perpendicular, so that it cannot be cut"
        raise ModelFileError(f"joint {joint.name!r} closes a loop and {wrong}; {todo}")
