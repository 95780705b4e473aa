"""What a loop between two frames says of itself, and what all kinds of loops check alike."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache
from typing import ClassVar, Literal, Self

import numpy as np
from msgspec.structs import force_setattr

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.model.joint_form import JointForm
from pmjac_pin.model.rows import Along, Rows, Tilt, across
from pmjac_pin.model.table import Name, TomlTable, Vector
from pmjac_pin.values.arrays import read_only
from pmjac_pin.values.checks import as_numbers

X: Vector = (1.0, 0.0, 0.0)
Y: Vector = (0.0, 1.0, 0.0)
Z: Vector = (0.0, 0.0, 1.0)
_SHORTEST_AXIS = 1e-6

#: What of the way between its frames a loop lets be: nothing, along an axis, or across it.
Opening = Literal["nothing", "along", "across"]


class LoopBetweenFrames(TomlTable, frozen=True):
    """A loop between two frames of the tree: what each kind of it says of itself.

    Attributes
    ----------
    opening : str
        What of the way between the frames is no gap.
    """

    frames: tuple[Name, Name]
    opening: ClassVar[Opening] = "nothing"

    def __post_init__(self) -> None:
        super().__post_init__()
        check_pair("frames", self.frames)

    @property
    def ends(self) -> tuple[str, str]:
        """The names of what the loop joins."""
        return self.frames

    @property
    def lines(self) -> tuple[Vector, Vector] | None:
        """The axis that each frame carries; None where none does."""
        return None

    @property
    def exchanged(self) -> LoopBetweenFrames:
        """What the loop is with its frames exchanged, but for their names."""
        return self

    def rows(self, values: Mapping[str, float]) -> tuple[Rows, ...]:
        """Return the loop's rows where the parameters have these values."""
        raise NotImplementedError(type(self).__name__)

    def form(self, values: Mapping[str, float]) -> JointForm:
        """Return the joints that keep the loop closed."""
        raise NotImplementedError(type(self).__name__)

    @property
    def parameter_names(self) -> frozenset[str]:
        """The parameters that its rows depend on: a kind that has some says so."""
        return frozenset()

    def resolved(self, values: Mapping[str, float]) -> Self:
        """Return the loop with numbers in the place of its parameters."""
        return self

    def rod(self, values: Mapping[str, float]) -> float:
        """Return the length of the rod between the frames, m; 0 without."""
        return 0.0


class LoopAlongAxis(LoopBetweenFrames, frozen=True):
    """A loop between two frames with a common axis."""

    axis: Vector = Z

    @property
    def lines(self) -> tuple[Vector, Vector] | None:
        """The one axis, twice."""
        return self.axis, self.axis

    @property
    def tilt(self) -> Tilt:
        """The tilt of the first frame's axis against the second's."""
        return _tilt(self.axis)

    @property
    def aside(self) -> Along:
        """The gap across the axis."""
        return _aside(self.axis)

    def __post_init__(self) -> None:
        super().__post_init__()
        force_setattr(self, "axis", unit_vector("axis", self.axis))


@lru_cache(maxsize=64)
def _tilt(axis: Vector) -> Tilt:
    return Tilt(read_only(np.array(axis)), read_only(across(np.array(axis))))


@lru_cache(maxsize=64)
def _aside(axis: Vector) -> Along:
    return Along(read_only(across(np.array(axis))), ("across 1", "across 2"))


def check_pair(what: str, names: object) -> None:
    """Raise ArgumentError where these are not two different names."""
    pair = list(names) if isinstance(names, tuple | list) else []
    if len(pair) != 2 or not all(isinstance(name, str) for name in pair):
        raise ArgumentError(f"a loop names two {what}, got {quoted(names)}")
    if pair[0] == pair[1]:
        raise ArgumentError(f"a loop joins two different {what}, got {quoted(pair[0])} twice")


def unit_vector(key: str, vector: Vector) -> Vector:
    """Return a vector of that direction and of length 1.

    Raises
    ------
    ArgumentError
        Not three numbers, or of no direction.
    """
    array = as_numbers(vector, f"`{key}`")
    if array.shape != (3,):
        raise ArgumentError(f"`{key}` has three components, got {quoted(vector)}")
    x, y, z = array.tolist()
    if (length := math.hypot(x, y, z)) < _SHORTEST_AXIS:
        raise ArgumentError(f"`{key}` needs a direction, got {[x, y, z]}")
    return (x / length, y / length, z / length)
