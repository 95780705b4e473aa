"""From a mechanism to a `PlainMachine`: bodies, joints, loops and closed poses, ready to write."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import pinocchio as pin

from pmjac_pin.files.unused_name import unused_name
from pmjac_pin.files.visuals import drawn_elements
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.frames import find_frame
from pmjac_pin.model.joint_kinds import known_kind, pitch_of
from pmjac_pin.model.loop_spec import JointLoop, resolved_loop
from pmjac_pin.studies.export.plain_machine import PlainBody, PlainJoint, PlainMachine, PlainShape
from pmjac_pin.studies.export.steps import JointSteps, step_values
from pmjac_pin.studies.export.turned_bodies import with_links_for_bodies

_NAMED_FRAMES = (pin.FrameType.BODY, pin.FrameType.OP_FRAME)


def taken_apart(mechanism: Mechanism) -> PlainMachine:
    """Return a mechanism, at its parameters' values, as what all formats write.

    Raises
    ------
    ArgumentError
        A joint of a kind that is not known.
    """
    model = mechanism.model
    poses = {name: mechanism.pose(name).q for name in mechanism.poses}
    joints: list[PlainJoint] = []
    values: dict[str, dict[str, tuple[float, ...]]] = {name: {} for name in poses}
    take = JointSteps(model)
    for joint in list(model.joints)[1:]:
        name = model.names[joint.id]
        kind, pitch = known_kind(joint, name, in_turn=True), pitch_of(joint)
        steps = take.steps(joint, kind, name in mechanism.spec.actuated)
        parent, place = int(model.parents[joint.id]), model.jointPlacements[joint.id].copy()
        joints.append(PlainJoint(name, kind.name, parent, joint.id, place, steps, pitch))
        for pose, q in poses.items():
            entries = q[joint.idx_q : joint.idx_q + joint.nq].tolist()
            values[pose] |= step_values(steps, kind, entries, pitch)
    loops = tuple(resolved_loop(loop, mechanism.parameters) for loop in mechanism.spec.loops)
    tool = mechanism.spec.tool
    machine = PlainMachine(
        name=mechanism.name,
        bodies=tuple(_plain_bodies(mechanism, model)),
        joints=tuple(joints),
        loops=loops,
        poses=values,
        motors=tuple(_driven_steps(mechanism, joints)),
        tool=() if tool.is_none else tool.names,
        gravity=np.array(model.gravity.linear),
        length=mechanism.characteristic_length,
    )
    links = {frame.name for frame in model.frames if frame.type == pin.FrameType.BODY}
    return with_links_for_bodies(machine, links)


def _driven_steps(mechanism: Mechanism, joints: Sequence[PlainJoint]) -> Iterator[str]:
    """Yield the steps that are driven, in the order of the motors."""
    by_name = {joint.name: joint for joint in joints}
    for name in mechanism.spec.actuated:
        yield from (step.name for step in by_name[name].steps if step.driven)


def _plain_bodies(mechanism: Mechanism, model: pin.Model) -> Iterator[PlainBody]:
    """Yield each body: called as its link, or after its joint where no link is at its frame."""
    taken = {frame.name for frame in model.frames}
    named = _frames(mechanism, model)
    shapes = _shapes_by_body(mechanism, model)
    for index in range(model.njoints):
        frames = {name: place for name, (joint, place) in named.items() if joint == index}
        links = [
            frame.name
            for frame in model.frames
            if frame.type == pin.FrameType.BODY
            and frame.parentJoint == index
            and frame.placement.isIdentity(0.0)
        ]
        wish = f"{model.names[index]}_body" if index else "world"
        name = links[0] if links else unused_name(wish, taken)
        frames.pop(name, None)
        inertia = model.inertias[index].copy() if index else pin.Inertia.Zero()
        yield PlainBody(name, inertia, frames, tuple(shapes.get(index, ())))


def _frames(mechanism: Mechanism, model: pin.Model) -> dict[str, tuple[int, pin.SE3]]:
    """Return links and added frames, and whatever else loops and tool name."""
    names = {frame.name: None for frame in list(model.frames)[1:] if frame.type in _NAMED_FRAMES}
    ends = (
        end for loop in mechanism.spec.loops if not isinstance(loop, JointLoop) for end in loop.ends
    )
    tool = mechanism.spec.tool
    named = dict.fromkeys((*names, *ends, *(() if tool.is_none else tool.names)))
    frames = {name: find_frame(model, name) for name in named}
    return {name: (frame.joint, frame.placement) for name, frame in frames.items()}


def _shapes_by_body(mechanism: Mechanism, model: pin.Model) -> dict[int, list[PlainShape]]:
    found: dict[int, list[PlainShape]] = {}
    if (urdf := mechanism.urdf) is None:
        return found
    for drawn in drawn_elements(urdf):
        if not model.existFrame(drawn.link, pin.FrameType.BODY):
            continue  # of a machine that was hung up another way
        frame = find_frame(model, drawn.link)
        place = frame.placement * drawn.place
        shape = PlainShape(drawn.shape, place, drawn.colour, urdf.path)
        found.setdefault(frame.joint, []).append(shape)
    return found
