"""SceneOptions: what of a scene is chosen."""

from __future__ import annotations

import math

import msgspec
from msgspec.structs import force_setattr

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.values.checks import as_flag


class SceneOptions(msgspec.Struct, frozen=True):
    """What is drawn beside links, joints, loop closures and free motions.

    Attributes
    ----------
    linear, angular, force : bool
        The ellipsoids at the tool.
    names : bool
        The motors' names.
    scale : float
        Of the ellipsoids, relative to the automatic one; positive.
    velocity_polytope, force_polytope : bool
        What the tool can do within the limits of each motor.
    """

    linear: bool = True
    angular: bool = False
    force: bool = False
    names: bool = True
    scale: float = 1.0
    velocity_polytope: bool = False
    force_polytope: bool = False

    def __post_init__(self) -> None:
        for name in ("linear", "angular", "force", "names", "velocity_polytope", "force_polytope"):
            force_setattr(self, name, as_flag(getattr(self, name), name))
        if not 0.0 < self.scale < math.inf:
            raise ArgumentError(f"scale must be a positive number, got {quoted(self.scale)}")
        force_setattr(self, "scale", float(self.scale))
