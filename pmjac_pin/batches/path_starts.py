"""Path starts: where the paths of many poses begin."""

from __future__ import annotations

from typing import Any

from pmjac_pin.batches.sound_rows import rows_of_q
from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.values.arrays import Array


def path_starts(mechanism: Mechanism, guess: Any, count: int) -> Array:
    """Return the closed q (nq,) where all begin, or rows (count, nq) of which nothing is known.

    Raises
    ------
    ArgumentError, UnknownNameError
    """
    pose = mechanism.pose(guess) if isinstance(guess, str) else guess
    if isinstance(pose, Configuration):
        return closed_q(mechanism, pose)
    rows = rows_of_q(pose, mechanism.nq)
    if len(rows) != count:
        raise ArgumentError(f"{count} guesses expected, one for each target; got {len(rows)}")
    return rows


def closed_q(mechanism: Mechanism, pose: Configuration) -> Array:
    """Return its q; of another mechanism, seen to be closed in this one."""
    return pose.q if pose.mechanism is mechanism else mechanism.configuration(pose.q).q
