"""Marks: the points and lines of a machine that tell its poses apart, whatever bears them.

The apex of three rods is where it is, though each rod that ends there spins about itself.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
from numpy.linalg import norm, qr

from pmjac_pin.kinematics.many import WorldPoses
from pmjac_pin.model.frames import Frame, find_frame
from pmjac_pin.model.loop_spec import JointLoop
from pmjac_pin.studies.modes.search_problem import SearchProblem
from pmjac_pin.values.arrays import Array

Mark = Callable[[WorldPoses], Array]
"""Tells of b poses where something is, without dimension, shape (b, entries)."""


def marks(problem: SearchProblem) -> list[Mark]:
    """Return the marks of the tool, of loops and of joints."""
    return [*_tool(problem), *_loops(problem), *_joints(problem)]


def _tool(problem: SearchProblem) -> Iterator[Mark]:
    tool = problem.mechanism.spec.tool
    for name in tool.names:
        frame = find_frame(problem.model, name)
        yield partial(_point, frame, problem.length)
        if not tool.points:
            yield partial(_marked_axes, frame)


def _loops(problem: SearchProblem) -> Iterator[Mark]:
    """Yield the points that loops join, and their axes as lines."""
    for loop in problem.closures:
        if isinstance(loop, JointLoop):
            continue
        for name, axis in zip(loop.frames, loop.lines or (None, None), strict=True):
            frame = find_frame(problem.model, name)
            yield partial(_point, frame, problem.length)
            if axis is not None:
                yield partial(_line, frame, np.array(axis))


def _joints(problem: SearchProblem) -> Iterator[Mark]:
    """Yield what motions each joint allows.

    Motors and geared joints have a sense, which counts.
    """
    # Axes of motors have a sense, and those of what is geared.
    geared = (
        name for loop in problem.closures if isinstance(loop, JointLoop) for name in loop.ends
    )
    sensed = {*problem.mechanism.spec.actuated, *geared}
    for joint in list(problem.model.joints)[1:]:
        columns = slice(joint.idx_v, joint.idx_v + joint.nv)
        screws = problem.model.names[joint.id] in sensed
        yield partial(_screws if screws else _motions, columns, problem.length)


def _point(frame: Frame, length: float, poses: WorldPoses) -> Array:
    place = poses.rotations[frame.joint] @ frame.placement.translation
    return np.asarray((poses.positions[frame.joint] + place) / length)


def _marked_axes(frame: Frame, poses: WorldPoses) -> Array:
    return np.asarray(poses.rotations[frame.joint] @ frame.placement.rotation).reshape(-1, 9)


def _line(frame: Frame, axis: Array, poses: WorldPoses) -> Array:
    line = poses.rotations[frame.joint] @ (frame.placement.rotation @ axis)
    return np.asarray(line[:, :, None] * line[:, None, :]).reshape(-1, 9)


def _screws(columns: slice, length: float, poses: WorldPoses) -> Array:
    twists = _twists(columns, length, poses)
    return twists.reshape(len(twists), 6 * twists.shape[2])


def _motions(columns: slice, length: float, poses: WorldPoses) -> Array:
    """Return the projector onto a joint's motions: seen from either side it is one."""
    twists = _twists(columns, length, poses)
    single = twists.shape[2] == 1  # most are, and need no QR
    basis = twists / norm(twists, axis=1)[:, None] if single else qr(twists)[0]
    return np.asarray(basis @ basis.swapaxes(1, 2)).reshape(-1, 36)


def _twists(columns: slice, length: float, poses: WorldPoses) -> Array:
    linear, angular = poses.linear[:, :, columns], poses.angular[:, :, columns]
    return np.concatenate([linear / length, angular], axis=1)
