"""The joints of MJCF: kind, anchor, axis, range, and the value at which the file shows the body."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from pmjac_pin.errors import ModelFileError, did_you_mean
from pmjac_pin.formats.mjcf_frames import Compiler, truth, unit_vector
from pmjac_pin.urdf_xml import numbers, shown

Array = NDArray[np.float64]

# How many numbers of qpos each kind takes.
KINDS: Mapping[str, int] = {"hinge": 1, "slide": 1, "ball": 4, "free": 7}
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
        Of a hinge or a slide, rad or m.
    reference : float
        MuJoCo's `ref`: the joint's value at qpos0, rad or m.
    """

    name: str
    kind: str
    anchor: Array
    axis: Array
    limits: tuple[float, float] | None
    reference: float

    def motion(self, value: float) -> pin.SE3:
        """Return how far a hinge or slide moves the body to that side of its anchor, at a value."""
        step = (value - self.reference) * self.axis
        if self.kind == "slide":
            return pin.SE3(np.eye(3), step)
        return pin.SE3(pin.exp3(step), np.zeros(3))


def read_joint(
    where: str, element: Element, called: tuple[str, str], frame: pin.SE3, compiler: Compiler
) -> MjcfJoint:
    """Read a joint of this name and kind that stands in a frame of its body.

    Raises
    ------
    ModelFileError
        An unknown kind, or a number that is none.
    """
    name, kind = called
    if kind not in KINDS:
        known = did_you_mean(kind, KINDS)
        raise ModelFileError(f"{where} has the unknown type {shown(kind)}{known}")
    unit = compiler.angle if kind == "hinge" else 1.0
    anchor, axis, reference, limits = np.zeros(3), np.array([0.0, 0.0, 1.0]), 0.0, None
    if kind in ("hinge", "ball"):
        anchor = frame.act(np.array(numbers(where, element, "pos", default="0 0 0", count=3)))
    if kind in SCALAR:
        given = np.array(numbers(where, element, "axis", default="0 0 1", count=3))
        axis = frame.rotation @ unit_vector(f"{where}: `axis`", given)
        reference = unit * numbers(where, element, "ref", default="0")[0]
        limits = _limits(where, element, unit, compiler.autolimits)
    return MjcfJoint(name, kind, anchor, axis, limits, reference)


def _limits(
    where: str, element: Element, unit: float, autolimits: bool
) -> tuple[float, float] | None:
    lower, upper = numbers(where, element, "range", default="0 0", count=2)
    limited = element.get("limited", "auto")
    if limited == "auto":
        if element.get("range") is not None and not autolimits:
            todo = '`limited` must be "true" or "false", since <compiler autolimits="false"/>'
            raise ModelFileError(f"{where} has a `range`; {todo}")
        limited = "false" if lower == upper == 0.0 else "true"
    if not truth(where, "limited", limited):
        return None
    if not lower < upper:
        raise ModelFileError(f"{where}: `range` is {lower:g} to {upper:g}; the second is greater")
    return unit * lower, unit * upper
