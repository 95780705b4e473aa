"""One J_eq and one direct kinematics, beside the same written out by hand, in the same run.

The hand-written side is what a user of Pinocchio would write for this one mechanism: the bare
Pinocchio calls, one ``np.linalg.solve`` and one ``np.linalg.svd``; no names, no checks, no
guard against changing the assembly mode. Ratios are what counts: both sides are timed in turn.
"""

from __future__ import annotations

import sys
import timeit
from collections.abc import Callable

import numpy as np
import pinocchio as pin

import pmjac_pin as pj

BUDGET = 2.5  # largest ratio to the hand-written equivalent
DISTANCE = 0.03  # m for the 3-RPS, rad for the four-bar


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


def microseconds(
    *functions: Callable[[], object], rounds: int = 40, number: int = 50
) -> list[float]:
    """Return the best time of each, taken in turn so that a slow machine is slow for all."""
    best = [np.inf] * len(functions)
    for _ in range(rounds):
        for k, function in enumerate(functions):
            best[k] = min(best[k], timeit.timeit(function, number=number) / number)
    return [1e6 * seconds for seconds in best]


def compare(name: str) -> list[tuple[str, float, float]]:
    mechanism = pj.load(name)
    hand = Hand(mechanism)
    start = mechanism.home
    target = start.actuated + DISTANCE
    q = start.q
    J_eq = hand.jacobian(q)[0]
    if np.abs(J_eq - start.jacobian().J_eq).max() > 1e-12:
        raise RuntimeError("the two sides do not compute the same J_eq")
    if np.abs(hand.close(q, target) - mechanism.close(target, start).q).max() > 1e-11:
        raise RuntimeError("the two sides do not close on the same pose")
    by_hand, given, fresh = microseconds(
        lambda: hand.jacobian(q),
        start.jacobian,
        lambda: mechanism.configuration(q).jacobian(),
    )
    hand_close, close, close_fresh = microseconds(
        lambda: hand.close(q, target),
        lambda: mechanism.close(target, start),
        lambda: mechanism.close(target, mechanism.configuration(q)),
    )
    return [
        (f"{name}: configuration.jacobian(), kinematics known", given, by_hand),
        (f"{name}: configuration(q).jacobian(), from q on", fresh, by_hand),
        (f"{name}: close(), {DISTANCE} away", close, hand_close),
        (f"{name}: configuration(q), then close()", close_fresh, hand_close),
    ]


def main() -> int:
    print(f"{'':52}{'library':>10}{'by hand':>10}{'ratio':>8}")
    for name in ("three_rps", "four_bar"):
        for what, library, by_hand in compare(name):
            print(f"{what:52}{library:8.1f}us{by_hand:8.1f}us{library / by_hand:8.2f}")
    print(f"The budget for jacobian() and for close() is {BUDGET}. By hand, the kinematics are")
    print("in every figure, and close() has no configuration to certify before.")
    return 0


if __name__ == "__main__":
    sys.exit(main())
