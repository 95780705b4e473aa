"""Targets as a caller gives them: poses, positions, single coordinates, joint values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from pmjac_pin.errors import ArgumentError, did_you_mean, quoted, unknown_name
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.frames import find_frame
from pmjac_pin.model.pinocchio_model import checked_tool
from pmjac_pin.model.tool_spec import Tool
from pmjac_pin.studies.reach.goal import Goal, JointGoal, ToolGoal, turn_between
from pmjac_pin.studies.reach.task import Task, plane_axes
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import as_number, as_numbers, check_kind

#: A pose, a position, a direction, coordinates or joint values by name, or several of these.
Target: TypeAlias = "pin.SE3 | ArrayLike | Mapping[str, Any] | Sequence[Any]"
ToolName: TypeAlias = "str | Sequence[str] | None"

#: Coordinates of the tool that may be named alone, and the rows that they are.
_COORDINATES = {"x": "vx", "y": "vy", "z": "vz", "angle": "wz"}
_NEARLY_RIGID = 1e-6  # of RᵀR − 1


def read_goals(
    mechanism: Mechanism,
    target: Target,
    tool: ToolName,
    task: Task | None,
    mask: Sequence[bool] | None = None,
) -> tuple[Goal, ...]:
    """Return what a caller wants, or say what is wrong with it.

    Raises
    ------
    NoToolError, UnknownNameError, ArgumentError
    """
    if task is not None:
        check_kind(task, Task)
    if mask is not None:
        if task is not None:
            raise ArgumentError("`task` and `mask` both say what of the target counts: give one")
        task = Task.masked(mask)
    if isinstance(target, Mapping):
        return _named_goals(mechanism, target, tool, task)
    if (tools := _several(target, tool)) is not None:
        pairs = zip(tools, target, strict=True)  # type: ignore[arg-type]
        return tuple(_goal(mechanism, one, name, task) for name, one in pairs)
    return (_goal(mechanism, target, tool, task),)


def _several(target: Any, tool: ToolName) -> tuple[Any, ...] | None:
    """Return the tools, where there is a target for each."""
    if tool is None or isinstance(tool, str) or isinstance(target, pin.SE3):
        return None
    shape = np.shape(target) if _is_numbers(target) else (len(target), 4, 4)
    if len(shape) < 2 or shape == (4, 4):
        return None
    if shape[0] != len(tool):
        raise ArgumentError(f"{len(tool)} tools, {quoted(tuple(tool))}, and {shape[0]} targets")
    if twice := [name for name in tool if list(tool).count(name) > 1]:
        raise ArgumentError(f"the tool {quoted(twice[0])} has two targets: give it one")
    return tuple(tool)


def _is_numbers(given: Any) -> bool:
    try:
        return np.asarray(given).dtype.kind in "iuf"
    except (TypeError, ValueError):
        return False


def _named_goals(
    mechanism: Mechanism, target: Mapping[str, Any], tool: ToolName, task: Task | None
) -> tuple[Goal, ...]:
    if not target:
        raise ArgumentError("the target names nothing: give coordinates, joints or tools by name")
    if all(name in _COORDINATES for name in target):
        _check_no_task(task, "single coordinates")
        return (_coordinates_goal(_checked_frames(mechanism, tool), target),)
    if all(np.ndim(one) == 0 and not isinstance(one, pin.SE3 | Mapping) for one in target.values()):
        _check_joints(mechanism, target)
        _check_no_task(task, "values of joints")
        return (_joint_goal(mechanism, target),)
    if tool is not None:
        raise ArgumentError("targets by the names of their tools, and tools besides: give one")
    return tuple(_goal(mechanism, one, name, task) for name, one in target.items())


def _check_no_task(task: Task | None, what: str) -> None:
    if task is not None:
        raise ArgumentError(f"{what} say themselves what counts: leave `task` and `mask` out")


def _check_joints(mechanism: Mechanism, target: Mapping[str, Any]) -> None:
    joints = mechanism.coordinates.names
    for name in target:
        if name not in joints and name not in _COORDINATES:
            raise unknown_name("coordinate or joint", name, (*_COORDINATES, *joints))
    mixed = [name for name in target if name not in joints]
    if mixed:
        wanted = "a target names coordinates of the tool or joints, not both"
        raise ArgumentError(f"{wanted}: {quoted(mixed[0])} is the tool's")


def _joint_goal(mechanism: Mechanism, target: Mapping[str, Any]) -> JointGoal:
    for name in target:
        if mechanism.coordinates.degrees_of_freedom(name) != 1:
            raise ArgumentError(f"joint {name!r} has several degrees of freedom, and no one value")
    values = [as_number(value, f"the value of {name!r}") for name, value in target.items()]
    return JointGoal(tuple(target), np.array(values))


def _coordinates_goal(tool: Tool, target: Mapping[str, Any]) -> ToolGoal:
    values = {name: as_number(one, f"the coordinate {name!r}") for name, one in target.items()}
    task = Task.of(_COORDINATES[name] for name in values)
    position = [values.get(name, 0.0) for name in ("x", "y", "z")]
    turn = pin.exp3(np.array([0.0, 0.0, values.get("angle", 0.0)]))
    axes = plane_axes(np.array(task.axis))
    # Headings count from the first of these axes, which is x where they are about z.
    return ToolGoal(tool, task, pin.SE3(axes @ turn, np.array(position)))


def _goal(mechanism: Mechanism, target: Any, tool: ToolName, task: Task | None) -> Goal:
    own = _checked_frames(mechanism, tool)
    if isinstance(target, Mapping):
        _check_no_task(task, "single coordinates")
        return _coordinates_goal(own, _checked_coordinates(target))
    pose = given_pose(target)
    if pose is not None:
        return ToolGoal(own, Task.pose() if task is None else task, pose)
    given = as_numbers(target, "a target")
    if given.shape != (3,):
        poses = "a pose (pin.SE3 or a 4x4 matrix), a position of three numbers"
        wanted = f"{poses}, or coordinates by name, as {{'x': 0.2, 'y': 0.4}}"
        raise ArgumentError(f"a target is {wanted}; got {_how_many(given)}")
    return ToolGoal(own, *_of_three(Task.position() if task is None else task, given))


def _how_many(given: Array) -> str:
    return f"{given.size} numbers" if given.ndim == 1 else f"numbers of shape {given.shape}"


def _of_three(task: Task, given: Array) -> tuple[Task, pin.SE3]:
    """Return the task and the pose of three numbers: a position, or where an axis points."""
    if task.turning == "free":
        return task, pin.SE3(np.eye(3), given)
    if task.turning != "pointing" or task.directions:
        raise ArgumentError(f"three numbers are no target for {task}: give a pose")
    if not (length := float(np.linalg.norm(given))) > 0.0:
        raise ArgumentError("the direction in which to point is of length 0")
    turn = pin.exp3(turn_between(np.array(task.axis), given / length))
    return task, pin.SE3(turn, np.zeros(3))


def given_pose(target: Any) -> pin.SE3 | None:
    """Return a pose as a caller gives it, None for what is no pin.SE3 and no 4x4 matrix.

    Raises
    ------
    ArgumentError
        A matrix of no rotation and translation.
    """
    if isinstance(target, pin.SE3):
        matrix = target.homogeneous
    elif np.shape(target) != (4, 4):
        return None
    else:
        matrix = target
    given = as_numbers(matrix, "a pose")
    rotation = given[:3, :3]
    rigid = np.abs(rotation.T @ rotation - np.eye(3)).max() < _NEARLY_RIGID
    if not rigid or np.linalg.det(rotation) < 0.0 or given[3].tolist() != [0.0, 0.0, 0.0, 1.0]:
        raise ArgumentError(
            f"a pose is a rotation and a translation, this is none: {quoted(given)}"
        )
    return pin.SE3(pin.Quaternion(rotation).normalized(), given[:3, 3])


def _checked_coordinates(target: Mapping[str, Any]) -> Mapping[str, Any]:
    for name in target:
        if name not in _COORDINATES:
            known = ", ".join(_COORDINATES)
            hint = did_you_mean(name, _COORDINATES)
            raise ArgumentError(f"a tool has the coordinates {known}; got {quoted(name)}{hint}")
    return target


def _checked_frames(mechanism: Mechanism, tool: ToolName) -> Tool:
    if tool is None:
        mechanism.need_tool()
        return mechanism.spec.tool
    own = checked_tool(tool)
    for name in own.names:
        find_frame(mechanism.kinematics.model, name)
    return own
