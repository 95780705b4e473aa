"""Event: what happens at one parameter of a path."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.values.arrays import Array, ReadOnlyArrays

EventKind = Literal[
    "motor limit", "passive limit", "loss", "gain", "fold", "branch point", "singular", "user"
]


@dataclass(frozen=True, eq=False)
class PathBranch(ReadOnlyArrays):
    """One of the ways on from a pose where branches meet.

    Attributes
    ----------
    velocity : ndarray, shape (nv,)
        dq/dt on it; where the motors turn back, all of them at rest there, a motion by the
        characteristic length or 1 rad.
    turns_back : bool
        Whether the motors are at rest there: the path has no such branch beyond.
    goes_on : bool
        Whether it is the one whose tangent is that of the path.
    ahead : Configuration or None
        A closed pose on it, a thousandth of the characteristic length or of a rad further; None
        where it is not told from the other there.
    """

    velocity: Array
    turns_back: bool
    goes_on: bool
    ahead: Configuration | None


@dataclass(frozen=True, eq=False, repr=False)
class Event:
    """What happens at one parameter of a path.

    Attributes
    ----------
    kind : str
        "motor limit" or "passive limit", where a joint leaves its limits or comes back; "loss",
        where the tool loses a motion; "gain", where a machine driven by its tool is lost by its
        motors; "fold", where the assembly mode ends with another one;
        "branch point", where branches of closed poses meet; "singular", where K* loses rank and
        nothing more is known; "user", where a function of the caller's changes its sign.
    t : float
        The path's parameter.
    configuration : Configuration
        The closed pose there.
    what : str
        In one sentence.
    name : str
        The joint, or the caller's name of the function.
    branches : tuple of PathBranch
        At a branch point, both.
    leaves : bool
        Whether a joint leaves its limits, and does not come back.
    """

    kind: EventKind
    t: float
    configuration: Configuration
    what: str
    name: str = ""
    branches: tuple[PathBranch, ...] = ()
    leaves: bool = False

    def __repr__(self) -> str:
        return f"Event({self.kind!r}, t={np.format_float_positional(self.t, 12)}, {self.what!r})"
