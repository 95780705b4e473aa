"""TreeUrdf: writing a URDF whose links are placed where they are with all joints at zero."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from xml.etree.ElementTree import Element, SubElement

import pinocchio as pin

from pmjac_pin.files.joint_dialects import WITHOUT_LIMIT
from pmjac_pin.files.unused_name import unused_name
from pmjac_pin.files.xml_text import written


@dataclass(frozen=True)
class MovingAxis:
    """The axis of a joint in its own frame, and its limits in m or rad, where it has them."""

    axis: Iterable[float] | None = None
    limits: tuple[float, float] | None = None


STILL = MovingAxis()


class TreeUrdf:
    """A URDF in the making.

    Parameters
    ----------
    name : str
        The robot's name.
    root : str
        Its first link.
    placement : pin.SE3
        Of the root, in the coordinates in which all other placements are given.
    taken : iterable of str, optional
        Names that `unused` leaves alone, for what is still to come.

    Attributes
    ----------
    robot : Element

    Examples
    --------
    >>> tree = TreeUrdf("pendulum", "ground", pin.SE3.Identity())
    >>> hinge = pin.XYZQUATToSE3([0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0])
    >>> ends = ("ground", tree.link("rod", hinge))
    >>> tree.joint("swing", "continuous", ends, MovingAxis(axis=(0.0, 1.0, 0.0)))
    >>> tree.robot.find("joint/origin").get("xyz")
    '0.0 0.0 1.0'
    """

    def __init__(self, name: str, root: str, placement: pin.SE3, taken: Iterable[str] = ()) -> None:
        self.robot = Element("robot", name=name)
        self._placements: dict[str, pin.SE3] = {}
        self._links: dict[str, Element] = {}
        self._taken = set(taken)
        self.link(root, placement)

    def unused(self, name: str) -> str:
        """Return this name, with a number at its end if a link or a joint has it."""
        return unused_name(name, self._taken)

    def link(self, name: str, placement: pin.SE3) -> str:
        """Add a link and return its name."""
        self._links[name] = SubElement(self.robot, "link", name=name)
        self._placements[name] = placement
        self._taken.add(name)
        return name

    def joint(
        self, name: str, kind: str, ends: tuple[str, str], motion: MovingAxis = STILL
    ) -> None:
        """Add a joint from a link that is there to another; its frame is the second's."""
        joint = SubElement(self.robot, "joint", name=name, type=kind)
        self._taken.add(name)
        parent, child = ends
        SubElement(joint, "parent", link=parent)
        SubElement(joint, "child", link=child)
        SubElement(
            joint, "origin", origin(self._placements[parent].actInv(self._placements[child]))
        )
        if motion.axis is not None:
            SubElement(joint, "axis", xyz=written(motion.axis))
        if motion.limits is not None:
            lower, upper = (written([limit]) for limit in motion.limits)
            without = written([WITHOUT_LIMIT])
            limit = {"lower": lower, "upper": upper, "effort": without, "velocity": without}
            SubElement(joint, "limit", limit)

    def fixed(self, parent: str, name: str, placement: pin.SE3) -> str:
        """Add a link that is fixed to another, and return its name."""
        self.joint(self.unused(f"{name}_fixed"), "fixed", (parent, self.link(name, placement)))
        return name

    def visual(self, link: str, placement: pin.SE3, shape: Element, rgba: str | None) -> None:
        """Add a shape to a link, in the link's frame."""
        visual = SubElement(self._links[link], "visual")
        SubElement(visual, "origin", origin(placement))
        SubElement(visual, "geometry").append(shape)
        if rgba is not None:
            material = SubElement(visual, "material", name=rgba)
            SubElement(material, "color", rgba=rgba)

    def inertial(self, link: str, inertia: pin.Inertia) -> None:
        """Give a link its inertia, in the link's frame."""
        inertial = SubElement(self._links[link], "inertial")
        SubElement(inertial, "origin", xyz=written(inertia.lever), rpy="0 0 0")
        SubElement(inertial, "mass", value=written([inertia.mass]))
        moments = inertia.inertia
        keys = {f"i{'xyz'[k]}{'xyz'[m]}": moments[k, m] for k in range(3) for m in range(k, 3)}
        SubElement(inertial, "inertia", {key: written([value]) for key, value in keys.items()})


def undrawn(name: str) -> Element:
    """Return what stands for a shape that a URDF has not: a mesh, which nobody looks into.

    It is there to be seen, so that its body is not taken to look the same when turned over.
    """
    return Element("mesh", filename=name)


def origin(placement: pin.SE3) -> dict[str, str]:
    """Return the attributes of URDF's <origin>."""
    rpy = pin.rpy.matrixToRpy(placement.rotation)
    return {"xyz": written(placement.translation), "rpy": written(rpy)}
