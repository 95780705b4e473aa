"""Krawczyk's test: exactly one root of as many rows as unknowns in a neighbourhood of a box.

K(X) = m − C η(m) + (I − C J(X)) (X − m), with C about J(m)⁻¹: where K(X) is in the interior of X,
η has exactly one root in X, and that is in K(X).

Source: R. Krawczyk, Newton-Algorithmen zur Bestimmung von Nullstellen mit Fehlerschranken,
Computing 4 (1969); R. E. Moore, A test for existence of solutions, SIAM J. Numer. Anal. 14 (1977).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.modes.interval_loops import IntervalLoops
from pmjac_pin.modes.intervals import Intervals
from pmjac_pin.partition import independent_rows

Array = NDArray[np.float64]
Index = NDArray[np.intp]

_RADII = 10.0 ** -np.arange(1.0, 9.5, 0.5)  # scaled: nested neighbourhoods that are tried at once


@dataclass(frozen=True, slots=True, eq=False)
class Enclosure:
    """Where one assembly mode is, exactly one.

    Attributes
    ----------
    mode : Intervals, shape (k,)
        The root of the kept rows is here.
    around : Intervals, shape (k,)
        It is the only one here.
    kept : tuple of str
        The k rows that vanish there together.
    left_out : float
        A bound on the other rows there, in shares of their tolerances.
    """

    mode: Intervals
    around: Intervals
    kept: tuple[str, ...]
    left_out: float


def enclose(loops: IntervalLoops, boxes: Intervals, scale: Array) -> list[Enclosure | None]:
    """Return for each small box the one mode in a neighbourhood of it, None where none is proven.

    Parameters
    ----------
    loops : IntervalLoops
    boxes : Intervals, shape (n, k)
    scale : ndarray, shape (k,)
        What counts as 1, rad or m.
    """
    if not len(boxes.lower):
        return []
    count = len(boxes.lower)
    kept, middle = _kept_rows_and_root(loops, boxes)
    around = Intervals.join([boxes.widened(radius * scale) for radius in _RADII])
    times = len(_RADII)
    image = _krawczyk(loops, np.tile(kept, (times, 1)), np.tile(middle, (times, 1)), around)
    proven = image.inside(around).all(axis=1).reshape(times, count)
    # The neighbourhoods are nested, so the root in the smallest is that of the largest.
    largest = proven.argmax(axis=0)
    smallest = times - 1 - proven[::-1].argmax(axis=0)
    each = np.arange(count)
    mode = image.meet(around)[smallest * count + each]  # a box where nothing is proven
    mode = _krawczyk(loops, kept, mode.middle, mode).meet(mode)
    there = loops.evaluate(mode)
    sizes = there.residual.magnitude / loops.tolerance
    np.put_along_axis(sizes, kept, 0.0, axis=1)
    return [
        Enclosure(
            mode=mode[index],
            around=around[int(largest[index]) * count + index],
            kept=tuple(loops.names[row] for row in kept[index]),
            left_out=float(sizes[index].max()),
        )
        if proven[:, index].any() and there.possible[index]
        else None
        for index in range(count)
    ]


def _krawczyk(loops: IntervalLoops, kept: Index, at: Array, boxes: Intervals) -> Intervals:
    """Return K(X) of each box (n, k) about a point in it, infinite where J is singular."""
    each, middle = np.arange(len(kept))[:, None], Intervals.exact(at)
    jacobian = loops.evaluate(boxes).jacobian[each, kept]
    residual = loops.residual(middle)[each, kept]
    square = jacobian.middle
    regular = np.linalg.matrix_rank(square, tol=0.0) == kept.shape[1]
    one = np.eye(kept.shape[1])
    inverse = np.linalg.inv(np.where(regular[:, None, None], square, one))
    spread = (Intervals.exact(one) - jacobian.after(inverse)) * (boxes - middle)[:, None]
    image = middle - residual[:, :, None].after(inverse)[:, :, 0] + spread.sum(axis=2)
    possible = (regular & boxes.holds(at).all(axis=1))[:, None]
    return Intervals(
        np.where(possible, image.lower, -np.inf), np.where(possible, image.upper, np.inf)
    )


def _kept_rows_and_root(loops: IntervalLoops, boxes: Intervals) -> tuple[Index, Array]:
    """Return k independent rows near each box, and a Newton step from its middle to their root."""
    middle = boxes.middle
    whole = loops.evaluate(Intervals.exact(middle))
    jacobian, residual = whole.jacobian.middle, whole.residual.middle
    kept = np.array(
        [independent_rows(rows / loops.tolerance[:, None], middle.shape[1]) for rows in jacobian]
    )
    steps = [
        np.linalg.lstsq(rows[keep], off[keep], rcond=None)[0]
        for rows, keep, off in zip(jacobian, kept, residual, strict=True)
    ]
    return kept, middle - np.array(steps)
