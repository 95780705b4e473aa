"""What MuJoCo says of an MJCF model, in the coordinates of ours: poses, loop equations, J_eq."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

from pmjac_pin.closing.assembly import build_parts
from pmjac_pin.files.mjcf.reader import read_mjcf
from pmjac_pin.files.urdf.locking import lock_joints
from pmjac_pin.files.urdf.robot import Urdf
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.linkage import with_spherical

mujoco: Any = pytest.importorskip("mujoco", reason="the oracle is MuJoCo")

JOINT, TENDON = int(mujoco.mjtEq.mjEQ_JOINT), int(mujoco.mjtEq.mjEQ_TENDON)
FREE, BALL = int(mujoco.mjtJoint.mjJNT_FREE), int(mujoco.mjtJoint.mjJNT_BALL)


def built(urdf: Urdf, spherical: tuple[str, ...]) -> pin.Model:
    model = pin.buildModelFromXML(urdf.kinematic_xml())
    return with_spherical(model, spherical) if spherical else model


class Pair:
    """One file, read by MuJoCo and by us; some joints may be locked in our home pose."""

    def __init__(self, path: Path, locked: tuple[str, ...] = ()) -> None:
        self.found, self.locked = read_mjcf(path), locked
        home = {name: self.found.home.get(name, 0.0) for name in locked}
        self.urdf = lock_joints(self.found.urdf, home)
        self.pin = built(self.urdf, self.found.spherical)
        self.mj = mujoco.MjModel.from_xml_path(str(path))
        self.mj.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
        self.data = mujoco.MjData(self.mj)

    def mechanism(self, actuated: tuple[str, ...] | None = None, tool: str = "") -> Mechanism:
        spec = self.found.spec(actuated, tool or self.found.urdf.links[-1])
        return Mechanism(build_parts(self.pin, spec.with_locked(self.locked), {}, self.urdf))

    def joints(self) -> list[tuple[Any, Any]]:
        """MuJoCo's joints with ours; a joint that we fixed is left out."""
        found = []
        for number in range(self.mj.njnt):
            joint = self.mj.joint(number)
            name = joint.name or self._unnamed(number)
            if self.pin.existJointName(name):
                found.append((joint, self.pin.joints[self.pin.getJointId(name)]))
        return found

    def _unnamed(self, number: int) -> str:
        kind = ("free", "ball", "slide", "hinge")[self.mj.jnt_type[number]]
        return f"{self.mj.body(self.mj.jnt_bodyid[number]).name}_{kind}"

    def held(self) -> dict[str, float]:
        """The value of each joint that an equality holds by itself: y₀ + a₀."""
        values = {}
        for number in self.active():
            if self.mj.eq_type[number] != JOINT:
                continue
            joint = self.mj.joint(self.mj.eq_obj1id[number])
            if not self.pin.existJointName(joint.name):
                reference = self.mj.qpos0[joint.qposadr[0]]
                values[joint.name] = float(reference + self.mj.eq_data[number, 0])
        return values

    def active(self) -> list[int]:
        """Numbers of the equalities that hold, those of joints at the end, as in our loops."""
        numbers = np.flatnonzero(self.mj.eq_active0)
        return sorted(numbers.tolist(), key=lambda number: self.mj.eq_type[number] == JOINT)

    def geared(self, number: int) -> set[str]:
        """The joints of an equality; none for those of bodies or sites."""
        if self.mj.eq_type[number] != JOINT:
            return set()
        ends = self.mj.eq_obj1id[number], self.mj.eq_obj2id[number]
        return {self.mj.joint(end).name for end in ends if end >= 0}

    def frame(self, name: str, kind: str = "body") -> int:
        """Pinocchio's index of a body's or site's frame."""
        link = f"{name}_site" if kind == "site" and name in self.bodies else name
        return self.pin.getFrameId(link, pin.FrameType.BODY)

    @property
    def bodies(self) -> list[str]:
        return [self.mj.body(number).name for number in range(self.mj.nbody)]

    def random(self, rng: np.random.Generator) -> np.ndarray:
        """A qpos: every joint anywhere, joints that are held where they are held."""
        qpos = self.neutral()
        for joint, _ in self.joints():
            start, kind = joint.qposadr[0], int(joint.type[0])
            size = {FREE: 7, BALL: 4}.get(kind, 1)
            qpos[start : start + size] = rng.uniform(-3.0, 3.0, size)
            if size > 1:
                wxyz = qpos[start + size - 4 : start + size]
                wxyz /= np.linalg.norm(wxyz)
        return qpos

    def neutral(self) -> np.ndarray:
        """MuJoCo's qpos0, with held joints where they are held."""
        qpos = self.mj.qpos0.copy()
        for name, value in self.held().items():
            qpos[self.mj.joint(name).qposadr[0]] = value
        return qpos

    def q(self, qpos: np.ndarray) -> np.ndarray:
        """MuJoCo's qpos as Pinocchio's q."""
        q = pin.neutral(self.pin)
        for joint, ours in self.joints():
            start, kind = joint.qposadr[0], int(joint.type[0])
            if kind in (FREE, BALL):
                size = 7 if kind == FREE else 4
                given = qpos[start : start + size]
                q[ours.idx_q : ours.idx_q + size] = [*given[:-4], *given[-3:], given[-4]]
            elif ours.nq == 2:
                q[ours.idx_q : ours.idx_q + 2] = np.cos(qpos[start]), np.sin(qpos[start])
            else:
                q[ours.idx_q] = qpos[start]
        return q

    def qpos(self, q: np.ndarray) -> np.ndarray:
        """Pinocchio's q as MuJoCo's qpos."""
        qpos = self.neutral()
        for joint, ours in self.joints():
            start, kind = joint.qposadr[0], int(joint.type[0])
            given = q[ours.idx_q : ours.idx_q + ours.nq]
            if kind in (FREE, BALL):
                qpos[start : start + ours.nq] = [*given[:-4], given[-1], *given[-4:-1]]
            else:
                qpos[start] = np.arctan2(given[1], given[0]) if ours.nq == 2 else given[0]
        return qpos

    def rates(self, qpos: np.ndarray) -> np.ndarray:
        """T of qvel = T v: a free body's linear velocity is the world's for MuJoCo."""
        matrix = np.zeros((self.mj.nv, self.pin.nv))
        for joint, ours in self.joints():
            row, column, kind = joint.dofadr[0], ours.idx_v, int(joint.type[0])
            size = {FREE: 6, BALL: 3}.get(kind, 1)
            matrix[row : row + size, column : column + size] = np.eye(size)
            if kind == FREE:
                start = joint.qposadr[0] + 3
                w, x, y, z = qpos[start : start + 4]
                matrix[row : row + 3, column : column + 3] = pin.Quaternion(w, x, y, z).matrix()
        return matrix

    def forward(self, qpos: np.ndarray) -> None:
        self.data.qpos[:] = qpos
        mujoco.mj_forward(self.mj, self.data)

    def placement(self, name: str, kind: str = "body") -> pin.SE3:
        """Where MuJoCo has a body or site after `forward`."""
        view = getattr(self.data, kind)(name)
        return pin.SE3(view.xmat.reshape(3, 3).copy(), np.array(view.xpos))

    def equations(self, qpos: np.ndarray, number: int) -> tuple[np.ndarray, np.ndarray]:
        """Residual and Jacobian, by Pinocchio's v, of the equality of this number."""
        self.forward(qpos)
        rows = (self.data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY) & (
            self.data.efc_id == number
        )
        jacobian = self.data.efc_J.reshape(-1, self.mj.nv)[rows]
        return self.data.efc_pos[rows].copy(), jacobian @ self.rates(qpos)

    def constraint_jacobian(self, qpos: np.ndarray) -> np.ndarray:
        """Every row of MuJoCo's equalities, by Pinocchio's v."""
        return np.vstack([self.equations(qpos, number)[1] for number in self.active()])

    def tool_jacobian(self, qpos: np.ndarray, body: str) -> np.ndarray:
        """The body's Jacobian (6, nv) in the world's axes, linear rows first."""
        self.forward(qpos)
        linear, angular = np.zeros((3, self.mj.nv)), np.zeros((3, self.mj.nv))
        number = self.mj.body(body).id
        mujoco.mj_jacBody(self.mj, self.data, linear, angular, number)
        return np.vstack([linear, angular]) @ self.rates(qpos)
