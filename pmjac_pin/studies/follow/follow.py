"""follow: a machine along a path of its motors."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal

from pmjac_pin.configuration import Configuration
from pmjac_pin.direct_kinematics import Guess, start_of
from pmjac_pin.errors import Interrupted
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.limits import enforced
from pmjac_pin.studies.follow.course import Course
from pmjac_pin.studies.follow.given_path import motor_path
from pmjac_pin.studies.follow.journey import Journey
from pmjac_pin.studies.follow.pose_course import PoseTargets, pose_course
from pmjac_pin.studies.follow.pose_path import is_of_poses, pose_path
from pmjac_pin.studies.follow.step import beginning
from pmjac_pin.studies.follow.tool_course import check_start_within, tool_course, tool_path
from pmjac_pin.studies.follow.trajectory import Trajectory, sample_times
from pmjac_pin.studies.follow.user_events import UserEvents
from pmjac_pin.studies.reach.task import Task
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import as_flag, check_callable, check_kind, check_one_of


def follow(
    mechanism: Mechanism,
    path: Any,
    *,
    start: Guess = "home",
    coordinates: Sequence[str] | Literal["pose"] | Task | None = None,
    tool: str | Sequence[str] | None = None,
    times: Any = None,
    samples: Any = None,
    events: Mapping[str, Callable[[Configuration], float]] | None = None,
    enforce_limits: bool | Literal["all"] = True,
    singularity: Literal["stop", "pass"] = "stop",
    certified: bool = False,
    progress: Callable[[float, float], object] | None = None,
) -> Trajectory:
    """Follow a path of the motors on one assembly mode, and tell what happens on it.

    Each step is covered as those of `Mechanism.close` are: about it there is a tube in which each
    t has exactly one closed pose. So nothing jumps to another mode; where no step is covered, it
    stops and says what is there. Events are located to 1e-10 of the parameter.

    Parameters
    ----------
    mechanism : Mechanism
    path : array_like (N, n), table by names, scipy spline, callable t ↦ (n,), or N poses
        Motor values, m or rad: waypoints, between which the motors move straight; a `PPoly`,
        `CubicSpline` or `BSpline`; or a smooth function, for which polynomials of degree 7 stand
        that agree with it to 1e-12. Poses are of the tool, pin.SE3 or 4 × 4: between them it slides
        straight and turns about one axis, the shorter way.
    start : str, Configuration or mapping of str to float
        The guess from which the path's first point is closed, as of `Mechanism.close`.
    coordinates : sequence of str, optional
        The path is of the tool's coordinates, of "x", "y", "z" (m, in the world) and "angle" (rad,
        of its x axis about z), in this order: the machine is driven by its tool, stays on its
        working mode, and its first point is reached straight from `start`. "pose", or a `Task`:
        the path is of poses of the tool, waypoints or a function t ↦ pin.SE3, of which the task's
        rows count, all six for "pose".
    tool : str or three str, optional
        Another frame than the mechanism's tool, or three that span one, for these.
    times : array_like, optional
        Of the waypoints, 0, 1, 2, ... where not given; where a spline or a function begins and
        ends, with what is between where a function has kinks.
    samples : int or array_like, optional
        The parameters to tell poses at, or how many; by default where the steps meet. What is
        beyond a stop is left out, and where it stopped is added.
    events : mapping of str to callable, optional
        Functions of a `Configuration` by their names: where one changes its sign is an event.
        Looked at four times a step.
    enforce_limits : bool or "all"
        Whether to stop where a motor leaves its limits; with "all" also where a passive joint does.
        They are events anyway.
    singularity : {"stop", "pass"}
        Where two branches of closed poses cross on the path, stop, or go on along the tangent that
        goes on. Beyond a fold there is nothing that could be passed to.
    certified : bool
        Prove each step by interval arithmetic, and stop where that fails.
    progress : callable, optional
        (t, last t) ↦ anything, after each step.

    Returns
    -------
    Trajectory

    Raises
    ------
    ArgumentError, UnknownNameError
        A path, times or options that are none.
    ClosureError, LimitError
        The path's first point is not reached from the guess, or beyond limits.
    Interrupted
        By Ctrl-C; its `done` is the trajectory as far as it is known.

    References
    ----------
    Govaerts, *Numerical Methods for Bifurcations of Dynamical Equilibria*, SIAM 2000; Krawczyk,
    *Newton-Algorithmen zur Bestimmung von Nullstellen mit Fehlerschranken*, Computing 4, 1969.

    Examples
    --------
    A four-bar whose crank cannot turn fully, to where its mode ends:

    >>> import math, pmjac_pin as pj
    >>> bar = pj.load("four_bar", {"l0": 4.0, "l1": 3.0, "l2": 2.5, "l3": 2.0})
    >>> trajectory = pj.follow(bar, [[0.9], [2.0]])
    >>> trajectory.status, [event.kind for event in trajectory.events]
    ('fold', ['fold'])
    >>> angle = trajectory.events[0].configuration.actuated[0]
    >>> bool(abs(angle - math.acos((4.0**2 + 3.0**2 - 4.5**2) / 24.0)) < 1e-10)
    True
    """
    check_kind(mechanism, Mechanism)
    check_callable(progress, "progress")
    check_one_of(singularity, "singularity", ("stop", "pass"))
    whose = enforced(enforce_limits)
    course, begin, targets = _course(
        mechanism, path, times, coordinates, tool, start=start, enforce_limits=enforce_limits
    )
    wanted = sample_times(samples, course.path.start, course.path.end)
    journey = Journey(
        course,
        beginning(course, begin),
        course.configuration(begin.q),
        UserEvents.given(course, events),
        whose=whose,
        passing=singularity == "pass",
        certified=as_flag(certified, "certified"),
    )
    found = _followed(journey, wanted, course.path.end, progress)
    if targets is not None:
        for t, q in zip(found.t.tolist(), found.q, strict=True):
            targets.check_met(t, q)
    return found


def _followed(
    journey: Journey,
    wanted: Array | None,
    end: float,
    progress: Callable[[float, float], object] | None,
) -> Trajectory:
    """Return what is found on the way; as far as it is known where somebody interrupts it."""
    try:
        for t in journey.go():
            if progress is not None:
                progress(t, end)
    except KeyboardInterrupt:
        done = journey.interrupted().trajectory(wanted)
        message = f"followed to t = {done.t[-1]:g} of {end:g}, kept in `done`"
        raise Interrupted(message, done) from None
    return journey.trajectory(wanted)


def _course(
    mechanism: Mechanism,
    path: Any,
    times: Any,
    coordinates: Sequence[str] | Literal["pose"] | Task | None,
    tool: str | Sequence[str] | None,
    *,
    start: Guess,
    enforce_limits: bool | Literal["all"],
) -> tuple[Course, Configuration, PoseTargets | None]:
    """Return the course, of motors or tool, the pose where it begins, and the tool's targets."""
    if coordinates is None and not is_of_poses(path):
        asked = motor_path(mechanism, path, times)
        values = asked.pieces[0].values(asked.start)
        begin = mechanism.close(values, start, enforce_limits=enforce_limits)
        return Course.beginning_at(begin, asked), begin, None
    guess = start_of(mechanism, start, mechanism.home.actuated)
    targets = None
    if coordinates is None or coordinates == "pose" or isinstance(coordinates, Task):
        task = coordinates if isinstance(coordinates, Task) else Task.pose()
        targets = PoseTargets(mechanism, pose_path(path, times), task, tool)
        course, begin = pose_course(targets, guess)
    else:
        asked = tool_path(path, times, coordinates)
        course, begin = tool_course(mechanism, asked, coordinates, tool, guess)
    check_start_within(course.configuration(begin.q), enforced(enforce_limits))
    return course, begin, targets
