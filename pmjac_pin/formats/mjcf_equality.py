"""The loop closures of MJCF: <connect> and <weld> of <equality>.

MuJoCo holds two bodies as they are to each other at qpos0: the file gives a point of one of them,
and the other's is where that is then (MuJoCo, XML reference, equality/connect and /weld).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from pmjac_pin.errors import ModelFileError, did_you_mean
from pmjac_pin.formats.mjcf_bodies import Body
from pmjac_pin.formats.mjcf_defaults import Defaults
from pmjac_pin.formats.mjcf_frames import Compiler, truth
from pmjac_pin.formats.mjcf_names import WORLD, find_name
from pmjac_pin.formats.mjcf_tree import MjcfTree
from pmjac_pin.loop_spec import FrameLoop, Loop, PointLoop
from pmjac_pin.urdf_checks import MAXIMAL_LINKS
from pmjac_pin.urdf_xml import numbers, shown

_READ = ("connect", "weld", "joint")
_NOT_READ = ("distance", "flex", "flexstrain", "flexvert", "tendon")
_AT_QPOS0 = "0 1 0 0 0 0 0"  # a relpose whose quaternion is zero


def active_equalities(root: Element, defaults: Defaults) -> tuple[list[Element], list[str]]:
    """Return the constraints that hold, with their defaults, and a note for each other one.

    Raises
    ------
    ModelFileError
        One that holds and is none of a loop's.
    """
    active, notes = [], []
    for flag in root.iterfind("option/flag"):
        if "disable" in (flag.get("equality"), flag.get("constraint")):
            notes.append("<flag> disables the constraints; they are read all the same")
    for given in root.iterfind("equality/*"):
        element = defaults.complete(given, tag="equality")
        where = called(element)
        if element.tag not in (*_READ, *_NOT_READ):
            known = did_you_mean(element.tag, _READ)
            what = f"<equality> holds an unknown <{shown(element.tag)[1:-1]}>"
            raise ModelFileError(f"{what}{known}")
        if not truth(where, "active", element.get("active", "true")):
            notes.append(f"{where} is not active, and left out")
        elif element.tag in _NOT_READ:
            todo = 'set active="false" to leave it out'
            raise ModelFileError(f"{where} is not read, only {', '.join(_READ)} are; {todo}")
        else:
            active.append(element)
    if len(active) > MAXIMAL_LINKS:
        what = f"{len(active)} equality constraints are too many"
        raise ModelFileError(f"{what}; at most {MAXIMAL_LINKS} are read")
    return active, notes


def read_closures(
    equalities: Sequence[Element], compiler: Compiler, bodies: Sequence[Body], tree: MjcfTree
) -> list[Loop]:
    """Return the loops of every <connect> and <weld>, whose frames are added to the tree.

    Raises
    ------
    ModelFileError
        A body or site that does not exist, or one joined to itself.
    """
    closures = _Closures(compiler, bodies, tree)
    return [closures.loop(element) for element in equalities if element.tag != "joint"]


def called(element: Element) -> str:
    """Return how messages call a constraint: by its name, or by what it joins."""
    if name := element.get("name"):
        return f"<{element.tag}> {shown(name)}"
    keys = ("body1", "body2", "site1", "site2", "joint1", "joint2")
    ends = [f"{key}={shown(element.get(key, ''))}" for key in keys if element.get(key)]
    return f"<{' '.join([element.tag, *ends])}>"


class _Closures:
    def __init__(self, compiler: Compiler, bodies: Sequence[Body], tree: MjcfTree) -> None:
        self._compiler, self._tree = compiler, tree
        self._bodies: Mapping[str, str] = {body.name: body.name for body in bodies}
        self._sites: Mapping[str, str] = {
            site.name: site.link for body in bodies for site in body.sites if site.name
        }

    def loop(self, element: Element) -> Loop:
        where = called(element)
        by_site = element.get("site1") is not None or element.get("site2") is not None
        given = [key for key in ("body1", "body2", "anchor", "relpose") if element.get(key)]
        if by_site and given:
            raise ModelFileError(f"{where}: give `site1` and `site2`, or `{given[0]}`, not both")
        first, second = self._sites_of(where, element) if by_site else self._points(where, element)
        turns = element.tag == "weld" and self._scale(where, element) != 0.0
        return (FrameLoop if turns else PointLoop)(frames=(first, second))

    def _scale(self, where: str, element: Element) -> float:
        return numbers(where, element, "torquescale", default="1")[0]

    def _sites_of(self, where: str, element: Element) -> list[str]:
        return self._ends(where, element, "site", self._sites, "")

    def _points(self, where: str, element: Element) -> list[str]:
        """Return the frames of the form with bodies."""
        ends = self._ends(where, element, "body", self._bodies, WORLD)
        wishes = (f"{ends[0]}_at_{ends[1]}", f"{ends[1]}_at_{ends[0]}")
        places = self._connected if element.tag == "connect" else self._welded
        placements = places(where, element, ends)
        return [
            self._tree.anchor(body, wish, placement)
            for body, wish, placement in zip(ends, wishes, placements, strict=True)
        ]

    def _connected(self, where: str, element: Element, ends: list[str]) -> list[pin.SE3]:
        point = pin.SE3(np.eye(3), np.array(numbers(where, element, "anchor", count=3)))
        seen = self._seen(ends[0], ends[1], point)
        return [point, pin.SE3(np.eye(3), seen.translation)]

    def _welded(self, where: str, element: Element, ends: list[str]) -> list[pin.SE3]:
        anchor = numbers(where, element, "anchor", default="0 0 0", count=3)
        point = pin.SE3(np.eye(3), np.array(anchor))
        pose = numbers(where, element, "relpose", default=_AT_QPOS0, count=7)
        if not any(pose[3:]):
            return [self._seen(ends[1], ends[0], point), point]
        # MuJoCo takes relpose's translation for the anchor on the first body as it is, even where
        # the second body's anchor is not at its origin.
        given = {"pos": " ".join(map(repr, pose[:3])), "quat": " ".join(map(repr, pose[3:]))}
        return [self._compiler.placement(where, Element("relpose", given)), point]

    def _seen(self, body: str, other: str, placement: pin.SE3) -> pin.SE3:
        """Return a place on a body as another body sees it at qpos0."""
        qpos0 = self._tree.qpos0
        return qpos0[other].actInv(qpos0[body] * placement)

    def _ends(
        self, where: str, element: Element, kind: str, known: Mapping[str, str], default: str
    ) -> list[str]:
        names = []
        for key, other in ((f"{kind}1", ""), (f"{kind}2", default)):
            if not (name := element.get(key, other)):
                raise ModelFileError(f"{where} has no `{key}`")
            names.append(find_name(f"{where}: the {kind}", name, known))
        if names[0] == names[1]:
            raise ModelFileError(f"{where} joins {kind} {shown(names[0])} to itself")
        return names
