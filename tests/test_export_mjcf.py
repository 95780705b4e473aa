"""MJCF that is exported: MuJoCo loads it, and has the same machine in its own words."""

from __future__ import annotations

import numpy as np
import pytest
from mechanisms import CATALOGUE, loaded

import pmjac_pin as pj
from pmjac_pin.studies.export.take_apart import taken_apart

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


def ours(mechanism):
    """J_eq as `InMujoco.J_eq`: of a tool of three points, the rates of these."""
    names = mechanism.spec.tool.names
    if len(names) == 1:
        return mechanism.home.jacobian().J_eq
    return np.vstack([mechanism.home.jacobian(tool=name).Jv_eq for name in names])


@pytest.mark.parametrize("name", CATALOGUE)
def test_mujoco_has_the_same_machine(name, tmp_path):
    mechanism = loaded(name)
    there = InMujoco(mechanism, tmp_path / "machine.xml")
    assert np.abs(there.gaps).max(initial=0.0) <= 1e-12
    assert there.allowed().shape[1] == mechanism.mobility
    motors = taken_apart(mechanism).motors
    expected = ours(mechanism)
    found = there.J_eq(motors, mechanism.spec.tool.names)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * (1 + np.abs(expected).max()))
