"""The bodies of an MJCF model with their joints, sites and geoms, in MuJoCo's order."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any
from xml.etree.ElementTree import Element

import pinocchio as pin

from pmjac_pin.files.mjcf.joints import MjcfJoint, joint_of
from pmjac_pin.files.mjcf.mujoco import Compiled
from pmjac_pin.files.mjcf.names import JOINT_TYPES, Names
from pmjac_pin.files.tree_urdf import undrawn
from pmjac_pin.files.xml_text import written
from pmjac_pin.values.arrays import Array

MAXIMAL_GEOMS = 2000

# Those that a URDF has, by their number in mujoco.mjtGeom.
_GEOMS = {2: "sphere", 3: "capsule", 5: "cylinder", 6: "box"}
_NO_COLOUR = (0.5, 0.5, 0.5, 1.0)  # MuJoCo's, where nothing is given
_SINGLE_DIGITS = 6  # of single precision


@dataclass(frozen=True, eq=False)
class Body:
    """A body: its parent's name, and its pose on the parent at MuJoCo's qpos0.

    Attributes
    ----------
    name, parent : str
        The world has no parent.
    placement : pin.SE3
    joints : list of MjcfJoint
    sites : list of (str, pin.SE3)
        Each one's link, and its pose on the body.
    shapes : list of (Element, pin.SE3, str or None)
        What is there to be seen, with its pose on the body and its colour.
    """

    name: str
    parent: str
    placement: pin.SE3
    joints: list[MjcfJoint] = field(default_factory=list)
    sites: list[tuple[str, pin.SE3]] = field(default_factory=list)
    shapes: list[tuple[Element, pin.SE3, str | None]] = field(default_factory=list)


def read_bodies(compiled: Compiled, names: Names) -> list[Body]:
    """Return the world and all bodies, parents first."""
    model = compiled.model
    bodies = [
        Body(name, names.bodies[parent] if number else "", place(position, quaternion))
        for number, (name, parent, position, quaternion) in enumerate(
            zip(names.bodies, model.body_parentid, model.body_pos, model.body_quat, strict=True)
        )
    ]
    for number, name in enumerate(names.joints):
        bodies[model.jnt_bodyid[number]].joints.append(joint_of(model, number, name))
    for number, name in enumerate(names.sites):
        placement = place(model.site_pos[number], model.site_quat[number])
        bodies[model.site_bodyid[number]].sites.append((name, placement))
    for number in range(min(model.ngeom, MAXIMAL_GEOMS)):
        body, kind = bodies[model.geom_bodyid[number]], int(model.geom_type[number])
        drawn = shape(kind, model.geom_size[number].tolist())
        _draw(body, model, number, undrawn("mesh") if number in compiled.meshes else drawn)
    for number in sorted(set(model.geom_bodyid[MAXIMAL_GEOMS:].tolist())):
        bodies[number].shapes.append((undrawn("more geoms"), pin.SE3.Identity(), None))
    return bodies


def body_notes(model: Any, names: Names) -> Iterator[str]:
    """Yield what is to be said of what is not read."""
    for number, name in enumerate(names.bodies):
        if model.body_mocapid[number] >= 0:
            yield f"mocap body {name!r} stands still"
    for number, name in enumerate(names.joints):
        if model.jnt_limited[number] and JOINT_TYPES[model.jnt_type[number]] == "ball":
            yield f"the range of ball joint {name!r} is left out"
    if model.ngeom > MAXIMAL_GEOMS:
        yield f"only the first {MAXIMAL_GEOMS} geoms are kept for the picture"


def place(position: Array, wxyz: Array) -> pin.SE3:
    """Return MuJoCo's position and quaternion as a placement."""
    return pin.SE3(pin.Quaternion(*wxyz.tolist()).toRotationMatrix(), position.copy())


def _draw(body: Body, model: Any, number: int, drawn: Element) -> None:
    rgba = tuple(round(float(value), _SINGLE_DIGITS) for value in model.geom_rgba[number])
    colour = None if rgba == _NO_COLOUR else written(rgba)
    body.shapes.append((drawn, place(model.geom_pos[number], model.geom_quat[number]), colour))


def shape(kind: int, size: Sequence[float]) -> Element:
    """Return the shape of a geom; one that is not drawn where a URDF has none.

    MuJoCo's sizes are half-lengths, a URDF's are whole ones.

    Examples
    --------
    >>> shape(3, [0.1, 0.5, 0.0]).attrib
    {'radius': '0.1', 'length': '1.0'}
    >>> shape(7, [0.0, 0.0, 0.0]).tag
    'mesh'
    """
    if (name := _GEOMS.get(kind)) is None:
        return undrawn(f"geom of type {kind}")
    if name == "sphere":
        return Element(name, radius=written(size[:1]))
    if name == "box":
        return Element(name, size=written(2.0 * side for side in size))
    return Element(name, radius=written(size[:1]), length=written([2.0 * size[1]]))
