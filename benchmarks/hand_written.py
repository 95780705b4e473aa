"""What a user of Pinocchio would write for one mechanism: bare calls, one solve, one SVD.

No names, no checks, no guard against changing the assembly mode.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

import pmjac_pin as pj


class Hand:
    """A mechanism with point loops, by hand."""

    def __init__(self, mechanism: pj.Mechanism) -> None:
        model = self.model = mechanism.model
        self.data = model.createData()
        self.models, self.datas = pin.StdVec_ConstraintModel(), pin.StdVec_ConstraintData()
        for loop in mechanism.spec.loops:
            first, second = (model.frames[model.getFrameId(name)] for name in loop.frames)
            anchor = pin.PointAnchorConstraintModel(
                model, second.parentJoint, second.placement, first.parentJoint, first.placement
            )
            self.models.append(pin.ConstraintModel(anchor))
            self.datas.append(pin.ConstraintData(anchor.createData()))
        self.pairs = list(zip(self.models, self.datas, strict=True))
        self.anchors = [(m.extract(), d.extract()) for m, d in self.pairs]
        self.tool = model.getFrameId(mechanism.spec.tool.frame)
        columns = {name: model.joints[model.getJointId(name)].idx_v for name in mechanism.actuated}
        self.actuated = np.array(list(columns.values()))
        self.passive = np.array([c for c in range(model.nv) if c not in columns.values()])
        self.rows = np.arange(self.passive.size)

    def constraint_jacobian(self, q: np.ndarray) -> np.ndarray:
        pin.computeJointJacobians(self.model, self.data, q)
        for model, data in self.anchors:
            model.calc(self.model, self.data, data)
        return pin.getConstraintsJacobian(self.model, self.data, self.models, self.datas)

    def jacobian(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        constraint = self.constraint_jacobian(q)[self.rows]
        tool = pin.getFrameJacobian(self.model, self.data, self.tool, pin.LOCAL_WORLD_ALIGNED)
        K_star = constraint[:, self.passive]
        singular_values = np.linalg.svd(K_star)[1]
        rates = np.linalg.solve(K_star, constraint[:, self.actuated])
        return tool[:, self.actuated] - tool[:, self.passive] @ rates, singular_values

    def close(self, q: np.ndarray, target: np.ndarray) -> np.ndarray:
        q = q.copy()
        joints = self.actuated_q
        q[joints] = target
        step = np.zeros(self.model.nv)
        for _ in range(20):
            constraint = self.constraint_jacobian(q)
            gap = np.concatenate([data.constraint_position_error for _, data in self.anchors])
            if np.abs(gap).max() < 1e-12:
                return q
            K_star = constraint[np.ix_(self.rows, self.passive)]
            step[self.passive] = np.linalg.solve(K_star, -gap[self.rows])
            q = pin.integrate(self.model, q, step)
        raise RuntimeError("open")

    @property
    def actuated_q(self) -> np.ndarray:
        by_column = {joint.idx_v: joint.idx_q for joint in list(self.model.joints)[1:]}
        return np.array([by_column[column] for column in self.actuated])
