"""Accelerations through the loops against MuJoCo's `qacc`, with its own constraints.

MuJoCo's constraints are soft: with A = J M⁻¹ Jᵀ they solve (A + R) f = a_ref − J (M⁻¹ (τ − h)), and
R is a share (1 − d)/d of A's diagonal, no less than 1e-4. Closed loops at rates that keep them
closed have a_ref = −J̇ v alone. So `qacc` is asked for at several d, and the polynomial through the
answers, taken at R = 0, is what hard constraints have: to some ten digits.
"""

from __future__ import annotations

from pathlib import Path

import mjcf_models
import numpy as np
import pinocchio as pin
import pytest
from mujoco_oracle import Pair, mujoco
from peer_models import peer_model
from transformed import rebuilt

import pmjac_pin as pj

OFF = ("CONTACT", "LIMIT", "WARMSTART")
SHARES = 1e-4 * np.arange(1, 9)  # 1 − d; MuJoCo has none below the first
GRAVITY = np.array([2.0, -7.0, -5.0])
TOOLS = {"four-bar": "coupler", "welded four-bar": "tip", "ball rod": "right", "gears": "b"}

pytestmark = pytest.mark.skipif(
    tuple(map(int, mujoco.__version__.split(".")[:2])) < (3, 7),
    reason="before 3.7, MuJoCo's constraints had no J̇ v",
)


@pytest.fixture(params=[*TOOLS, "cassie"])
def machine(request, tmp_path, monkeypatch):
    """A file as MuJoCo has it, under the gravity of these tests, and our mechanism of it."""
    monkeypatch.chdir(tmp_path)  # MuJoCo writes its log into the working directory
    path, motors, tool = tmp_path / "robot.xml", None, TOOLS.get(request.param)
    if request.param == "cassie":
        path.write_text(standing_cassie())
        motors, tool = LEGS, "left-foot"
    else:
        path.write_text(mjcf_models.MODELS[request.param])
    pair = Pair(path)
    pair.mj.opt.gravity[:] = GRAVITY
    for name in OFF:
        pair.mj.opt.disableflags |= int(getattr(mujoco.mjtDisableBit, f"mjDSBL_{name}"))
    pair.mj.opt.tolerance, pair.mj.opt.iterations = 0.0, 100
    pair.mj.dof_damping[:] = 0.0
    loaded = pj.load(path, actuated=motors, tool=tool)
    model = loaded.model
    model.gravity = pin.Motion(GRAVITY, np.zeros(3))
    assert list(model.names) == list(pair.pin.names)
    return pair, rebuilt(loaded, model)


LEGS = tuple(
    f"{side}-{joint}"
    for side in ("left", "right")
    for joint in ("hip-roll", "hip-yaw", "hip-pitch", "knee", "foot")
)


def standing_cassie() -> str:
    """Held at the pelvis, its springs at rest: without these joints."""
    spec = mujoco.MjSpec.from_file(str(Path(peer_model("mjcf/cassie_closed_chain.xml"))))
    for joint in list(spec.joints):
        if joint.type == mujoco.mjtJoint.mjJNT_FREE or joint.name.endswith(("shin", "spring")):
            spec.delete(joint)
    spec.compile()
    return spec.to_xml()


def moving(mechanism, rng):
    """A closed pose with rates, efforts of the motors and a wrench on the tool."""
    start = mechanism.home.actuated
    step = 0.1 * rng.uniform(-1, 1, start.size)
    configuration = mechanism.close(start + step, enforce_limits=False)
    rates, efforts = rng.normal(size=(2, start.size))
    return configuration, rates, efforts * 5.0, rng.normal(size=6) * 3.0


def accelerations(pair, configuration, v, forces):
    """Of hard constraints, by Pinocchio's v: MuJoCo's `qacc` as R goes to 0."""
    qpos = pair.qpos(configuration.q)
    rates, data = pair.rates(qpos), pair.data
    softness, found = SHARES / (1.0 - SHARES), []
    for share in SHARES:
        pair.mj.eq_solimp[:] = [1.0 - share, 1.0 - share, 1.0, 0.5, 2.0]
        mujoco.mj_resetData(pair.mj, data)
        data.qpos[:], data.qvel[:] = qpos, rates @ v
        data.qfrc_applied[:] = np.linalg.pinv(rates.T) @ forces
        mujoco.mj_forward(pair.mj, data)
        found.append(np.linalg.pinv(rates) @ data.qacc)
    weights = [np.prod([x / (x - one) for x in softness if x != one]) for one in softness]
    return np.array(weights) @ found


def test_forward_dynamics_are_mujocos(machine, rng):
    """All joints, but for what idles: that accelerates by masses that no motor drives."""
    pair, mechanism = machine
    configuration, rates, efforts, wrench = moving(mechanism, rng)
    dynamics = configuration.dynamics(rates)
    motion = configuration.motion(rates, dynamics.accelerations(efforts, wrench))
    forces = np.zeros(mechanism.nv)
    forces[mechanism.problem.partition.actuated] = efforts
    forces += tool_jacobian(pair, configuration).T @ wrench
    wanted = accelerations(pair, configuration, motion.v, forces)
    moved = ~np.any(np.abs(dynamics.motion.jacobian.idle_map) > 1e-9, axis=1)
    assert moved[mechanism.problem.partition.actuated].all()
    size = max(1.0, np.abs(wanted).max())
    np.testing.assert_allclose(motion.a[moved], wanted[moved], atol=1e-9 * size)


def tool_jacobian(pair, configuration):
    """MuJoCo's, of the tool's body."""
    tool = configuration.mechanism.spec.tool.frame
    return pair.tool_jacobian(pair.qpos(configuration.q), tool)


def test_what_rates_alone_ask_of_the_loops_is_mujocos(machine, rng):
    """J̇ v in J a + J̇ v + R f = 0 of MuJoCo's rows; a weld's turn it has by half, in its frame."""
    pair, mechanism = machine
    configuration, rates, efforts, _ = moving(mechanism, rng)
    motion = configuration.motion(rates)
    qpos = pair.qpos(configuration.q)
    data, to_mujoco = pair.data, pair.rates(qpos)
    pair.mj.eq_solimp[:] = [0.9999, 0.9999, 1.0, 0.5, 2.0]
    mujoco.mj_resetData(pair.mj, data)
    data.qpos[:], data.qvel[:] = qpos, to_mujoco @ motion.v
    forces = np.zeros(mechanism.nv)
    forces[mechanism.problem.partition.actuated] = efforts
    data.qfrc_applied[:] = np.linalg.pinv(to_mujoco.T) @ forces
    mujoco.mj_forward(pair.mj, data)
    rows = data.efc_J.reshape(-1, pair.mj.nv)
    asked = -(rows @ data.qacc + data.efc_R * data.efc_force)
    # By what its rows ask of our freedoms, ours in the same motion.
    gamma = motion.jacobian.slopes(motion.v[:, None])[0][0] @ motion.v
    ours = motion.jacobian.constraint_jacobian
    written = np.linalg.lstsq(ours.T, (rows @ to_mujoco).T, rcond=1e-9)[0].T
    np.testing.assert_allclose(written @ ours, rows @ to_mujoco, atol=1e-9)
    size = max(1.0, np.abs(gamma).max())
    np.testing.assert_allclose(written @ gamma, asked, atol=1e-9 * size)
    geared = all(isinstance(loop, pj.JointLoop) for loop in mechanism.spec.loops)
    assert (np.abs(gamma).max() > 1e-3) != geared  # what is linear asks for nothing
