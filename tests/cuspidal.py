"""The cuspidal 3-RPR, as a mechanism and by its circle equations alone."""

from __future__ import annotations

from functools import cache
from math import atan2, sqrt

import numpy as np
import pinocchio as pin

import pmjac_pin as pj

BASE = np.array([[0.0, 0.0], [15.91, 0.0], [0.0, 10.0]])
D12, D23, D31 = 17.04, 16.54, 20.84
_X3 = (D12**2 + D31**2 - D23**2) / (2.0 * D12)
PLATE = np.array([[0.0, 0.0], [D12, 0.0], [_X3, sqrt(D31**2 - _X3**2)]])
CUSP = (18.040919, 31.596386)  # of the second and third leg, the first being 17


def legs(angles, first):
    """Vectors (3, 2) along the legs: the first one's and the plate's angle are known."""
    leg, plate = angles
    corner = first * np.array([np.cos(leg), np.sin(leg)])
    turn = np.array([[np.cos(plate), -np.sin(plate)], [np.sin(plate), np.cos(plate)]])
    return corner + PLATE @ turn.T - BASE


def circles(angles, lengths):
    """Squares of the second and third leg less what they should be, and their derivative."""
    leg, plate = angles
    found = legs(angles, lengths[0])
    moved = lengths[0] * np.array([-np.sin(leg), np.cos(leg)])
    turned = PLATE @ np.array([[-np.sin(plate), np.cos(plate)], [-np.cos(plate), -np.sin(plate)]])
    gap = (found[1:] ** 2).sum(axis=1) - np.square(lengths[1:])
    return gap, np.column_stack(
        [2.0 * found[1:] @ moved, 2.0 * (found[1:] * turned[1:]).sum(axis=1)]
    )


def newton(angles, lengths, steps=60):
    """A zero of the circles near these angles; None where none is found."""
    for _ in range(steps):
        gap, slope = circles(angles, lengths)
        step = np.linalg.solve(slope, gap)
        size = np.linalg.norm(step)
        angles = angles - step * min(1.0, 0.5 / (size or 1.0))
        if size < 1e-14:
            break
    return angles if np.abs(circles(angles, lengths)[0]).max() < 1e-9 else None


@cache
def solutions(lengths):
    """All zeros that many starts lead to, as angles."""
    rng, found = np.random.default_rng(0), []
    for start in rng.uniform(-np.pi, np.pi, (150, 2)):
        angles = newton(start, lengths)
        if angles is not None and not any(apart(angles, one) < 1e-6 for one in found):
            found.append(np.remainder(angles + np.pi, 2.0 * np.pi) - np.pi)
    return found


def apart(angles, others):
    """How far two pairs of angles are from each other, full turns aside."""
    return np.abs(np.exp(1j * np.asarray(angles)) - np.exp(1j * np.asarray(others))).max()


def sign(angles, lengths):
    return float(np.sign(np.linalg.det(circles(angles, lengths)[1])))


def mechanism(angles, lengths):
    """The machine, at home with these angles."""
    model, loops = pin.Model(), []
    model.name = "cuspidal"

    def at(x, y):
        return pin.SE3(np.eye(3), np.array([x, y, 0.0]))

    def frame(name, joint, placement):
        model.addFrame(pin.Frame(name, joint, 0, placement, pin.FrameType.OP_FRAME))

    vectors = legs(angles, lengths[0])
    home = {}
    for k, (x, y) in enumerate(BASE, 1):
        turn = model.addJoint(0, pin.JointModelRZ(), at(x, y), f"theta{k}")
        slide = model.addJoint(turn, pin.JointModelPX(), pin.SE3.Identity(), f"rho{k}")
        home |= {f"theta{k}": atan2(*vectors[k - 1][::-1]), f"rho{k}": lengths[k - 1]}
        if k == 1:
            plate = model.addJoint(slide, pin.JointModelRZ(), pin.SE3.Identity(), "psi")
            home["psi"] = angles[1] - angles[0]
            frame("plate", plate, pin.SE3.Identity())
        else:
            frame(f"tip{k}", slide, pin.SE3.Identity())
            frame(f"corner{k}", plate, at(*PLATE[k - 1]))
            loops.append(pj.PointLoop(frames=(f"tip{k}", f"corner{k}")))
    motors, rows = ["rho1", "rho2", "rho3"], ["vx", "vy", "wz"]
    return pj.Mechanism.from_pinocchio(model, loops, motors, "plate", tool_rows=rows, home=home)


def angles_of(configuration):
    """The first leg's and the plate's angle."""
    values = configuration.joint_values
    return np.array([values["theta1"], values["theta1"] + values["psi"]])
