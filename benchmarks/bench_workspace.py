"""Loci and maps of slices, beside what is written by hand for one machine, in the same run.

Points of the five-bar's locus of gain, one curve traced and then all with seeds and modes sought,
beside SciPy's root finder on its closed equation, the elbows two distal links apart; maps of
500 x 500 cells of motor space, the smallest singular value of K* at each, beside the five-bar's
closed form in NumPy. In seconds of the processor, in turn; ratios are what counts. Workspaces of
the tool with their borders, and a hexapod's nearest singularity, with the threads of BLAS that
studies leave it and with all that there are.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq

import pmjac_pin as pj
from pmjac_pin.algebra import one_thread
from pmjac_pin.studies.singularities.curve_tracing import Tracer
from pmjac_pin.studies.singularities.plane_slice import PlaneSlice
from pmjac_pin.studies.singularities.singular_equations import SingularEquations

ROUNDS = 3
CELLS = 500
PROXIMAL, DISTAL, GROUND = 0.3, 0.4, 0.3


def seconds(of: Callable[[], object]) -> float:
    start = time.process_time()
    of()
    return time.process_time() - start


def apart(theta1: float, theta2: float) -> float:
    x = GROUND + PROXIMAL * (np.cos(theta2) - np.cos(theta1))
    y = PROXIMAL * (np.sin(theta2) - np.sin(theta1))
    return float(np.hypot(x, y) - 2.0 * DISTAL)


def by_hand(count: int) -> int:
    """Roots of the closed equation over a grid of the first motor; how many."""
    found = 0
    brackets = np.linspace(-np.pi, np.pi, 41)
    for theta1 in np.linspace(-np.pi, np.pi, count):
        values = [apart(theta1, theta2) for theta2 in brackets]
        for k in range(len(brackets) - 1):
            if values[k] * values[k + 1] < 0.0:
                brentq(lambda theta2, one=theta1: apart(one, theta2), *brackets[k : k + 2])
                found += 1
    return found


def locus_points(mechanism: pj.Mechanism) -> int:
    locus = pj.singularity_locus(mechanism, mechanism.actuated[:2], kinds=["gain"], cells=21)
    return sum(len(curve.places) for curve in locus.curves)


def five_bar_by_hand(axes: tuple[np.ndarray, np.ndarray]) -> float:
    """Both passive angles of all cells in closed form, and the smallest singular value of K*."""
    one, two = np.meshgrid(*axes, indexing="ij")
    ends = [np.stack([PROXIMAL * np.cos(t), PROXIMAL * np.sin(t)]) for t in (one, two)]
    away = ends[1] + np.array([GROUND, 0.0])[:, None, None] - ends[0]
    distance = np.hypot(*away)
    with np.errstate(invalid="ignore"):
        turn = np.arccos(distance / (2.0 * DISTAL))
    towards = np.arctan2(away[1], away[0])
    links = [
        DISTAL * np.stack([np.cos(a), np.sin(a)]) for a in (towards + turn, towards + np.pi - turn)
    ]
    columns = np.stack([np.stack([-link[1], link[0]]) for link in links])
    matrices = np.moveaxis(columns, (0, 1), (-1, -2))[np.isfinite(turn)]
    return float(np.linalg.svd(matrices, compute_uv=False)[:, -1].min())


def mapped(mechanism: pj.Mechanism) -> pj.Workspace:
    return pj.workspace(
        mechanism,
        mechanism.actuated[:2],
        cells=CELLS,
        measure="smallest singular value",
        trace=False,
    )


def one_curve(mechanism: pj.Mechanism) -> Callable[[], int]:
    equations = SingularEquations(mechanism, "gain")
    area = PlaneSlice.of(mechanism.actuated[:2], mechanism.home, None)
    tracer = Tracer(equations, area)
    beside = mechanism.close([2.3, 0.37])
    seed = tracer.corrected(equations.begin(beside.q), 1.0)
    return lambda: len(tracer.trace(seed).points)


def compared(what: str, points: Callable[[], int]) -> None:
    """Print points a second, beside those by hand."""
    taken: list[tuple[float, float]] = []
    for _ in range(ROUNDS):
        found: list[int] = []
        ours = seconds(lambda: found.append(points()))  # noqa: B023
        theirs = seconds(lambda: found.append(by_hand(100)))  # noqa: B023
        taken.append((found[0] / ours, found[1] / theirs))
    ours, theirs = (statistics.median(one) for one in zip(*taken, strict=True))
    print(f"{what:34s}{ours:10.0f}{theirs:10.0f}{ours / theirs:8.2f}   points/s")


def studied() -> dict[str, Callable[[], object]]:
    """Studies of many small matrices, by name."""
    planar, delta, hexapod = (pj.load(name) for name in ("planar_3rrr", "delta", "stewart_gough"))
    return {
        "workspace of planar_3rrr": lambda: pj.workspace(planar, ("x", "y"), cells=31),
        "workspace of delta": lambda: pj.workspace(delta, ("x", "y"), cells=31),
        "nearest of stewart_gough": lambda: pj.nearest_singularity(hexapod.home),
    }


def with_all_threads(of: Callable[[], object]) -> float:
    """Return the seconds of a study that BLAS shares among its threads."""
    limits = one_thread._ONE_THREAD
    limits._within += 1
    try:
        return seconds(of)
    finally:
        limits._within -= 1


def main() -> None:
    bar = pj.load("five_bar")
    compared("one curve of the five-bar", one_curve(bar))
    compared("locus of the five-bar", lambda: locus_points(bar))
    axes = tuple(np.linspace(-np.pi, np.pi, CELLS) for _ in range(2))
    for name in ("five_bar", "three_rps"):
        mechanism = pj.load(name)
        mapped(mechanism)
        rounds = [
            (seconds(lambda: mapped(mechanism)), seconds(lambda: five_bar_by_hand(axes)))  # noqa: B023
            for _ in range(ROUNDS)
        ]
        ours, theirs = (1e6 * statistics.median(x) / CELLS**2 for x in zip(*rounds, strict=True))
        what = f"map of {name}, {CELLS} x {CELLS}"
        print(f"{what:34s}{ours:10.2f}{theirs:10.2f}{ours / theirs:8.1f}   µs a cell")
    for what, study in studied().items():
        study()
        ours, theirs = seconds(study), with_all_threads(study)
        print(f"{what:34s}{ours:10.2f}{theirs:10.2f}{theirs / ours:8.1f}   s, one thread and all")


if __name__ == "__main__":
    main()
