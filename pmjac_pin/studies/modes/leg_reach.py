"""Leg reach: the ball or universal joint of a leg turned so that the leg's end is where it must.

With the hinges' axes a ⟂ b and the leg w ⟂ b, all at zero, the second hinge sets the height
along a, |w| cos(ψ + β) = d·a, in two ways, and the first the direction around a.
"""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin

from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.frames import Frame, find_frame
from pmjac_pin.model.linkage import Edge
from pmjac_pin.studies.modes.legs import Leg
from pmjac_pin.values.arrays import Array


def reached(mechanism: Mechanism, leg: Leg, q: Array) -> Array:
    """Return q with the leg's passive joints such that its end meets its loop's other frame.

    A universal joint can do that in two ways, its cross turned by half a turn; they are one
    mode: the one within the joints' limits, or the one nearer to home.
    """
    coordinates = mechanism.coordinates
    passive = [edge for edge in leg.edges if edge.name not in mechanism.spec.actuated]
    columns = coordinates.columns([edge.name for edge in passive])
    if len(passive) == 1:
        return _ball_turned(mechanism, leg, passive[0].name, q)
    zero = coordinates.with_values(q, columns, np.zeros(2))
    home = coordinates.values(mechanism.home.q)[columns]
    poses = [
        coordinates.unwound(coordinates.with_values(zero, columns, np.array(pair)), columns, True)
        for pair in _hinge_angles(mechanism, leg, passive, zero)
    ]

    def cost(pose: Array) -> tuple[int, float]:
        values = coordinates.values(pose)[columns]
        return len(coordinates.outside(values, columns)), float(np.abs(values - home).sum())

    return min(poses, key=cost)


def _leg_ends(mechanism: Mechanism, leg: Leg, q: Array) -> tuple[pin.Data, Array, Array, Array]:
    """Return the kinematics at q, and centre, end and target of a leg in the world."""
    model, data = mechanism.kinematics.model, mechanism.kinematics.placed(q)

    def point(frame: Frame) -> Array:
        return np.asarray(data.oMi[frame.joint].act(frame.placement.translation))

    own = next(name for name in leg.loop.ends if name != leg.frame)
    centre = data.oMi[leg.body].act(leg.centre)
    return data, centre, point(find_frame(model, own)), point(find_frame(model, leg.frame))


def _hinge_angles(
    mechanism: Mechanism, leg: Leg, passive: list[Edge], zero: Array
) -> list[tuple[float, float]]:
    """Return both pairs of angles (second hinge, first hinge)."""
    data, centre, end, target = _leg_ends(mechanism, leg, zero)
    b, a = ((data.oMi[edge.child] * edge.after.inverse()).rotation[:, 2] for edge in passive)
    w, d = end - centre, target - centre
    aside = np.cross(b, a)
    height = min(1.0, max(-1.0, float(d @ a) / leg.length))
    lift, psi = math.acos(height), math.atan2(w @ aside, w @ a)
    pairs = []
    for beta in (lift - psi, -lift - psi):
        moved = math.cos(beta) * w + math.sin(beta) * np.cross(b, w)
        around = np.cross(a, moved)
        alpha = math.atan2(d @ around, d @ (moved - (moved @ a) * a))
        pairs.append((beta, alpha))
    return pairs


def _ball_turned(mechanism: Mechanism, leg: Leg, name: str, q: Array) -> Array:
    """Return q with a ball turned the shortest way from where its leg points."""
    data, centre, end, target = _leg_ends(mechanism, leg, q)
    turn = pin.Quaternion.FromTwoVectors(end - centre, target - centre).matrix()
    model = mechanism.kinematics.model
    joint = model.joints[model.getJointId(name)]
    local = data.oMi[joint.id].rotation.T @ turn @ data.oMi[joint.id].rotation
    velocity = np.zeros(model.nv)
    velocity[joint.idx_v : joint.idx_v + 3] = pin.log3(local)
    return np.asarray(pin.integrate(model, q, velocity))
