"""Reached: where a machine came to on the way to a target, and why not farther."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from pmjac_pin.configuration import Configuration
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.reach.goal import Miss
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.shown import Shown

ReachStatus = Literal["reached", "at a limit", "out of reach", "singular", "on another branch"]


@dataclass(frozen=True, eq=False)
class Reached(Shown):
    """What `reach` came to.

    Attributes
    ----------
    status : str
        "reached": the target is met. "at a limit": the straight way there takes `joints` to their
        limits. "singular": on that way the motors lose the tool, or the way begins where they have
        none. "on another branch": machine and target fit together (`elsewhere`), but from the guess
        no regular way was found there on its working and assembly mode. "out of reach": no closed
        pose was found that meets the target, within limits where these count.
    configuration : Configuration
        Of the machine, closed: at the target; the last pose on the way; or, out of reach, the
        nearest that there is around there.
    error : Miss
        How far its tools are from the targets, `linear` m and `angular` rad.
    share : float
        How much of the straight way was gone.
    message : str
        The same in one sentence.
    joints : tuple of str
        At their limits.
    elsewhere : Configuration or None
        A closed pose at the target, on another branch.
    evidence : Evidence
        What it rests on.
    """

    status: ReachStatus
    configuration: Configuration
    error: Miss
    share: float
    message: str
    evidence: Evidence
    joints: tuple[str, ...] = ()
    elsewhere: Configuration | None = None

    def __bool__(self) -> bool:
        return self.status == "reached"

    @property
    def actuated(self) -> Array:
        """Motor values, shape (n,), m or rad."""
        return self.configuration.actuated

    def __repr__(self) -> str:
        return f"Reached({self.status}: {self.message})"
