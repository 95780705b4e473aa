"""The same machine written another way: elsewhere, in other units, with other frames and gears."""

from __future__ import annotations

import msgspec
import numpy as np
import pinocchio as pin

import pmjac_pin as pj


def rebuilt(mechanism, model=None, loops=None, home=None, tolerance=None):
    """The mechanism of another model or other loops, else as it is."""
    spec = mechanism.spec
    return pj.Mechanism.from_pinocchio(
        mechanism.model if model is None else model,
        resolved(mechanism) if loops is None else loops,
        spec.actuated,
        spec.tool.frame or spec.tool.points,
        passive=spec.passive,
        home=mechanism.home.q if home is None else home,
        name=mechanism.name,
        tolerance=spec.tolerance if tolerance is None else tolerance,
    )


def resolved(mechanism):
    """Its loops, the lengths as numbers."""
    values = mechanism.parameters
    return [
        msgspec.structs.replace(loop, length=loop.resolved_length(values))
        if isinstance(loop, pj.DistanceLoop)
        else loop
        for loop in mechanism.spec.loops
    ]


def moved(mechanism, place):
    """The whole machine put elsewhere in the world."""
    model = mechanism.model
    for joint in range(1, model.njoints):
        if model.parents[joint] == 0:
            model.jointPlacements[joint] = place * model.jointPlacements[joint]
    for frame in list(model.frames)[1:]:
        if frame.parentJoint == 0:
            frame.placement = place * frame.placement
    return rebuilt(mechanism, model)


def slide_entries(model):
    """Entries of q that are lengths."""
    entries = []
    for joint in list(model.joints)[1:]:
        kind = joint.shortname()
        count = 3 if "FreeFlyer" in kind else 2 if "Planar" in kind else int("ModelP" in kind)
        entries += range(joint.idx_q, joint.idx_q + count)
    return entries


def scaled(mechanism, factor):
    """All lengths times a factor."""
    model = mechanism.model
    for joint in range(1, model.njoints):
        model.jointPlacements[joint].translation *= factor
    for frame in model.frames:
        frame.placement = pin.SE3(frame.placement.rotation, factor * frame.placement.translation)
    entries = slide_entries(model)
    lower, upper, home = (
        np.array(values)
        for values in (model.lowerPositionLimit, model.upperPositionLimit, mechanism.home.q)
    )
    for values in (lower, upper, home):
        values[entries] *= factor
    model.lowerPositionLimit, model.upperPositionLimit = lower, upper
    loops = [scaled_loop(loop, factor, mechanism.units) for loop in resolved(mechanism)]
    return rebuilt(mechanism, model, loops, home)


def scaled_loop(loop, factor, units):
    """Its length or, for geared slides, its ratio times a factor."""
    if isinstance(loop, pj.DistanceLoop):
        return msgspec.structs.replace(loop, length=factor * loop.length)
    if isinstance(loop, pj.JointLoop):
        first, second = (factor if units[name] == "m" else 1.0 for name in loop.joints)
        ratio, offset = loop.ratio * second / first, loop.offset * second
        return msgspec.structs.replace(loop, ratio=ratio, offset=offset)
    return loop


def with_frames(mechanism, rng):
    """Frames added that nothing uses: anywhere on any body, one of them very far away."""
    model = mechanism.model
    for k in range(12):
        away = 10.0 ** rng.uniform(-3, 3) * rng.normal(size=3)
        place = pin.SE3(pin.exp3(rng.normal(size=3)), away)
        body = int(rng.integers(model.njoints))
        model.addFrame(pin.Frame(f"extra{k}", body, place, pin.FrameType.OP_FRAME), False)
    far = pin.SE3(np.eye(3), np.array([5e6, 0.0, 0.0]))
    model.addFrame(pin.Frame("beacon", 0, far, pin.FrameType.OP_FRAME), False)
    return rebuilt(mechanism, model)


def with_needed_frames_only(mechanism):
    """No frames but those that loops and tool name."""
    spec, whole = mechanism.spec, mechanism.model
    needed = {name for loop in spec.loops for name in loop.ends}
    needed |= {spec.tool.frame} if spec.tool.frame else set(spec.tool.points)
    model = pin.Model()
    for joint in range(1, whole.njoints):
        kind = whole.joints[joint]
        v = slice(kind.idx_v, kind.idx_v + kind.nv)
        q = slice(kind.idx_q, kind.idx_q + kind.nq)
        model.addJoint(
            whole.parents[joint],
            kind,
            whole.jointPlacements[joint],
            whole.names[joint],
            whole.effortLimit[v],
            whole.velocityLimit[v],
            whole.lowerPositionLimit[q],
            whole.upperPositionLimit[q],
        )
    for frame in list(whole.frames)[1:]:
        if frame.name in needed:
            model.addFrame(frame, False)
    return rebuilt(mechanism, model)


def geared_from_the_other_side(mechanism):
    """Each gear named from its second joint."""
    return rebuilt(mechanism, loops=[from_the_other_side(loop) for loop in resolved(mechanism)])


def from_the_other_side(loop):
    if not isinstance(loop, pj.JointLoop):
        return loop
    ratio = 1.0 / loop.ratio
    return pj.JointLoop(joints=loop.joints[::-1], ratio=ratio, offset=-ratio * loop.offset)
