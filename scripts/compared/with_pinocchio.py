"""Pinocchio has constraints and their Jacobians; what follows is Newton's method, by own lines."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pinocchio as pin
from compared.known import BEYOND, CRANK, LENGTHS, SHORT, error, none, rocker, rocker_rate

import pmjac_pin as pj


def parts_of(mechanism: pj.Mechanism) -> tuple[object, ...]:
    """Return the model with its loop, and scratch for both."""
    model = mechanism.model
    ends = [model.frames[model.getFrameId(f"{name}_tip")] for name in ("coupler", "rocker")]
    sides = [side for end in ends for side in (end.parentJoint, end.placement)]
    loop = pin.PointAnchorConstraintModel(model, *sides)
    return model, model.createData(), loop, loop.createData()


def opened(q: np.ndarray, parts: tuple[object, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Return the loop's gap at q and its Jacobian."""
    model, data, loop, scratch = parts
    pin.computeJointJacobians(model, data, q)
    loop.calc(model, data, scratch)
    jacobian = loop.jacobian(model, data, scratch)
    return scratch.constraint_position_error.copy(), jacobian


def newton(mechanism: pj.Mechanism, crank: float) -> tuple[np.ndarray, float, np.ndarray]:
    """Return q, the gap that is left and the rates of the other joints by the crank's."""
    parts, q = parts_of(mechanism), mechanism.home.q.copy()
    column = mechanism.model.joints[mechanism.model.getJointId("theta1")].idx_v
    others = [k for k in range(3) if k != column]
    q[column] = crank
    for _ in range(100):
        open_by, jacobian = opened(q, parts)
        q[others] -= np.linalg.lstsq(jacobian[:, others], open_by, rcond=None)[0]
    open_by, jacobian = opened(q, parts)
    rates = -np.linalg.lstsq(jacobian[:, others], jacobian[:, [column]], rcond=None)[0]
    return q, float(np.linalg.norm(open_by)), rates


def answers() -> Mapping[str, str]:
    """Return what it says, by question."""
    bar, short = pj.load("four_bar", LENGTHS), pj.load("four_bar", SHORT)
    q, _, rates = newton(bar, CRANK)
    row = bar.model.joints[bar.model.getJointId("phi1")].idx_v
    return {
        "close": f"by own lines, {error(q[row], rocker(CRANK))}",
        "beyond": f"own lines end open by {newton(short, BEYOND)[1]:.2g} m",
        "rate": f"by own lines, {error(rates[0, 0], rocker_rate(CRANK))}",
        "singular": none(pin, "singular"),
        "modes": none(pin, "modes"),
        "mobility": none(pin, "mobility"),
        "simulate": f"no stepping; {pin.constraintDynamics.__name__}",
    }
