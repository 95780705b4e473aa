"""JointForm: the joints that hold two frames together as a loop closure does."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from pmjac_pin.model.rows import across
from pmjac_pin.values.arrays import Array


class Step(NamedTuple):
    """A joint of the form: before · motion · after, with 4×4 matrices.

    Attributes
    ----------
    suffix : str
        Of its name, where there are two.
    kind : str
        Of the joint: one of `JOINT_KINDS`.
    before, after : ndarray, shape (4, 4)
    """

    suffix: str
    kind: str
    before: Array
    after: Array


@dataclass(frozen=True, slots=True, eq=False)
class JointForm:
    """One joint, or two with a body without mass between them.

    Attributes
    ----------
    steps : tuple of Step
        From the loop's first frame to its second.
    middle : callable or None
        The second frame seen from the first, 4×4 ↦ where the body between is, seen from the first.
    """

    steps: tuple[Step, ...]
    middle: Callable[[Array], Array] | None = field(default=None)


def single(kind: str, along: Array) -> JointForm:
    """Return one joint, z of its motion along z of a 4×4 rotation in both frames."""
    return JointForm((Step("", kind, along, along.T),))


def frame_along(axis: Array) -> Array:
    """Return a 4×4 rotation that takes z to a unit vector.

    Examples
    --------
    >>> frame_along(np.array([1.0, 0.0, 0.0]))[:3, 2].tolist()
    [1.0, 0.0, 0.0]
    """
    turn = np.eye(4)
    turn[:3, :3] = np.column_stack([*across(axis), axis])
    return turn


def about_z(turned: Array) -> Array:
    """Return the 4×4 turn about z that takes x to the direction (x, y) of a vector."""
    x, y = turned[:2]
    turn, angle = np.eye(4), math.atan2(y, x)
    turn[:2, :2] = [[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]
    return turn


def shifted(shift: Array) -> Array:
    """Return a 4×4 translation."""
    place = np.eye(4)
    place[:3, 3] = shift
    return place
