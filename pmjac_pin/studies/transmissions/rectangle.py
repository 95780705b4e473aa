"""Rectangle: the joint values, of one joint or two, that a transmission is asked for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.values.arrays import Array, Index, Mask
from pmjac_pin.values.checks import as_numbers

_MOST_JOINTS = 2


@dataclass(frozen=True, slots=True, eq=False)
class Rectangle:
    """Where each joint begins and ends.

    Attributes
    ----------
    joints : tuple of str
    lower, upper : ndarray, shape (n,)
        m or rad.
    """

    joints: tuple[str, ...]
    lower: Array
    upper: Array

    @classmethod
    def of(cls, over: object) -> Rectangle:
        """Return what a caller gave: a mapping of names to where values begin and end.

        Raises
        ------
        ArgumentError
        """
        if not isinstance(over, Mapping) or not over:
            wanted = "`over` is a mapping of joints to where they begin and end"
            raise ArgumentError(f"{wanted}, as {{'pitch': (-0.4, 0.4)}}, got {quoted(over)}")
        if len(over) > _MOST_JOINTS:
            names = ", ".join(map(str, over))
            wanted = "a rectangle is of one joint or two; `pmjac_pin.transmission` has more"
            raise ArgumentError(f"{wanted}, at any pose; got {names}")
        ends = [_checked_ends(name, given) for name, given in over.items()]
        return cls(tuple(over), np.array([a for a, _ in ends]), np.array([b for _, b in ends]))

    def axes(self, points: int) -> tuple[Array, ...]:
        """Return so many evenly spaced values of each joint, both ends among them."""
        ends = zip(self.lower.tolist(), self.upper.tolist(), strict=True)
        return tuple(np.linspace(lower, upper, points) for lower, upper in ends)

    def __str__(self) -> str:
        ends = zip(self.joints, self.lower.tolist(), self.upper.tolist(), strict=True)
        return ", ".join(f"{name} {lower:.6g} to {upper:.6g}" for name, lower, upper in ends)


def _checked_ends(name: object, given: object) -> tuple[float, float]:
    ends = as_numbers(given, f"`over`: where {quoted(name)} begins and ends")
    if ends.shape != (2,) or not ends[0] < ends[1]:
        wanted = f"`over`: of {quoted(name)} two numbers are wanted, the lower one first"
        raise ArgumentError(f"{wanted}, got {quoted(given)}")
    return float(ends[0]), float(ends[1])


def largest_block(good: Mask, start: tuple[int, ...]) -> tuple[Index, Index]:
    """Return first and last indices of the largest block of good cells around one of them.

    Examples
    --------
    >>> good = np.array([[1, 1, 0], [1, 1, 1], [1, 1, 0]], dtype=bool)
    >>> [ends.tolist() for ends in largest_block(good, (1, 1))]
    [[0, 0], [2, 1]]
    """
    first, *others = start
    best, ends = 0, (np.array(start), np.array(start))
    for low in range(first, -1, -1):
        if not good[(low, *others)]:
            break
        for high in range(first, len(good)):
            if not good[(high, *others)]:
                break
            block = np.asarray(good[low : high + 1].all(axis=0))
            inner = _run(block, others[0]) if others else ()
            size = (high - low + 1) * (inner[1] - inner[0] + 1 if inner else 1)
            if size > best:
                lower, upper = [low, *inner[:1]], [high, *inner[1:]]
                best, ends = size, (np.array(lower), np.array(upper))
    return ends


def _run(good: Mask, start: int) -> tuple[int, int]:
    """Return first and last index of the run of good cells around one."""
    bad = np.flatnonzero(~good)
    return int(bad[bad < start].max(initial=-1)) + 1, int(
        bad[bad > start].min(initial=good.size)
    ) - 1
