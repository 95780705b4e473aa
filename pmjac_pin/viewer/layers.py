"""Layers: groups of items that get their transforms in the same way, all at once."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.configuration import Configuration
from pmjac_pin.files.shapes import Colour, Shape, Text
from pmjac_pin.pictures.bodies import PointsOfBodies
from pmjac_pin.pictures.within_limits import ToolQuantity
from pmjac_pin.rates.ellipsoid import Ellipsoid
from pmjac_pin.rates.solid import Solid
from pmjac_pin.values.arrays import Array, Index
from pmjac_pin.viewer.facets import Facets
from pmjac_pin.viewer.items import Part, stretched_between

SolidKind = Literal["velocity", "force"]

SPECK = 1e-6  # of the mechanism's size: what is smaller is hidden


@dataclass(frozen=True, eq=False, slots=True)
class DrawnPose:
    """What the layers draw.

    Attributes
    ----------
    configuration : Configuration
    ellipsoids : mapping of str to Ellipsoid
        By kind, those that are drawn; none where no J_eq exists.
    directions : mapping of str to ndarray, shape (3, 3)
        In columns, to which side the arrows of their axes point.
    placements : ndarray, shape (njoints + 1, 4, 4)
        oMi of all joints, and the tool's pose as the last.
    scale : float
        Of ellipsoids and polytopes, relative to the automatic one.
    solids : mapping of str to Solid
        By kind, the polytopes that are drawn.
    force : ndarray, shape (3,)
        On the tool, N, in the world.
    """

    configuration: Configuration
    ellipsoids: Mapping[ToolQuantity, Ellipsoid]
    directions: Mapping[ToolQuantity, Array]
    placements: Array
    scale: float
    solids: Mapping[SolidKind, Solid]
    force: Array

    @property
    def tool(self) -> Array:
        """The tool's position, shape (3,)."""
        position: Array = self.placements[-1, :3, 3]
        return position


@dataclass(frozen=True, eq=False, slots=True)
class Drawing:
    """Where the parts of a layer stand at one pose.

    Attributes
    ----------
    transforms : ndarray, shape (k, 4, 4)
    visible : ndarray of bool, shape (k,)
    shapes : mapping of int to Shape or Facets
        Of those parts that have another one at every pose, by their place in the layer.
    """

    transforms: Array
    visible: NDArray[np.bool_]
    shapes: Mapping[int, Shape | Facets] = field(default_factory=dict)


class Layer(Protocol):
    """Some items, the same ones at every pose."""

    @property
    def parts(self) -> Sequence[Part]:
        """What never changes."""
        ...

    def draw(self, pose: DrawnPose) -> Drawing:
        """Return where the parts stand."""
        ...


@dataclass(frozen=True, eq=False)
class Attached:
    """Parts that are fixed to bodies; index −1 is the tool.

    Attributes
    ----------
    parts : sequence of Part
    bodies : ndarray of int, shape (k,)
    places : ndarray, shape (k, 4, 4)
        Transforms in the bodies, the parts' scales included.
    """

    parts: Sequence[Part]
    bodies: Index
    places: Array

    @classmethod
    def of(cls, pieces: Iterable[tuple[Part, int, Array]]) -> Attached:
        """Stack parts, each with its body and its transform there."""
        parts, bodies, places = zip(*pieces, strict=True) if (pieces := [*pieces]) else ((),) * 3
        stack = np.array(places, dtype=np.float64).reshape(-1, 4, 4)
        return cls(distinct_parts(parts), np.array(bodies, dtype=np.intp), stack)

    def draw(self, pose: DrawnPose) -> Drawing:
        """Move the parts with their bodies."""
        transforms = pose.placements[self.bodies] @ self.places
        return Drawing(transforms, np.ones(len(transforms), dtype=bool))


@dataclass(frozen=True, eq=False)
class MidwayLabels:
    """Words midway between points of bodies and points of bodies."""

    parts: Sequence[Part]
    starts: PointsOfBodies
    ends: PointsOfBodies
    height: float

    def draw(self, pose: DrawnPose) -> Drawing:
        """Put the words there."""
        positions = 0.5 * (self.starts.at(pose.placements) + self.ends.at(pose.placements))
        return Drawing(lettering(positions, self.height), np.ones(len(positions), dtype=bool))


@dataclass(frozen=True, eq=False)
class Lines:
    """Cylinders from points of bodies to points of bodies.

    Attributes
    ----------
    parts : sequence of Part
    starts, ends : Points
    radii : ndarray, shape (k,)
    smallest : float
        What is shorter is hidden.
    """

    parts: Sequence[Part]
    starts: PointsOfBodies
    ends: PointsOfBodies
    radii: Array
    smallest: float

    def draw(self, pose: DrawnPose) -> Drawing:
        """Stretch the cylinders."""
        starts, ends = self.starts.at(pose.placements), self.ends.at(pose.placements)
        transforms, visible = stretched_between(starts, ends, self.radii, self.smallest)
        return Drawing(transforms, visible)


def lettering(positions: Array, height: float) -> Array:
    """Return transforms (k, 4, 4) of letters of this height at these positions (k, 3)."""
    transforms = np.zeros((len(positions), 4, 4))
    transforms[:, [0, 1, 2], [0, 1, 2]] = height
    transforms[:, :3, 3] = positions
    transforms[:, 3, 3] = 1.0
    return transforms


def specks(transforms: Array, visible: NDArray[np.bool_], position: Array, size: float) -> None:
    """Turn hidden transforms into specks at a position, in place."""
    transforms[~visible] = lettering(position[None], size)


def part_of_path(name: str) -> str:
    """Return a name as one part of a path."""
    return name.replace("/", "_")


def distinct_parts(parts: Sequence[Part]) -> tuple[Part, ...]:
    """Return the parts, those whose names would be equal numbered.

    Links that are named "a/b" and "a_b" would otherwise be one, and so would visuals that share
    a name.
    """
    seen: set[str] = set()
    found = []
    for part in parts:
        name, number = part.name, 1
        while name in seen:
            number += 1
            name = f"{part.name}~{number}"
        seen.add(name)
        found.append(replace(part, name=name))
    return tuple(found)


def words(name: str, text: str, colour: Colour) -> Part:
    """Return a part that reads `text`."""
    return Part(name, Text(text), colour)
