"""Efforts within limits: the smallest of all that balance a load, a quadratic programme.

Of efforts t + N y, with t orthogonal to the orthonormal columns of N, the smallest are those of the
smallest y: with |t + N y|ᵢ ≤ limitᵢ for all i a problem of least distance, min |y| where G y ≥ h.
Lawson and Hanson (*Solving Least Squares Problems*, chapter 23) make it one of least squares with
u ≥ 0, of the rows Gᵀ and hᵀ against (0, ..., 0, 1), whose residual r has y = −r / r_last. An active
set, so that the answer is exact but for rounding. SciPy has such least squares, and the linear
programme that says whether there is an answer at all.
"""

from __future__ import annotations

import numpy as np

from pmjac_pin.values.arrays import Array, Mask

JUST_WITHIN = 1e-10  # of the limits: what rounding may leave of motors that are at theirs
_SHARING = 1e-12  # of an internal effort of length 1
_PRESSING = 1e-9  # of multipliers that add up to 1
_ROUNDING = 1e-12  # of a limit


def needed_limits(particular: Array, internal: Array, limits: Array) -> Array:
    """Return what the limits of motors would have to be, shape (n,), 0 of those that do not press.

    Of a motor that no internal effort relieves that is its effort. Those that share are counted by
    the least factor of all limits with which some efforts are within them, and those of them press
    that hold it up: however they share, one of them is at so many times its limit.

    Parameters
    ----------
    particular : ndarray, shape (n,)
        t.
    internal : ndarray, shape (n, k)
        N.
    limits : ndarray, shape (n,)
    """
    sharing = np.linalg.norm(internal, axis=1) > _SHARING
    alone = np.where(sharing, 0.0, np.abs(particular))
    if not sharing.any():
        return alone
    # SciPy's programmes are imported with the first.
    from scipy.optimize import linprog  # noqa: PLC0415

    share = particular[sharing] / limits[sharing]
    ways, below = internal[sharing] / limits[sharing, None], -np.ones((share.size, 1))
    found = linprog(
        np.append(np.zeros(internal.shape[1]), 1.0),
        A_ub=np.block([[ways, below], [-ways, below]]),
        b_ub=np.concatenate([-share, share]),
        bounds=(None, None),
        options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
    )
    pressing = -found.ineqlin.marginals.reshape(2, -1).sum(axis=0) > _PRESSING
    factor = float(np.abs(share + ways @ found.x[:-1]).max())
    alone[sharing] = np.where(pressing, factor, 0.0) * limits[sharing]
    return alone


def least_within(particular: Array, internal: Array, limits: Array) -> Array:
    """Return y, shape (k,), of the least efforts within the limits.

    Parameters
    ----------
    particular, internal, limits
        As of `needed_limits`, which are no more than `limits`; t orthogonal to the columns of N,
        and these orthonormal.
    """
    bounds = limits * (1.0 + 2.0 * JUST_WITHIN)
    if not internal.shape[1] or (np.abs(particular) <= bounds).all():
        return np.zeros(internal.shape[1])
    from scipy.optimize import nnls  # noqa: PLC0415

    size = np.abs(particular).max()
    ways = np.vstack([-internal, internal]) * size
    least = np.concatenate([particular - bounds, -particular - bounds])
    rows = np.hypot(np.linalg.norm(ways, axis=1), np.abs(least))
    ways, least = ways / rows[:, None], least / rows
    target = np.append(np.zeros(internal.shape[1]), 1.0)
    pushing, _ = nnls(np.vstack([ways.T, least]), target, maxiter=30 * len(rows))
    share = rows / np.tile(bounds, 2)
    return np.asarray(size * _polished(ways, least, pushing > 0.0, share))


def _polished(ways: Array, least: Array, active: Mask, share: Array) -> Array:
    """Return the smallest y on the active rows, and such as rounding had left out, to all digits.

    `share` makes what a row lacks a share of its limit.
    """
    active = active.copy()
    while True:
        y = np.linalg.lstsq(ways[active], least[active], rcond=None)[0]
        lacking = np.where(active, 0.0, (least - ways @ y) * share)
        if lacking.max() <= _ROUNDING:
            return np.asarray(y)
        active[lacking.argmax()] = True
