"""MJCF that is exported: MuJoCo loads it, and has the same machine in its own words."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
import scipy.linalg
from exported import MACHINES, PEERS
from mechanisms import CATALOGUE, loaded, mostly_slow
from peer_models import peer_model
from test_export import QUICK

import pmjac_pin as pj

mujoco = pytest.importorskip("mujoco", reason="the oracle is MuJoCo")


class InMujoco:
    """A mechanism as MuJoCo has it, at a keyframe; it shares no code with ours."""

    def __init__(self, mechanism, path, pose="home"):
        self.exported = pj.export(mechanism, to="mjcf", file=path)
        self.model = mujoco.MjModel.from_xml_path(str(path))
        self.model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
        self.data = mujoco.MjData(self.model)
        mujoco.mj_resetDataKeyframe(self.model, self.data, self.model.key(pose).id)
        mujoco.mj_forward(self.model, self.data)
        equality = self.data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        self.gaps = self.data.efc_pos[equality]
        self.constraint = self.data.efc_J.reshape(-1, self.model.nv)[equality]

    def allowed(self):
        """Orthonormal columns: the rates that the equalities allow."""
        if not len(self.constraint):
            return np.eye(self.model.nv)
        _, values, rows = np.linalg.svd(self.constraint)
        return rows[np.count_nonzero(values > 1e-9 * values[0]) :].T

    def columns(self, names):
        """Columns of joints, freedom by freedom."""
        dofs = (self.model.joint(name).dofadr[0] for name in names)
        sizes = {int(mujoco.mjtJoint.mjJNT_FREE): 6, int(mujoco.mjtJoint.mjJNT_BALL): 3}
        counts = (sizes.get(int(self.model.joint(name).type[0]), 1) for name in names)
        return [dof + k for dof, count in zip(dofs, counts, strict=True) for k in range(count)]

    def tool_jacobian(self, names):
        """Linear rows of three points, or all six of a frame, by MuJoCo's rates."""
        rows = []
        for name in names:
            linear, angular = np.zeros((3, self.model.nv)), np.zeros((3, self.model.nv))
            self.jacobian_of(name, linear, angular)
            rows += [linear] if len(names) > 1 else [linear, angular]
        return np.vstack(rows)

    def jacobian_of(self, name, linear, angular):
        bodies = [self.model.body(k).name for k in range(self.model.nbody)]
        if name in bodies:
            mujoco.mj_jacBody(self.model, self.data, linear, angular, self.model.body(name).id)
        else:
            mujoco.mj_jacSite(self.model, self.data, linear, angular, self.model.site(name).id)

    def J_eq(self, motors, tool):
        """The tool's rates for unit rates of each motor, of MuJoCo's numbers alone."""
        allowed, driven = self.allowed(), self.columns(motors)
        solved = np.linalg.lstsq(allowed[driven], np.eye(len(driven)), rcond=1e-9)[0]
        return self.tool_jacobian(tool) @ allowed @ solved

    def our_rates(self, model):
        """S of v = S qvel, Pinocchio's rates from MuJoCo's; those of hubs have no part in it."""
        S = np.zeros((model.nv, self.model.nv))
        known = {self.model.joint(k).name for k in range(self.model.njnt)}
        for name, joint in list(zip(model.names, model.joints, strict=True))[1:]:
            own = slice(joint.idx_v, joint.idx_v + joint.nv)
            steps = [name] if name in known else [n for n in known if n.startswith(f"{name}.")]
            dofs = sorted(self.columns(steps))
            turn = np.eye(joint.nv)
            if joint.shortname() == "JointModelFreeFlyer":  # its linear rates are the world's
                w, x, y, z = self.data.qpos[self.model.joint(name).qposadr[0] + 3 :][:4]
                turn[:3, :3] = pin.Quaternion(w, x, y, z).toRotationMatrix().T
            elif joint.shortname() == "JointModelPlanar":  # its slides do not turn
                angle = self.data.qpos[self.model.joint(f"{name}.rz").qposadr[0]]
                turn = pin.AngleAxis(-angle, np.array([0.0, 0.0, 1.0])).matrix()
            S[own, dofs] = turn
        return S

    def as_ours(self, mechanism):
        """Rates of MuJoCo's motors for unit rates of ours: a free body's linear ones differ."""
        blocks = []
        for name in mechanism.spec.actuated:
            joint = mechanism.model.joints[mechanism.model.getJointId(name)]
            block = np.eye(joint.nv)
            if joint.nv == 6:  # the world's axes there, the body's here
                w, x, y, z = self.data.qpos[self.model.joint(name).qposadr[0] + 3 :][:4]
                block[:3, :3] = pin.Quaternion(w, x, y, z).toRotationMatrix()
            blocks.append(block)
        return scipy.linalg.block_diag(*blocks)


def ours(mechanism):
    """J_eq as `InMujoco.J_eq`: of a tool of three points, the rates of these."""
    names = mechanism.spec.tool.names
    if len(names) == 1:
        return mechanism.home.jacobian().J_eq
    return np.vstack([mechanism.home.jacobian(tool=name).Jv_eq for name in names])


def mujoco_agrees(mechanism, path):
    """Gaps, what moves, and J_eq."""
    there = InMujoco(mechanism, path)
    allowed, exported = max(1e-12, mechanism.tolerance), there.exported
    assert np.abs(there.gaps).max(initial=0.0) <= allowed
    # At home as it is: a mobility is that of poses in general.
    split = mechanism.home.split_jacobian()
    rank = np.linalg.matrix_rank(split.constraint_jacobian, tol=1e-8) if mechanism.rows else 0
    assert there.allowed().shape[1] == mechanism.nv - rank
    rates = there.our_rates(mechanism.model) @ there.allowed()
    assert np.linalg.matrix_rank(rates, tol=1e-8) == mechanism.nv - rank
    # So these span the null space of ours: one row space.
    equations = mechanism.loop_equations(mechanism.home.q)[1]
    size = 1.0 + np.abs(equations).max(initial=0.0)
    np.testing.assert_allclose(equations @ rates, 0.0, rtol=0, atol=1e-9 * size)
    try:
        expected = ours(mechanism)
    except pj.NoJacobianError:
        return
    found = there.J_eq(exported.actuated, exported.tool)
    found = found @ there.as_ours(mechanism)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * (1 + np.abs(expected).max()))


@pytest.mark.parametrize(
    "name", mostly_slow(CATALOGUE, ("agile_eye", "delta_rods", "watt_six_bar"))
)
def test_mujoco_has_the_same_machine(name, tmp_path):
    mujoco_agrees(loaded(name), tmp_path / "machine.xml")


@pytest.mark.parametrize("name", mostly_slow(MACHINES, QUICK))
def test_mujoco_has_odd_machines(name, tmp_path):
    if name != "planar base that is driven":  # which MJCF cannot say
        mujoco_agrees(MACHINES[name](), tmp_path / "machine.xml")


@pytest.mark.slow
@pytest.mark.parametrize(("path", "given"), PEERS.items())
def test_mujoco_has_published_models(path, given, tmp_path):
    mujoco_agrees(pj.load(peer_model(path), **given), tmp_path / "machine.xml")


def test_all_poses_are_keyframes_that_close(tmp_path):
    mechanism = loaded("three_rps")
    for pose in mechanism.poses:
        there = InMujoco(mechanism, tmp_path / f"{pose}.xml", pose)
        assert np.abs(there.gaps).max() <= 1e-12
        for name in mechanism.spec.tool.names:
            expected = mechanism.pose(pose).tool_pose(name).translation
            found = there.data.site(name).xpos
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)
