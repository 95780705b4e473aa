"""Pinocchio has constraints and their Jacobians; the rest is by own lines."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pinocchio as pin
from compared import own_lines as own
from compared.known import (
    BEYOND,
    CRANK,
    LENGTHS,
    SHORT,
    SHORT_ENDS,
    SHORT_NEAR,
    error,
    own_lines,
    rocker,
    rocker_rate,
)

import pmjac_pin as pj


def constraint(kind: type, mechanism: pj.Mechanism, tips: tuple[str, str]) -> tuple[object, object]:
    """Return a constraint of two frames, and scratch for it."""
    model = mechanism.model
    ends = [model.frames[model.getFrameId(tip)] for tip in tips]
    made = kind(model, *(side for end in ends for side in (end.parentJoint, end.placement)))
    return made, made.createData()


def loop_of(lengths: Mapping[str, float]) -> own.Loop:
    """Return the four-bar's loop."""
    bar = pj.load("four_bar", lengths)
    model, data = bar.model, bar.model.createData()
    anchor, scratch = constraint(pin.PointAnchorConstraintModel, bar, ("coupler_tip", "rocker_tip"))

    def opened(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        pin.computeJointJacobians(model, data, q)
        anchor.calc(model, data, scratch)
        jacobian = anchor.jacobian(model, data, scratch)
        return scratch.constraint_position_error[:2].copy(), jacobian[:2]

    joints = (model.joints[model.getJointId(name)].idx_v for name in ("theta1", "phi1"))
    return own.Loop(opened, bar.home.q, *joints)


def bennett() -> str:
    """Return its mobility: a hinge leaves the rotation about its z free, the last of six rows."""
    machine = pj.load("bennett")
    model, data = machine.model, machine.model.createData()
    tips = ("follower_tip", "ground_tip")
    hinge, scratch = constraint(pin.FrameAnchorConstraintModel, machine, tips)
    pin.computeJointJacobians(model, data, machine.home.q)
    hinge.calc(model, data, scratch)
    return own.mobility(hinge.jacobian(model, data, scratch)[:5])


def answers() -> Mapping[str, str]:
    """Return what it says, by question."""
    bar, short = loop_of(LENGTHS), loop_of(SHORT)
    q, _ = own.newton(bar, CRANK)
    end = error(own.end_of_mode(short, SHORT_NEAR), SHORT_ENDS)
    return {
        "close": f"by own lines, {error(q[bar.rocker], rocker(CRANK))}",
        "beyond": f"own lines end open by {own.newton(short, BEYOND)[1]:.2g} m",
        "rate": f"by own lines, {error(bar.rates(q)[bar.rocker], rocker_rate(CRANK))}",
        "singular": own_lines(pin, "singular", end),
        "modes": own_lines(pin, "modes", f"{own.ways(bar, CRANK)} from random starts"),
        "mobility": own_lines(pin, "mobility", bennett()),
        "simulate": f"no stepping; {pin.constraintDynamics.__name__}",
    }
