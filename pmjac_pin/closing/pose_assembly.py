"""Closing the loops of a pose that a model file gives, which may be wide open."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.closing.damped_closure import Assembled, assemble, motor_weights, unlimited
from pmjac_pin.closing.held_motors import Room, assemble_held, is_rounding, shaken
from pmjac_pin.closing.parts import Parts
from pmjac_pin.errors import ClosureError
from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.model.limits import SWITCH, Violation, limit_error, violations
from pmjac_pin.model.rounded_numbers import wider_tolerance
from pmjac_pin.model.spec import MechanismSpec
from pmjac_pin.values.arrays import Array, norm

# How easily the motors move, beside the passive joints, where a pose does not assemble with them
# at rest: reluctantly, then like the others.
_MOTOR_WEIGHTS = (0.1, 1.0)
_FAR_MOTORS = 1e-2  # lengths: at the end of the reach, motors move about as far as the gap
_STARTS_WITHIN = 64  # random, within all limits
_MOST_SHAKEN = 8
FOLDS = (0.03, 0.03, 0.1, 0.1, 0.3, 0.3, 0.6, 0.6)  # rad or share of the length


def assemble_pose(parts: Parts, q: Array, pose: str) -> Array:
    """Close the loops near q, within the joints' limits if the spec enforces them.

    Where it does not, a pose that starts within them is looked for within them first, so that a
    file that keeps to them means the same pose either way.

    The motors stay where they are where a closed pose is found with them at rest, from q itself or
    from one of the starts of `assemble_held`; elsewhere they move as little as it takes.

    Raises
    ------
    ClosureError
        With the smallest gap found and the loop that stays open most, or with the joints that
        leave their limits where the loops close.
    """
    coordinates = parts.coordinates
    if parts.spec.enforce_limits:
        return _assembled(parts, q, pose, coordinates.room)
    if not violations(coordinates, q, coordinates.names):
        with suppress(ClosureError):
            return _assembled(parts, q, pose, coordinates.room)
    return _assembled(parts, q, pose, unlimited)


def _assembled(parts: Parts, q: Array, pose: str, room: Room) -> Array:
    problem = parts.split
    found = [assemble(problem, q, motor_weights(problem, 0.0), room=room)]
    if found[0].gap > problem.tolerance:
        found = [assemble_held(problem, q, found[0], room)]
    if found[0].gap <= problem.tolerance:
        return found[0].q
    for motor_weight in _MOTOR_WEIGHTS:
        found.append(assemble(problem, q, motor_weights(problem, motor_weight), room=room))
        if found[-1].gap > problem.tolerance:
            continue
        if is_rounding(problem, found[0].gap) and _moved(problem, q, found[-1].q) > _FAR_MOTORS:
            break
        return _beyond_the_end(parts, q, found[-1].q, room)
    # A small gap that stays is the rounding of the model's numbers: no fold would cure it, and
    # motors that moved far for it would hide it.
    best = found[0] if is_rounding(problem, found[0].gap) else min(found, key=lambda it: it.gap)
    if not is_rounding(problem, best.gap) and (folded := _folded(parts, q, room)) is not None:
        return folded
    raise _open(parts, q, best, pose, room)


def _moved(problem: ClosureProblem, start: Array, end: Array) -> float:
    """Return how far the motors moved, in characteristic lengths."""
    partition = problem.partition
    moves = problem.difference(start, end) / partition.column_scale
    return norm(moves[partition.actuated]) / partition.length


def _folded(parts: Parts, q: Array, room: Room) -> Array | None:
    """Return a closed pose from shaken starts, all joints free to move."""
    # From a pose that is straight or flat, as many are with all joints at zero, the gap does not
    # say which way the joints should fold.
    problem, weights = parts.split, motor_weights(parts.split, 1.0)
    for start in shaken(problem, q, FOLDS, weights):
        found = assemble(problem, start, weights, room=room)
        if found.gap <= problem.tolerance:
            return found.q
    return None


def check_motors(coordinates: JointCoordinates, q: Array, spec: MechanismSpec, what: str) -> None:
    """Raise LimitError where a motor is outside its limits; the message starts with `what`."""
    if not spec.enforce_limits:
        return
    columns, names = coordinates.columns(spec.actuated), coordinates.dof_names(spec.actuated)
    values = coordinates.values(q)[columns]
    for name in coordinates.outside(values, columns):
        value = float(values[names.index(name)])
        found = {name: Violation.of(coordinates, name, value)}
        raise limit_error(f"{what} a motor beyond its limits: ", found, SWITCH)


def _beyond_the_end(parts: Parts, start: Array, found: Array, room: Room) -> Array:
    """Return the pose with motors moved half as far again as it takes, where that closes.

    Where the motors have to move, the nearest closed pose is at the end of the reach: singular.
    """
    problem, coordinates = parts.split, parts.coordinates
    actuated = problem.partition.actuated
    motors, moved = (coordinates.values(q)[actuated] for q in (start, found))
    beyond = moved + 0.5 * (moved - motors)
    q = coordinates.with_values(start, actuated, beyond)
    pose = assemble(problem, q, motor_weights(problem, 0.0), room=room)
    kept = room is unlimited or not coordinates.outside(beyond, actuated)
    return pose.q if pose.gap <= problem.tolerance and kept else found


def _open(parts: Parts, q: Array, best: Assembled, pose: str, room: Room) -> ClosureError:
    """Say which loop stays open, or which joints leave their limits where it closes."""
    problem, coordinates = parts.split, parts.coordinates
    what = f"{parts.spec.name}: the pose {pose!r}"
    freely = assemble(problem, q, motor_weights(problem, 1.0))
    outside = violations(coordinates, freely.q, coordinates.names)
    if room is not unlimited and freely.gap <= problem.tolerance and outside:
        beyond = "; ".join(f"{name!r} = {one.words}" for name, one in outside.items())
        message = f"{what} closes where {beyond}; {_within_limits(parts)}{SWITCH}"
        return ClosureError(message, residual_norm=best.gap, q=best.q)
    residual = np.abs(problem.evaluate(best.q)[0] * problem.partition.row_scale)
    row, loops = int(np.argmax(residual)), parts.kinematics.loops
    message = (
        f"{what} does not assemble: the loops stay open by {best.gap:.3g} m, the least "
        f"from several starts, most at {loops.row_names[row]!r}; give joint values nearer to a "
        "closed pose, or other lengths"
    )
    if is_rounding(problem, best.gap):
        message += f", or {wider_tolerance(best.gap, problem.largest_tolerance)}"
    return ClosureError(message, residual_norm=best.gap, q=best.q, loop=loops.row_loops[row])


def _within_limits(parts: Parts) -> str:
    """Say whether the loops close within all limits, as far as random starts tell."""
    problem, coordinates = parts.split, parts.coordinates
    rng = np.random.default_rng(0)
    weights = motor_weights(problem, 1.0)
    for _ in range(_STARTS_WITHIN):
        q = _anywhere(parts, rng)
        found = assemble(problem, q, weights, room=coordinates.room)
        if found.gap <= problem.tolerance:
            pose = coordinates.joint_values(found.q, coordinates.names[:_MOST_SHAKEN])
            values = ", ".join(f"{name} = {_few_digits(value)}" for name, value in pose.items())
            more = ", ..." * (len(coordinates.names) > _MOST_SHAKEN)
            return f"within all limits they close elsewhere, at {values}{more}"
    return f"from {_STARTS_WITHIN} random starts no pose within all limits was found"


def _anywhere(parts: Parts, rng: np.random.Generator) -> Array:
    """Return a random pose within the limits; what has none is around its home value."""
    problem, coordinates = parts.split, parts.coordinates
    length, turns = problem.partition.length, coordinates.rotational
    spread = np.where(turns, np.pi, 2.0 * length)
    q = problem.integrate(parts.home_q, spread * rng.uniform(-1.0, 1.0, spread.size))
    columns = np.flatnonzero(np.isfinite(coordinates.lower) & np.isfinite(coordinates.upper))
    values = coordinates.values(parts.home_q)[columns]
    lower = np.maximum(coordinates.lower[columns], values - 2.0 * spread[columns])
    upper = np.minimum(coordinates.upper[columns], values + 2.0 * spread[columns])
    between = lower + (upper - lower) * rng.uniform(size=columns.size)
    inside = np.clip(between, coordinates.lower[columns], coordinates.upper[columns])
    return coordinates.with_values(q, columns, inside)


def _few_digits(value: float | tuple[float, ...]) -> str:
    """Return a joint's value, or values, in a few digits."""
    if isinstance(value, tuple):
        return f"({', '.join(f'{one:.4g}' for one in value)})"
    return f"{value:.4g}"
