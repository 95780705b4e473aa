"""The steps that a joint of Pinocchio's moves by, and their values in a pose."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.model.joint_kind import JointKind
from pmjac_pin.model.limits import stated_limits
from pmjac_pin.studies.export.plain_machine import PlainStep, StepKind
from pmjac_pin.values.arrays import Array

_ANY_WAY = 6  # freedoms


class JointSteps:
    """Takes the joints of a model apart.

    Parameters
    ----------
    model : pin.Model
    """

    def __init__(self, model: pin.Model) -> None:
        self._model, self._coordinates = model, JointCoordinates(model)
        self._data = model.createData()
        pin.computeJointJacobians(model, self._data, pin.neutral(model))
        self._joints = [one.id for one in list(model.joints)[1:] for _ in range(one.nv)]
        self._efforts = stated_limits(model.lowerEffortLimit, model.upperEffortLimit)
        self._rates = stated_limits(model.lowerVelocityLimit, model.upperVelocityLimit)

    def steps(self, joint: pin.JointModel, kind: JointKind, driven: bool) -> tuple[PlainStep, ...]:
        """Return a joint's steps in the order in which they move.

        Those of one freedom are called as the degree of freedom is; a screw's slide, and the ball
        of a free body that hangs on another, get names of their own.
        """
        name, column = self._model.names[joint.id], joint.idx_v
        names = self._coordinates.dof_names([name])
        if kind.nv == _ANY_WAY and self._model.parents[joint.id] == 0:
            return (self._step(name, "free", column, driven),)
        if kind.screw:
            turn = self._step(name, "hinge", column, driven)
            return (turn, PlainStep(f"{name}.slide", "slide", turn.axis))
        scalar = kind.slides if turns_freely(kind) else kind.nv
        single = [
            self._step(names[k], "slide" if k < kind.slides else "hinge", column + k, driven)
            for k in range(scalar)
        ]
        if not turns_freely(kind):
            return tuple(single)
        turning = f"{name}.r" if kind.slides else name
        return (*single, self._step(turning, "ball", column + kind.slides, driven))

    def _step(self, name: str, kind: StepKind, column: int, driven: bool) -> PlainStep:
        """Return a step; at the neutral pose each axis is where the joint's frame has it."""
        single = kind in ("hinge", "slide")
        limits = (self._coordinates.lower[column], self._coordinates.upper[column])
        return PlainStep(
            name,
            kind,
            self._axis(column, 3 if kind == "hinge" else 0) if single else np.zeros(3),
            (float(limits[0]), float(limits[1])) if single else (-np.inf, np.inf),
            float(self._model.armature[column]),
            float(self._efforts[column]),
            float(self._rates[column]),
            driven,
        )

    def _axis(self, column: int, row: int) -> Array:
        joint = self._joints[column]
        own = pin.getJointJacobian(self._model, self._data, joint, pin.LOCAL).reshape(6, -1)
        axis = own[row : row + 3, column]
        return np.asarray(axis / np.linalg.norm(axis))


def step_values(
    steps: Sequence[PlainStep], kind: JointKind, entries: Sequence[float], pitch: float = 0.0
) -> dict[str, tuple[float, ...]]:
    """Return the values of a joint's steps where q has these entries for it."""
    numbers = tuple(map(float, entries))
    if steps[0].kind == "free":
        return {steps[0].name: numbers}
    if kind.screw:
        return {steps[0].name: numbers, steps[1].name: (pitch * numbers[0],)}
    slides, turn = numbers[: kind.slides], numbers[kind.slides :]
    values: list[tuple[float, ...]] = [(number,) for number in slides]
    if turns_freely(kind):
        values.append(turn)
    elif kind.turns and not kind.angle:
        values.append((math.atan2(turn[1], turn[0]),))
    else:
        values += [(number,) for number in turn]
    return {step.name: value for step, value in zip(steps, values, strict=True)}


def turns_freely(kind: JointKind) -> bool:
    """Tell whether a joint turns by a quaternion: its last step is a ball."""
    return kind.turns > 1 and not kind.angle
