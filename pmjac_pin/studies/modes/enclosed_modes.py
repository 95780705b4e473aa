"""Enclosed modes: exactly one root of as many rows as unknowns in a neighbourhood of a small box.

By Krawczyk's test over the box widened, more and more: where it holds in one neighbourhood, all of
the box's solutions are the one in the smallest. Boxes that hold all poses near a root are longer
in some unknowns than in others, which no ball about a point is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.rates.partition import independent_rows
from pmjac_pin.studies.krawczyk import image_of_boxes
from pmjac_pin.studies.modes.box_equations import BoxEquations
from pmjac_pin.values.arrays import Array, Index, Mask

#: Scaled: nested neighbourhoods that are tried at once.
_NESTED_RADII = 10.0 ** -np.arange(1.0, 9.5, 0.5)


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


def enclose(loops: BoxEquations, boxes: Intervals, scale: Array) -> list[Enclosure | None]:
    """Return for each small box the one mode in a neighbourhood of it, None where none is proven.

    Parameters
    ----------
    loops : BoxEquations
    boxes : Intervals, shape (n, k)
    scale : ndarray, shape (k,)
        What counts as 1, rad or m.
    """
    if not len(boxes.lower):
        return []
    count = len(boxes.lower)
    kept, middle = _kept_rows_and_root(loops, boxes)
    around = Intervals.join([boxes.widened(radius * scale) for radius in _NESTED_RADII])
    times = len(_NESTED_RADII)
    image = _image(loops, np.tile(kept, (times, 1)), np.tile(middle, (times, 1)), around)
    proven = image.inside(around).all(axis=1).reshape(times, count)
    # The neighbourhoods are nested, so the root in the smallest is that of the largest.
    largest = proven.argmax(axis=0)
    smallest = times - 1 - proven[::-1].argmax(axis=0)
    each = np.arange(count)
    mode = image.meet(around)[smallest * count + each]  # a box where nothing is proven
    mode = _image(loops, kept, mode.middle, mode).meet(mode)
    possible, sizes = _at_root(loops, kept, mode)
    return [
        Enclosure(
            mode=mode[index],
            around=around[int(largest[index]) * count + index],
            kept=tuple(loops.names[row] for row in kept[index]),
            left_out=float((sizes[index] / loops.tolerance).max()),
        )
        if proven[:, index].any() and possible[index]
        else None
        for index in range(count)
    ]


def _image(loops: BoxEquations, kept: Index, at: Array, boxes: Intervals) -> Intervals:
    """Return K(X) of each box (n, k) about a point in it, for its kept rows."""
    each = np.arange(len(kept))[:, None]
    jacobian = loops.evaluate(boxes).jacobian[each, kept]
    residual = loops.residual(Intervals.exact(at))[each, kept]
    inverse = np.asarray(np.linalg.pinv(jacobian.middle), dtype=np.float64)
    return image_of_boxes(inverse, residual, jacobian, at, boxes)


def _at_root(loops: BoxEquations, kept: Index, mode: Intervals) -> tuple[Mask, Array]:
    """Return whether the root of the kept rows can be a mode, and how far the other rows are off.

    At the root φ, where the kept rows ηₖ vanish, each row is, for any matrix W,
    η(φ) ∈ η(m) − W ηₖ(m) + (J − W Jₖ)(φ − m): with W Jₖ about J, nearly η(m) alone.
    """
    each, at = np.arange(len(kept))[:, None], Intervals.exact(mode.middle)
    whole, residual = loops.evaluate(mode), loops.residual(at)
    middle = whole.jacobian.middle
    weights: Array = middle @ np.linalg.pinv(middle[each, kept])
    rest = (whole.jacobian - whole.jacobian[each, kept].after(weights)) * (mode - at)[:, None]
    off = residual - residual[each, kept][:, :, None].after(weights)[:, :, 0] + rest.sum(axis=2)
    sizes = off.magnitude
    np.put_along_axis(sizes, kept, 0.0, axis=1)
    return whole.possible, sizes


def _kept_rows_and_root(loops: BoxEquations, boxes: Intervals) -> tuple[Index, Array]:
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
