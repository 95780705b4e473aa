"""The masses of MJCF: <inertial>, or else the geoms' as MuJoCo infers them.

A geom is a solid of its density, 1000 kg/m³ by default, or of its mass; of <compiler>,
`inertiafromgeom`, `inertiagrouprange`, `boundmass`, `boundinertia`, `balanceinertia` and
`settotalmass` count (MuJoCo, XML reference, compiler and body/inertial). Meshes are not opened.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass, field
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from pmjac_pin.formats.inertia import inertia_at
from pmjac_pin.formats.joint_dialects import listed
from pmjac_pin.formats.massless import without_mass
from pmjac_pin.formats.mjcf_frames import Compiler, truth
from pmjac_pin.formats.mjcf_shapes import SOLIDS, half_sizes
from pmjac_pin.urdf_xml import numbers

Array = NDArray[np.float64]

_DENSITY = "1000"
_FLAT = ("plane", "hfield")  # without volume
_DIAGONAL = 3
_FULL = 6


@dataclass(frozen=True)
class MassRules:
    """What <compiler> says of masses.

    Attributes
    ----------
    from_geoms : bool or None
        Always, never, or where there is no <inertial>.
    groups : tuple of float
        The first and the last group of geoms that have a mass.
    least_mass, least_inertia : float
        kg and kg m².
    balance : bool
        Moments that no body can have are replaced by their mean.
    total : float or None
        The mass of all bodies together, kg.
    """

    from_geoms: bool | None
    groups: tuple[float, float]
    least_mass: float
    least_inertia: float
    balance: bool
    total: float | None

    @classmethod
    def of(cls, root: Element) -> MassRules:
        """Return the rules of <mujoco>; where there are several <compiler>, the last counts."""
        given = Element("compiler")
        for element in root.iterfind("compiler"):
            given.attrib.update(element.attrib)
        where, wanted = "<compiler>", given.get("inertiafromgeom", "auto")
        low, high = numbers(where, given, "inertiagrouprange", default="0 5", count=2)
        (total,) = numbers(where, given, "settotalmass", default="-1")
        return cls(
            None if wanted == "auto" else truth(where, "inertiafromgeom", wanted),
            (low, high),
            numbers(where, given, "boundmass", default="0")[0],
            numbers(where, given, "boundinertia", default="0")[0],
            truth(where, "balanceinertia", given.get("balanceinertia", "false")),
            total if total > 0.0 else None,
        )

    def corrected(self, inertia: pin.Inertia) -> pin.Inertia:
        """Return a body's inertia within these bounds."""
        moments, axes = np.linalg.eigh(inertia.inertia)
        moments = np.maximum(moments, self.least_inertia)
        if self.balance and moments[0] + moments[1] < moments[2]:
            moments[:] = moments.mean()
        mass = max(inertia.mass, self.least_mass)
        return pin.Inertia(mass, inertia.lever, axes @ np.diag(moments) @ axes.T)


@dataclass
class BodyMass:
    """What a body's mass is made of: its <inertial>, its geoms, and geoms that are not read."""

    given: pin.Inertia | None = None
    solids: list[pin.Inertia] = field(default_factory=list)
    unknown: bool = False

    def add(self, solid: pin.Inertia | None) -> None:
        """Add a geom; None for one that is not known."""
        if solid is None:
            self.unknown = True
        else:
            self.solids.append(solid)

    def inertia(self, rules: MassRules) -> pin.Inertia | None:
        """Return the inertia in the body's frame; None for none."""
        found = self.given
        if rules.from_geoms is True or (rules.from_geoms is None and found is None):
            found = _sum(self.solids)
        if found is None and not (rules.least_mass or rules.least_inertia):
            return None
        return rules.corrected(found or pin.Inertia.Zero())


def inertias(
    bodies: Mapping[str, BodyMass], moving: Container[str], rules: MassRules
) -> tuple[dict[str, pin.Inertia], list[str]]:
    """Return the inertia of each body that has one, in the body's frame, and notes.

    `moving` are the bodies with joints, of which none is told that it has no mass.
    """
    found = {name: mass.inertia(rules) for name, mass in bodies.items()}
    known = {name: inertia for name, inertia in found.items() if inertia is not None}
    total = sum(inertia.mass for inertia in known.values())
    if rules.total is not None and total > 0.0:
        known = {name: _scaled(inertia, rules.total / total) for name, inertia in known.items()}
    guessed = [
        name
        for name, mass in bodies.items()
        if mass.unknown and (mass.given is None or rules.from_geoms is True)
    ]
    notes = []
    if guessed:
        what = "geoms that are no solid sphere, capsule, cylinder, box or ellipsoid"
        notes.append(f"the mass of {what} is left out of {listed(guessed)}")
    points = [name for name, body in known.items() if body.mass > 0.0 and not body.inertia.any()]
    if points:
        notes.append(f"no moments of inertia are given for {listed(points)}: they are 0 in `model`")
    none = [name for name in bodies if name in moving and name not in {*known, *guessed}]
    return known, [*notes, *without_mass(none)]


def read_inertial(where: str, element: Element, frame: pin.SE3, compiler: Compiler) -> pin.Inertia:
    """Return what an <inertial> in a frame of its body says.

    Raises
    ------
    ModelFileError
        A number that is none, or no mass.
    """
    (mass,) = numbers(where, element, "mass")
    if element.get("fullinertia") is not None:
        xx, yy, zz, xy, xz, yz = numbers(where, element, "fullinertia", count=_FULL)
        moments = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    else:
        given = numbers(where, element, "diaginertia", default="0 0 0", count=_DIAGONAL)
        moments = np.diag(given)
    return inertia_at(where, mass, moments, frame * compiler.placement(where, element))


def read_solid(
    where: str, geom: Element, placement: pin.SE3, rules: MassRules
) -> pin.Inertia | None:
    """Return the inertia of a geom with its defaults; None where it is not known.

    Raises
    ------
    ModelFileError
        A number that is none.
    """
    kind = geom.get("type", "sphere")
    (group,) = numbers(where, geom, "group", default="0")
    given = geom.get("mass") is not None
    (mass,) = numbers(where, geom, "mass", default="0")
    (density,) = numbers(where, geom, "density", default=_DENSITY)
    outside = not rules.groups[0] <= group <= rules.groups[1]
    if kind in _FLAT or outside or (mass if given else density) == 0.0:
        return pin.Inertia.Zero()
    shell = truth(where, "shellinertia", geom.get("shellinertia", "false"))
    if kind not in SOLIDS or geom.get("mesh") is not None or shell:
        return None
    volume, unit_moments = _VOLUMES[kind](*half_sizes(geom))
    mass = mass if given else density * volume
    return inertia_at(where, mass, mass * np.diag(unit_moments), placement)


def _scaled(inertia: pin.Inertia, factor: float) -> pin.Inertia:
    return pin.Inertia(factor * inertia.mass, inertia.lever, factor * inertia.inertia)


def _sum(solids: Sequence[pin.Inertia]) -> pin.Inertia | None:
    total = None
    for solid in solids:
        if solid.mass > 0.0:
            total = solid if total is None else total + solid
    return total


def _sphere(radius: float) -> tuple[float, Array]:
    return 4.0 / 3.0 * math.pi * radius**3, np.full(3, 0.4 * radius**2)


def _box(x: float, y: float, z: float) -> tuple[float, Array]:
    return 8.0 * x * y * z, np.array([y * y + z * z, x * x + z * z, x * x + y * y]) / 3.0


def _ellipsoid(x: float, y: float, z: float) -> tuple[float, Array]:
    squares = np.array([y * y + z * z, x * x + z * z, x * x + y * y])
    return 4.0 / 3.0 * math.pi * x * y * z, squares / 5.0


def _cylinder(radius: float, half: float) -> tuple[float, Array]:
    across = radius**2 / 4.0 + half**2 / 3.0
    return 2.0 * math.pi * radius**2 * half, np.array([across, across, radius**2 / 2.0])


def _capsule(radius: float, half: float) -> tuple[float, Array]:
    """Return those of a cylinder with half a sphere at each end."""
    (tube, moments), (ball, ball_moments) = _cylinder(radius, half), _sphere(radius)
    share = ball / (tube + ball)
    # The centre of half a sphere is 3/8 of its radius from the flat side.
    across = half**2 + 0.75 * radius * half
    ends = ball_moments + np.array([across, across, 0.0])
    return tube + ball, (1.0 - share) * moments + share * ends


_VOLUMES: Mapping[str, Callable[..., tuple[float, Array]]] = {
    "sphere": _sphere,
    "box": _box,
    "ellipsoid": _ellipsoid,
    "cylinder": _cylinder,
    "capsule": _capsule,
}
