"""From a Pinocchio model and a spec to the parts of a Mechanism: the loops assembled at home."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import partial

import pinocchio as pin

from pmjac_pin.closing.closure_problem import CLOSURE_TOLERANCE, LARGEST_SHARE, ClosureProblem
from pmjac_pin.closing.machine_size import Size, shifted_model
from pmjac_pin.closing.parts import Parts, PartsAtHome
from pmjac_pin.closing.pose_assembly import assemble_pose, check_motors
from pmjac_pin.closing.scales import column_scale, row_scale
from pmjac_pin.errors import ArgumentError, PmjacError, unknown_name
from pmjac_pin.files.urdf.robot import Urdf
from pmjac_pin.kinematics.loop_system import LoopSystem
from pmjac_pin.kinematics.pinocchio import Kinematics
from pmjac_pin.kinematics.tool import tool_kinematics
from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.model.frames import carrying_columns
from pmjac_pin.model.limits import stated_limits
from pmjac_pin.model.spec import MechanismSpec
from pmjac_pin.rates.factorisation import RANK_TOLERANCE
from pmjac_pin.rates.partition import Partition
from pmjac_pin.values.arrays import Array

# Numbers that are off by a share of the mechanism's length are off by that in K*, and more.
_SMALLEST_SIZE = 1e-2  # of [K K*]: rows are measured by their loops, columns by the machine
_RANK_ROOM = 10.0

_logger = logging.getLogger(__name__)


def build_parts(
    model: pin.Model,
    spec: MechanismSpec,
    values: Mapping[str, float],
    urdf: Urdf | None = None,
    start: Array | None = None,
) -> PartsAtHome:
    """Resolve all names and assemble the home pose.

    Parameters
    ----------
    model, spec, values, urdf
        What the mechanism is made of.
    start : ndarray, shape (nq,), optional
        Where to start assembling the home pose; the spec's values when None.

    Raises
    ------
    UnknownNameError
        A joint or frame that the model does not have.
    ArgumentError
        The actuated and passive joints are not a partition of the joints that move; a pose
        that does not fit the joints, or is outside the motors' limits.
    ClosureError
        The home pose does not assemble.
    """
    return assembled(unassembled(model, spec, values, urdf), start)


def assembled(parts: Parts, start: Array | None = None) -> PartsAtHome:
    """Assemble the home pose, as `build_parts` does."""
    try:
        return _at_home(parts, start)
    except PmjacError as error:
        error.built_of = (parts.standing, parts.spec, parts.values)
        raise


def _at_home(parts: Parts, start: Array | None) -> PartsAtHome:
    spec, coordinates, given = parts.spec, parts.coordinates, parts.home_q
    for name, pose in spec.poses.items():
        check_motors(coordinates, coordinates.q(pose, given), spec, f"the pose {name!r} has")
    q = assemble_pose(parts, given if start is None else start, "home")
    size = Size(parts.kinematics, spec, coordinates.rotational, q)
    partition = _partition(spec, coordinates, parts.kinematics, size, parts.split.rounding)
    own = {field.name: getattr(parts, field.name) for field in fields(parts)}
    split = replace(parts.split, partition=partition)
    return PartsAtHome(**{**own, "home_q": q, "split": split})


def unassembled(
    model: pin.Model,
    spec: MechanismSpec,
    values: Mapping[str, float],
    urdf: Urdf | None = None,
) -> Parts:
    """Resolve all names, the home pose left as it is given.

    Raises
    ------
    UnknownNameError, ArgumentError
        As `build_parts`, but for what the home pose has.
    """
    coordinates = JointCoordinates(model)
    given = coordinates.q(spec.poses["home"])
    near, kinematics = model, _kinematics(model, spec, values)
    size = Size(kinematics, spec, coordinates.rotational, given)
    if size.place.any():
        near = shifted_model(model, -size.place)
        kinematics = _kinematics(near, spec, values, kinematics.placed(given))
    rounding = size.rounding
    partition = _partition(spec, coordinates, kinematics, size, rounding)
    problem = _closure_problem(kinematics, spec, partition, rounding)
    return Parts(
        near, spec, values, coordinates, kinematics, problem, given, urdf, model, size.place
    )


def _closure_problem(
    kinematics: Kinematics, spec: MechanismSpec, partition: Partition, rounding: float
) -> ClosureProblem:
    model = kinematics.model
    return ClosureProblem(
        kinematics,
        partial(pin.integrate, model),
        partial(pin.difference, model),
        partition,
        spec.tolerance,
        rounding,
    )


@dataclass(frozen=True, slots=True, eq=False)
class FoundAtHome:
    """What is computed for a mechanism and an equal one elsewhere need not: plain numbers.

    The attributes are those of `PartsAtHome` and its problem.
    """

    home_q: Array
    place: Array
    rounding: float
    partition: Partition

    @classmethod
    def of(cls, parts: PartsAtHome) -> FoundAtHome:
        """Return what was found for these parts."""
        problem = parts.problem
        return cls(parts.home_q, parts.place, problem.rounding, replace(problem.partition))


def rebuilt_parts(
    model: pin.Model,
    spec: MechanismSpec,
    values: Mapping[str, float],
    urdf: Urdf | None,
    found: FoundAtHome,
) -> PartsAtHome:
    """Return the parts that `build_parts` would, with the ranks that were found before.

    The loops of the home pose are looked at again: where they are open, as on a machine that
    computes otherwise, all is found anew.

    Raises
    ------
    UnknownNameError, ArgumentError, ClosureError
        As `build_parts`.
    """
    near = shifted_model(model, -found.place) if found.place.any() else model
    kinematics = _kinematics(near, spec, values)
    problem, q = _closure_problem(kinematics, spec, found.partition, found.rounding), found.home_q
    if not problem.gap(problem.evaluate(q)[0]) <= problem.tolerance:
        return build_parts(model, spec, values, urdf)
    coordinates = JointCoordinates(model)
    own = (near, spec, values, coordinates, kinematics, problem, q, urdf, model, found.place)
    return PartsAtHome(*own).with_problem(problem)


def _kinematics(
    model: pin.Model,
    spec: MechanismSpec,
    values: Mapping[str, float],
    data: pin.Data | None = None,
) -> Kinematics:
    loops = LoopSystem(model, spec.loops, values)
    return Kinematics(model, loops, tool_kinematics(model, spec.tool), data)


def _partition(
    spec: MechanismSpec,
    coordinates: JointCoordinates,
    kinematics: Kinematics,
    size: Size,
    rounding: float,
) -> Partition:
    passive = _passive_names(spec, coordinates)
    opened, length = max(spec.tolerance or 0.0, rounding), size.length
    if opened > LARGEST_SHARE * length:
        raise ArgumentError(
            f"a tolerance of {opened:g} m leaves nothing of a machine whose characteristic length "
            f"is {length:.3g} m; at most {LARGEST_SHARE * length:.3g} m would do"
        )
    model, loops = kinematics.model, kinematics.loops
    carrying = carrying_columns(model, spec.tool.names)
    columns = column_scale(loops, coordinates.rotational, length, size.loop_sizes, carrying)
    return Partition(
        actuated=coordinates.columns(spec.actuated),
        passive=coordinates.columns(passive),
        actuated_names=coordinates.dof_names(spec.actuated),
        passive_names=coordinates.dof_names(passive),
        length=length,
        loop_sizes=size.loop_sizes,
        row_scale=row_scale(loops, columns, length, size.loop_sizes),
        column_scale=columns,
        rank_tolerance=max(RANK_TOLERANCE, _RANK_ROOM * opened / length),
        tool_rows=spec.tool.judged,
        smallest_size=_SMALLEST_SIZE,
        strokes=size.strokes,
        gap=max(CLOSURE_TOLERANCE, opened / length),
        rate_limits=stated_limits(model.lowerVelocityLimit, model.upperVelocityLimit),
        effort_limits=stated_limits(model.lowerEffortLimit, model.upperEffortLimit),
        units=tuple("rad" if turns else "m" for turns in coordinates.rotational.tolist()),
        row_names=loops.row_names,
        row_units=loops.row_units,
    )


def _passive_names(spec: MechanismSpec, coordinates: JointCoordinates) -> tuple[str, ...]:
    """Return the passive joints, or say why these motors and joints do not make up the tree."""
    for name in spec.actuated:
        count = coordinates.degrees_of_freedom(name)
        if count != 1 and not (count and coordinates.is_known(name)):
            message = f"joint {name!r}, of {count} degrees of freedom, is of no known kind"
            raise ArgumentError(f"{message}: it cannot be a motor")
    others = tuple(name for name in coordinates.names if name not in spec.actuated)
    passive = others if spec.passive is None else tuple(spec.passive)
    for name in passive:
        if name not in coordinates.names:
            raise unknown_name("joint", name, coordinates.names)
    if forgotten := [name for name in others if name not in passive]:
        message = f"joint {forgotten[0]!r} moves and is neither actuated nor passive"
        raise ArgumentError(message)
    return passive
