"""The box of all values that the unknowns can have: full turns, limits, and what loops reach."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.coordinates import JointCoordinates
from pmjac_pin.errors import ArgumentError
from pmjac_pin.frames import Frame
from pmjac_pin.linkage import Edge
from pmjac_pin.modes.interval_loops import BoxRows
from pmjac_pin.modes.interval_tree import IntervalTree
from pmjac_pin.modes.intervals import Intervals

Array = NDArray[np.float64]
Truth = NDArray[np.bool_]

#: The interval that holds 2π.
FULL_TURN = Intervals.exact(2.0 * np.pi).widened(1e-15)
_CUT = -3.0  # rad: where a full turn begins, away from the angles of symmetric poses
_SLACK = 1e-9  # m or rad: what a pose may be beyond a limit
_ROUNDING = 1.0 + 1e-9  # for lengths that are added up


class NoBoxesError(ArgumentError):
    """The equations cannot be written over a bounded box of joints with one degree of freedom."""


def box_domain(
    coordinates: JointCoordinates,
    tree: IntervalTree,
    unknowns: Sequence[Edge],
    rows: Sequence[BoxRows],
    limits: bool,
) -> tuple[Intervals, Truth]:
    """Return each unknown's values (k,), and for which of them a full turn is all there is.

    Parameters
    ----------
    coordinates : JointCoordinates
    tree : IntervalTree
    unknowns : sequence of Edge
    rows : sequence of BoxRows
    limits : bool
        Keep within the joints' limits. An angle that its limits let turn fully has none.

    Raises
    ------
    NoBoxesError
        Nothing bounds a slide.
    """
    names = [edge.name for edge in unknowns]
    slides = np.array([edge.kind == "prismatic" for edge in unknowns], dtype=bool)
    lower, upper = np.full(len(names), -np.inf), np.full(len(names), np.inf)
    if limits:
        columns = coordinates.columns(names)
        lower, upper = coordinates.lower[columns] - _SLACK, coordinates.upper[columns] + _SLACK
    endless = ~slides & ~(upper - lower < FULL_TURN.lower)
    lower = np.where(endless, _CUT, lower)
    upper = np.where(endless, _CUT + FULL_TURN.upper + 1e-14, upper)
    sliding = {names[k]: k for k in np.flatnonzero(slides).tolist()}
    for row in rows:
        for first, second, span in row.spans:
            _bound_slide(tree, sliding, (first, second), span, (lower, upper))
    if not np.isfinite(upper - lower).all():
        unbounded = names[int(np.flatnonzero(~np.isfinite(upper - lower))[0])]
        raise NoBoxesError(f"nothing bounds the passive slide {unbounded!r}")
    return Intervals(lower, upper), endless


def _bound_slide(
    tree: IntervalTree,
    slides: Mapping[str, int],
    frames: tuple[Frame, Frame],
    span: float,
    bounds: tuple[Array, Array],
) -> None:
    """Bound the only slide without bounds of a loop, in place.

    It is one side of a polygon, no longer than all the others together.
    """
    lower, upper = bounds
    one, other = (set(tree.path(frame.joint)) for frame in frames)
    sizes = {
        name: max(abs(float(lower[k])), abs(float(upper[k])))
        for name, k in slides.items()
        if name in one | other
    }
    free = [name for name, size in sizes.items() if not math.isfinite(size)]
    if len(free) == 1 and free[0] in one ^ other:
        bounded = [size for size in sizes.values() if math.isfinite(size)]
        far = _ROUNDING * (span + sum(map(tree.reach, frames)) + sum(bounded))
        k = slides[free[0]]
        lower[k], upper[k] = max(lower[k], -far), min(upper[k], far)
