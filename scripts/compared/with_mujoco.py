"""MuJoCo: the crank is held by an equality, and time runs until all is at rest."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path

import mujoco as mj
import numpy as np
from compared.known import BEYOND, CRANK, LENGTHS, SHORT, error, none, rocker, rocker_rate

import pmjac_pin as pj


def settled(lengths: Mapping[str, float], crank: float) -> tuple[mj.MjModel, mj.MjData]:
    """Return the model and where it comes to rest with the crank held at an angle."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "bar.xml"
        pj.export(pj.load("four_bar", lengths), to="mjcf", file=path)
        spec = mj.MjSpec.from_file(str(path))
    spec.option.gravity = [0.0, 0.0, 0.0]
    held = spec.add_equality(type=mj.mjtEq.mjEQ_JOINT, name1="theta1")
    held.data[:5] = [crank, 0.0, 0.0, 0.0, 0.0]
    model = spec.compile()
    model.dof_damping[:], model.dof_armature[:] = 5.0, 0.1
    data = mj.MjData(model)
    mj.mj_resetDataKeyframe(model, data, 0)
    # It counts from where the joint has its zero.
    model.eq_data[-1, 0] = crank - model.qpos0[model.joint("theta1").qposadr[0]]
    for _ in range(20_000):
        mj.mj_step(model, data)
    mj.mj_forward(model, data)
    return model, data


def gap(data: mj.MjData) -> float:
    """Return how far the loop is open, m."""
    return float(np.linalg.norm(data.efc_pos[:3]))


def answers() -> Mapping[str, str]:
    """Return what it says, by question."""
    model, data = settled(LENGTHS, CRANK)
    place = model.joint("phi1").qposadr[0]
    jacobian = data.efc_J.reshape(data.nefc, model.nv)[:3]
    crank = model.joint("theta1").dofadr[0]
    others = [k for k in range(model.nv) if k != crank]
    rates = -np.linalg.lstsq(jacobian[:, others], jacobian[:, crank], rcond=None)[0]
    row = others.index(model.joint("phi1").dofadr[0])
    near = error(data.qpos[place], rocker(CRANK))
    return {
        "close": f"by time, {near}, loop open by {gap(data):.0e} m",
        "beyond": f"no error: rests open by {gap(settled(SHORT, BEYOND)[1]):.2g} m",
        "rate": f"by own lines, {error(rates[row], rocker_rate(CRANK))}",
        "singular": none(mj, "singular"),
        "modes": none(mj, "modes"),
        "mobility": none(mj, "mobility"),
        "simulate": f"yes: {data.time:.0f} s in {model.opt.timestep:g} s steps",
    }
