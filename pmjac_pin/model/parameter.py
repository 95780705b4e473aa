"""Parameters: lengths and angles of a model file that a user may vary, and what they move."""

from __future__ import annotations

import math
from numbers import Real
from typing import Literal

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.model.table import NonEmpty, TomlTable, Vector

LARGEST_PARAMETER = 1e6  # m or rad, where a model file gives no limit
ORIGIN: Vector = (0.0, 0.0, 0.0)


class Move(TomlTable, frozen=True, kw_only=True):
    """How one parameter moves one thing of the URDF: the change per unit of the parameter.

    The URDF is written at the parameters' defaults; a component becomes
    ``component + coefficient * (value - default)``.
    """

    joint: str | None = None
    visual: str | None = None
    xyz: Vector = ORIGIN
    rpy: Vector = ORIGIN
    size: Vector = ORIGIN
    length: float = 0.0
    radius: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if (self.joint is None) == (self.visual is None):
            raise ArgumentError("a move names either a `joint` or a `visual`")
        shape = any(self.size) or self.length != 0.0 or self.radius != 0.0
        if self.joint is not None and shape:
            raise ArgumentError(
                "a joint has an origin (`xyz`, `rpy`) only; sizes belong to a visual"
            )
        if not (shape or any(self.xyz) or any(self.rpy)):
            raise ArgumentError("a move without a coefficient moves nothing")


class Parameter(TomlTable, frozen=True, kw_only=True):
    """A length or an angle that a user may vary."""

    default: float
    unit: Literal["m", "rad"]
    meaning: NonEmpty
    minimum: float | None = None
    maximum: float | None = None
    moves: tuple[Move, ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        lower, upper = self.range
        if not lower < upper:
            raise ArgumentError(f"minimum {lower:g} is not below maximum {upper:g}")
        self.check("default", self.default)

    def check(self, name: str, value: float) -> float:
        """Return `value` as a float, or say why this parameter cannot have it."""
        if isinstance(value, bool) or not isinstance(value, Real):
            message = (
                f"parameter {quoted(name)} must be a number in {self.unit}, got {quoted(value)}"
            )
            raise ArgumentError(message)
        try:
            value = float(value)
        except OverflowError:
            value = math.inf
        lower, upper = self.range
        if not lower <= value <= upper:
            got = f"parameter {quoted(name)} = {value:g} {self.unit}"
            message = f"{got} is not within [{lower:g}, {upper:g}]"
            raise ArgumentError(message)
        return value

    @property
    def range(self) -> tuple[float, float]:
        """The least and the largest value that it may have."""
        lower = -LARGEST_PARAMETER if self.minimum is None else self.minimum
        return lower, LARGEST_PARAMETER if self.maximum is None else self.maximum
