"""Unit shapes, and the transforms that give them their size and place."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pmjac_pin.values.arrays import Array

Colour = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class Box:
    """A cube of side 1 about the origin."""

    round_axes = 0
    half_extents = (0.5, 0.5, 0.5)


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A cylinder of radius 1 along z, from z = −1/2 to 1/2."""

    round_axes = 2
    half_extents = (1.0, 1.0, 0.5)


@dataclass(frozen=True, slots=True)
class Cone:
    """A cone of radius 1 along z, its base at z = −1/2 and its apex at z = 1/2."""

    round_axes = 2
    half_extents = (1.0, 1.0, 0.5)


@dataclass(frozen=True, slots=True)
class Sphere:
    """A sphere of radius 1 about the origin."""

    round_axes = 3
    half_extents = (1.0, 1.0, 1.0)


@dataclass(frozen=True, slots=True)
class Text:
    """One line of text whose letters are 1 high, its middle at the origin.

    Its transform is a translation and one scale, the height of the letters in m; how the text
    is turned towards the eye is left to the drawing.
    """

    text: str
    round_axes = 0
    half_extents = (0.0, 0.0, 0.0)  # its size depends on the font, its place is what counts


Shape = Box | Cylinder | Cone | Sphere | Text


def scaled(scale: float | tuple[float, float, float] | Array) -> Array:
    """Return the transform (4, 4) that only scales."""
    transform = np.eye(4)
    transform[:3, :3] *= scale
    return transform
