"""Idle and gained: which of the motions that are free at a singular pose are free at every pose.

At a singular pose the null space of K* holds the idle motions, those that are free at every pose
(a rod that spins between two ball joints), and what comes free here. One matrix cannot tell
them apart; what K* becomes on the way to other poses can. Let N and W span null K* and
null K*ᵀ at the pose q, and let v be a motion that the loops allow, [K K*] v = 0. Along it

    Wᵀ K*(q ⊕ t v) N = t B(v) + O(t²),    B(v) = Wᵀ (∂K*/∂q · v) N,

is what decides the rank (its Schur complement differs by O(t²)): the vanishing singular values
of K* grow like t σ(B(v)), and null K*(q ⊕ t v) tends to N null B(v) as t → 0. A motion that is
idle wherever the loops allow to go is in null B(v) for every v, so that the idle space is

    N ∩ᵥ null B(v),

and, B being linear in v, one for each v of a basis is enough. What is gained is told modulo
that space: its orthogonal complement in null K*, on dimensionless rates.

Where B does not see all that is gained (K* changes to second order only) or too
much (branches meet, and not every v leads somewhere), the idle space is the mean of null K* at
regular poses nearby. Where there are none either, they are not told apart.

A hair beside a singular pose the singular values of K* still tell (`Factorisation.tells_apart`).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.closing.damped_closure import assemble
from pmjac_pin.rates.factorisation import Factorisation, factorise
from pmjac_pin.rates.partition import LoopRates
from pmjac_pin.values.arrays import Array, norm

_DIFFERENCE_STEP = 1e-3  # of the characteristic length, of differences of fourth order
_NOTICED = 1e-3  # of the size of [K K*]: how much K* changes where a radian or a length is moved
_PROBE_DISTANCES = (1e-3, 1e-2, 1e-1)  # of the characteristic length, to regular poses nearby


def gained_and_idle(problem: ClosureProblem, q: Array, rank: int) -> tuple[Array, Array]:
    """Split null K* at a closed pose into what is gained there and what is idle.

    Parameters
    ----------
    problem : ClosureProblem
    q : ndarray, shape (nq,)
    rank : int
        Of K* here.

    Returns
    -------
    gained, idle : ndarray, shapes (m_p, g) and (m_p, d)
        Orthonormal columns on the scaled rates, together a basis of null K*; d is m_p less the
        generic rank, or 0 where nothing tells them apart.
    """
    partition = problem.partition
    loops = partition.loop_rates(problem.evaluate(q)[1])
    scaled, passive = loops.scaled, loops.passive
    free, gained = passive.right[rank:].T, partition.passive_rank - rank
    if gained <= 0 or gained == free.shape[1]:
        return (free, free[:, :0]) if gained > 0 else (free[:, :0], free)
    turned = _by_what_changes(problem, q, scaled, passive, rank)
    if turned is None:
        turned = _by_neighbours(problem, q, scaled, free)
    if turned is None:
        return free, free[:, :0]
    return free @ turned[:, :gained], free @ turned[:, gained:]


def _by_what_changes(
    problem: ClosureProblem, q: Array, scaled: Array, passive: Factorisation, rank: int
) -> Array | None:
    """Return an orthogonal matrix, its first columns gained, the others in all null B(v)."""
    seen = _changes(problem, q, scaled, passive, rank)
    return seen.right.T if seen.rank == problem.partition.passive_rank - rank else None


def _changes(
    problem: ClosureProblem, q: Array, scaled: Array, passive: Factorisation, rank: int
) -> Factorisation:
    """Return B(v) factorised, for all v of a basis one above the other."""
    partition = problem.partition
    free, left = passive.right[rank:].T, passive.left[:, rank:]
    allowed = partition.factorise(scaled, partition.size_of(scaled)).null_space
    changes = [left.T @ _derivative(problem, q, v) @ free for v in allowed.T]
    return factorise(np.vstack([free[:0], *changes]), partition.size_of(scaled), _NOTICED)


def rank_changes(problem: ClosureProblem, q: Array, rates: LoopRates) -> bool:
    """Tell whether K* has another rank at once where a closed pose is left as loops allow."""
    passive = rates.passive
    return bool(_changes(problem, q, rates.scaled, passive, passive.rank).rank)


def _derivative(problem: ClosureProblem, q: Array, v: Array) -> Array:
    """Return the change of the scaled K* where the joints move by the length along v."""
    partition = problem.partition
    stride = _DIFFERENCE_STEP * partition.length * partition.column_scale * v

    def passive_columns(steps: int) -> Array:
        there = problem.evaluate(problem.integrate(q, steps * stride))[1]
        columns: Array = partition.scaled(there)[:, partition.passive]
        return columns

    near, far = (passive_columns(k) - passive_columns(-k) for k in (1, 2))
    change: Array = (8.0 * near - far) / (12.0 * _DIFFERENCE_STEP)
    return change


def _by_neighbours(problem: ClosureProblem, q: Array, scaled: Array, free: Array) -> Array | None:
    """Return an orthogonal matrix, its last columns those nearest to null K* at regular poses."""
    for distance in _PROBE_DISTANCES:
        if found := list(_regular_null_spaces(problem, q, scaled, distance)):
            nearest_first = factorise(free.T @ np.hstack(found), 1.0).left
            return nearest_first[:, ::-1]
    return None


def _regular_null_spaces(
    problem: ClosureProblem, q: Array, scaled: Array, distance: float
) -> Iterator[Array]:
    partition = problem.partition
    stride = distance * partition.length * partition.column_scale
    for v in partition.factorise(scaled, partition.size_of(scaled)).null_space.T:
        for way in (stride * v, -stride * v):
            pose = assemble(problem, problem.integrate(q, way), np.ones(way.size), limit=50)
            there = partition.scaled(problem.evaluate(pose.q)[1])
            factors = partition.factorise(there[:, partition.passive], norm(there))
            if pose.gap <= problem.tolerance and factors.rank == partition.passive_rank:
                yield factors.null_space
