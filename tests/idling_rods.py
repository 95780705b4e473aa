"""Machines with rods between two balls, and with other joints that idle: several at once."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from mechanisms import RSSR

import pmjac_pin as pj

#: An RSSR whose crank and rocker both turn back.
FOLDING_RSSR = {
    "crank": 0.39624289394258017,
    "rod": 1.8229658090444263,
    "rocker": [0.9664932864625546, 0.7621956881415934, 0.3758168559972404],
    "foot": [0.3354421305038132, -0.18904657416632772, -0.10530658465079472],
    "axis": [-0.9063697800659738, -0.40699879463272415, 0.1133393265846767],
}


def _at(*point):
    return pin.SE3(np.eye(3), np.array(point, dtype=float))


def _frames(model, *frames):
    for body, name, place in frames:
        model.addFrame(pin.Frame(name, body, place, pin.FrameType.OP_FRAME))


def rod_on_a_ball(disc=False):
    """An RSSR whose rod is on one ball joint; with a disc that lies loose on a plane in it.

    The rod is along the ball's x. The disc is no part of the loop: three more motions idle.
    """
    model = pin.Model()
    crank = model.addJoint(0, pin.JointModelRZ(), _at(0, 0, 0), "theta")
    rod = model.addJoint(crank, pin.JointModelSpherical(), _at(RSSR["crank"], 0, 0), "ball")
    rocker = model.addJoint(0, pin.JointModelRY(), _at(1.5, 0.5, 0.2), "psi")
    if disc:
        on_rod = pin.SE3(pin.utils.rpyToMatrix(0.3, 0.2, 0.1), np.array([1.0, 0.0, 0.0]))
        model.addJoint(rod, pin.JointModelPlanar(), on_rod, "disc")
    ends = ((rod, "rod_tip", _at(RSSR["rod"], 0, 0)), (rocker, "tip", _at(0, 0, RSSR["rocker"])))
    _frames(model, *ends)
    loop, home = pj.PointLoop(frames=("rod_tip", "tip")), {"theta": 0.4, "psi": 0.2}
    return pj.Mechanism.from_pinocchio(model, [loop], ["theta"], "tip", home=home, name="rod")


def puck():
    """A crank's end in a ball of a puck that slides and turns on the plane, and carries a rod."""
    model = pin.Model()
    crank = model.addJoint(0, pin.JointModelRZ(), _at(0, 0, 0), "theta")
    body = model.addJoint(0, pin.JointModelPlanar(), _at(0, 0, 0), "puck")
    model.addJoint(body, pin.JointModelSpherical(), _at(0.3, 0, 0), "ball")
    _frames(model, (crank, "tip", _at(1, 0, 0)), (body, "pin", _at(0.5, 0, 0)))
    loop, home = pj.PointLoop(frames=("tip", "pin")), {"theta": 0.4}
    return pj.Mechanism.from_pinocchio(model, [loop], ["theta"], "tip", home=home, name="puck")


def gough_on_balls():
    """A plate that floats on six legs from balls to balls, which all spin about their lines."""
    model, home, loops = pin.Model(), [], []
    plate = model.addJoint(0, pin.JointModelFreeFlyer(), _at(0, 0, 0), "plate")
    pose = pin.SE3(pin.utils.rpyToMatrix(0.1, -0.07, 0.2), np.array([0.1, 0.05, 1.3]))
    home += [*pose.translation, *pin.Quaternion(pose.rotation).coeffs()]
    for leg in range(6):
        below, above = np.radians([(0, 20, 120, 140, 240, 260), (-30, 50, 90, 170, 210, 290)])
        foot = np.array([1.2 * np.cos(below[leg]), 1.2 * np.sin(below[leg]), 0.05 * leg])
        top = np.array([0.6 * np.cos(above[leg]), 0.6 * np.sin(above[leg]), 0.03 * leg])
        ball = model.addJoint(0, pin.JointModelSpherical(), _at(*foot), f"ball{leg}")
        slide = model.addJoint(ball, pin.JointModelPX(), _at(0, 0, 0), f"l{leg}")
        _frames(model, (slide, f"tip{leg}", _at(0, 0, 0)), (plate, f"top{leg}", _at(*top)))
        line = pose.act(top) - foot
        home += [*pin.Quaternion.FromTwoVectors(np.array([1.0, 0, 0]), line).coeffs()]
        home += [np.linalg.norm(line)]
        loops.append(pj.PointLoop(frames=(f"tip{leg}", f"top{leg}")))
    motors, home = [f"l{leg}" for leg in range(6)], np.array(home)
    return pj.Mechanism.from_pinocchio(model, loops, motors, "top0", home=home, name="legs")


def rod_of_an_rssr(body, motors=("theta",)):
    """An RSSR whose rod is a distance, or a body on three hinges that spins about itself."""
    sizes, model = FOLDING_RSSR, pin.Model()
    theta = model.addJoint(0, pin.JointModelRZ(), _at(0, 0, 0), "theta")
    hinge = pin.JointModelRevoluteUnaligned(*sizes["axis"])
    psi = model.addJoint(0, hinge, _at(*sizes["foot"]), "psi")
    tip = _at(sizes["crank"], 0, 0)
    _frames(model, (theta, "crank", tip), (psi, "rocker", _at(*sizes["rocker"])))
    loop = pj.DistanceLoop(frames=("crank", "rocker"), length=sizes["rod"])
    home = {"theta": -2.7363274182588153, "psi": 1.6556300936016042}
    if body:
        at = model.addJoint(theta, pin.JointModelRX(), tip, "rx")
        at = model.addJoint(at, pin.JointModelRY(), _at(0, 0, 0), "ry")
        at = model.addJoint(at, pin.JointModelRZ(), _at(0, 0, 0), "rz")
        _frames(model, (at, "rod", _at(sizes["rod"], 0, 0)))
        loop = pj.PointLoop(frames=("rod", "rocker"))
        home |= {"rx": -0.21558591191808468, "ry": -0.3369772249080566, "rz": -3.1050619528635806}
    return pj.Mechanism.from_pinocchio(model, [loop], list(motors), "rocker", home=home)
