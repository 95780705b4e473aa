"""The box of all values that the unknowns can have: full turns, limits, and what loops reach."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.coordinates import JointCoordinates
from pmjac_pin.errors import ArgumentError
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
    for row in rows:
        for first, second, span in row.spans:
            paths = [set(tree.path(frame.joint)) for frame in (first, second)]
            passed = [k for k in np.flatnonzero(slides) if names[k] in paths[0] | paths[1]]
            sizes = np.maximum(np.abs(lower[passed]), np.abs(upper[passed]))
            free = [k for k, size in zip(passed, sizes, strict=True) if not np.isfinite(size)]
            if len(free) == 1 and names[free[0]] in paths[0] ^ paths[1]:
                # The slide is one side of a polygon, no longer than all the others together.
                places = [tree.reach(frame) for frame in (first, second)]
                far = _ROUNDING * (span + sum(places) + float(sizes[np.isfinite(sizes)].sum()))
                lower[free], upper[free] = (
                    np.maximum(lower[free], -far),
                    np.minimum(upper[free], far),
                )
    if not np.isfinite(upper - lower).all():
        unbounded = names[int(np.flatnonzero(~np.isfinite(upper - lower))[0])]
        raise NoBoxesError(f"nothing bounds the passive slide {unbounded!r}")
    return Intervals(lower, upper), endless
