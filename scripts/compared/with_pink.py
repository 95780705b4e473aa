"""pink: the loop and the crank are tasks, weighed against each other."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pink
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
    none,
    own_lines,
    rocker,
    rocker_rate,
)

import pmjac_pin as pj

TIPS = ("coupler_tip", "rocker_tip")


def tracked(lengths: Mapping[str, float], crank: float) -> tuple[float, float]:
    """Return the rocker's angle and how far the loop is open after 300 steps."""
    mechanism = pj.load("four_bar", lengths)
    model = mechanism.model
    columns = [model.joints[model.getJointId(name)].idx_v for name in ("theta1", "phi1")]
    row, wanted = np.eye(model.nv)[[columns[0]]], np.zeros(model.nq)
    wanted[columns[0]] = crank
    held = pink.LinearHolonomicTask(row, np.zeros(1), wanted, cost=1.0)
    loop = pink.tasks.RelativeFrameTask(*TIPS, 1.0, 0.0)
    loop.set_target(pin.SE3.Identity())
    pose = pink.Configuration(model, model.createData(), mechanism.home.q.copy())
    for _ in range(300):
        rates = pink.solve_ik(pose, [loop, held], dt=0.1, solver="daqp", damping=1e-9)
        pose.integrate_inplace(rates, 0.1)
    gap = pose.get_transform(*TIPS).translation
    return float(pose.q[columns[1]]), float(np.linalg.norm(gap))


def apart(pose: pink.Configuration, tips: tuple[str, str]) -> tuple[np.ndarray, np.ndarray]:
    """Return where the one is from the other and how that moves, and one turns, in the world."""
    first, second = (pose.get_transform_frame_to_world(tip) for tip in tips)
    moved = [
        np.kron(np.eye(2), place.rotation) @ pose.get_frame_jacobian(tip)
        for place, tip in zip((first, second), tips, strict=True)
    ]
    return first.translation - second.translation, moved[0] - moved[1]


def loop_of(lengths: Mapping[str, float]) -> own.Loop:
    """Return the four-bar's loop."""
    bar = pj.load("four_bar", lengths)
    pose = pink.Configuration(bar.model, bar.model.createData(), bar.home.q.copy())

    def opened(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        pose.update(q)
        gap, jacobian = apart(pose, TIPS)
        return gap[:2], jacobian[:2]

    model = bar.model
    joints = (model.joints[model.getJointId(name)].idx_v for name in ("theta1", "phi1"))
    return own.Loop(opened, bar.home.q, *joints)


def bennett() -> str:
    """Return its mobility: a hinge leaves the rotation about its z free."""
    machine = pj.load("bennett")
    pose = pink.Configuration(machine.model, machine.model.createData(), machine.home.q.copy())
    _, jacobian = apart(pose, ("follower_tip", "ground_tip"))
    across = pose.get_transform_frame_to_world("ground_tip").rotation[:, :2].T
    return own.mobility(np.vstack([jacobian[:3], across @ jacobian[3:]]))


def answers() -> Mapping[str, str]:
    """Return what it says, by question."""
    angle, _ = tracked(LENGTHS, CRANK)
    bar, short = loop_of(LENGTHS), loop_of(SHORT)
    rates = bar.rates(own.newton(bar, CRANK)[0])
    end = error(own.end_of_mode(short, SHORT_NEAR), SHORT_ENDS)
    return {
        "close": f"as a task, {error(angle, rocker(CRANK))}",
        "beyond": f"no error: ends open by {tracked(SHORT, BEYOND)[1]:.2g} m",
        "rate": f"by own lines, {error(rates[bar.rocker], rocker_rate(CRANK))}",
        "singular": own_lines(pink, "singular", end),
        "modes": own_lines(pink, "modes", f"{own.ways(bar, CRANK)} from random starts"),
        "mobility": own_lines(pink, "mobility", bennett()),
        "simulate": none(pink, "simulate"),
    }
