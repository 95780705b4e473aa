"""pink: the loop and the crank are tasks, weighed against each other."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pink as pk
import pinocchio as pin
from compared.known import BEYOND, CRANK, LENGTHS, SHORT, error, none, rocker

import pmjac_pin as pj


def tracked(lengths: Mapping[str, float], crank: float) -> tuple[float, float]:
    """Return the rocker's angle and how far the loop is open after 300 steps."""
    mechanism = pj.load("four_bar", lengths)
    model = mechanism.model
    columns = [model.joints[model.getJointId(name)].idx_v for name in ("theta1", "phi1")]
    row, wanted = np.eye(model.nv)[[columns[0]]], np.zeros(model.nq)
    wanted[columns[0]] = crank
    held = pk.LinearHolonomicTask(row, np.zeros(1), wanted, cost=1.0)
    loop = pk.tasks.RelativeFrameTask("coupler_tip", "rocker_tip", 1.0, 0.0)
    loop.set_target(pin.SE3.Identity())
    pose = pk.Configuration(model, model.createData(), mechanism.home.q.copy())
    for _ in range(300):
        rates = pk.solve_ik(pose, [loop, held], dt=0.1, solver="daqp", damping=1e-9)
        pose.integrate_inplace(rates, 0.1)
    gap = pose.get_transform("coupler_tip", "rocker_tip").translation
    return float(pose.q[columns[1]]), float(np.linalg.norm(gap))


def answers() -> Mapping[str, str]:
    """Return what it says, by question."""
    angle, _ = tracked(LENGTHS, CRANK)
    return {
        "close": f"as a task, {error(angle, rocker(CRANK))}",
        "beyond": f"no error: ends open by {tracked(SHORT, BEYOND)[1]:.2g} m",
        "rate": none(pk, "rate"),
        "singular": none(pk, "singular"),
        "modes": none(pk, "modes"),
        "mobility": none(pk, "mobility"),
        "simulate": none(pk, "simulate"),
    }
