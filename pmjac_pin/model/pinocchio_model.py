"""From a Pinocchio model and constraints that somebody already holds to a model and a spec."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Protocol, TypeAlias

import msgspec
import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.model.joint_kinds import pitch_of
from pmjac_pin.model.loop_spec import FrameLoop, Loop, PointLoop
from pmjac_pin.model.spec import JointValue, MechanismSpec, checked_pitch, decode_spec, encode_spec
from pmjac_pin.model.tool_spec import NO_TOOL, Tool
from pmjac_pin.values.checks import as_names, as_numbers
from pmjac_pin.values.named_values import named_values

Constraint: TypeAlias = Any  # Pinocchio's constraint models


class RobotWrapper(Protocol):
    """What ``pinocchio.RobotWrapper`` is, and what robot_descriptions returns: it has a model."""

    model: pin.Model


def own_model(
    model: pin.Model | RobotWrapper,
    loops: Iterable[Loop | Constraint],
    actuated: Iterable[str],
    tool: str | Sequence[str] | None,
    *,
    passive: Iterable[str] | None,
    home: ArrayLike | Mapping[str, JointValue] | None,
    name: str,
    tool_rows: Iterable[str] | None,
    tool_axes: str | None,
    tolerance: float | None,
    enforce_limits: bool,
) -> tuple[pin.Model, MechanismSpec]:
    """Return a copy of the model, with the constraints' anchors as frames, and the spec.

    The arguments are those of `Mechanism.from_pinocchio`.

    Raises
    ------
    ArgumentError
    """
    given = getattr(model, "model", model)
    if not isinstance(given, pin.Model):
        raise ArgumentError(f"model must be a pinocchio.Model, got {type(model).__name__}")
    own = given.copy()
    _refuse_mimics(own)
    _refuse_what_is_not_finite(own)
    try:
        spec = MechanismSpec(
            name=name or own.name or "mechanism",
            actuated=as_names(actuated, "actuated is a list of joint names"),
            passive=None
            if passive is None
            else as_names(passive, "passive is a list of joint names"),
            tool=NO_TOOL if tool is None else checked_tool(tool),
            loops=_checked_loops(own, loops),
            poses={"home": _home_pose(own, home)},
            tolerance=tolerance,
            enforce_limits=enforce_limits,
        ).with_tool_rows(tool_rows, tool_axes)
        return own, decode_spec(encode_spec(spec))  # checks the types, as in a model file
    except (TypeError, ValueError, msgspec.MsgspecError) as error:
        raise ArgumentError(str(error)) from None


def _refuse_mimics(model: pin.Model) -> None:
    """Refuse joints that follow others: through them Pinocchio's constraints have no Jacobian."""
    for joint, leader in zip(model.mimicking_joints, model.mimicked_joints, strict=True):
        led, leads = model.names[joint], model.names[leader]
        raise ArgumentError(
            f"joint {quoted(led)} is one of Pinocchio's that mimic another; make it a joint of its "
            f"own, and gear it by a loop: JointLoop(joints=({leads!r}, {led!r}), ratio=..., "
            "offset=...)"
        )


def _refuse_what_is_not_finite(model: pin.Model) -> None:
    for name, place in zip(model.names, model.jointPlacements, strict=True):
        if not np.isfinite(place.homogeneous).all():
            raise ArgumentError(f"the placement of joint {quoted(name)} is not finite")
    for name, joint in list(zip(model.names, model.joints, strict=True))[1:]:
        if pitch := pitch_of(joint):
            checked_pitch(name, pitch)
    for frame in model.frames:
        if not np.isfinite(frame.placement.homogeneous).all():
            raise ArgumentError(f"the placement of frame {quoted(frame.name)} is not finite")


def _checked_loops(own: pin.Model, loops: Iterable[Loop | Constraint]) -> tuple[Loop, ...]:
    if isinstance(loops, Loop) or not isinstance(loops, Iterable):
        raise ArgumentError(f"loops is a list of PointLoop, RevoluteLoop, ..., got {quoted(loops)}")
    return tuple(
        loop if isinstance(loop, Loop) else _anchored(own, loop, number)
        for number, loop in enumerate(loops, start=1)
    )


def _anchored(own: pin.Model, constraint: Constraint, number: int) -> Loop:
    """Return the loop of a Pinocchio constraint, with frames of its own added to the model."""
    if isinstance(constraint, pin.ConstraintModel):
        constraint = constraint.extract()
    kind = _loop_kind(constraint, number)
    offset = getattr(constraint, "desired_constraint_offset", np.zeros(1))
    if np.any(offset):
        why = "with a desired offset, which makes Pinocchio's Jacobian wrong"
        raise ArgumentError(f"loop {number} is a constraint {why}; move its placements instead")
    ends = (
        (constraint.joint1_id, constraint.joint1_placement),
        (constraint.joint2_id, constraint.joint2_placement),
    )
    names = (f"loop{number}_first", f"loop{number}_second")
    for name, (joint, placement) in zip(names, ends, strict=True):
        if not np.isfinite(placement.homogeneous).all():
            raise ArgumentError(f"a placement of loop {number} is not finite")
        if not 0 <= joint < own.njoints:
            have = f"the model has {own.njoints}"
            raise ArgumentError(f"loop {number} is fixed to joint {joint}; {have}")
        if own.existFrame(name):
            raise ArgumentError(
                f"loop {number} needs a frame {quoted(name)}, which the model has already"
            )
        own.addFrame(pin.Frame(name, joint, placement, pin.FrameType.OP_FRAME), False)
    return kind(frames=names)


def _loop_kind(constraint: Any, number: int) -> type[PointLoop | FrameLoop]:
    match constraint:
        case pin.PointAnchorConstraintModel():
            return PointLoop
        case pin.FrameAnchorConstraintModel():
            return FrameLoop
        case pin.RigidConstraintModel(type=pin.ContactType.CONTACT_3D):
            return PointLoop
        case pin.RigidConstraintModel(type=pin.ContactType.CONTACT_6D):
            return FrameLoop
        case _:
            known = "PointLoop, RevoluteLoop, ... or a point or frame anchor of Pinocchio"
            raise ArgumentError(f"loop {number} is a {type(constraint).__name__}; {known} expected")


def checked_tool(tool: str | Sequence[str]) -> Tool:
    """Return the tool that is a frame of this name, or that three frames span.

    Raises
    ------
    ArgumentError
    """
    if isinstance(tool, str) and tool:
        return Tool(frame=tool)
    names = as_names(tool, "a tool is one frame or three")
    if len(names) != 3:
        raise ArgumentError(f"a tool is one frame or three, got {quoted(tool)}")
    return Tool(points=(names[0], names[1], names[2]))


def _home_pose(
    model: pin.Model, home: ArrayLike | Mapping[str, JointValue] | None
) -> dict[str, JointValue]:
    if (by_name := named_values(home, "home")) is not None:
        return {
            name: tuple(
                np.atleast_1d(as_numbers(value, f"the value of joint {quoted(name)}")).tolist()
            )
            for name, value in by_name.items()
        }
    if home is None:
        return {}
    q = as_numbers(home, "home")
    if q.shape != (model.nq,):
        raise ArgumentError(f"home has nq = {model.nq} entries, got shape {q.shape}")
    return JointCoordinates(model).pose(q)
