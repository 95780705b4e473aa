"""NearestSingularity: a singular pose, and how far it is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from pmjac_pin.configuration import Configuration
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.singularities.change import Space
from pmjac_pin.studies.singularities.singular_equations import Freed


@dataclass(frozen=True, slots=True)
class NearestSingularity:
    """The nearest singular pose that was found.

    Attributes
    ----------
    configuration : Configuration or None
        There; None where none was found.
    freed : "gain" or "loss"
        Whether K* drops there, or the tool loses a motion.
    space : "motors" or "joints"
    distance : float
        Euclidean, in `unit`, from the pose to there; infinite where none was found.
    unit : "m" or "rad"
        Of `distance`: m where all that counts slides, else rad, a slide by `characteristic_length`
        counting as 1 rad.
    motor_change : mapping of str to float
        The motors' values there less those here, m or rad.
    straight : bool
        Whether the motors' straight way from the pose leads there on its assembly mode and meets no
        other singularity of K*. Else another way may lead there, or none.
    starts, found : int
        How many starts there were, and how many of them led to a singular pose.
    """

    configuration: Configuration | None
    freed: Freed
    space: Space
    distance: float
    unit: Literal["m", "rad"]
    motor_change: Mapping[str, float]
    straight: bool
    starts: int
    found: int

    @property
    def evidence(self) -> Evidence:
        """What it rests on: it is an upper bound, as any singular pose is."""
        if self.configuration is None:
            return Evidence("nothing", f"none of {self.starts} starts led to a singular pose")
        return Evidence(
            "tolerance",
            f"a local estimate: {self.found} of {self.starts} starts led to a singular pose, of "
            f"which this is the nearest{' that a straight way leads to' * self.straight}; it is "
            "closed, and singular to 1e-10; a nearer one may not have been met",
        )

    def __bool__(self) -> bool:
        return self.configuration is not None
