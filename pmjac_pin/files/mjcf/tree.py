"""MjcfTree: the bodies of an MJCF model as a URDF in which a joint's value is MuJoCo's qpos.

MuJoCo shows each body at qpos0, where a joint's value is its `ref`; a URDF shows it where the
joint's value is 0. So a joint's frame, at its anchor, is turned or shifted back by `ref`. A body
with several joints gets links in between, and one whose last joint is not at its origin gets a
link fixed to that joint's: both are called `JOINT_on_BODY`.
"""

from __future__ import annotations

from collections.abc import Container, Sequence

import numpy as np
import pinocchio as pin

from pmjac_pin.files.joint_dialects import WITHOUT_LIMIT
from pmjac_pin.files.mjcf.bodies import Body
from pmjac_pin.files.mjcf.joints import SCALAR, MjcfJoint
from pmjac_pin.files.mjcf.names import WORLD_BODY, Names
from pmjac_pin.files.tree_urdf import MovingAxis, TreeUrdf

_URDF_TYPES = {"hinge": "revolute", "slide": "prismatic", "ball": "floating", "free": "floating"}


class MjcfTree:
    """The URDF, body by body.

    Parameters
    ----------
    name : str
        The model's.
    bodies : sequence of Body
        The world first, parents before their children.
    names : Names
    counted : container of str
        Hinges whose turns count, so that they must not be ``continuous``.

    Attributes
    ----------
    urdf : TreeUrdf
    """

    def __init__(
        self, name: str, bodies: Sequence[Body], names: Names, counted: Container[str]
    ) -> None:
        self.urdf = TreeUrdf(name, WORLD_BODY, pin.SE3.Identity(), names.taken)
        self._zero = {WORLD_BODY: pin.SE3.Identity()}
        self._counted = counted
        for body in bodies:
            if body.name != WORLD_BODY:
                self._add(body)
            for link, placement in body.sites:
                self.urdf.fixed(body.name, link, self._zero[body.name] * placement)
            for shape, placement, colour in body.shapes:
                self.urdf.visual(body.name, placement, shape, colour)

    def anchor(self, body: str, wish: str, placement: pin.SE3) -> str:
        """Return a frame at this place of a body: its own, where it is that."""
        if placement.isIdentity(0.0):
            return body
        return self.urdf.fixed(body, self.urdf.unused(wish), self._zero[body] * placement)

    def _add(self, body: Body) -> None:
        above, placement = body.parent, self._zero[body.parent] * body.placement
        for joint in body.joints:
            anchor = pin.SE3(np.eye(3), joint.anchor)
            if joint.kind == "free":
                placement = pin.SE3.Identity()
            elif joint.kind in SCALAR:
                placement = placement * anchor * joint.motion(0.0) * anchor.inverse()
            at_origin = joint is body.joints[-1] and not joint.anchor.any()
            link = body.name if at_origin else self.urdf.unused(f"{joint.name}_on_{body.name}")
            self.urdf.link(link, placement * anchor)
            self._move(joint, (above, link))
            above = link
        self._zero[body.name] = placement
        if above != body.name:
            self.urdf.fixed(above, body.name, placement)

    def _move(self, joint: MjcfJoint, ends: tuple[str, str]) -> None:
        kind, limits = _URDF_TYPES[joint.kind], joint.limits
        if kind == "floating":
            self.urdf.joint(joint.name, kind, ends)
            return
        if kind == "revolute" and limits is None and joint.name not in self._counted:
            self.urdf.joint(joint.name, "continuous", ends, MovingAxis(joint.axis))
            return
        wide = (-WITHOUT_LIMIT, WITHOUT_LIMIT)
        self.urdf.joint(joint.name, kind, ends, MovingAxis(joint.axis, limits or wide))
