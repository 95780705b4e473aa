"""The box of all values that the unknowns can have: full turns, limits, and what loops reach."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.errors import ArgumentError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.linkage import Edge
from pmjac_pin.studies.modes.interval_loops import BoxRows
from pmjac_pin.studies.modes.slide_ranges import Polygons
from pmjac_pin.values.arrays import Mask

#: The interval that holds 2π.
FULL_TURN = Intervals.exact(2.0 * np.pi).widened(1e-15)
_CUT = -3.0  # rad: where a full turn begins, away from the angles of symmetric poses
_SLACK = 1e-9  # m or rad: what a pose may be beyond a limit


class NoBoxesError(ArgumentError):
    """The equations cannot be written over a bounded box of joints with one degree of freedom."""


def box_domain(
    mechanism: Mechanism,
    motors: Mapping[str, float],
    unknowns: Sequence[Edge],
    rows: Sequence[BoxRows],
    limits: bool,
) -> tuple[Intervals, Mask]:
    """Return each unknown's values (k,), and for which of them a full turn is all there is.

    Parameters
    ----------
    mechanism : Mechanism
    motors : mapping of str to float
        Their values.
    unknowns : sequence of Edge
    rows : sequence of BoxRows
    limits : bool
        Keep within the joints' limits. An angle that its limits let turn fully has none.

    Raises
    ------
    NoBoxesError
        Nothing bounds a slide.
    """
    coordinates, names = mechanism.coordinates, [edge.name for edge in unknowns]
    slides = np.array([bool(edge.kind.along) for edge in unknowns], dtype=bool)
    lower, upper = np.full(len(names), -np.inf), np.full(len(names), np.inf)
    if limits:
        columns = coordinates.columns(names)
        lower, upper = coordinates.lower[columns] - _SLACK, coordinates.upper[columns] + _SLACK
    endless = ~slides & ~(upper - lower < FULL_TURN.lower)
    lower = np.where(endless, _CUT, lower)
    upper = np.where(endless, _CUT + FULL_TURN.upper + 1e-14, upper)
    columns, values = coordinates.columns(list(motors)), np.array([*motors.values()])
    polygons = Polygons(
        mechanism.kinematics.model,
        coordinates.with_values(mechanism.home.q, columns, values),
        [edge for edge, slide in zip(unknowns, slides, strict=True) if slide],
        [span for row in rows for span in row.spans],
    )
    sliding = {names[k]: k for k in np.flatnonzero(slides).tolist()}
    bounds = polygons.bounds({name: (lower[[k]], upper[[k]]) for name, k in sliding.items()})
    for name, k in sliding.items():
        lower[k], upper[k] = (float(end[0]) for end in bounds[name])
    if not np.isfinite(upper - lower).all():
        unbounded = names[int(np.flatnonzero(~np.isfinite(upper - lower))[0])]
        raise NoBoxesError(f"nothing bounds the passive slide {unbounded!r}")
    return Intervals(lower, upper), endless
