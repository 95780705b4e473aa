"""The bodies of an MJCF model with their joints, sites and geoms, in MuJoCo's order."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.etree.ElementTree import Element

import pinocchio as pin

from pmjac_pin.errors import ModelFileError, did_you_mean
from pmjac_pin.formats.mjcf_defaults import Defaults
from pmjac_pin.formats.mjcf_frames import Compiler, truth
from pmjac_pin.formats.mjcf_joints import MjcfJoint, read_joint
from pmjac_pin.formats.mjcf_masses import BodyMass, MassRules, read_inertial, read_solid
from pmjac_pin.formats.mjcf_names import WORLD, Names
from pmjac_pin.urdf_checks import MAXIMAL_LINKS
from pmjac_pin.urdf_xml import shown

MAXIMAL_GEOMS = 2000

_IGNORED = ("camera", "light", "plugin")
_READ = ("body", "frame", "geom", "site", "joint", "freejoint", "inertial", *_IGNORED)
_GENERATED = ("attach", "composite", "flexcomp", "replicate")


@dataclass(frozen=True, eq=False)
class Fixture:
    """A site or a geom: the element with its defaults, and its pose on the body."""

    element: Element
    placement: pin.SE3


@dataclass(frozen=True, eq=False)
class Site:
    """A site: its name in the file, which may be "", and that of its link."""

    name: str
    link: str
    placement: pin.SE3


@dataclass(frozen=True, eq=False)
class Body:
    """A body: its parent's name, and its pose on the parent at MuJoCo's qpos0.

    `stem` is the nearest name that the file gives, from which those of nameless bodies are made.
    """

    name: str
    parent: str
    stem: str
    placement: pin.SE3
    joints: list[MjcfJoint] = field(default_factory=list)
    sites: list[Site] = field(default_factory=list)
    geoms: list[Fixture] = field(default_factory=list)
    mass: BodyMass = field(default_factory=BodyMass)


@dataclass(frozen=True)
class _Within:
    """Where an element stands: on which body, in which frame of it, in which default class."""

    body: Body
    placement: pin.SE3
    childclass: str


def read_bodies(
    root: Element, compiler: Compiler, defaults: Defaults, names: Names
) -> tuple[list[Body], list[str]]:
    """Return the world, with no parent, and all bodies, parents first; and notes.

    Raises
    ------
    ModelFileError
        An element that is not known, or one that only MuJoCo can multiply out.
    """
    sections = root.findall("worldbody")
    tags = ("body", "site", "joint", "freejoint")
    count = sum(element.tag in tags for section in sections for element in section.iter())
    if count > MAXIMAL_LINKS:
        what = f"{count} bodies, sites and joints are too many"
        raise ModelFileError(f"{what}; at most {MAXIMAL_LINKS} links are read")
    walk = _Walk(compiler, defaults, names, MassRules.of(root))
    for section in sections:
        walk.into(section, _Within(walk.bodies[0], pin.SE3.Identity(), ""))
    return walk.bodies, walk.notes


class _Walk:
    """One pass through <worldbody>; the nesting of its elements is bounded by the parser."""

    def __init__(
        self, compiler: Compiler, defaults: Defaults, names: Names, rules: MassRules
    ) -> None:
        self._compiler, self._defaults, self._names = compiler, defaults, names
        self._rules = rules
        self.bodies = [Body(WORLD, "", WORLD, pin.SE3.Identity())]
        self.notes: list[str] = []
        self._geoms = 0

    def into(self, element: Element, within: _Within) -> None:
        """Read what a body holds, then its bodies, as MuJoCo counts the joints."""
        contents = list(self._contents(element, within))
        for child, place in contents:
            if child.tag != "body":
                self._fix(child, place)
        for child, place in contents:
            if child.tag == "body":
                self._body(child, place)

    def _contents(self, element: Element, within: _Within) -> Iterator[tuple[Element, _Within]]:
        """Yield the children, those of a <frame> in its stead."""
        for child in element:
            if child.tag in _GENERATED:
                todo = "save the model from MuJoCo (mj_saveLastXML) and read that"
                raise ModelFileError(f"<{child.tag}> is not read; {todo}")
            if child.tag not in _READ:
                known = did_you_mean(child.tag, _READ)
                raise ModelFileError(
                    f"{_where(element, within)} holds an unknown <{child.tag}>{known}"
                )
            if child.tag == "frame":
                yield from self._contents(child, self._inside(child, within))
            else:
                yield child, within

    def _inside(self, frame: Element, within: _Within) -> _Within:
        where = _where(frame, within)
        placement = within.placement * self._compiler.placement(where, frame)
        return _Within(within.body, placement, self._childclass(frame, within))

    def _childclass(self, element: Element, within: _Within) -> str:
        if (name := element.get("childclass", "")) != "":
            self._defaults.check(_where(element, within), name)
        return name or within.childclass

    def _fix(self, child: Element, within: _Within) -> None:
        if child.tag in _IGNORED:
            return
        if child.tag == "inertial":
            self._inertial(child, within)
            return
        element, body = self._defaults.complete(child, within.childclass), within.body
        if child.tag in ("joint", "freejoint"):
            body.joints.append(self._joint(element, within))
            return
        placement = within.placement * self._compiler.placement(_where(child, within), element)
        if child.tag == "geom":
            self._draw(Fixture(element, placement), body)
            solid = read_solid(_where(child, within), element, placement, self._rules)
            body.mass.add(solid)
        elif name := element.get("name", ""):
            body.sites.append(Site(name, self._names.site(name), placement))
        else:
            body.sites.append(Site("", self._names.new(f"{body.name}_site"), placement))

    def _inertial(self, child: Element, within: _Within) -> None:
        mass, where = within.body.mass, _where(child, within)
        if mass.given is not None:
            raise ModelFileError(f"{where}: there is another; give one")
        mass.given = read_inertial(where, child, within.placement, self._compiler)

    def _draw(self, geom: Fixture, body: Body) -> None:
        self._geoms += 1
        if self._geoms <= MAXIMAL_GEOMS:
            body.geoms.append(geom)
        elif self._geoms == MAXIMAL_GEOMS + 1:
            self.notes.append(f"only the first {MAXIMAL_GEOMS} geoms are kept for the picture")

    def _joint(self, element: Element, within: _Within) -> MjcfJoint:
        where, body = _where(element, within), within.body
        kind = "free" if element.tag == "freejoint" else element.get("type", "hinge")
        if body.name == WORLD:
            raise ModelFileError(f"{where}: the world cannot have joints")
        if kind == "free" and (body.parent != WORLD or body.joints):
            what = "a free joint is the only joint of a body that stands in <worldbody>"
            raise ModelFileError(f"{where}: {what}")
        if body.joints and body.joints[0].kind == "free":
            raise ModelFileError(f"{where}: the body moves freely already")
        name = element.get("name") or self._names.new(f"{body.name}_{kind}")
        if kind == "ball" and element.get("range") is not None:
            self.notes.append(f"the range of ball joint {name!r} is left out")
        return read_joint(where, element, (name, kind), within.placement, self._compiler)

    def _body(self, element: Element, within: _Within) -> None:
        parent, given, where = within.body, element.get("name", ""), _where(element, within)
        name = given or self._names.new(f"{parent.stem}_body")
        placement = within.placement * self._compiler.placement(where, element)
        body = Body(name, parent.name, given or parent.stem, placement)
        self.bodies.append(body)
        if truth(where, "mocap", element.get("mocap", "false")):
            self.notes.append(f"mocap body {name!r} stands still")
        childclass = self._childclass(element, within)
        self.into(element, _Within(body, pin.SE3.Identity(), childclass))
        self._refuse_aligned(element, body)

    def _refuse_aligned(self, element: Element, body: Body) -> None:
        """Refuse a body whose frame MuJoCo moves to where the inertia is."""
        default = "true" if self._compiler.alignfree else "false"
        typed = ["auto" for joint in body.joints if joint.kind == "free"]
        free = [joint.get("align", "auto") for joint in element.iter("freejoint")] or typed
        aligned = "true" in [default if align == "auto" else align for align in free]
        if aligned and element.find(".//body") is None:
            why = "MuJoCo would move its frame to its inertia's"
            raise ModelFileError(f"body {body.name!r}: `align` is not read ({why}); remove it")


def _where(element: Element, within: _Within) -> str:
    """Return how messages call an element: by its name, or by the body that it is on."""
    if name := element.get("name", ""):
        return f"{element.tag} {shown(name)}"
    return f"<{element.tag}> on body {shown(within.body.name)}"
