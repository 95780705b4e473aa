"""The loop equations over boxes of joint values: rows and their derivatives, enclosed.

The rows vanish where those of `loop_rows` do and nowhere else, but are polynomials in sines,
cosines and slides: a tilt is tₖ·a (of length sin α instead of 2 sin α/2), a turn is the rotation
vector's sin(α)/α times. Both vanish at half a turn as well, which a separate condition excludes.
Neither is larger than the row that it stands for, so a closed pose keeps its tolerance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.frames import Frame
from pmjac_pin.kinematics.rows import Along, Distance, Gap, RightAngle, Rows, Tilt, Turn
from pmjac_pin.modes.interval_tree import IntervalTree, Poses

Array = NDArray[np.float64]
Truth = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Enclosed:
    """p loop equations over b boxes of k unknowns.

    Attributes
    ----------
    residual : Intervals, shape (b, p)
    jacobian : Intervals, shape (b, p, k)
        ∂η/∂φ; k = 0 where nobody asked for it.
    possible : ndarray of bool, shape (b,)
        False where a body is certainly half a turn from where the rows want it.
    """

    residual: Intervals
    jacobian: Intervals
    possible: Truth


class BoxRows(Protocol):
    """Some rows of the equations.

    Attributes
    ----------
    frames : tuple of Frame
        Whose poses the rows need.
    names : tuple of str
    tolerance : tuple of float
        How far each row can be from 0 at a pose that counts as closed.
    spans : tuple of (Frame, Frame, float)
        How far apart, m, the origins of two frames are at most where the rows vanish.
    """

    @property
    def frames(self) -> tuple[Frame, ...]: ...  # noqa: D102
    @property
    def names(self) -> tuple[str, ...]: ...  # noqa: D102
    @property
    def tolerance(self) -> tuple[float, ...]: ...  # noqa: D102
    @property
    def spans(self) -> tuple[tuple[Frame, Frame, float], ...]: ...  # noqa: D102

    def __call__(self, poses: Poses) -> tuple[Intervals, Truth | None]:
        """Return the rows with their derivatives, (b, 1 + rates, rows), and what is possible."""
        ...


class IntervalLoops:
    """All equations of a mechanism over boxes (b, k) of its unknowns.

    Attributes
    ----------
    names : tuple of str
        Of the p rows.
    tolerance : ndarray, shape (p,)
        How far each row can be from 0 at a pose that counts as closed.
    """

    __slots__ = ("_frames", "_rows", "_tree", "_unknowns", "names", "tolerance")

    def __init__(self, tree: IntervalTree, rows: Sequence[BoxRows], unknowns: int) -> None:
        self._tree, self._rows, self._unknowns = tree, rows, unknowns
        frames = {frame.index: frame for block in rows for frame in block.frames}
        self._frames = tuple(frames.values())
        self.names = tuple(name for block in rows for name in block.names)
        self.tolerance = np.array([size for block in rows for size in block.tolerance])

    def evaluate(self, box: Intervals) -> Enclosed:
        """Return all rows and their derivatives by all unknowns."""
        return self._evaluate(box, range(self._unknowns))

    def residual(self, box: Intervals) -> Intervals:
        """Return all rows, shape (b, p)."""
        return self._evaluate(box, ()).residual

    def _evaluate(self, box: Intervals, by: Sequence[int]) -> Enclosed:
        poses = self._tree.frames(self._frames, box, by)
        count, possible = len(box.lower), np.ones(len(box.lower), dtype=bool)
        blocks = []
        for rows in self._rows:
            block, allowed = rows(poses)
            blocks.append(_broadcast(block, count))
            if allowed is not None:
                possible = possible & allowed
        whole = Intervals.join(blocks, axis=2)
        jacobian = whole[:, 1:]
        across = Intervals(
            jacobian.lower.transpose(0, 2, 1).copy(), jacobian.upper.transpose(0, 2, 1).copy()
        )
        return Enclosed(whole[:, 0], across, possible)


@dataclass(frozen=True, slots=True, eq=False)
class PairRows:
    """One block of rows of a loop between two frames."""

    first: Frame
    second: Frame
    block: Rows
    names: tuple[str, ...]
    tolerance: tuple[float, ...]

    @property
    def frames(self) -> tuple[Frame, ...]:
        """The loop's frames."""
        return (self.first, self.second)

    @property
    def spans(self) -> tuple[tuple[Frame, Frame, float], ...]:
        """A coincident pair is no further apart than its tolerance, a rod's ends than the rod."""
        match self.block:
            case Gap():
                return ((self.first, self.second, 2.0 * sum(self.tolerance)),)
            case Distance(length):
                return ((self.first, self.second, length + sum(self.tolerance) / length),)
        return ()

    def __call__(self, poses: Poses) -> tuple[Intervals, Truth | None]:
        """Return the block's rows."""
        one, other = poses[self.first.index], poses[self.second.index]
        gap = point(one) - point(other)
        match self.block:
            case Gap():
                return gap, None
            case Distance(length):
                return squared(gap) - constant(Intervals.exact(length).square(), gap), None
            case Along(directions):
                return side_by_side([dot(axis(other, d), gap) for d in directions]), None
            case Tilt(given, across):
                turned = axis(one, given)
                rows = side_by_side([dot(axis(other, t), turned) for t in across])
                return rows, dot(axis(other, given), turned).upper[:, 0, 0] > 0.0
            case RightAngle(given, normal):
                return dot(axis(one, given), axis(other, normal)), None
            case Turn():
                return _turn(one, other)
        raise NotImplementedError(type(self.block).__name__)


def point(pose: Intervals) -> Intervals:
    """Return a pose's p and its derivatives, shape (b, 1 + rates, 3)."""
    return pose[..., 3]


def axis(pose: Intervals, given: Array) -> Intervals:
    """Return R·given and its derivatives, shape (b, 1 + rates, 3)."""
    return pose[..., :3].before(np.asarray(given, dtype=float)[:, None])[..., 0]


def dot(u: Intervals, v: Intervals) -> Intervals:
    """Return u·v and its derivatives, shape (b, 1 + rates, 1)."""
    value = (u[:, :1] * v[:, :1]).sum(axis=2)
    rates = Intervals.join([u[:, 1:] * v[:, :1], u[:, :1] * v[:, 1:]], axis=2).sum(axis=2)
    return Intervals.join([value, rates], axis=1)[:, :, None]


def squared(u: Intervals) -> Intervals:
    """Return u·u and its derivatives, shape (b, 1 + rates, 1)."""
    value = u[:, :1].square().sum(axis=2)
    rates = (u[:, 1:] * u[:, :1]).sum(axis=2)
    return Intervals.join([value, rates + rates], axis=1)[:, :, None]


def constant(value: Intervals, like: Intervals) -> Intervals:
    """Return a number as a row that does not change, with as many derivatives as `like`."""
    lower, upper = np.zeros((1, like.shape[1], 1)), np.zeros((1, like.shape[1], 1))
    lower[0, 0, 0], upper[0, 0, 0] = value.lower, value.upper
    return Intervals(lower, upper)


def side_by_side(rows: Sequence[Intervals]) -> Intervals:
    """Return rows (b, 1 + rates, 1) as one block (b, 1 + rates, rows)."""
    count = max(row.shape[0] for row in rows)
    return Intervals.join([_broadcast(row, count) for row in rows], axis=2)


def _turn(one: Intervals, other: Intervals) -> tuple[Intervals, Truth]:
    """Return ½ (R − Rᵀ)'s vector for R = R₁R₂ᵀ seen from the second, and trace R > 1."""
    a, b = ([pose[..., k] for k in range(3)] for pose in (one, other))
    rows = [dot(a[j], b[k]) - dot(a[k], b[j]) for j, k in ((1, 2), (2, 0), (0, 1))]
    half = side_by_side(rows) * Intervals.exact(0.5)
    trace = dot(a[0], b[0]) + dot(a[1], b[1]) + dot(a[2], b[2])
    return half, trace.upper[:, 0, 0] > 1.0


def _broadcast(block: Intervals, count: int) -> Intervals:
    shape = (count, *block.shape[1:])
    return Intervals(np.broadcast_to(block.lower, shape), np.broadcast_to(block.upper, shape))


def tolerances(block: Rows, closed: float, length: float) -> tuple[float, ...]:
    """Return how far a block's rows can be from 0 where the loops gape by `closed` m at most.

    Parameters
    ----------
    block : Rows
    closed : float
        m
    length : float
        The mechanism's characteristic length, m: a rad counts as that.
    """
    if isinstance(block, Distance):
        return (2.0 * block.length * closed,)
    size = closed / length if block.unit == "rad" else closed
    return (size,) * len(block.names)
