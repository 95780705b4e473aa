"""Where MJCF places things: angles, orientations of every form, and the pose of an element."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from pmjac_pin.errors import ModelFileError
from pmjac_pin.urdf_xml import numbers, shown

Array = NDArray[np.float64]

ORIENTATIONS: Mapping[str, int] = MappingProxyType(
    {"quat": 4, "axisangle": 4, "euler": 3, "xyaxes": 6, "zaxis": 3}
)
_SHORTEST = 1e-9
_UNITS = {"degree": math.pi / 180.0, "radian": 1.0}
_TRUTHS = {"true": True, "false": False}


@dataclass(frozen=True)
class Compiler:
    """What <compiler> says of angles and limits.

    Attributes
    ----------
    angle : float
        The unit of angles in rad.
    sequence : str
        Three of x, y, z (about the axes as turned so far) and X, Y, Z (about the fixed ones).
    autolimits : bool
        A joint with a range is limited.
    alignfree : bool
        A body that moves freely, and carries no other, gets its inertia's frame.
    """

    angle: float
    sequence: str
    autolimits: bool
    alignfree: bool

    @classmethod
    def of(cls, root: Element) -> Compiler:
        """Return the settings of <mujoco>; where there are several <compiler>, the last counts."""
        given: dict[str, str] = {}
        for element in root.iterfind("compiler"):
            given.update(element.attrib)
        if given.get("coordinate", "local") != "local":
            todo = "MuJoCo gave them up; load and save the file in MuJoCo 2.3.3 or older"
            raise ModelFileError(f"<compiler>: only local coordinates are read; {todo}")
        if (unit := given.get("angle", "degree")) not in _UNITS:
            raise ModelFileError(f"<compiler>: `angle` is {shown(unit)}, not degree or radian")
        sequence = given.get("eulerseq", "xyz")
        if len(sequence) != 3 or not set(sequence) <= set("xyzXYZ"):
            raise ModelFileError(f"<compiler>: `eulerseq` is {shown(sequence)}, not like 'xyz'")
        return cls(
            _UNITS[unit],
            sequence,
            truth("<compiler>", "autolimits", given.get("autolimits", "true")),
            truth("<compiler>", "alignfree", given.get("alignfree", "false")),
        )

    def placement(self, where: str, element: Element) -> pin.SE3:
        """Return the pose that an element gives itself in the frame around it.

        Raises
        ------
        ModelFileError
            A number that is none, several orientations, or one that is no direction.
        """
        if element.get("fromto") is not None:
            ends = np.array(numbers(where, element, "fromto", count=6))
            middle, along = (ends[:3] + ends[3:]) / 2.0, ends[:3] - ends[3:]
            return pin.SE3(_from_z(f"{where}: `fromto`", along), middle)
        position = np.array(numbers(where, element, "pos", default="0 0 0", count=3))
        return pin.SE3(self._rotation(where, element), position)

    def _rotation(self, where: str, element: Element) -> Array:
        given = [key for key in ORIENTATIONS if element.get(key) is not None]
        if not given:
            return np.eye(3)
        if len(given) > 1:
            raise ModelFileError(f"{where} has both `{given[0]}` and `{given[1]}`; give one")
        values = np.array(numbers(where, element, given[0], count=ORIENTATIONS[given[0]]))
        return self._forms()[given[0]](f"{where}: `{given[0]}`", values)

    def _forms(self) -> dict[str, Callable[[str, Array], Array]]:
        return {
            "quat": _from_quaternion,
            "axisangle": self._from_axis_and_angle,
            "euler": self._from_euler,
            "xyaxes": _from_xy,
            "zaxis": _from_z,
        }

    def _from_axis_and_angle(self, what: str, values: Array) -> Array:
        rotation: Array = pin.exp3(self.angle * values[3] * unit_vector(what, values[:3]))
        return rotation

    def _from_euler(self, what: str, values: Array) -> Array:
        rotation = np.eye(3)
        for letter, value in zip(self.sequence, self.angle * values, strict=True):
            turn = pin.exp3(value * np.eye(3)["xyz".index(letter.lower())])
            rotation = rotation @ turn if letter.islower() else turn @ rotation
        return rotation


def unit_vector(what: str, vector: Array) -> Array:
    """Return a vector scaled to length 1, unless it has none."""
    length = float(np.linalg.norm(vector))
    if length < _SHORTEST:
        raise ModelFileError(f"{what} has a direction of length zero")
    return vector / length


def truth(where: str, key: str, text: str) -> bool:
    """Return what "true" or "false" says."""
    if text not in _TRUTHS:
        raise ModelFileError(f"{where}: `{key}` is {shown(text)}, not true or false")
    return _TRUTHS[text]


def _from_quaternion(what: str, wxyz: Array) -> Array:
    w, x, y, z = unit_vector(what, wxyz)
    rotation: Array = pin.Quaternion(w, x, y, z).toRotationMatrix()
    return rotation


def _from_xy(what: str, values: Array) -> Array:
    x = unit_vector(what, values[:3])
    y = unit_vector(what, values[3:] - (x @ values[3:]) * x)
    return np.column_stack([x, y, np.cross(x, y)])


def _from_z(what: str, vector: Array) -> Array:
    """Return the shortest turn that takes z to a direction; half a turn is about x."""
    z = unit_vector(what, vector)
    across = np.array([-z[1], z[0], 0.0])
    sine = float(np.linalg.norm(across))
    axis = across / sine if sine > 1e-10 else np.array([1.0, 0.0, 0.0])
    rotation: Array = pin.exp3(math.atan2(sine, z[2]) * axis)
    return rotation
