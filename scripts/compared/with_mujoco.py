"""MuJoCo: the crank is held by an equality, and time runs until all is at rest."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path

import mujoco
import numpy as np
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


def exported(mechanism: pj.Mechanism) -> mujoco.MjSpec:
    """Return the machine as MuJoCo reads it."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "machine.xml"
        pj.export(mechanism, to="mjcf", file=path)
        spec = mujoco.MjSpec.from_file(str(path))
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    return spec


def settled(lengths: Mapping[str, float], crank: float) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """Return the model and where it comes to rest with the crank held at an angle."""
    spec = exported(pj.load("four_bar", lengths))
    spec.option.gravity = [0.0, 0.0, 0.0]
    held = spec.add_equality(type=mujoco.mjtEq.mjEQ_JOINT, name1="theta1")
    held.data[:5] = [crank, 0.0, 0.0, 0.0, 0.0]
    model = spec.compile()
    model.dof_damping[:], model.dof_armature[:] = 5.0, 0.1
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    # It counts from where the joint has its zero.
    model.eq_data[-1, 0] = crank - model.qpos0[model.joint("theta1").qposadr[0]]
    for _ in range(20_000):
        mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    return model, data


def gap(data: mujoco.MjData) -> float:
    """Return how far the loop is open, m."""
    return float(np.linalg.norm(data.efc_pos[:3]))


def loop_of(lengths: Mapping[str, float]) -> own.Loop:
    """Return the four-bar's loop: the first rows of what MuJoCo's equalities ask for."""
    model = exported(pj.load("four_bar", lengths)).compile()
    data = mujoco.MjData(model)

    def opened(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        data.qpos[:] = q
        mujoco.mj_fwdPosition(model, data)
        return data.efc_pos[:2].copy(), data.efc_J.reshape(data.nefc, model.nv)[:2].copy()

    joints = (model.joint(name).dofadr[0] for name in ("theta1", "phi1"))
    return own.Loop(opened, model.key_qpos[0].copy(), *joints)


def bennett() -> str:
    """Return its mobility: a hinge is held at two points of its axis, six rows."""
    model = exported(pj.load("bennett")).compile()
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_fwdPosition(model, data)
    return own.mobility(data.efc_J.reshape(data.nefc, model.nv)[: data.ne])


def answers() -> Mapping[str, str]:
    """Return what it says, by question."""
    model, data = settled(LENGTHS, CRANK)
    near = error(data.qpos[model.joint("phi1").qposadr[0]], rocker(CRANK))
    bar, short = loop_of(LENGTHS), loop_of(SHORT)
    rates = bar.rates(own.newton(bar, CRANK)[0])
    end = error(own.end_of_mode(short, SHORT_NEAR), SHORT_ENDS)
    return {
        "close": f"by time, {near}, loop open by {gap(data):.0e} m",
        "beyond": f"no error: rests open by {gap(settled(SHORT, BEYOND)[1]):.2g} m",
        "rate": f"by own lines, {error(rates[bar.rocker], rocker_rate(CRANK))}",
        "singular": own_lines(mujoco, "singular", end),
        "modes": own_lines(mujoco, "modes", f"{own.ways(bar, CRANK)} from random starts"),
        "mobility": own_lines(mujoco, "mobility", bennett()),
        "simulate": f"yes: {data.time:.0f} s in {model.opt.timestep:g} s steps",
    }
