"""Least motion: of all poses that meet a target, the one whose motors are nearest to given values.

θ moves by J⁺ e towards the target and by (I − J⁺J)(θ₀ − θ) along the self-motion, until neither is
left: there θ₀ − θ is in the range of Jᵀ, which is the condition for the least distance |θ₀ − θ|.
Where motors are at limits, θ₀ − θ = Jᵀλ + μ, μ of these alone and outwards: a self-motion that
leads a motor off its limit is gone as well.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import nnls

from pmjac_pin.configuration import Configuration
from pmjac_pin.rates.factorisation import factorise
from pmjac_pin.studies.reach.motor_space import NO_MOTION, MotorSpace
from pmjac_pin.studies.reach.nearest import LONGEST_STEP
from pmjac_pin.values.arrays import Array, norm

_LEAST = 1e-8  # of the characteristic length: what may be left of a self-motion
_NOTHING_LEFT = 1e-12
_MOST_MOVES = 300
_NO_FARTHER = 1.0 + 1e-12  # of the distance before
_SLOWER = 0.5  # where a step overshoots


def least_motion(space: MotorSpace, point: Configuration, wanted: Array) -> Configuration:
    """Move along the self-motion at a target, as near to wanted motor values as it leads.

    Parameters
    ----------
    space : MotorSpace
    point : Configuration
        At the target.
    wanted : ndarray, shape (n,)
        Motor values, m or rad.
    """
    pace, before = 1.0, np.inf
    towards, along = _ways_on(space, point, wanted)
    for _ in range(_MOST_MOVES):
        left = norm(along) / space.length
        if left <= _NOTHING_LEFT and norm(towards) <= _NOTHING_LEFT * space.length:
            break
        away = norm((wanted - point.actuated) / space.scale)
        pace = pace * _SLOWER if away > before * _NO_FARTHER else min(1.0, pace / _SLOWER)
        before = away
        step = towards + pace * along
        step *= min(1.0, LONGEST_STEP * space.length / norm(step))
        trial = space.moved(point, space.up_to_limits(point, step))
        if trial is None:
            if pace < _NOTHING_LEFT:
                break
            pace *= _SLOWER
            continue
        point = trial
        towards, along = _ways_on(space, point, wanted)
    return point


def is_least_motion(space: MotorSpace, point: Configuration, wanted: Array) -> bool:
    """Tell whether no self-motion at a target brings the motors nearer to wanted values."""
    return norm(_ways_on(space, point, wanted)[1]) <= _LEAST * space.length


def _ways_on(space: MotorSpace, point: Configuration, wanted: Array) -> tuple[Array, Array]:
    """Return the step towards the target, and the one along the self-motion, in m.

    The latter is what is nearest to the way to wanted values of all self-motions that lead no motor
    beyond its limit: Moreau's decomposition, of which μ ≥ 0 is the other part.
    """
    gap, rates = space.system(point)
    away = (wanted - point.actuated) / space.scale
    inverse = _inverse(rates)
    self_motions = np.eye(away.size) - inverse @ rates
    along, barriers = self_motions @ away, space.barriers(point)
    if not len(barriers):
        return inverse @ gap, along
    outwards = self_motions @ barriers.T
    pressing, _ = nnls(outwards, along)
    held = barriers[pressing > 0.0].any(axis=0)
    return _inverse(np.where(held, 0.0, rates)) @ gap, along - outwards @ pressing


def _inverse(rates: Array) -> Array:
    factors = factorise(rates, norm(rates), NO_MOTION)
    return factors.inverse(factors.rank)
