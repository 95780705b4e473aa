"""All assembly modes, beside SciPy's `root` from random starts on the same loop equations.

Both sides run in turn in one process; ratios are what counts. SciPy solves η(q ⊕ v) = 0 for the
passive v with Levenberg–Marquardt (there may be more equations than unknowns) and stops as soon
as it has met as many modes as the search found, or when its time is up. The same starts descend by
recorded programs, in lanes of a kernel, and by NumPy, all poses at once.
"""

from __future__ import annotations

import sys
import time
from statistics import median
from unittest import mock

import numpy as np
import pinocchio as pin
from scipy.optimize import root

import pmjac_pin as pj
from pmjac_pin.studies.modes import descents_in_lanes
from pmjac_pin.studies.modes.search import ManyClosures
from pmjac_pin.studies.modes.search_problem import home_with, search_problem
from pmjac_pin.studies.modes.starts import StartSpace

PATIENCE = 30.0  # seconds for SciPy
CASES = {
    "three_rps_ss": [2 / 3, 3 / 5, 3 / 4],
    "three_rps": [2 / 3, 3 / 5, 3 / 4],
    "stewart_gough_dietmaier": None,
    "delta": None,
}


class Multistart:
    """What a user of Pinocchio and SciPy would write."""

    def __init__(self, mechanism: pj.Mechanism, theta: np.ndarray) -> None:
        self.mechanism, self.model = mechanism, mechanism.model
        self.rng = np.random.default_rng(0)
        self.base = mechanism.close(theta).q
        motors = [self.model.getJointId(name) for name in mechanism.actuated]
        fixed = [self.model.joints[motor].idx_v for motor in motors]
        self.passive = np.setdiff1d(np.arange(self.model.nv), fixed)
        self.length = mechanism.characteristic_length

    def pose(self, start: np.ndarray, x: np.ndarray) -> np.ndarray:
        v = np.zeros(self.model.nv)
        v[self.passive] = x
        return pin.integrate(self.model, start, v)

    def solve(self) -> np.ndarray | None:
        """Return a signature of the closed pose that one start leads to, if it leads to one."""
        spread = self.rng.uniform(-np.pi, np.pi, self.passive.size)
        start = self.pose(self.base, spread)
        equations = self.mechanism.loop_equations
        found = root(
            lambda x: equations(self.pose(start, x))[0],
            np.zeros(spread.size),
            method="lm",
            tol=1e-12,
        )
        if np.abs(found.fun).max() > 1e-9 * self.length:
            return None
        pose = self.mechanism.configuration(self.pose(start, found.x)).tool_pose()
        return pose.homogeneous.ravel()


def multistart(case: Multistart, wanted: int) -> tuple[int, int, float]:
    """Return how many modes were met, from how many starts, and in what time."""
    met: list[np.ndarray] = []
    begin, solves = time.perf_counter(), 0
    while len(met) < wanted and time.perf_counter() - begin < PATIENCE:
        solves += 1
        try:
            pose = case.solve()
        except pj.ClosureError:
            continue
        if pose is not None and all(np.abs(pose - known).max() > 1e-6 for known in met):
            met.append(pose)
    return len(met), solves, time.perf_counter() - begin


def search(
    mechanism: pj.Mechanism, theta: np.ndarray, **options: bool | int
) -> tuple[pj.AssemblyModes, float]:
    """Return what the library finds, and in what time."""
    begin = time.perf_counter()
    modes = pj.assembly_modes(mechanism, theta, rng=0, limits=False, **options)
    return modes, time.perf_counter() - begin


def descents(mechanism: pj.Mechanism, theta: np.ndarray) -> str:
    """Return how many starts descend in a second, by the programs and by NumPy, in turn."""
    problem = search_problem(mechanism, home_with(mechanism, theta))
    space = StartSpace.of(problem, limits=False)
    starts = space.draw(np.random.default_rng(0), 2048)
    recorded, plain = (ManyClosures(problem, space.strides(problem)) for _ in range(2))
    begin = time.perf_counter()
    recorded.ends(starts[:1])
    first = time.perf_counter() - begin
    with mock.patch.object(descents_in_lanes, "descent_kernel", return_value=None):
        plain.ends(starts[:64])
    times: list[list[float]] = [[], []]
    for _ in range(5):
        for closures, spent in zip((recorded, plain), times, strict=True):
            begin = time.perf_counter()
            closures.ends(starts)
            spent.append(time.perf_counter() - begin)
    rates = [len(starts) / median(spent) for spent in times]
    told = (
        f"{rates[0]:.0f} starts a second, {rates[1]:.0f} by NumPy, ratio {rates[0] / rates[1]:.0f}"
    )
    return f"{told}; recorded in {first:.3f} s"


def main() -> int:
    print("Assembly modes, with limits left aside, and what it rests on that these are all.")
    for name, values in CASES.items():
        mechanism = pj.load(name)
        theta = mechanism.home.actuated if values is None else np.array(values)
        first, soon = search(mechanism, theta, proof=False, most_starts=1)
        modes, elapsed = search(mechanism, theta)
        bound, whole = search(mechanism, theta, proof=False)
        met, solves, theirs = multistart(Multistart(mechanism, theta), len(modes))
        rate, hand = bound.starts / whole, solves / theirs
        print(f"{name}: {len(modes)} in {elapsed:.3f} s, {modes.evidence.kind}")
        print(f"    {first.starts} starts alone: {len(first)} in {soon:.3f} s")
        print(f"    descents: {descents(mechanism, theta)}")
        print(f"    until the bound is met: {len(bound)} in {whole:.3f} s", end="; ")
        print(f"{rate:.0f} starts a second")
        print(f"    SciPy, told that there are {len(modes)}: {met} in {theirs:.2f} s", end="; ")
        print(f"{hand:.0f} starts a second, ratio {rate / hand:.0f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
