"""Gimbals: three hinges in turn that reach a set of orientations without coming near to a lock.

    R = B Rz(yaw) Ry(pitch) Rx(roll) Aᵀ,        sin(pitch) = −z₀ · R x₁,

with z₀ the last column of B and x₁ the first of A. They lock where R takes x₁ to ± z₀, so that
these two are chosen as far from that as they can be.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from pmjac_pin.model.rows import across
from pmjac_pin.values.arrays import Array

_UNLOCKED = 0.2  # cosine of the pitch: nearer to a lock, small turns are large ones of the hinges


@dataclass(frozen=True, slots=True, eq=False)
class Gimbal:
    """Where the hinges are.

    Attributes
    ----------
    before, after : ndarray, shape (3, 3)
        B and A.
    """

    before: Array
    after: Array


#: Turns about the axes themselves.
PLAIN_GIMBAL = Gimbal(np.eye(3), np.eye(3))


def gimbal_for(rotations: Array) -> Gimbal | None:
    """Return one that is far from a lock at all of these rotations (N, 3, 3); None for none."""
    axes = np.array([axis for axis in product((0.0, 1.0, -1.0), repeat=3) if _is_first(axis)])
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    turned = np.einsum("ai,nij,bj->nab", axes, rotations, axes)
    worst = np.abs(turned).max(axis=0)
    # Of those that are alike the first: rounding decides nothing.
    number = int(np.argmax(worst <= worst.min() + 1e-9))
    one, other = divmod(number, len(axes))
    if np.sqrt(max(0.0, 1.0 - worst[one, other] ** 2)) < _UNLOCKED:
        return None
    first, last = axes[other], axes[one]
    return Gimbal(np.column_stack([*across(last), last]), np.column_stack([first, *across(first)]))


def _is_first(axis: tuple[float, ...]) -> bool:
    """Tell whether an axis is the one of it and its opposite that is taken."""
    entries = [entry for entry in axis if entry]
    return bool(entries) and entries[0] > 0.0
