"""Loops as MuJoCo's equality constraints: which kind becomes what.

A point is a <connect> of two sites, a frame a <weld>; a hinge two <connect>, of two points on its
axis (one row more than it needs); a rod between two points a <tendon> held at its length. A cross
is a <connect>, and a rod between the ends of its two axes, which is as long as the diagonal of a
square where they are perpendicular. Other kinds have a hub: `pmjac_pin.studies.export.hubs`.
All of them are exact: closed where ours are, and at rates that ours allow.
"""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from pmjac_pin.files.unused_name import unused_name
from pmjac_pin.files.xml_text import written
from pmjac_pin.model.loop_between_frames import LoopBetweenFrames
from pmjac_pin.model.loop_spec import (
    DistanceLoop,
    FrameLoop,
    JointLoop,
    PointLoop,
    RevoluteLoop,
    UniversalLoop,
)
from pmjac_pin.studies.export.closable import with_point_on_axis
from pmjac_pin.studies.export.plain_machine import PlainMachine
from pmjac_pin.values.arrays import Array

#: Kinds of loops that need no hub, beside gears.
MJCF_LOOPS = (PointLoop, FrameLoop, RevoluteLoop, UniversalLoop, DistanceLoop)


def closed_by_equalities(machine: PlainMachine) -> tuple[PlainMachine, Element, Element]:
    """Return the machine with all sites that its loops need, its <equality> and its <tendon>.

    Parameters
    ----------
    machine : PlainMachine
        Its loops are of `MJCF_LOOPS`.
    """
    machine, sites = _with_sites(machine)
    equalities = _Equalities(machine, sites)
    for loop in machine.loops:
        equalities.add(loop)
    return equalities.machine, equalities.equality, equalities.tendons


def _with_sites(machine: PlainMachine) -> tuple[PlainMachine, Mapping[str, str]]:
    """Return the machine with a site at each frame of a loop, and their names.

    A frame is a site of its name; a body's own gets one of another.
    """
    bodies, taken = {body.name for body in machine.bodies}, machine.taken
    between = (loop for loop in machine.loops if isinstance(loop, LoopBetweenFrames))
    sites = {name: name for loop in between for name in loop.frames}
    for name in sites.keys() & bodies:
        sites[name] = unused_name(f"{name}_site", taken)
        machine = machine.with_frame(sites[name], *machine.frames[name])
    return machine, sites


class _Equalities:
    """Writes loops one by one."""

    def __init__(self, machine: PlainMachine, sites: Mapping[str, str]) -> None:
        self.machine, self._sites = machine, sites
        self.equality, self.tendons = Element("equality"), Element("tendon")
        self._names: set[str] = set()

    def add(self, loop: LoopBetweenFrames | JointLoop) -> None:
        if isinstance(loop, JointLoop):
            self._gear(loop)
            return
        first, second = sites = tuple(self._sites[name] for name in loop.frames)
        label = unused_name("-".join(loop.frames), self._names)
        match loop:
            case PointLoop():
                self._connect(label, first, second)
            case FrameLoop():
                SubElement(self.equality, "weld", name=label, site1=first, site2=second)
            case RevoluteLoop():
                self._connect(label, first, second)
                one, other = (self._point(site, np.array(loop.axis)) for site in sites)
                self._connect(unused_name(f"{label}_axis", self._names), one, other)
            case UniversalLoop():
                self._connect(label, first, second)
                ends = zip(sites, loop.axes, strict=True)
                one, other = (self._point(site, np.array(axis)) for site, axis in ends)
                diagonal = np.sqrt(2.0) * self.machine.length
                self._rod(unused_name(f"{label}_cross", self._names), one, other, diagonal)
            case DistanceLoop():
                self._rod(label, first, second, loop.resolved_length({}))
            case _:
                raise AssertionError(f"{loop} has a hub")

    def _connect(self, label: str, first: str, second: str) -> None:
        SubElement(self.equality, "connect", name=label, site1=first, site2=second)

    def _point(self, site: str, axis: Array) -> str:
        """Return a site on an axis through another."""
        self.machine, name = with_point_on_axis(self.machine, site, axis)
        return name

    def _rod(self, label: str, first: str, second: str, length: float) -> None:
        """Hold a tendon at its length; MuJoCo counts from that with all joints at zero."""
        tendon = SubElement(self.tendons, "spatial", name=label)
        placed = self.machine.placements(None)
        points = []
        for site in (first, second):
            SubElement(tendon, "site", site=site)
            body, place = self.machine.frames[site]
            points.append((placed[body] * place).translation)
        at_zero = float(np.linalg.norm(points[0] - points[1]))
        terms = written([length - at_zero, 0.0, 0.0, 0.0, 0.0])
        SubElement(self.equality, "tendon", name=label, tendon1=label, polycoef=terms)

    def _gear(self, loop: JointLoop) -> None:
        driver, follower = loop.joints
        label = unused_name("-".join(loop.joints), self._names)
        terms = written([loop.offset, loop.ratio, 0.0, 0.0, 0.0])
        ends = {"joint1": follower, "joint2": driver}
        SubElement(self.equality, "joint", ends, name=label, polycoef=terms)
