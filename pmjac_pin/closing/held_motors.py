"""Closing the loops with the motors held where they are, from more than one start."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

import numpy as np

from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.closing.damped_closure import Assembled, assemble, motor_weights, unlimited
from pmjac_pin.values.arrays import Array

Room = Callable[[Array], tuple[Array | float, Array | float]]

#: How far the passive joints are shaken from where they were given, rad or share of the length:
#: nearby first, so that of several assembly modes the nearer ones are met first.
SHAKES = (0.03, 0.1, 0.3, 0.6, *4 * (1.0,), *8 * (1.5,), *8 * (3.0,))
_NEARLY_ALL = 8  # of them, where the gap is small already
_LIMIT = 100  # iterations from a shaken start: those that close at all mostly do within these
#: Of the length: a file with three digits is open by less.
ROUNDED_SHARE = 2e-3


def assemble_held(
    problem: ClosureProblem, q: Array, first: Assembled, room: Room = unlimited
) -> Assembled:
    """Return the best of a pose and of those from shaken starts, the motors at rest.

    Damped least squares ends in the nearest valley of the gap, which need not reach down to zero
    though another one does. So after q itself the starts are q with its passive joints shaken,
    seeded, by `SHAKES`: the nearer of them alone where the gap is small, as rounded numbers, the
    end of the reach or a flat pose leave it.

    Parameters
    ----------
    problem : ClosureProblem
    q : ndarray, shape (nq,)
        The motors at their values, the passive joints anywhere.
    first : Assembled
        What came of q itself: its loops are open.
    room : callable
        As for `assemble`.
    """
    best, weights = first, motor_weights(problem, 0.0)
    sizes = SHAKES[:_NEARLY_ALL] if is_rounding(problem, best.gap) else SHAKES
    for start in shaken(problem, q, sizes, weights):
        found = assemble(problem, start, weights, _LIMIT, room)
        if found.gap < best.gap:
            best = found
        if best.gap <= problem.tolerance:
            break
    return best


def shaken(
    problem: ClosureProblem, q: Array, sizes: Iterable[float], weights: Array
) -> Iterator[Array]:
    """Yield seeded random poses around q, at these sizes: rad or shares of the length."""
    rng, partition = np.random.default_rng(0), problem.partition
    scale = weights * partition.column_scale * partition.length
    for size in sizes:
        yield problem.integrate(q, size * scale * rng.normal(size=scale.size))


def is_rounding(problem: ClosureProblem, gap: float) -> bool:
    """Tell whether a gap is so small that rounded numbers may be its cause."""
    return gap <= ROUNDED_SHARE * problem.partition.length
