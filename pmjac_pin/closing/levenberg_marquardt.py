"""Levenberg and Marquardt's damped least squares, from one start or from many at once.

    x = −E (J̃ᵀJ̃ + λ)⁻¹ J̃ᵀe,    J̃ = J E,

where E says how easily each unknown moves, and λ holds the step back: less after one that closes
further, more after one that does not. What is to be closed, its scales, and how patient one is
are given. All is over leading axes: one start has none, hundreds have one.

Sources: K. Levenberg, A method for the solution of certain non-linear problems in least squares,
Quarterly of Applied Mathematics 2 (1944); D. W. Marquardt, An algorithm for least-squares
estimation of nonlinear parameters, Journal of SIAM 11 (1963).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from pmjac_pin.values.arrays import Array, Index, Mask

_TINY_VALUE = 1e-9  # of the largest singular value: idle and redundant directions stay alone
_LEAST_DIVISOR = float(np.finfo(float).tiny)
TINY_SQUARE = 1e-12  #: of the diagonal of JᵀJ with columns of length one: it has an inverse


class Descent(Protocol):
    """What is to be closed, over poses q (..., nq): errors e (..., p) of unknowns x (..., k)."""

    def evaluate(self, q: Array) -> tuple[Array, Array]:
        """Return e (..., p) and J = ∂e/∂x (..., p, k)."""
        ...

    def ease(self, q: Array, error: Array, rows: Array, before: Array | None) -> Array:
        """Return how easily each unknown moves (..., k), by what it was a step before."""
        ...

    def fading(self, gap: Array) -> Array:
        """Return what the damping is multiplied by at gaps (...)."""
        ...

    def solution(self, rows: Array, error: Array, damping: Array) -> Array:
        """Return x of (JᵀJ + λ) x = Jᵀe: `by_singular_values` or `by_normal_equations`."""
        ...

    def bounded(self, q: Array, step: Array) -> Array:
        """Return steps x (..., k) that are not too long."""
        ...

    def moved(self, q: Array, step: Array) -> Array:
        """Return the poses after steps x (..., k)."""
        ...


@dataclass(frozen=True, slots=True)
class Patience:
    """When a start has arrived, and when it is given up; by default steps are Newton's.

    Attributes
    ----------
    steps : int
        Tried at most.
    enough : float
        A gap at which nothing is improved any more.
    tolerance : float
        A gap that counts as closed.
    damping : float
        At the start.
    least, most : float
        Of damping; one that needs more is given up.
    shrinks, grows : float
        By what damping is divided after a step that closes further, and multiplied after one that
        does not.
    grows_within : float
        The same within the tolerance.
    falling : float
        Of itself: a gap within the tolerance that falls less is the least there is.
    creeping, creeping_steps : float, int
        Of itself: an open gap that falls less in each of so many steps stays open.
    """

    steps: int
    enough: float
    tolerance: float = 0.0
    damping: float = 0.0
    least: float = 0.0
    most: float = np.inf
    shrinks: float = 1.0
    grows: float = 1.0
    grows_within: float = 1.0
    falling: float = 0.0
    creeping: float = 0.0
    creeping_steps: int = 1


class Descended(NamedTuple):
    """Where starts lead to: one, or many in their order.

    `closed` where the gap is small enough, `spent` where the steps were used up; the others were
    given up. `iterations` counts the steps tried until the pose was reached.
    """

    q: Array
    gap: Array
    iterations: Index
    closed: Mask
    spent: Mask


class Linearised(NamedTuple):
    """Poses q (..., nq) with their e and J, and how easily each unknown moves there."""

    q: Array
    error: Array
    rows: Array
    ease: Array


class _Starts(NamedTuple):
    """Where starts are that go on, and how they have fared; `which` of all they are."""

    points: Linearised
    gap: Array
    damping: Array
    creeping: Index
    least: Mask
    iterations: Index
    which: Index

    def only(self, which: Mask) -> _Starts:
        points, *rest = self
        some = Linearised._make(each[which] for each in points)
        return _Starts._make([some, *(each[which] for each in rest)])


def descend(descent: Descent, q: Array, patience: Patience) -> Descended:
    """Return where one start q (nq,), or many (b, nq), lead to."""
    here = _begun(descent, q, patience)
    ended: list[tuple[Index, Descended]] = []
    for tries in range(1, patience.steps + 1):
        closed = (here.gap <= patience.enough) | here.least
        over = closed | (here.damping >= patience.most)
        over |= here.creeping >= patience.creeping_steps
        if over.all():
            return _all_ended([*ended, _ended(here, closed, ~over)])
        if over.any():
            ended.append(_ended(here.only(over), closed[over], ~over[over]))
            here = here.only(~over)
        here = _after_a_step(descent, here, patience, tries)
    nowhere = here.gap < 0.0
    return _all_ended([*ended, _ended(here, nowhere, ~nowhere)])


def points_at(descent: Descent, q: Array) -> Linearised:
    """Return poses (..., nq) of which no step before is known."""
    error, rows = descent.evaluate(q)
    return Linearised(q, error, rows, descent.ease(q, error, rows, None))


def damped_step(descent: Descent, points: Linearised, damping: Array) -> Array:
    """Return steps x (..., k), not too long."""
    q, error, rows, ease = points
    return descent.bounded(q, -ease * descent.solution(rows * ease[..., None, :], error, damping))


def norms(vectors: Array) -> Array:
    """Return the Euclidean norms of vectors (..., n)."""
    found: Array = np.sqrt(np.vecdot(vectors, vectors))
    return found


def by_singular_values(rows: Array, error: Array, damping: Array) -> Array:
    """Return (JᵀJ + λ)⁻¹ Jᵀe, λ in squares of the largest singular value; exact near singularities.

    Parameters
    ----------
    rows : ndarray, shape (..., p, k)
    error : ndarray, shape (..., p)
    damping : ndarray, shape (...)
    """
    # No rank is said here: what vanishes is held back by damping.
    left, values, right = np.linalg.svd(rows, full_matrices=False)
    squares = values * values
    held = (damping[..., None] + _TINY_VALUE**2) * squares[
        ..., :1
    ] + _LEAST_DIVISOR  # J may be zero
    along = (values / (squares + held))[..., None, :] * (error[..., None, :] @ left)
    return np.asarray((along @ right)[..., 0, :])


def by_normal_equations(rows: Array, error: Array, damping: Array) -> Array:
    """Return (JᵀJ + λ)⁻¹ Jᵀe at a tenth of the cost: of columns of about length one.

    Squares of singular values below 1e-8 drown in rounding; steps along these are too short.

    Parameters
    ----------
    rows : ndarray, shape (..., p, k)
    error : ndarray, shape (..., p)
    damping : ndarray, shape (...)
    """
    across = rows.swapaxes(-1, -2)
    square = across @ rows
    diagonal = np.einsum("...ii->...i", square)
    diagonal += (damping + TINY_SQUARE)[..., None]
    return np.asarray(np.linalg.solve(square, across @ error[..., None])[..., 0])


def _begun(descent: Descent, q: Array, patience: Patience) -> _Starts:
    points = points_at(descent, q)
    gap = norms(points.error)
    least = gap < 0.0
    nothing = 0 * least
    damping: Array = patience.damping + 0.0 * gap
    which = np.arange(gap.size).reshape(gap.shape)
    return _Starts(points, gap, damping, nothing, least, nothing, which)


def _ended(here: _Starts, closed: Mask, spent: Mask) -> tuple[Index, Descended]:
    return here.which, Descended(here.points.q, here.gap, here.iterations, closed, spent)


def _all_ended(ended: list[tuple[Index, Descended]]) -> Descended:
    if len(ended) == 1:
        return ended[0][1]
    order = np.argsort(np.concatenate([which for which, _ in ended]))
    each = zip(*(ends for _, ends in ended), strict=True)
    return Descended(*(np.concatenate(one)[order] for one in each))


def _after_a_step(descent: Descent, here: _Starts, patience: Patience, tries: int) -> _Starts:
    """Try a step from each pose, and take those that close further."""
    points, gap, damping = here.points, here.gap, here.damping
    step = damped_step(descent, points, damping * descent.fading(gap))
    q = descent.moved(points.q, step)
    error, rows = descent.evaluate(q)
    reached = norms(error)
    better, within = reached < gap, gap <= patience.tolerance
    falls = within | (reached < (1.0 - patience.creeping) * gap)
    least = within & better & (reached >= (1.0 - patience.falling) * gap)
    eased = np.maximum(damping / patience.shrinks, patience.least)
    iterations = 0 * here.iterations + tries
    if not better.all():
        grows = np.where(within, patience.grows_within, patience.grows)
        # Where nothing moves, damping changes nothing.
        harder = np.where(step.any(axis=-1), damping * grows, np.inf)
        eased = np.where(better, eased, harder)
        q = np.where(better[..., None], q, points.q)
        error = np.where(better[..., None], error, points.error)
        rows = np.where(better[..., None, None], rows, points.rows)
        reached = np.where(better, reached, gap)
        iterations = np.where(better, iterations, here.iterations)
    return _Starts(
        points=Linearised(q, error, rows, descent.ease(q, error, rows, points.ease)),
        gap=reached,
        damping=eased,
        creeping=~falls * (here.creeping + better),
        least=least,
        iterations=iterations,
        which=here.which,
    )
