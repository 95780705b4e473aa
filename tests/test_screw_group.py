"""The group that a loop's joints move in, of joints whose group is in every textbook."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pmjac_pin.rates.screw_group import generated_algebra, group_name

X, Y, Z = np.eye(3)


def turn(axis, point=(0.0, 0.0, 0.0)):
    return np.concatenate([np.cross(point, axis), axis])


def slide(axis):
    return np.concatenate([axis, np.zeros(3)])


def screw(axis, pitch, point=(0.0, 0.0, 0.0)):
    return turn(axis, point) + slide(pitch * axis)


CASES = {
    "about an axis": (1, [turn(Z), turn(Z)]),
    "along a line": (1, [slide(X)]),
    "cylindrical": (2, [turn(Z), slide(Z)]),
    "translations of a plane": (2, [slide(X), slide(Y)]),
    "translations": (3, [slide(X), slide(Y), slide(X + Z)]),
    "planar": (3, [turn(Z), turn(Z, X), slide(Y)]),
    "along a screw": (1, [screw(Z, 0.3), screw(-Z, 0.3)]),
    "along parallel screws": (3, [screw(Z, 0.3), screw(Z, 0.3, X)]),
    "spherical": (3, [turn(X), turn(Y + Z), turn(Z - X)]),
    "Schoenflies": (4, [turn(Z), turn(Z, X), slide(Z)]),
    # Three skew axes.
    "spatial": (6, [turn(Z), turn(Y + Z, X), turn(Z - Y, X + Y)]),
}


@pytest.mark.parametrize("name", CASES)
def test_groups_are_found_wherever_they_are(name, rng):
    dimension, twists = CASES[name]
    for _ in range(5):
        rotation = Rotation.random(random_state=int(rng.integers(1 << 30))).as_matrix()
        shift = rng.uniform(-2, 2, 3)
        moved = []
        for twist in twists:
            angular = rotation @ twist[3:]
            moved.append(np.concatenate([rotation @ twist[:3] + np.cross(shift, angular), angular]))
        columns = np.array(moved).T * rng.uniform(0.1, 10.0, len(moved))
        algebra = generated_algebra(columns, 1e-9)
        assert algebra.shape == (6, dimension)
        assert group_name(algebra, 1e-9) == name


def test_two_parallel_axes_that_are_nearly_so_are_told_apart_by_the_tolerance():
    tilted = turn(Z + 1e-5 * X, Y)
    columns = np.array([turn(Z), tilted / np.linalg.norm(tilted), turn(Z, X)]).T
    assert generated_algebra(columns, 1e-3).shape == (6, 3)
    assert generated_algebra(columns, 1e-9).shape == (6, 6)
