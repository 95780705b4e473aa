"""The torque map of a humanoid's ankle: two derivations of joint torques from motor torques.

Run `python docs/settled_ankle.py`.
"""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

import pmjac_pin as pj

JOINTS = ("pitch", "roll")
PITCHES, ROLLS = np.linspace(-0.4, 0.25, 14), np.linspace(-0.15, 0.15, 13)  # rad
POSE = (0.1, 0.05)  # rad

# As in the open software of the AgiBot X1: docs/settled.md says where. m and rad.
CRANK = 0.025
MOTORS = np.array([[-0.041, 0.0, 0.195], [-0.041, 0.0, 0.14]])
BALLS = np.array([[-0.041, -0.025, 0.009], [-0.041, 0.025, 0.009]])  # on the foot
ZEROS = np.array([1.2028, -1.2030])

Array = NDArray[np.float64]


def foot(pitch: float, roll: float) -> tuple[Array, Array]:
    """Return R_y(pitch) and R_y(pitch) R_x(roll)."""
    c, s = np.cos([pitch, roll]), np.sin([pitch, roll])
    pitched = np.array([[c[0], 0.0, s[0]], [0.0, 1.0, 0.0], [-s[0], 0.0, c[0]]])
    return pitched, pitched @ np.array([[1.0, 0.0, 0.0], [0.0, c[1], -s[1]], [0.0, s[1], c[1]]])


def rods(motors: Array, turned: Array) -> tuple[Array, Array]:
    """Return the rods' directions, and how their upper ends move with the motors, both (2, 3)."""
    angles = np.asarray(motors) + ZEROS
    still = np.zeros(2)
    tips = MOTORS + CRANK * np.column_stack([still, -np.sin(angles), np.cos(angles)])
    moving = CRANK * np.column_stack([still, -np.cos(angles), -np.sin(angles)])
    along = BALLS @ turned.T - tips
    return along / np.linalg.norm(along, axis=1)[:, None], moving


def by_virtual_work(joints: tuple[float, float], motors: Array) -> Array:
    """Return Rᵀ: rod i keeps its length, uᵢ · dtipᵢ = uᵢ · dballᵢ, both joints at their balls."""
    pitched, turned = foot(*joints)
    directions, moving = rods(motors, turned)
    balls, long_axis = BALLS @ turned.T, pitched[:, 0]
    moments = np.array([np.cross([0.0, 1.0, 0.0], balls), np.cross(long_axis, balls)])
    return (moments * directions).sum(axis=2) / (moving * directions).sum(axis=1)


def with_short_arms(joints: tuple[float, float], motors: Array) -> Array:
    """Return the map of the other derivation.

    It differs in two places: the rods' arms are (−0.041, 0, 0) about pitch and (0, ∓0.025, 0) about
    roll, without the rest of where the balls are; and u₁ stands for u₂ in the second denominator.
    """
    pitched, turned = foot(*joints)
    directions, moving = rods(motors, turned)
    behind = BALLS * [1.0, 0.0, 0.0] @ pitched.T
    beside = BALLS * [0.0, 1.0, 0.0] @ turned.T
    moments = np.array([np.cross([0.0, 1.0, 0.0], behind), np.cross(pitched[:, 0], beside)])
    return (moments * directions).sum(axis=2) / (moving @ directions[0])


def main() -> None:
    """Print both maps at a pose, and how far apart they are over the ankle's range."""
    transmission = pj.transmission(pj.load("humanoid_ankle"), JOINTS)
    geared = transmission.at_joints(POSE)
    maps = {
        "the library, one call": geared.ratio.T,
        "by hand, virtual work": by_virtual_work(POSE, geared.motors),
        "with the short arms": with_short_arms(POSE, geared.motors),
    }
    print(f"joint torques of motor torques at pitch {POSE[0]}, roll {POSE[1]} rad:")
    for words, found in maps.items():
        print(f"  {words:24}", "  ".join(f"{entry:9.6f}" for entry in found.ravel()))
    agree, apart = [], []
    for joints in itertools.product(PITCHES, ROLLS):
        there = transmission.at_joints(joints)
        exact = there.ratio.T
        agree.append(np.abs(by_virtual_work(joints, there.motors) - exact).max())
        other = with_short_arms(joints, there.motors)
        apart.append(np.linalg.norm(other - exact) / np.linalg.norm(exact))
    print(f"over pitch -0.4 to 0.25, roll -0.15 to 0.15 rad, {len(apart)} poses:")
    print(f"  library and virtual work differ by {max(agree):.9f} at most")
    print(f"  the short arms by {np.median(apart):.1%} in the median, {max(apart):.1%} at most")


if __name__ == "__main__":
    main()
