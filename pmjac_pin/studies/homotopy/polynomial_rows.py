"""Places of frames in polynomials, and the rows of η that loops ask of them.

Tilts and turns are taken as t·a = 0 and as the skew part of R, which vanish at half a turn as well.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin
from flint import fmpq
from numpy.typing import NDArray

from pmjac_pin.kinematics.rows import Along, Distance, Gap, RightAngle, Rows, Tilt
from pmjac_pin.studies.homotopy.joint_unknowns import Symbols, quaternion_of_gap

Array = NDArray[np.float64]

_ROUNDING = 1e-15  # of an entry of a rotation, which is of size 1


@dataclass(frozen=True, slots=True, eq=False)
class Place:
    """A rotation (3, 3) and an origin (3, 1) in polynomials, in characteristic lengths.

    `floating` is, for a frame of a free body, that body's base, its g and e, and where the frame
    is on the body.
    """

    turn: Symbols
    origin: Symbols
    floating: tuple[Place, Symbols, Symbols, pin.SE3] | None = None

    def at(self, placement: pin.SE3, length: float) -> Place:
        """Return a frame of a body."""
        shift = exact(placement.translation[:, None] / length)
        turn = np.where(np.abs(placement.rotation) < _ROUNDING, 0.0, placement.rotation)
        floating = self.floating and (*self.floating[:3], self.floating[3] * placement)
        return Place(self.turn @ exact(turn), self.origin + self.turn @ shift, floating)

    def seen_from(self, other: Place) -> Symbols:
        """Return this rotation in another's axes."""
        return np.asarray(other.turn.T @ self.turn)

    def rod(self, other: Place, square: Any, length: float) -> Any:
        """Return |gap|² − square, for a free body times |e|² = 1: of lower degree so."""
        if self.floating is None:
            gap = self.origin - other.origin
            return (gap * gap).sum() - square
        base, g, e, placement = self.floating
        b = (base.turn.T @ (other.origin - base.origin)).ravel()
        gap = quaternion_of_gap(g, e, exact(placement.translation / length), b)
        return (gap * gap).sum() - square * (e * e).sum()


def block_rows(block: Rows, one: Place, other: Place) -> Iterator[Any]:
    """Yield the rows of a block."""
    gap = one.origin - other.origin
    match block:
        case Gap():
            yield from gap.ravel()
        case Along():
            yield from (exact(block.directions) @ other.turn.T @ gap).ravel()
        case Tilt():
            axis = one.seen_from(other) @ exact(block.axis)
            yield from exact(block.across) @ axis
        case RightAngle():
            yield exact(block.second) @ one.seen_from(other) @ exact(block.first)
        case _:
            turn = one.turn @ other.turn.T
            yield from (turn[i, j] - turn[j, i] for i, j in ((2, 1), (0, 2), (1, 0)))


def turned_over_rows(block: Rows, one: Place, other: Place) -> Iterator[Any]:
    """Yield what is 0 at a closed pose and not at half a turn."""
    match block:
        case Tilt():
            axis = exact(block.axis)
            yield axis @ one.seen_from(other) @ axis - 1
        case Gap() | Distance() | Along() | RightAngle():
            return
        case _:
            yield (one.turn @ other.turn.T).trace() - 3


def exact(numbers: Array) -> Symbols:
    """Return doubles as the rational numbers that they are."""
    return np.asarray(np.vectorize(rational, otypes=[object])(numbers))


def rational(number: float) -> fmpq:
    """Return a double as the rational number that it is."""
    return fmpq(*float(number).as_integer_ratio())
