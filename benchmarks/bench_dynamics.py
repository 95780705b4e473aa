"""Mass matrix, bias and J̇_eq θ̇ at one pose, beside the same written by hand, in the same run.

By hand: Pinocchio's Jacobians and accelerations of the loops' frames, one least-squares solution,
crba and rnea. Machines whose loops are points.
"""

from __future__ import annotations

import statistics
import time
from functools import partial

import numpy as np
import pinocchio as pin
from recording import recorded, unrecorded

import pmjac_pin as pj

NAMES = ("four_bar", "watt_six_bar", "three_rps")
POSES, ROUNDS = 50, 7
LWA = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


def heavy(name: str) -> pj.Mechanism:
    """Return a catalogue machine whose bodies have mass."""
    mechanism = pj.load(name)
    model = mechanism.model
    for joint in range(1, model.njoints):
        model.inertias[joint] = pin.Inertia(1.0, np.array([0.1, 0.2, 0.05]), 0.1 * np.eye(3))
    tool = mechanism.spec.tool
    return pj.Mechanism.from_pinocchio(
        model,
        mechanism.spec.loops,
        mechanism.spec.actuated,
        tool.frame or tool.points or (),
        passive=mechanism.spec.passive,
        home=mechanism.home.q,
        name=name,
    )


class ByHand:
    """The same of a machine whose loops are points and whose tool is a frame."""

    def __init__(self, mechanism: pj.Mechanism) -> None:
        model = self.model = mechanism.model
        self.data = model.createData()
        partition = mechanism.problem.partition
        self.motors, self.passive = partition.actuated, partition.passive
        self.pairs = [
            [model.getFrameId(name) for name in loop.frames] for loop in mechanism.spec.loops
        ]
        self.tool = model.getFrameId(mechanism.spec.tool.frame)

    def __call__(self, q: np.ndarray, rates: np.ndarray) -> tuple[np.ndarray, ...]:
        model, data = self.model, self.data
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        rows = [
            pin.getFrameJacobian(model, data, one, LWA)[:3]
            - pin.getFrameJacobian(model, data, other, LWA)[:3]
            for one, other in self.pairs
        ]
        C, J = np.vstack(rows), pin.getFrameJacobian(model, data, self.tool, LWA).copy()
        inverse = np.linalg.pinv(C[:, self.passive], rcond=1e-9)
        G = np.zeros((model.nv, rates.size))
        G[self.motors] = np.eye(rates.size)
        G[self.passive] = -inverse @ C[:, self.motors]
        v = G @ rates
        pin.forwardKinematics(model, data, q, v, np.zeros(model.nv))
        gamma = [
            pin.getFrameClassicalAcceleration(model, data, one, LWA).linear
            - pin.getFrameClassicalAcceleration(model, data, other, LWA).linear
            for one, other in self.pairs
        ]
        bias = np.zeros(model.nv)
        bias[self.passive] = -inverse @ np.concatenate(gamma)
        drift = pin.getFrameClassicalAcceleration(model, data, self.tool, LWA).vector
        upper = np.triu(pin.crba(model, data, q))
        mass = G.T @ (upper + np.triu(upper, 1).T) @ G
        return mass, G.T @ pin.rnea(model, data, q, v, bias), J @ bias + drift


def ours(mechanism: pj.Mechanism, q: np.ndarray, rates: np.ndarray) -> tuple[np.ndarray, ...]:
    configuration = mechanism.configuration(q)
    dynamics = configuration.dynamics(rates)
    return dynamics.mass_matrix, dynamics.bias, dynamics.motion.acceleration


def main() -> None:
    print(f"{'µs':14s}{'by hand':>10s}{'recorded':>10s}{'ratio':>8s}{'without':>10s}{'ratio':>8s}")
    for name in NAMES:
        mechanism, rng = recorded(heavy(name)), np.random.default_rng(0)
        by_hand, n = ByHand(mechanism), len(mechanism.actuated)
        plain = unrecorded(heavy(name))
        home = mechanism.home.actuated
        poses = [mechanism.close(home + rng.uniform(-0.02, 0.02, n)).q for _ in range(POSES)]
        rates = rng.normal(size=(POSES, n))
        for one, other in zip(
            by_hand(poses[0], rates[0]), ours(mechanism, poses[0], rates[0]), strict=True
        ):
            np.testing.assert_allclose(one, other, atol=1e-9 * max(1.0, np.abs(one).max()))
        ways = (by_hand, partial(ours, mechanism), partial(ours, plain))
        times: tuple[list[float], ...] = ([], [], [])
        for _ in range(ROUNDS):
            for of, found in zip(ways, times, strict=True):
                start = time.process_time()
                for q, rate in zip(poses, rates, strict=True):
                    of(q, rate)
                found.append((time.process_time() - start) / POSES)
        hand, here, slow = (1e6 * statistics.median(found) for found in times)
        print(f"{name:14s}{hand:10.1f}{here:10.1f}{here / hand:8.2f}{slow:10.1f}{slow / hand:8.2f}")


if __name__ == "__main__":
    main()
