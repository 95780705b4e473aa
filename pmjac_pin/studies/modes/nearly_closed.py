"""Nearly closed poses: modes that rounded numbers leave open by more than the tolerance."""

from __future__ import annotations

from collections.abc import Iterable

from pmjac_pin.closing.closed import closed_point
from pmjac_pin.closing.damped_closure import assemble, motor_weights
from pmjac_pin.closing.held_motors import is_rounding
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.rounded_numbers import wider_tolerance
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.values.arrays import Array, norm

_MOST_POSES = 16  # poses that are looked at
_LEAST_GAIN = 1e-2  # of a gap: what K* could take off it to first order, where it is least


def rounded_gaps(mechanism: Mechanism, rows: Iterable[Array]) -> list[float]:
    """Return the least gaps near rows of q that rounding of the model's numbers may have opened, m.

    K* has its generic rank there: equations that repeat others contradict them by a little. Beyond
    a fold, where the motors' values are out of reach, K* is singular where the gap is least.
    """
    problem, gaps = mechanism.problem, []
    for q in rows:
        found = assemble(problem, q, motor_weights(problem, 0.0))
        if found.gap <= problem.tolerance or not is_rounding(problem, found.gap):
            continue
        factors = closed_point(problem, found.q).factors
        error = problem.evaluate(found.q)[0] * problem.partition.row_scale
        falls = norm(factors.left[:, : factors.rank].T @ error) > _LEAST_GAIN * found.gap
        if factors.rank >= problem.partition.passive_rank and not falls:
            gaps.append(found.gap)
            if len(gaps) == _MOST_POSES:
                break
    return gaps


def with_rounded(mechanism: Mechanism, gaps: list[float], evidence: Evidence) -> Evidence:
    """Say that poses are open by these gaps and what tolerance they need: then nothing is sure."""
    problem = mechanism.problem
    missed = (
        f"poses open by {max(gaps):.2g} m at most miss the tolerance of {problem.tolerance:.2g} m"
    )
    advice = wider_tolerance(max(gaps), problem.largest_tolerance)
    return Evidence("nothing", f"{evidence.statement}; {missed} and are left out: give {advice}")
