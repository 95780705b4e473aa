"""The frames of an SDFormat model: where each is, and which link carries it.

SDFormat places every link, joint and frame where it is with all joints at zero, in the frame that
its pose is relative to: by default the model's for a link, the child's for a joint, and for a
frame the one that it is attached to (SDFormat 1.7, "Pose frame semantics"). Before version 1.7
the attribute `relative_to` was called `frame`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from pmjac_pin.errors import ModelFileError, quoted
from pmjac_pin.files.xml_text import check_name, numbers_in, only

MODEL = "__model__"
WORLD = "world"
_SDF_TRUTHS: Mapping[str, bool] = {"1": True, "true": True, "0": False, "false": False}


@dataclass(frozen=True)
class SdfFrame:
    """A named frame as the file gives it.

    Attributes
    ----------
    where : str
        How messages call it.
    attached_to : str
        The frame that carries it; for a link its own.
    relative_to : str
        The frame that places it.
    placement : pin.SE3
        In the frame `relative_to`.
    """

    where: str
    attached_to: str
    relative_to: str
    placement: pin.SE3


class Frames:
    """All named frames of a model, in the model's frame.

    Parameters
    ----------
    given : mapping of str to Frame
        All of them, the links' among them.
    links : sequence of str
    canonical : str
        The link that carries the model's frame.

    Raises
    ------
    ModelFileError
        A frame that does not exist, or one that is placed relative to itself in the end.
    """

    def __init__(self, given: Mapping[str, SdfFrame], links: Sequence[str], canonical: str) -> None:
        self._given = given
        self._placements = {MODEL: pin.SE3.Identity()}
        self._links = {MODEL: canonical, WORLD: WORLD} | {link: link for link in links}
        for name in self._in_order(self._placements, "relative_to"):
            frame = given[name]
            self._placements[name] = self._placements[frame.relative_to] * frame.placement
        for name in self._in_order(self._links, "attached_to"):
            self._links[name] = self._links[given[name].attached_to]

    def placement(self, name: str, where: str) -> pin.SE3:
        """Return a frame's placement in the model's frame."""
        return self._placements[self._known(name, self._placements, where)]

    def link(self, name: str, where: str) -> str:
        """Return the link that carries a frame; "world" carries itself."""
        return self._links[self._known(name, self._links, where)]

    def _known(self, name: str, names: Mapping[str, object], where: str) -> str:
        check_name(f"{where}: the frame", name, names)
        return name

    def _in_order(self, done: Mapping[str, object], towards: str) -> list[str]:
        """Return the frames that are not done yet, each behind the one that it rests on."""
        above = {
            name: getattr(frame, towards) for name, frame in self._given.items() if name not in done
        }
        for name, other in above.items():
            if other not in done:
                self._known(other, self._given, self._given[name].where)
        graph = {name: [other] for name, other in above.items()}
        try:
            return [name for name in TopologicalSorter(graph).static_order() if name in above]
        except CycleError as error:
            cycle = error.args[1][::-1]
            some = " -> ".join(map(repr, cycle[:6])) + (" -> ..." if len(cycle) > 6 else "")
            what = f"frames are {towards.replace('_', ' ')} each other: {some}"
            raise ModelFileError(what) from None


def pose(where: str, element: Element, default: str) -> tuple[str, pin.SE3]:
    """Return the frame that an element's <pose> is relative to, and the placement in it."""
    where = f"{where}, <pose>"
    found = only(where, element, "pose")
    if found is None:
        return default, pin.SE3.Identity()
    relative_to = found.get("relative_to") or found.get("frame") or default
    text = (found.text or "").strip() or None
    rotation_format = found.get("rotation_format", "euler_rpy")
    if rotation_format == "quat_xyzw":
        values = numbers_in(where, text or "0 0 0 0 0 0 1", count=7)
        return relative_to, pin.SE3(_rotation_of(where, values[3:]), np.array(values[:3]))
    if rotation_format != "euler_rpy":
        got = f"`rotation_format` is {quoted(rotation_format)}"
        raise ModelFileError(f"{where}: {got}; euler_rpy and quat_xyzw are read")
    values = numbers_in(where, text or "0 0 0 0 0 0", count=6)
    unit = np.pi / 180.0 if truth(where, found.get("degrees", "false")) else 1.0
    return relative_to, pin.SE3(
        pin.rpy.rpyToMatrix(unit * np.array(values[3:])), np.array(values[:3])
    )


def _rotation_of(where: str, xyzw: list[float]) -> NDArray[np.float64]:
    length = float(np.linalg.norm(xyzw))
    if not abs(length - 1.0) < 1e-3:
        raise ModelFileError(f"{where}: the quaternion has length {length:g}, not 1")
    rotation: NDArray[np.float64] = pin.Quaternion(np.array(xyzw) / length).toRotationMatrix()
    return rotation


def truth(where: str, text: str) -> bool:
    """Return a yes or no as SDFormat writes it."""
    if (value := _SDF_TRUTHS.get(text.strip().lower())) is None:
        raise ModelFileError(f"{where}: {quoted(text)} is neither true nor false")
    return value
