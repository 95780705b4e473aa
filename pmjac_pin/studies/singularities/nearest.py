"""The singular pose that is nearest to a pose, by motors or by all joints: an estimate."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from types import MappingProxyType

import numpy as np
import pinocchio as pin

from pmjac_pin.algebra.one_thread import on_one_thread
from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError, ClosureError, PmjacError
from pmjac_pin.studies.modes.closed_pose import generator
from pmjac_pin.studies.singularities.change import ChangeFrom, Space
from pmjac_pin.studies.singularities.closest import ClosestPoint
from pmjac_pin.studies.singularities.nearest_singularity import NearestSingularity
from pmjac_pin.studies.singularities.singular_equations import FREED, Freed, SingularEquations
from pmjac_pin.values.arrays import Array, norm
from pmjac_pin.values.checks import as_count, check_kind, check_one_of
from pmjac_pin.values.ties import LIKE

_SPACES = ("motors", "joints")
_REACHES = (0.3, 1.0, 2.5)  # rad or lengths: how far starts lead from the pose
_SHY = 1e-6  # of the way: where a straight way ends that is to lead to the singular pose
_NEAR_ENOUGH = 2e-2  # rad or lengths between there and the singular pose


@on_one_thread
def nearest_singularity(
    configuration: Configuration,
    *,
    kind: Freed | None = None,
    space: Space = "motors",
    weights: Mapping[str, float] | None = None,
    starts: int = 6,
    rng: np.random.Generator | int | None = None,
) -> NearestSingularity:
    """Return the singular pose that is nearest to a pose: an estimate, no proof.

    The least |W (θ − θ₀)| of the poses with η(q) = 0 where K*, or what the tool feels, has less
    than its generic rank, by Newton's method along the locus of such poses (`SingularEquations`),
    from the pose itself and from where motors in random directions lead.

    Parameters
    ----------
    configuration : Configuration
    kind : {"gain", "loss"}, optional
        A gain: K* drops, and passive joints come free with the motors locked. A loss: the tool
        loses a motion, on the judged rows. The nearer one when None.
    space : {"motors", "joints"}
        Whether motors count or all joints of the cut tree.
    weights : mapping of str to float, optional
        How much a rad or a metre of each motor, or joint, counts: 1 where it is not named. The
        distance is of the weighted changes.
    starts : int
        Random directions, 0 or more.
    rng : Generator or int, optional
        For these; a seed makes a generator, and none takes one that differs every time.

    Raises
    ------
    ArgumentError
        Another kind or space; a mechanism that cannot be singular so, or whose generic ranks are
        not known; a joint that is not in the table of joints.
    UnknownNameError
        A weight of no motor, or no joint.
    NoToolError
        A loss, and no frame is named as the tool.

    Examples
    --------
    A 2R arm loses a motion where its elbow is stretched:

    >>> import pmjac_pin as pj
    >>> arm = pj.load("serial_2r").close([0.3, 0.9])
    >>> nearest = pj.nearest_singularity(arm, rng=0)
    >>> nearest.freed, round(nearest.distance, 9), nearest.unit
    ('loss', 0.9, 'rad')
    >>> round(nearest.motor_change["theta2"], 9)
    -0.9
    """
    check_kind(configuration, Configuration)
    check_one_of(space, "space", _SPACES)
    if kind is not None:
        check_one_of(kind, "kind", FREED)
    starts = as_count(starts, "starts", 0)
    equations = _equations_of(configuration, kind)
    measure = ChangeFrom(configuration, space, weights or {})
    begun = [configuration.q, *_starts(configuration, starts, generator(rng))]
    found = [_nearest_of(configuration, one, measure, begun) for one in equations]
    # One on another assembly mode is none that motors meet, however near their values are.
    best = min(found, key=lambda one: (not one.straight, one.distance))
    alike = (one for one in found if one.straight is best.straight)
    return next(one for one in alike if LIKE * one.distance <= best.distance)  # not by rounding


def _equations_of(configuration: Configuration, kind: Freed | None) -> list[SingularEquations]:
    """Return the equations of the kind that is asked for, of all that there are for None."""
    mechanism = configuration.mechanism
    if configuration.problem is not mechanism.problem:
        told = "the pose is on a branch of more motions than home has"
        raise ArgumentError(f"{told}: ask a mechanism whose home is on this branch")
    if kind is not None:
        return [SingularEquations(mechanism, kind)]
    found, refused = [], None
    for one in FREED:
        try:
            found.append(SingularEquations(mechanism, one))
        except PmjacError as error:
            refused = error
    if not found and refused is not None:
        raise refused
    return found


def _starts(configuration: Configuration, count: int, rng: np.random.Generator) -> Iterator[Array]:
    """Yield closed q where the motors lead in random directions, or where they cannot go on."""
    mechanism = configuration.mechanism
    partition = mechanism.problem.partition
    stride = partition.length * partition.motor_scale
    for number in range(count):
        way = rng.normal(size=stride.size)
        far = _REACHES[number % len(_REACHES)] * stride * way / norm(way)
        try:
            target = configuration.actuated + far
            yield mechanism.close(target, configuration, enforce_limits=False).q
        except ClosureError as error:
            if error.reached is not None:
                yield error.reached.q


def _nearest_of(
    configuration: Configuration,
    equations: SingularEquations,
    measure: ChangeFrom,
    begun: Sequence[Array],
) -> NearestSingularity:
    found = _singular_poses(configuration, ClosestPoint(equations, measure), begun)
    straight = next((one for one in found if _leads_straight(configuration, one[1])), None)
    distance, there = straight or next(iter(found), (math.inf, None))
    return NearestSingularity(
        configuration=there,
        freed=equations.freed,
        space=measure.space,
        distance=distance,
        unit=measure.unit,
        motor_change=MappingProxyType(_motor_change(configuration, there)),
        straight=straight is not None,
        starts=len(begun),
        found=len(found),
    )


def _singular_poses(
    configuration: Configuration, search: ClosestPoint, begun: Sequence[Array]
) -> list[tuple[float, Configuration]]:
    """Return what the starts lead to, nearest first."""
    found = []
    for q in begun:
        if (closest := search.from_start(q)) is not None:
            with suppress(ClosureError):
                there = configuration.mechanism.configuration(closest.point.q)
                found.append((closest.distance, there))
    return sorted(found, key=lambda one: one[0])


def _change(configuration: Configuration, there: Configuration) -> Array:
    return np.asarray(
        pin.difference(configuration.mechanism.kinematics.model, configuration.q, there.q)
    )


def _motor_change(configuration: Configuration, there: Configuration | None) -> dict[str, float]:
    if there is None:
        return {}
    partition = configuration.mechanism.problem.partition
    change = _change(configuration, there)[partition.actuated]
    return dict(zip(partition.actuated_names, change.tolist(), strict=True))


def _leads_straight(configuration: Configuration, there: Configuration) -> bool:
    """Tell whether motors that move straight lead there, up to a millionth of their way."""
    partition = configuration.mechanism.problem.partition
    way = _change(configuration, there)[partition.actuated]
    target = configuration.actuated + (1.0 - _SHY) * way
    try:
        reached = configuration.mechanism.close(target, configuration, enforce_limits=False)
    except ClosureError:
        return False
    left = _change(reached, there) / (partition.length * partition.column_scale)
    return norm(left) <= _NEAR_ENOUGH
