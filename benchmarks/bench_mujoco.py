"""Many poses at once, beside hand-written Python around MuJoCo's C, in the same run, one core each.

Both close, give J_eq, and the singular values of its linear and angular rows, at the same targets.
The peer has the machine as `pmjac_pin.export` writes it, and closes each target from home by
Newton's method on the residual and the Jacobian of MuJoCo's equalities, until the loops are open
by less than the library's tolerance. First both must have the same poses, J_eq and radii, to 1e-9
of the machine's length and of the largest entry of J_eq.

Fair to MuJoCo: it is asked for positions and equalities alone, never for a step of time, which is
what it is made for; the first step from home is known once for all; of redundant rows those that
are independent at home are kept; steps are solved by LAPACK's own routine, as SciPy has it, and
J_eq and singular values are found of all poses in one call of NumPy. Not fair to it: between its
calls is a loop in Python. So what its calls take by themselves, as often as they were made, is
told as well: entering them from Python is still in it, and linear algebra, which C around them
would need, is not. Not fair to the library: the peer certifies nothing, neither that it has
stayed in its assembly mode, nor that K* is regular there.
"""

from __future__ import annotations

import statistics
import tempfile
from pathlib import Path

import numpy as np
import pinocchio as pin
from bench_batch import MANY, NAMES, ROUNDS, at_once, machine, seconds, targets
from scipy.linalg import qr
from scipy.linalg.lapack import dgesv

import pmjac_pin as pj

try:
    import mujoco
except ImportError:
    mujoco = None

SINGLE = 2_000
SAME = 1e-9  # of lengths, and of J_eq


class Peer:
    """One machine in MuJoCo, whose loops decide where the joints go that are no motors."""

    def __init__(self, mechanism: pj.Mechanism, folder: Path) -> None:
        path = folder / f"{mechanism.name}.xml"
        pj.export(mechanism, to="mjcf", file=path)
        model = self.model = mujoco.MjModel.from_xml_path(str(path))
        model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
        for left_out in (mujoco.mjtDisableBit.mjDSBL_CONTACT, mujoco.mjtDisableBit.mjDSBL_LIMIT):
            model.opt.disableflags |= int(left_out)
        self.data, self.home = mujoco.MjData(model), model.key("home").qpos.copy()
        self.integrate, self.jacobian_of = mujoco.mj_integratePos, mujoco.mj_jacSite
        self.evaluations = [mujoco.mj_kinematics, mujoco.mj_comPos, mujoco.mj_makeConstraint]
        if model.ntendon:
            self.evaluations.insert(2, mujoco.mj_tendon)
        self.motors = np.array([model.joint(name).dofadr[0] for name in mechanism.actuated])
        self.passive = np.setdiff1d(np.arange(model.nv), self.motors)
        self.tool = model.site(mechanism.spec.tool.names[0]).id
        self.from_home, self.tolerance = mechanism.home.actuated, mechanism.tolerance
        self.rates, self.evaluated = np.zeros(model.nv), 0
        self._choose()

    def _choose(self) -> None:
        """Choose rows that are independent at home, and know the first step from there."""
        self.data.qpos[:] = self.home
        self.evaluate()
        nv, K = self.model.nv, self.data.efc_J.reshape(-1, self.model.nv)
        order = qr(K[:, self.passive].T, pivoting=True)[2]
        self.kept = np.sort(order[: self.passive.size])
        # Where they are in MuJoCo's array, transposed, as LAPACK has them.
        self.K_star_at = self.passive[:, None] + nv * self.kept
        self.first = self.follow(K[None])[0]

    def follow(self, K: np.ndarray) -> np.ndarray:
        """Return K*⁻¹ K, of many poses."""
        kept = K[:, self.kept]
        return np.linalg.solve(kept[..., self.passive], kept[..., self.motors])

    def evaluate(self) -> None:
        for call in self.evaluations:
            call(self.model, self.data)
        self.evaluated += 1

    def close(self, displacement: np.ndarray) -> None:
        """Lead the motors from home by a displacement, the others by Newton's method."""
        model, data, rates, passive = self.model, self.data, self.rates, self.passive
        data.qpos[:] = self.home
        rates[self.motors], rates[passive] = -displacement, self.first.dot(displacement)
        self.integrate(model, data.qpos, rates, -1.0)
        rates[self.motors] = 0.0
        for _ in range(20):
            self.evaluate()
            residual = data.efc_pos
            if residual.dot(residual) < self.tolerance**2:
                return
            K_star, right = data.efc_J.take(self.K_star_at).T, residual.take(self.kept)
            *_, rates[passive], failed = dgesv(K_star, right, overwrite_a=True, overwrite_b=True)
            assert not failed
            self.integrate(model, data.qpos, rates, -1.0)
        raise RuntimeError("open")

    def run(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        model, data, count = self.model, self.data, len(values)
        K, tool = np.empty((count, data.nefc * model.nv)), np.empty((count, 6, model.nv))
        for displacement, its_K, its in zip(values - self.from_home, K, tool, strict=True):
            self.close(displacement)
            its_K[:] = data.efc_J
            self.jacobian_of(model, data, its[:3], its[3:], self.tool)
        follow = self.follow(K.reshape(count, -1, model.nv))
        J_eq = tool[..., self.motors] - tool[..., self.passive] @ follow
        return J_eq, np.linalg.svd(J_eq.reshape(count, 2, 3, -1), compute_uv=False)

    def calls_alone(self, count: int, evaluations: int) -> None:
        """Make MuJoCo's calls of as many poses, and nothing between them."""
        model, data, still = self.model, self.data, np.zeros(self.model.nv)
        rows = np.empty((6, model.nv))
        for _ in range(evaluations):
            self.integrate(model, data.qpos, still, 1.0)
            self.evaluate()
        for _ in range(count):
            self.jacobian_of(model, data, rows[:3], rows[3:], self.tool)


def same(found: np.ndarray, expected: np.ndarray, size: float) -> None:
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=SAME * size)


def check(mechanism: pj.Mechanism, peer: Peer, values: np.ndarray) -> None:
    """Compare the places of all sites that both have, and the tool's axes; J_eq and radii."""
    poses, found = pj.batch(mechanism).ellipsoids_at(values, enforce_limits=False, threads=1)
    (J_eq, radii), model = peer.run(values), mechanism.model
    told = np.stack([found.velocity_radii, found.angular_radii], axis=1)[..., : radii.shape[-1]]
    same(found.J_eq, J_eq, np.abs(J_eq).max())
    same(told, radii, np.abs(J_eq).max())
    names = [peer.model.site(number).name for number in range(peer.model.nsite)]
    both = [number for number, name in enumerate(names) if model.existFrame(name)]
    frames, data = [model.getFrameId(names[number]) for number in both], model.createData()
    for q, one in zip(poses.q[:20], values, strict=False):
        peer.close(one - peer.from_home)
        pin.framesForwardKinematics(model, data, q)
        places = [data.oMf[frame].translation for frame in frames]
        same(peer.data.site_xpos[both], places, mechanism.characteristic_length)
        axes = data.oMf[model.getFrameId(names[peer.tool])].rotation
        same(peer.data.site_xmat[peer.tool], axes.ravel(), 1.0)


def compare(mechanism: pj.Mechanism, folder: Path) -> tuple[float, float, float]:
    """Seconds a pose: by the peer, of MuJoCo's calls alone, and at once."""
    many, peer, values = pj.batch(mechanism), Peer(mechanism, folder), targets(mechanism, MANY)
    few = values[:SINGLE]
    check(mechanism, peer, few)
    times: list[list[float]] = [[], [], []]
    for _ in range(ROUNDS):
        peer.evaluated = 0
        times[0].append(seconds(lambda: peer.run(few)) / SINGLE)
        again = peer.evaluated
        times[1].append(seconds(lambda n=again: peer.calls_alone(SINGLE, n)) / SINGLE)
        times[2].append(seconds(lambda: at_once(many, values)) / MANY)
    one, alone, once = map(statistics.median, times)
    return one, alone, once


def main() -> None:
    if mujoco is None:
        print("MuJoCo is not installed (pip install mujoco)")
        return
    titles = ("MuJoCo", "at once", "ratio", "its calls", "ratio")
    print(f"{'':16s}{''.join(f'{title:>12s}' for title in titles)}   µs a pose")
    with tempfile.TemporaryDirectory() as folder:
        for name in NAMES:
            one, alone, once = compare(machine(name), Path(folder))
            numbers = (1e6 * one, 1e6 * once, one / once, 1e6 * alone, alone / once)
            print(f"{name:16s}{''.join(f'{number:12.2f}' for number in numbers)}", flush=True)


if __name__ == "__main__":
    main()
