"""Reach: the motor values that put a tool at a target, on the branch of a guess."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import assert_never

from pmjac_pin.closing.motor_values import MotorValues, motor_values
from pmjac_pin.configuration import Configuration
from pmjac_pin.direct_kinematics import Guess, start_of
from pmjac_pin.errors import ClosureError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.reach.asked import Asked
from pmjac_pin.studies.reach.driven import Driven
from pmjac_pin.studies.reach.reached import Reached
from pmjac_pin.studies.reach.targets import Target, ToolName, read_goals
from pmjac_pin.studies.reach.task import Task
from pmjac_pin.studies.reach.tool_path import Stop, ToolPath, leads
from pmjac_pin.values.checks import as_flag, check_kind

_BY_MOTORS = "straight in motor values; on the tool's straight way the motors lose it"


def reach(
    mechanism: Mechanism,
    target: Target,
    *,
    tool: ToolName = None,
    task: Task | None = None,
    mask: Sequence[bool] | None = None,
    guess: Guess = "home",
    limits: bool = True,
    posture: MotorValues | None = None,
) -> Reached:
    """Find the motor values that put a tool at a target: inverse kinematics by continuation.

    The tool goes straight to its target, the machine driven by it as by a motor, and stays on the
    guess's working mode as `close` stays on its assembly mode. On the way joints have to keep their
    limits, and motors must not lose the tool: that the machine's own motors lead it there is seen
    by driving it. Rows of the target in which the tool cannot move must fit. Where the straight
    way ends before, or no choice of rows tells the tool's pose, the motors go on downhill, to
    where the tool is nearest, a rad counted as the characteristic length; and closed poses at the
    target are looked for from seeded starts.

    Parameters
    ----------
    mechanism : Mechanism
    target : pin.SE3, array_like (4, 4) or (3,), mapping, or a sequence of these
        A pose, or a position, in the world; coordinates "x", "y", "z" and "angle" (of the tool's x
        axis about z) by name; values of joints by their names; or a target for each of several
        tools, in their order or by their names.
    tool : str, three str, or a sequence of several tools, optional
        The mechanism's own when None.
    task : Task, optional
        What of the target counts: the position where it is one, all of a pose by default.
    mask : sequence of six bool, optional
        The same by the rows of the tool's twist, vx, vy, vz, wx, wy and wz: `Task.masked`.
    guess : str, Configuration or mapping of str to float
        Where to start, as of `Mechanism.close`.
    limits : bool
        Keep within the limits of all joints.
    posture : array_like, shape (n,), or mapping of str to float, optional
        Motor values to be as near to as the target allows, where it leaves freedom; those of the
        guess when None. Motors are counted by their natural rates.

    Returns
    -------
    Reached
        With a status; what cannot be reached is no error.

    Raises
    ------
    ArgumentError, UnknownNameError, NoToolError
        A target, tool, task, mask or posture that is none.
    ClosureError
        The guess does not close.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> arm = pj.load("serial_2r")
    >>> there = pj.reach(arm, {"x": 1.0, "y": 1.0})
    >>> there.status, there.actuated.round(4).tolist()
    ('reached', [...])
    >>> pj.reach(arm, {"x": 3.0, "y": 0.0}).status
    'out of reach'
    """
    check_kind(mechanism, Mechanism)
    goals = read_goals(mechanism, target, tool, task, mask)
    start = start_of(mechanism, guess, mechanism.home.actuated)
    wanted = start.actuated
    if posture is not None:
        wanted = motor_values(mechanism.spec, mechanism.coordinates, posture)
    return _answer(Asked(mechanism, goals, start, as_flag(limits, "limits"), wanted))


def _answer(asked: Asked) -> Reached:
    """Go straight; where that ends, go downhill; where that ends, look elsewhere."""
    path = None if asked.driven is None else _straight_path(asked, asked.driven)
    if path is None:
        return _off_the_way(asked, Stop(asked.start, 0.0, "end of the mode"))
    stop = path.walked(asked.limits)
    match stop.end:
        case "limit":
            return _at_limit(asked, stop)
        case "lost by its motors":
            message = f"{_how_far(stop)} the motors lose the tool"
            return asked.told("singular", stop.configuration, stop.share, message)
        case "target":
            if not asked.meets(stop.configuration):
                return _off_the_way(asked, stop)
            return _met(
                asked, stop.configuration, _BY_MOTORS if path.turns_over(stop) else "straight"
            )
        case "end of the mode":
            return _off_the_way(asked, stop)
        case _:
            assert_never(stop.end)


def _straight_path(asked: Asked, driven: Driven) -> ToolPath | None:
    try:
        return ToolPath(driven, asked.goals, asked.start)
    except ClosureError:  # where rows follow each other at home alone, nothing drives from here
        return None


def _how_far(stop: Stop) -> str:
    return f"after {100.0 * stop.share:.4g} % of the way"


def _met(asked: Asked, configuration: Configuration, how: str) -> Reached:
    least = asked.with_least_motion(configuration)
    left = "" if asked.is_least_motion(least) else "; the motors may move less for it"
    return asked.told("reached", least, 1.0, f"the target is met, {how}{left}")


def _at_limit(asked: Asked, stop: Stop) -> Reached:
    values = stop.configuration.joint_values
    told = ", ".join(f"{name!r} at {values[name]:.6g}" for name in stop.joints)
    message = f"{_how_far(stop)} joints reach their limits: {told}"
    return asked.told("at a limit", stop.configuration, stop.share, message, joints=stop.joints)


def _off_the_way(asked: Asked, stop: Stop) -> Reached:
    """Go on by the motors, to where the tool is nearest; look elsewhere if that is not enough."""
    trail = asked.trail_downhill(stop.configuration)
    nearest, ambiguous = trail[-1], _tells_no_branch(asked, stop)
    met = nearest if asked.meets(nearest) else None
    if met is not None and (ambiguous or _on_one_mode(asked, trail)):
        return _met(asked, met, "by a way around")
    for found in asked.poses_elsewhere():
        around = asked.trail_by_motors(found)
        if around and (ambiguous or _on_one_mode(asked, around)):
            return _met(asked, around[-1], "by another way of the motors")
        met = met or found
    if met is not None:
        return _on_another_branch(asked, stop, met)
    miss = asked.miss(nearest)
    parts = [f"{miss.linear:.6g} m"] * (miss.linear > 0.0)
    parts += [f"{miss.angular:.6g} rad"] * (miss.angular > 0.0)
    which = "of all around it" if asked.is_nearest(nearest) else "that the motors lead to"
    message = f"the nearest pose {which} is {' and '.join(parts)} from the target"
    return asked.told("out of reach", nearest, stop.share, message)


def _tells_no_branch(asked: Asked, stop: Stop) -> bool:
    """Tell whether no working mode is left: no rows tell the tool's pose, or several modes meet."""
    if asked.driven is None or stop.end == "target":
        return True
    return not stop.share and asked.driven.lifted(asked.start).singularity().kind != "regular"


def _on_one_mode(asked: Asked, trail: Sequence[Configuration]) -> bool:
    """Tell whether the tool leads the machine along a trail, on one working mode."""
    if asked.driven is None:
        return False
    poses = map(asked.driven.lifted, trail)
    return all(leads(one, other) for one, other in itertools.pairwise(poses))


def _on_another_branch(asked: Asked, stop: Stop, found: Configuration) -> Reached:
    where = "the machine meets the target, but by no way that was found from here"
    message = f"{_how_far(stop)} this branch ends; {where}"
    last = stop.configuration
    return asked.told("on another branch", last, stop.share, message, elsewhere=found)
