"""Direct kinematics: from motor values and a guess to the closed pose on the guess's mode."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np

from pmjac_pin.algebra.one_thread import one_thread_from
from pmjac_pin.closing.closed import closed_point
from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.closing.damped_closure import Assembled, assemble, motor_weights
from pmjac_pin.closing.held_motors import assemble_held
from pmjac_pin.closing.motor_values import MotorValues, by_joint, motor_values
from pmjac_pin.closing.over_actuation import ties_in_words, walk_led
from pmjac_pin.closing.straight_path import MOST_STEPS, Followed, follow
from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError, ClosureError
from pmjac_pin.model.limits import Violation, enforced, limit_error
from pmjac_pin.model.rounded_numbers import wider_tolerance
from pmjac_pin.values.arrays import Array, norm
from pmjac_pin.values.named_values import named_values

if TYPE_CHECKING:
    from pmjac_pin.mechanism import Mechanism

Guess: TypeAlias = "str | Configuration | Mapping[str, float | Sequence[float]]"

_ARRIVED = 1e-9  # m or rad
_GO_ON = "go on from there, the error's `reached`, as guess"
_IN_BETWEEN = "go there by motor values in between"
_TOO_NEAR = (
    "the loops close at these values, so near to a singularity of the straight path of the other "
    f"motors that which assembly mode they are on is not told; {_IN_BETWEEN}"
)
_BESIDE_AN_END = 1e-2  # lengths or rad: nearer to where a path ends, its mode may be the one found
_FAR_AWAY_GAP = 1e-9  # of the characteristic length: a gap of a pose far away, closed as it can be
_SAME_POSE = 1e-5  # lengths or rad: what rounding moves a regular pose by, at most
_SMALL = 1e-4  # of the characteristic length: a gap of a target hardly missed, or of rounding
_NEARLY_SINGULAR = 1e-3  # relative singular value of K* that explains why a path ended


def close(
    mechanism: Mechanism,
    actuated: MotorValues,
    guess: Guess = "home",
    *,
    enforce_limits: bool | Literal["all"] = True,
) -> Configuration:
    """Close the loops at these motor values: direct kinematics by continuation.

    Walks from the guess to the target along a straight line in the motor values, with
    Newton's method on the passive joints at every step, and stays on the guess's assembly
    mode. A step is taken only where K* is shown to be regular along the whole of it, from
    its values at three poses and bounds on its derivatives from the links' lengths: what
    comes closer to singular than 1e-6 ends the path, and only the target itself may be
    singular. `docs/closing_loops.md` says what this rests on: with joints that are not known
    (composite, universal), the three poses alone. With more motors than freedom, as many
    as may move at will walk straight, and the values of the others must fit at the end, on
    the same side of each fold of that walk; an error says first how the loops tie them. What
    idles, as a rod that spins about itself, ends where it has not moved from the guess,
    whatever the steps were (`docs/closing_loops.md`).

    Parameters
    ----------
    actuated : array_like, shape (n,), or mapping of str to float
        Motor values, m or rad: in the order of `actuated`, or by name where they have names,
        as those of a pandas Series do.
    guess : str, Configuration or mapping of str to float
        Where to start: a pose's name, a configuration, or joint values; joints that a
        mapping does not name are taken from the target (motors) and from home. The loops
        of a mapping are closed as those of a pose are, the motors at rest; it is an error
        where that fails.
    enforce_limits : bool or "all"
        Refuse motor values outside the motors' limits; with "all", also a pose that has a
        passive joint outside its limits. Passive joints are looked at where the path ends,
        not on the way; without "all", `Configuration.limits_violated` names them.

    Returns
    -------
    Configuration
        Closed to `tolerance`.

    Raises
    ------
    ClosureError
        The path meets a singularity, the target is out of reach, the loops forbid the motors
        to move so together (`ties` says how they tie them), or the path is too long for one
        call. Attributes: the smallest gap found at the target (`residual_norm`, `q`), the
        last closed pose on the path (`reached`, a Configuration), the `share` of the path
        up to there.
    LimitError, ArgumentError, UnknownNameError

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> mechanism = pj.load("three_rps")
    >>> configuration = mechanism.close([1.0, 1.1, 0.9])
    >>> nearby = mechanism.close([1.0, 1.1, 0.95], guess=configuration)
    """
    whose = "motors" if enforce_limits is True else enforced(enforce_limits)
    values = None if whose == "none" else mechanism.motors.within_limits(actuated)
    if values is None:
        parts = mechanism._parts
        values = motor_values(parts.spec, parts.coordinates, actuated)
        if whose != "none":
            check_limits(mechanism, values)
    start = start_of(mechanism, guess, values)
    closed = _end_of_path(mechanism, start, values)
    if whose == "all" and (beyond := closed.limits_violated):
        what = f"{mechanism.name}: at these motor values, on this assembly mode, "
        raise limit_error(what, beyond, "; enforce_limits=True asks for the motors' alone")
    return closed


def _end_of_path(mechanism: Mechanism, start: Configuration, values: Array) -> Configuration:
    """Return where the path from a closed pose to motor values ends, or say why it does not."""
    problem, ahead = start.problem, None
    if problem is mechanism._parts.problem:
        ahead = mechanism.recorded.path(start.q, values)
    if ahead is None:
        path = _walked(mechanism, start, values)
    else:
        reached = Configuration._certified(
            mechanism, ahead.q, ahead.iterations, ahead.gap, problem=problem
        )
        if ahead.share == 1.0:
            return reached
        rest = _walked(mechanism, reached, values)
        share = rest.share if rest.share == 1.0 else ahead.share + (1.0 - ahead.share) * rest.share
        path = rest._replace(share=share, iterations=ahead.iterations + rest.iterations)
    if path.share < 1.0:
        raise _stopped(mechanism, values, start, path)
    return Configuration._of_point(mechanism, path.point, path.iterations, problem)


def _walked(mechanism: Mechanism, start: Configuration, values: Array) -> Followed:
    """Walk from a closed pose to motor values by singular values."""
    with one_thread_from(mechanism.nv):
        problem, guard, motors = start.problem, mechanism.step_guard, mechanism.motors
        partition = problem.partition
        if partition.constraint_rank > partition.passive_rank:
            return walk_led(problem, mechanism._parts.coordinates, guard, start._point, values)
        displacement, point = motors.way(start.q, values), start._point
        if partition.idles and (idle := mechanism.idle_way) is not None:
            from pmjac_pin.closing.idle_path import IdlePath  # noqa: PLC0415

            target = _on_the_way(mechanism, start, displacement, values)
            return IdlePath(problem, guard, idle, point, displacement, target).walk()
        return follow(problem, guard, point, displacement, lambda q: motors.at(q, values))


def _on_the_way(
    mechanism: Mechanism, start: Configuration, displacement: Array, values: Array
) -> Callable[[Array, float], Array]:
    """Return (q, share) ↦ q with the motors at that share of a straight way, at its end exactly."""
    problem, motors, coordinates = start.problem, mechanism.motors, mechanism.coordinates
    columns = problem.partition.actuated
    way = np.zeros(mechanism.nv)
    way[columns] = displacement

    def target(q: Array, share: float) -> Array:
        if share == 1.0:
            return motors.at(q, values)
        there = coordinates.values_of(problem.integrate(start.q, share * way), columns)
        return motors.at(q, there)

    return target


def check_limits(mechanism: Mechanism, values: Array) -> None:
    """Raise LimitError where a motor value is outside its joint's limits."""
    parts = mechanism._parts
    for name in parts.coordinates.outside(values, parts.problem.partition.actuated):
        value = float(values[mechanism.actuated.index(name)])
        found = {name: Violation.of(parts.coordinates, name, value)}
        raise limit_error("motor ", found, "; enforce_limits=False turns this check off")


def start_of(mechanism: Mechanism, guess: Guess, values: Array) -> Configuration:
    """Return the closed pose that a guess names; motors that it does not name have these values."""
    if isinstance(guess, Configuration):
        if guess.mechanism is mechanism:
            return guess
        if guess.mechanism._parts.coordinates.names != mechanism._parts.coordinates.names:
            message = f"the guess is a pose of {guess.mechanism.name!r}, not of {mechanism.name!r}"
            raise ArgumentError(message)
        # The same machine, from another process or with other parameters.
        return _assembled_at_guess(mechanism, guess.joint_values, values)
    if isinstance(guess, str):
        return mechanism._poses.get(guess) or mechanism.pose(guess)
    by_name = named_values(guess, "joint values of a guess")
    if by_name is None:
        message = (
            "guess must be the name of a pose, a Configuration or a mapping of joint values, "
            f"got {type(guess).__name__}"
        )
        raise ArgumentError(message)
    return _assembled_at_guess(mechanism, by_name, values)


def _assembled_at_guess(
    mechanism: Mechanism, guess: Mapping[str, float | Sequence[float]], values: Array
) -> Configuration:
    """Assemble at the guessed joint values; motors it does not name start at their target."""
    parts = mechanism._parts
    motors = by_joint(parts.spec, parts.coordinates, values)
    q = parts.coordinates.q({**motors, **guess}, parts.home_q)
    pose = _with_motors_held(parts.problem, q)
    if pose.gap > parts.problem.tolerance:
        message = (
            f"the guess does not assemble: the loops of {mechanism.name!r} stay open by "
            f"{pose.gap:.3g} m at best; give joint values nearer to a closed pose, or "
            f"{wider_tolerance(pose.gap, parts.problem.largest_tolerance)}"
        )
        raise ClosureError(message, residual_norm=pose.gap, q=pose.q, actuated=values)
    return Configuration._of_q(mechanism, pose.q, pose.iterations)


def _with_motors_held(problem: ClosureProblem, q: Array) -> Assembled:
    """Close the loops at q with the motors held; beside where rounding alone keeps them open."""
    first = assemble(problem, q, motor_weights(problem, 0.0))
    if first.gap <= problem.tolerance:
        return first
    best, factors = assemble_held(problem, q, first), closed_point(problem, first.q).factors
    if first.gap > _FAR_AWAY_GAP * problem.partition.length:
        return best
    apart = problem.difference(first.q, best.q) / problem.partition.column_scale
    near = norm(apart) <= _SAME_POSE * problem.partition.length
    # From a regular pose whose gap is rounding, starts around it lead to other modes.
    return best if near or factors.rank < problem.partition.passive_rank else first


def _stopped(
    mechanism: Mechanism, values: Array, start: Configuration, path: Followed
) -> ClosureError:
    """Build the error of a path that ended early, with the best pose at the target itself."""
    parts, problem = mechanism._parts, start.problem
    reached = Configuration._of_point(mechanism, path.point, path.iterations, problem)
    at_target = parts.coordinates.with_values(path.point.q, problem.partition.actuated, values)
    best = assemble(problem, at_target, motor_weights(problem, 0.0))
    ties = ties_in_words(problem, start._point)
    if path.strayed is not None:
        closes = best.gap <= problem.tolerance
        message = _forbidden(mechanism, values, path.strayed, closes) if path.proven else _TOO_NEAR
    else:
        going_on = _GO_ON if path.share else _IN_BETWEEN
        apart = problem.difference(path.point.q, best.q) / problem.partition.column_scale
        beside = norm(apart) <= _BESIDE_AN_END * problem.partition.length
        advice = going_on if path.spent else _advice(problem, best.gap, bool(ties), beside)
        message = f"the straight path to the target {_reason(reached, path)}; {advice}"
    # What the motors can do at all comes first, before what became of this target.
    if ties and problem.tolerance < best.gap <= _SMALL * problem.partition.length:
        enough = wider_tolerance(best.gap, problem.largest_tolerance)
        message = (
            f"at the target the loops stay open by {best.gap:.3g} m at best: give {enough}; where "
            f"they are not, the machine is {ties}"
        )
    elif ties:
        message = f"{ties}. {message[0].upper()}{message[1:]}"
    return ClosureError(
        f"{mechanism.name}: {message}",
        residual_norm=best.gap,
        q=best.q,
        actuated=values,
        reached=reached,
        share=path.share,
        singular_value=reached.singularity().smallest,
        ties=ties,
    )


def _forbidden(mechanism: Mechanism, values: Array, strayed: Array, closes: bool) -> str:
    """Say which motors the loops lead elsewhere than they were told to go."""
    parts = mechanism._parts
    motors = parts.problem.partition.actuated
    there, wraps = parts.coordinates.values(strayed)[motors], parts.coordinates.wraps[motors]
    misses = np.where(
        wraps, np.remainder(there - values + np.pi, 2 * np.pi) - np.pi, there - values
    )
    least = min(_ARRIVED, 0.5 * float(np.abs(misses).max()))
    led = [
        f"{name} goes to {value:.9g}, which is {miss:+.2g} from its target"
        for name, value, miss in zip(mechanism.actuated, there.tolist(), misses, strict=True)
        if abs(miss) > least
    ]
    if closes:
        return (
            "the loops close at these values, but no straight path of the other motors leads "
            f"there: on it {' and '.join(led)}; {_IN_BETWEEN}"
        )
    if len(mechanism.actuated) == 1:
        return f"the loops forbid this motor to move: there, {led[0]}"
    passive = f"{len(led)} of them" if len(led) > 1 else "one of them"
    return (
        "the loops forbid these motors to move so together: with the other motors at their "
        f"targets, {' and '.join(led)}; give values that fit, or make {passive} passive"
    )


def _reason(reached: Configuration, path: Followed) -> str:
    """Say where a path ended, and why."""
    singularity = reached.singularity()
    motors = ", ".join(
        f"{name}={value:.6g}"
        for name, value in zip(reached.mechanism.actuated, reached.actuated, strict=True)
    )
    where = f"after {100.0 * path.share:.4g} % of the way, at {motors}"
    if path.spent and not path.share:
        return f"is too long for the {MOST_STEPS} steps that one call may take"
    if path.spent:
        return f"takes more than {MOST_STEPS} steps, which end {where}"
    if singularity.smallest < _NEARLY_SINGULAR:
        value = f"(relative singular value of K* {singularity.smallest:.2g})"
        return f"meets a singularity {where} {value}, where this assembly mode ends"
    if singularity.forbidden_rates.shape[1]:
        return f"is left by the loops {where}: they forbid these motors to move so together"
    return f"cannot be followed further than {where}"


def _advice(problem: ClosureProblem, gap: float, tied: bool, beside: bool) -> str:
    """Say what to do about it: whether the loops close at the target at all, and how near by."""
    if gap <= problem.tolerance:
        if tied:
            return f"the loops do close at the target: {_IN_BETWEEN}, or start from another pose"
        if beside:
            return (
                "the loops do close at the target, so near a singularity that this assembly mode "
                "and those that meet it there are not told apart: start from a pose beside it"
            )
        where = "the loops do close at the target, on another assembly mode"
        return f"{where}: start from a pose of that mode"
    open_by = f"at the target the loops stay open by {gap:.3g} m at best: "
    beyond = "it is out of reach from here; try a nearer target, or another pose as guess"
    if gap <= _SMALL * problem.partition.length:
        enough = wider_tolerance(gap, problem.largest_tolerance)
        return f"{open_by}give {enough}; where they are not, {beyond}"
    return f"{open_by}{beyond}"
