"""Nearest: the closed pose whose tool is nearest to a target, as far as motors lead downhill.

Levenberg–Marquardt on the motors while the target comes nearer as fast as it should; then Newton's
method on the distance itself, whose second derivatives come from differences of its exact gradient:
at the end of the reach the tool moves in fewer ways, and only they say how it goes on.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pmjac_pin.closing.levenberg_marquardt import by_singular_values
from pmjac_pin.configuration import Configuration
from pmjac_pin.studies.reach.motor_space import MotorSpace
from pmjac_pin.values.arrays import Array, Index, norm

# Relative to the characteristic length.
LONGEST_STEP = 0.25  # step
_NOTHING = 1e-13  # gap that no step improves
_OF_DIFFERENCES = 1e-5  # of differences: what is lost is its square
_SHORTEST_STEP = 1e-11  # step of Newton's method
_LEVEL = 1e-6  # gradient of the distance, m for each m of the motors
_MOST_DOWNHILL = 200
_MOST_NEWTON_STEPS = 40
_LITTLE_GAINED = 1e-6  # of the squared gap: less leaves the rest to Newton's method
_MOST_DAMPED = 1e12  # damping


def trail_to_nearest(space: MotorSpace, start: Configuration) -> Iterator[Configuration]:
    """Yield the poses on the way from a closed one to a local minimum of the distance."""
    point = start
    yield point
    for point in _downhill(space, start):
        yield point
    gap, _ = space.system(point)
    if norm(gap) > _NOTHING * space.length:
        yield from _settled(space, point)


def _downhill(space: MotorSpace, point: Configuration) -> Iterator[Configuration]:
    gap, rates = space.system(point)
    damping, length = 1e-4, space.length
    for _ in range(_MOST_DOWNHILL):
        if norm(gap) <= _NOTHING * length or damping > _MOST_DAMPED:
            return
        step = _damped(space, point, gap, rates, damping)
        trial = space.moved(point, step) if step.any() else None
        if trial is None:
            damping *= 8.0
            continue
        ahead = space.system(trial)
        if not norm(ahead[0]) < norm(gap):
            damping *= 8.0
            continue
        gained = 1.0 - (norm(ahead[0]) / norm(gap)) ** 2
        point, (gap, rates) = trial, ahead
        damping = max(damping / 8.0, 1e-12)
        yield point
        if gained < _LITTLE_GAINED:
            return


def _damped(
    space: MotorSpace, point: Configuration, gap: Array, rates: Array, damping: float
) -> Array:
    """Return the damped step of the motors that limits do not hold, not too long."""
    free = space.free(point, rates.T @ gap)
    step = np.zeros(free.size)
    if free.any():
        step[free] = by_singular_values(rates[:, free], gap, np.array(damping))
    return _capped(space, step)


def _capped(space: MotorSpace, step: Array) -> Array:
    return step * min(1.0, LONGEST_STEP * space.length / (norm(step) or 1.0))


def _settled(space: MotorSpace, point: Configuration) -> Iterator[Configuration]:
    """Yield Newton's poses towards where the distance's gradient vanishes and all ways lead up."""
    distance = norm(space.system(point)[0])
    for _ in range(_MOST_NEWTON_STEPS):
        step = _newton(space, point)
        if step is None:
            return
        while norm(step) > _SHORTEST_STEP * space.length:
            trial = space.moved(point, step)
            ahead = np.inf if trial is None else norm(space.system(trial)[0])
            if trial is not None and ahead <= distance * (1.0 + 1e-15):
                break
            step = 0.25 * step
        else:
            return
        point, distance = trial, ahead
        yield point


def _newton(space: MotorSpace, point: Configuration) -> Array | None:
    """Return the step to where the gradient vanishes, downhill where that is uphill."""
    uphill = _gradient(space, point)
    free = space.free(point, -uphill)
    hessian = _hessian(space, point, np.flatnonzero(free))
    if hessian is None or not free.any():
        return None
    values, vectors = np.linalg.eigh(hessian[np.ix_(free, free)])
    least = 1e-9 * max(float(np.abs(values).max()), 1e-30)
    along = vectors.T @ uphill[free] / np.maximum(np.abs(values), least)
    step = np.zeros(free.size)
    step[free] = -vectors @ along
    return _capped(space, step)


def is_nearest(space: MotorSpace, point: Configuration) -> bool:
    """Tell whether no motor that limits do not hold brings the target nearer, to first order."""
    gap, _ = space.system(point)
    uphill = _gradient(space, point)
    return norm(uphill[space.free(point, -uphill)]) <= _LEVEL * norm(gap)


def _gradient(space: MotorSpace, point: Configuration) -> Array:
    gap, rates = space.system(point)
    return -(rates.T @ gap)


def _hessian(space: MotorSpace, point: Configuration, motors: Index) -> Array | None:
    """Return differences of the gradient over steps of these motors; one-sided at a limit."""
    size, n = _OF_DIFFERENCES * space.length, len(point.actuated)
    hessian = np.zeros((n, n))
    for motor in motors.tolist():
        ends = [(space.moved(point, way * size * np.eye(n)[motor]), way) for way in (1.0, -1.0)]
        seen = [(_gradient(space, end), end.actuated[motor]) for end, _ in ends if end is not None]
        if not seen:
            return None
        if len(seen) < 2:
            seen.append((_gradient(space, point), point.actuated[motor]))
        apart = (seen[0][1] - seen[1][1]) / space.scale[motor]
        if not apart:
            return None
        hessian[:, motor] = (seen[0][0] - seen[1][0]) / apart
    return 0.5 * (hessian + hessian.T)
