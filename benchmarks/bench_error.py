"""The error of J_eq beside a fold, against fifty digits; what is told of it; what that costs."""

from __future__ import annotations

import sys
import timeit

import mpmath as mp
import numpy as np

import pmjac_pin as pj

LENGTHS = {"l0": 4.0, "l1": 3.0, "l2": 2.5, "l3": 2.0}  # a rocker: its crank cannot turn around
DISTANCES = (1.0, 1e-1, 1e-2, 1e-3, 1e-5, 1e-7, 1e-9, 1e-10)
POSES = 25


def middle(theta: mp.mpf, side: int) -> list[mp.mpf]:
    """Return where the coupler's middle is, in closed form."""
    l0, l1, l2, l3 = (mp.mpf(length) for length in LENGTHS.values())
    crank = [l1 * mp.cos(theta), l1 * mp.sin(theta)]
    x, y = l0 - crank[0], -crank[1]
    diagonal = mp.hypot(x, y)
    cosine = (l2**2 + diagonal**2 - l3**2) / (2 * l2 * diagonal)
    angle = mp.atan2(y, x) + side * mp.acos(cosine)
    return [crank[0] + l2 / 2 * mp.cos(angle), crank[1] + l2 / 2 * mp.sin(angle)]


def velocity(pose: pj.Configuration) -> list[mp.mpf]:
    """Return J_v, its x and y, with fifty digits."""
    theta, height = mp.mpf(float(pose.actuated[0])), float(pose.tool_pose().translation[1])
    side = min((1, -1), key=lambda way: abs(float(middle(theta, way)[1]) - height))
    step = mp.mpf(10) ** -20
    return [mp.diff(lambda t, k=k: middle(t, side)[k], theta, h=step) for k in (0, 1)]


def relative(pose: pj.Configuration) -> tuple[float, float, float]:
    """Return cond(K*), and the error and the estimate relative to the largest entry."""
    jacobian, exact = pose.jacobian(), velocity(pose)
    size = float(max(map(abs, exact)))
    error = max(float(abs(mp.mpf(float(jacobian.J_eq[k, 0])) - exact[k])) for k in (0, 1))
    estimate = float(jacobian.error_estimate[:2].max())
    return pose.singularity().condition, error / size, estimate / size


def main() -> int:
    mp.mp.dps = 50
    rocker, rng = pj.load("four_bar", LENGTHS), np.random.default_rng(0)
    l0, l1, l2, l3 = LENGTHS.values()
    fold = mp.acos((l0**2 + mp.mpf(l1) ** 2 - (l2 + mp.mpf(l3)) ** 2) / (2 * l0 * l1))
    print(f"rocker four-bar, {POSES} poses each; relative to J_v")
    print("rad from fold  cond(K*)  error, median     max  estimate  cond 1e-16  cond^2 1e-16")
    for distance in DISTANCES:
        aways = distance * rng.uniform(0.5, 1.5, POSES)
        poses = [rocker.close([float(fold - mp.mpf(away))]) for away in aways]
        found = np.array([relative(pose) for pose in poses])
        condition, error, estimate = np.median(found, axis=0)
        print(
            f"{distance:13.0e}{condition:10.1e}{error:15.1e}{found[:, 1].max():8.1e}"
            f"{estimate:10.1e}{1e-16 * condition:12.1e}{1e-16 * condition**2:14.1e}"
        )
    print("mechanism      jacobian, us  with its error_estimate, us")
    for name in ("four_bar", "three_rps", "stewart_gough", "delta"):
        home = pj.load(name).home
        home.jacobian()
        times = [
            1e6 * float(np.median(timeit.repeat(ask, number=20, repeat=5))) / 20
            for ask in (home.jacobian, lambda home=home: home.jacobian().error_estimate)
        ]
        print(f"{name:14}{times[0]:13.0f}{times[1]:29.0f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
