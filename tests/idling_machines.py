"""Machines with parts that idle as a whole, and what is known of their modes by hand."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

import pmjac_pin as pj

CRANK, COUPLER, ROCKER, BASE = 1.0, 2.6, 2.0, 3.0


def on_a_turntable(mechanism, axis):
    """The machine on a passive turntable about this axis, with the tool beside it.

    Its loops' frames on the ground must have been made by the model.
    """
    base = pin.Model()
    base.addJoint(0, pin.JointModelRevoluteUnaligned(*axis), pin.SE3.Identity(), "table")
    base.addFrame(pin.Frame("top", 1, pin.SE3.Identity(), pin.FrameType.OP_FRAME))
    model = pin.appendModel(base, mechanism.model, base.getFrameId("top"), pin.SE3.Identity())
    return with_tool_at_rest(model, mechanism, {"table": 0.3})


def with_tool_at_rest(model, mechanism, more=None):
    """The machine with its tool on the ground: all of it idles that the motors do not hold."""
    stand = pin.SE3(np.eye(3), np.array([1.0, 2.0, 3.0]))
    model.addFrame(pin.Frame("stand", 0, stand, pin.FrameType.OP_FRAME))
    home = {**mechanism.home.joint_values, **(more or {})}
    return pj.Mechanism.from_pinocchio(
        model, mechanism.spec.loops, mechanism.actuated, "stand", home=home
    )


def leg_with_a_four_bar(hinge, end, theta, placed):
    """A leg between two balls, its length set by a four-bar in it; it turns a flap.

    Parameters
    ----------
    hinge : ndarray, shape (3,)
        Of the flap, from the leg's ball; it turns about y.
    end : ndarray, shape (3,)
        Of the leg on the flap, from there.
    theta : float
        Angle of the four-bar's crank, rad: its one motor.
    placed : pin.SE3
        Where all that is.

    Returns
    -------
    Mechanism, ndarray, shape (modes, 2)
        And all pairs of the rocker's and the flap's angles, by hand.
    """
    model, no = pin.Model(), np.zeros(3)

    def joint(parent, joint_model, name, place=no):
        placement = pin.SE3(np.eye(3), np.asarray(place, float))
        return model.addJoint(
            parent, joint_model, placed * placement if parent == 0 else placement, name
        )

    def frame(body, name, place):
        placement = pin.SE3(np.eye(3), np.asarray(place, float))
        model.addFrame(pin.Frame(name, body, placement, pin.FrameType.OP_FRAME))

    leg = joint(0, pin.JointModelSpherical(), "ball")
    crank = joint(leg, pin.JointModelRZ(), "theta")
    coupler = joint(crank, pin.JointModelRZ(), "between", (CRANK, 0, 0))
    rocker = joint(leg, pin.JointModelRZ(), "rocker", (BASE, 0, 0))
    flap = joint(0, pin.JointModelRY(), "flap", hinge)
    frame(coupler, "coupler_end", (COUPLER, 0, 0))
    frame(rocker, "rocker_pin", (ROCKER, 0, 0))
    frame(rocker, "leg_end", (1.5 * ROCKER, 0, 0))
    frame(flap, "flap_end", end)
    frame(flap, "tool", (1, 0, 0))
    loops = [
        pj.PointLoop(frames=("coupler_end", "rocker_pin")),
        pj.PointLoop(frames=("leg_end", "flap_end")),
    ]
    angles = np.array(
        [
            (rocker_angle, flap_angle)
            for rocker_angle in _rocker_angles(theta)
            for flap_angle in _flap_angles(hinge, end, _length(rocker_angle))
        ]
    )
    home = _home(model, placed, hinge, end, theta, angles[0])
    return pj.Mechanism.from_pinocchio(model, loops, ["theta"], "tool", home=home), angles


def _rocker_angles(theta):
    """Return the two angles at which the coupler reaches from crank to rocker."""
    apart = CRANK * np.array([np.cos(theta), np.sin(theta)]) - [BASE, 0.0]
    far = np.linalg.norm(apart)
    aside = np.arccos((ROCKER**2 + far**2 - COUPLER**2) / (2.0 * ROCKER * far))
    middle = np.arctan2(apart[1], apart[0])
    return middle + aside, middle - aside


def _leg_end(rocker):
    return np.array([BASE + 1.5 * ROCKER * np.cos(rocker), 1.5 * ROCKER * np.sin(rocker), 0.0])


def _length(rocker):
    return np.linalg.norm(_leg_end(rocker))


def _flap_angles(hinge, end, length):
    """Return both ψ with |h + R_y(ψ) e| = L: e × cos(ψ - ψ₀) is what the rest leaves."""
    across = hinge[0] * end[0] + hinge[2] * end[2]
    along = hinge[0] * end[2] - hinge[2] * end[0]
    left = (length**2 - hinge @ hinge - end @ end) / 2.0 - hinge[1] * end[1]
    aside = np.arccos(left / np.hypot(across, along))
    middle = np.arctan2(along, across)
    return middle + aside, middle - aside


def _home(model, placed, hinge, end, theta, angles):
    rocker, flap = angles
    tip, along = _leg_end(rocker), hinge + pin.utils.rotate("y", flap) @ end
    turn = pin.Quaternion.FromTwoVectors(tip, along)
    coupler = np.array([BASE, 0.0]) + ROCKER * np.array([np.cos(rocker), np.sin(rocker)])
    apart = coupler - CRANK * np.array([np.cos(theta), np.sin(theta)])
    between = np.arctan2(apart[1], apart[0]) - theta
    q = pin.neutral(model)
    q[:4], q[4:] = turn.coeffs(), (theta, between, rocker, flap)
    return q


def frame_origin(configuration, name):
    """Return where a frame is in the world."""
    model = configuration.mechanism.model
    data = model.createData()
    pin.framesForwardKinematics(model, data, configuration.q)
    return data.oMf[model.getFrameId(name)].translation.copy()


def tripod(aside=0.2):
    """Three legs from balls to one point, each with a motor that slides beside the leg's line.

    All spin about their lines. The tool's axes are those of two points on the ground.

    Returns
    -------
    Mechanism, ndarray of motor values, shape (3,), and the two places of the point, shape (2, 3)
    """
    model, apex = pin.Model(), np.array([0.8, 0.5, 1.2])
    feet = np.array([(0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (0.5, 1.7, 0.3)])
    q = []
    for number, foot in enumerate(feet):
        to_line = pin.SE3(np.eye(3), np.array([0.0, -aside, 0.0]))
        place = pin.SE3(np.eye(3), foot)
        ball = model.addJoint(0, pin.JointModelSpherical(), place, f"ball{number}")
        slide = model.addJoint(ball, pin.JointModelPX(), to_line.inverse(), f"l{number}")
        model.addFrame(pin.Frame(f"tip{number}", slide, to_line, pin.FrameType.OP_FRAME))
        line = apex - foot
        q += [*pin.Quaternion.FromTwoVectors(np.array([1.0, 0, 0]), line).coeffs()]
        q += [np.linalg.norm(line)]
    for name, place in (("first", (1.0, 0.0, 0.0)), ("second", (0.0, 1.0, 0.0))):
        where = pin.SE3(np.eye(3), np.array(place))
        model.addFrame(pin.Frame(name, 0, where, pin.FrameType.OP_FRAME))
    loops = [pj.PointLoop(frames=("tip0", f"tip{number}")) for number in (1, 2)]
    motors, tool = ["l0", "l1", "l2"], ["tip0", "first", "second"]
    normal = np.cross(feet[1] - feet[0], feet[2] - feet[0])
    normal /= np.linalg.norm(normal)
    other = apex - 2.0 * ((apex - feet[0]) @ normal) * normal
    mechanism = pj.Mechanism.from_pinocchio(model, loops, motors, tool, home=np.array(q))
    return mechanism, mechanism.home.actuated, np.array([apex, other])


def flap_on_a_leg():
    """A flap and an arm that slides on it, whose end a leg between two balls holds.

    With the arm's end on the flap's hinge, the leg holds the flap no more.

    Returns
    -------
    Mechanism, and the motor values (leg, arm) with the end on the hinge
    """
    model, hinge, out = pin.Model(), np.array([1.0, 0.5, 0.2]), 0.7
    along, no = pin.JointModelPX(), pin.SE3.Identity()
    ball = model.addJoint(0, pin.JointModelSpherical(), no, "ball")
    leg = model.addJoint(ball, along, no, "leg")
    flap = model.addJoint(0, pin.JointModelRY(), pin.SE3(np.eye(3), hinge), "flap")
    arm = model.addJoint(flap, along, no, "arm")
    for body, name in ((leg, "tip"), (arm, "end"), (flap, "tool")):
        model.addFrame(pin.Frame(name, body, no, pin.FrameType.OP_FRAME))
    end = hinge + np.array([out, 0.0, 0.0])
    turn = pin.Quaternion.FromTwoVectors(np.array([1.0, 0.0, 0.0]), end)
    home = np.array([*turn.coeffs(), np.linalg.norm(end), 0.0, out])
    loop = pj.PointLoop(frames=("tip", "end"))
    mechanism = pj.Mechanism.from_pinocchio(model, [loop], ["leg", "arm"], "tool", home=home)
    return mechanism, np.array([np.linalg.norm(hinge), 0.0])


def four_bar_of_rounded_numbers(off):
    """A four-bar on a turntable, its hinges off from parallel by an angle, rad."""
    model, one = pin.Model(), pin.SE3.Identity()
    table = model.addJoint(0, pin.JointModelRY(), one, "table")
    crank = model.addJoint(table, pin.JointModelRZ(), one, "theta")
    tilt = pin.SE3(pin.utils.rotate("x", off), np.array([CRANK, 0.0, 0.0]))
    coupler = model.addJoint(crank, pin.JointModelRZ(), tilt, "between")
    foot = pin.SE3(pin.utils.rotate("y", off), np.array([BASE, 0.0, off]))
    rocker = model.addJoint(table, pin.JointModelRZ(), foot, "rocker")
    for body, name, far in ((coupler, "one", COUPLER), (rocker, "other", ROCKER)):
        place = pin.SE3(np.eye(3), np.array([far, 0.0, 0.0]))
        model.addFrame(pin.Frame(name, body, place, pin.FrameType.OP_FRAME))
    model.addFrame(pin.Frame("stand", 0, one, pin.FrameType.OP_FRAME))
    angle = _rocker_angles(0.9)[0]
    pins = np.array([BASE + ROCKER * np.cos(angle), ROCKER * np.sin(angle)])
    apart = pins - CRANK * np.array([np.cos(0.9), np.sin(0.9)])
    home = np.array([0.3, 0.9, np.arctan2(apart[1], apart[0]) - 0.9, angle])
    loop = pj.PointLoop(frames=("one", "other"))
    return pj.Mechanism.from_pinocchio(
        model, [loop], ["theta"], "stand", home=home, tolerance=10.0 * off
    )
