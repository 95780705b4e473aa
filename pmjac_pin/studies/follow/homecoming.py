"""Homecoming: whether a path that is closed in motor values ends where it began."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.studies.follow.event import Event
from pmjac_pin.studies.modes.recognition import SAME_MOTORS, Recognition

_SINGULAR_EVENTS = ("fold", "branch point", "singular")


@dataclass(frozen=True, slots=True)
class Homecoming:
    """How a path that is closed in motor values ends.

    Attributes
    ----------
    same_mode : bool
        Whether all bodies are where they were.
    met_singular : bool
        Whether a singular pose of K* was on the way.
    """

    same_mode: bool
    met_singular: bool

    @property
    def cuspidal(self) -> bool:
        """Another assembly mode, and no singular pose on the way: the machine is cuspidal."""
        return not (self.same_mode or self.met_singular)

    def __str__(self) -> str:
        met = "met a singular pose" if self.met_singular else "met no singular pose"
        if self.same_mode:
            return f"closed in motor values, ends on the same assembly mode, {met}"
        told = f"closed in motor values, ends on another assembly mode, {met}"
        return f"{told}: a cuspidal machine" if self.cuspidal else told


def homecoming(
    start: Configuration, end: Configuration, events: Sequence[Event]
) -> Homecoming | None:
    """Return how a path ends that is closed in motor values, full turns aside; None of others."""
    mechanism = start.mechanism
    coordinates, motors = mechanism.coordinates, mechanism.problem.partition.actuated
    apart = end.actuated - start.actuated
    turns = coordinates.angles[motors] | coordinates.wraps[motors]
    apart[turns] = np.remainder(apart[turns] + np.pi, 2.0 * np.pi) - np.pi
    if not np.abs(apart).max(initial=0.0) <= SAME_MOTORS:
        return None
    turned_back = coordinates.with_values(end.q, motors, start.actuated + apart)
    same = Recognition([start]).index(mechanism.configuration(turned_back)) is not None
    return Homecoming(same, any(event.kind in _SINGULAR_EVENTS for event in events))
