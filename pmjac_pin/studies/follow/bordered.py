"""Where a path is singular, by Newton's method on a bordered system, quadratic where q is steep.

A is G_y at a fold, square, and G_x where branches meet, with one column more. With borders b (r, 1)
and C (c, k), k = c − r + 1,

    [ A  b ] [ V ]   [ 0 ]
    [ Cᵀ 0 ] [ gᵀ] = [ I ],    Aᵀ w + C h = 0,  bᵀ w = 1,

is regular, g vanishes where A loses one rank, and g' = −wᵀ A' V. At a fold the unknowns x of
G = 0, g = 0 are as many as the equations. Where branches meet there are two numbers g, and one
unknown more, μ, of G + μ b = 0: loops that close to branches that meet have μ = 0, and such as keep
them apart have not.

References
----------
Govaerts, *Numerical Methods for Bifurcations of Dynamical Equilibria*, SIAM 2000, chapters 3, 4, 7.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from pmjac_pin.studies.follow.path_equations import PathEquations
from pmjac_pin.values.arrays import Array, norm

_LAST_STEP = 1e-13  # of a length: the last step was quadratic
_BORDERED_STEPS = 25
_LONGEST_STEP = 0.1  # of a length or rad: one step
_ONE_RANK = 1e-6  # of G_x: what only one motion that comes free leaves


@dataclass(frozen=True, slots=True, eq=False)
class SingularSpot:
    """Where A loses rank on a path.

    Attributes
    ----------
    equations : PathEquations
    q : ndarray, shape (nq,)
    t : float
    null : ndarray, shape (c, k)
        V.
    left : ndarray, shape (r,)
        w.
    apart : float
        μ, in lengths: 0 for a fold.
    """

    equations: PathEquations
    q: Array
    t: float
    null: Array
    left: Array
    apart: float


def singular_spot(
    equations: PathEquations, q: Array, t: float, what: Literal["fold", "branches"]
) -> SingularSpot | None:
    """Return where a path folds, or where branches meet, near a pose; None where nothing is found.

    Parameters
    ----------
    equations : PathEquations
    q, t
        Where to begin.
    what : {"fold", "branches"}
    """
    rank, length = equations.rank, equations.course.problem.partition.length
    columns = rank if what == "fold" else rank + 1
    apart = 0.0
    for _ in range(_BORDERED_STEPS):
        G, Gx = equations.at(q, t)
        A = Gx[:, :columns]
        left, _, right = np.linalg.svd(A)
        b, C = left[:, -1:], right[rank - 1 :].T
        V, g, w = _bordered(A, b, C)
        slopes = equations.slopes(q, t, np.eye(rank + 1))[:, :, :columns]
        slope_rows = -np.einsum("i,xic,ck->kx", w, slopes, V)
        system, value = np.vstack([Gx, slope_rows]), np.concatenate([G + apart * b[:, 0], g])
        if what == "branches":
            system = np.column_stack([system, np.append(b[:, 0], np.zeros(len(g)))])
        try:
            step = -np.linalg.solve(system, value)
        except np.linalg.LinAlgError:
            return None
        size = norm(step[: rank + 1]) / length
        if not np.isfinite(size):
            return None
        if size > _LONGEST_STEP:
            step *= _LONGEST_STEP / size
        q, t = equations.moved(q, t, step[: rank + 1])
        apart += float(step[-1]) if what == "branches" else 0.0
        if size <= _LAST_STEP**0.5 * 1e-1 and norm(value) <= _LAST_STEP * 10 * length:
            return _of_one_rank(SingularSpot(equations, q, t, V, w, apart / length), A)
    return None


def _bordered(A: Array, b: Array, C: Array) -> tuple[Array, Array, Array]:
    """Return V (c, k), g (k,) and w (r,)."""
    (r, c), k = A.shape, C.shape[1]
    matrix = np.block([[A, b], [C.T, np.zeros((k, 1))]])
    right = np.vstack([np.zeros((r, k)), np.eye(k)])
    found = np.linalg.solve(matrix, right)
    turned = np.linalg.solve(matrix.T, np.append(np.zeros(c), 1.0))
    return found[:c], found[c], turned[:r]


def _of_one_rank(spot: SingularSpot, A: Array) -> SingularSpot | None:
    """Return the spot where one rank is lost and no more."""
    values = np.linalg.svd(A, compute_uv=False)
    if len(values) > 1 and values[-2] <= _ONE_RANK * values[0]:
        return None
    return spot
