"""The joints of MJCF: kind, anchor, axis, range, and the value at which the file shows the body."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from pmjac_pin.files.mjcf.names import JOINT_TYPES
from pmjac_pin.values.arrays import Array

SCALAR = ("hinge", "slide")


@dataclass(frozen=True, eq=False)
class MjcfJoint:
    """A joint in the frame of its body at qpos0.

    Attributes
    ----------
    name, kind : str
    anchor : ndarray, shape (3,)
        The point about which it turns, m; zero where it does not matter.
    axis : ndarray, shape (3,)
        A unit vector.
    limits : tuple of float, or None
        Rad or m.
    qpos : slice
        Its numbers in MuJoCo's qpos.
    qpos0 : ndarray
        Those of the pose that the file shows: of a hinge or a slide its `ref`, rad or m.
    """

    name: str
    kind: str
    anchor: Array
    axis: Array
    limits: tuple[float, float] | None
    qpos: slice
    qpos0: Array

    @property
    def reference(self) -> float:
        """The value of a hinge or slide at qpos0."""
        return float(self.qpos0[0])

    def motion(self, value: float) -> pin.SE3:
        """Return how far a hinge or slide moves the body to that side of its anchor, at a value."""
        step = (value - self.reference) * self.axis
        if self.kind == "slide":
            return pin.SE3(np.eye(3), step)
        return pin.SE3(pin.exp3(step), np.zeros(3))


def joint_of(model: Any, number: int, name: str) -> MjcfJoint:
    """Return the joint of this number of a mujoco.MjModel."""
    kind = JOINT_TYPES[model.jnt_type[number]]
    start = int(model.jnt_qposadr[number])
    qpos = slice(start, start + {"free": 7, "ball": 4, "slide": 1, "hinge": 1}[kind])
    lower, upper = model.jnt_range[number].tolist()
    return MjcfJoint(
        name=name,
        kind=kind,
        anchor=model.jnt_pos[number].copy() if kind in ("hinge", "ball") else np.zeros(3),
        axis=model.jnt_axis[number].copy(),
        limits=(lower, upper) if model.jnt_limited[number] else None,
        qpos=qpos,
        qpos0=model.qpos0[qpos].copy(),
    )
