"""Where a Delta whose rods end in balls is singular by its constraints, in closed form.

A leg's two parallel rods, along uᵢ, forbid the plate a turn about nᵢ = aᵢ × uᵢ, aᵢ along its axles:
the plate gains a turn that no motor takes back where these three are dependent, and two where all
rods are level. Where a leg's rods lie along its axles they are one line, nᵢ = 0, and forbid a slide
along it instead: there are more motions, but no more of the plate's twists. Two legs do so at once
at 24 poses at most, each pair to either side and above or below the base, the third leg either way.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cache
from math import acos, atan2, hypot, pi, sqrt

import numpy as np
import pytest
from scipy.optimize import brentq

import pmjac_pin as pj

OUT = np.array([[np.cos(t), np.sin(t), 0.0] for t in 2 * pi * np.arange(3) / 3])
AXLES = np.array([[-np.sin(t), np.cos(t), 0.0] for t in 2 * pi * np.arange(3) / 3])


@dataclass(frozen=True)
class Delta:
    """Lengths, and closed poses by them."""

    base: float
    arm: float
    rod: float
    plate: float

    @property
    def offset(self):
        return self.base - self.plate

    def thetas(self, point, leg):
        """The arm's angles with the plate's middle there: two, or none."""
        x, y = point @ OUT[leg] - self.offset, point @ AXLES[leg]
        if abs(y) > self.rod:
            return []
        far = hypot(x, point[2])
        cosine = (self.arm**2 + far**2 - self.rod**2 + y**2) / (2 * self.arm * far)
        if abs(cosine) > 1.0:
            return []
        towards = atan2(-point[2], x)
        return [towards + acos(cosine), towards - acos(cosine)]

    def rods(self, point, thetas):
        """Their directions, by rows."""
        arms = np.cos(thetas)[:, None] * OUT - np.sin(thetas)[:, None] * np.array([0.0, 0.0, 1.0])
        return (point - self.offset * OUT - self.arm * arms) / self.rod

    def moments(self, point, thetas):
        """The nᵢ, by rows."""
        return np.cross(AXLES, self.rods(point, thetas))

    def machine(self):
        return built(self)

    def singularity(self, point, thetas):
        machine = self.machine()
        values = {f"theta{k + 1}": theta for k, theta in enumerate(thetas)}
        values["platform"] = [*point, 0.0, 0.0, 0.0, 1.0]
        return machine.configuration(machine.coordinates.q(values, machine.home.q)).singularity()


@cache
def built(delta):
    return pj.delta(delta.base, delta.arm, delta.rod, delta.plate, home=1.2)


CATALOGUE = Delta(0.2, 0.3, 0.7, 0.06)
LONG = Delta(0.12, 0.5, 0.7, 0.06)


def two_legs_in_line(delta):
    """Poses (point, thetas) with the rods of two legs along their axles, to opposite sides."""
    for leg in range(3):
        one, other = (leg + 1) % 3, (leg + 2) % 3
        for side in (1.0, -1.0):
            sides = side * delta.rod * np.array([1.0, -1.0])
            place = np.linalg.solve(AXLES[[one, other], :2], sides)
            out = float(OUT[one, :2] @ place) - delta.offset
            for up in (1.0, -1.0) if abs(out) < delta.arm else ():
                point = np.append(place, up * sqrt(delta.arm**2 - out**2))
                for third in delta.thetas(point, leg):
                    thetas = np.empty(3)
                    thetas[[one, other]] = atan2(-point[2], out)
                    thetas[leg] = third
                    yield point, thetas


def test_two_pairs_of_rods_lie_in_line_at_24_poses():
    poses = list(two_legs_in_line(LONG))
    assert len({(*point.round(6), *thetas.round(6)) for point, thetas in poses}) == 24
    assert len(list(two_legs_in_line(CATALOGUE))) == 12  # its arms are too short for the others
    for point, thetas in poses:
        lengths = np.linalg.norm(LONG.moments(point, thetas), axis=1)
        assert np.count_nonzero(lengths < 1e-7) == 2
        found = LONG.singularity(point, thetas)
        assert found.kind == "configuration space"
        assert found.types.counts["IIM"] == 2
        assert found.types.gosselin_angeles == "III"
        # The plate gains two turns, and loses two slides: no more twists than elsewhere.
        assert found.types.here.twist == found.types.generic.twist == 3
        assert not found.types.constraint_singularity


def test_beside_these_there_is_none(rng):
    for point, thetas in list(two_legs_in_line(LONG))[::5]:
        inwards = point * np.array([0.96, 0.96, 1.0])
        near = [
            min(LONG.thetas(inwards, k), key=lambda t, k=k: abs(t - thetas[k])) for k in range(3)
        ]
        found = LONG.singularity(inwards, np.array(near))
        assert found.kind == "regular"
        assert "IIM" not in found.types.present


def test_one_pair_in_line_is_a_singular_pose_of_the_loops_alone():
    theta, delta = 2.0, LONG
    point = (delta.offset + delta.arm * np.cos(theta)) * OUT[0] + delta.rod * AXLES[0]
    point[2] = -delta.arm * np.sin(theta)
    thetas = np.array([theta, *(delta.thetas(point, leg)[0] for leg in (1, 2))])
    found = delta.singularity(point, thetas)
    assert found.types.counts["IIM"] == 1
    assert not found.types.constraint_singularity


def dependent_moments(delta, rng):
    """A pose on a random upright line where the nᵢ are dependent, and one beside it; or None."""
    aside, modes = rng.uniform(-0.15, 0.15, 2), rng.integers(0, 2, 3)

    def pose(height):
        point = np.array([*aside, height])
        angles = [delta.thetas(point, leg) for leg in range(3)]
        if not all(angles):
            return None
        return point, np.array([own[mode] for own, mode in zip(angles, modes, strict=True)])

    def determinant(height):
        return np.linalg.det(delta.moments(*pose(height)))

    heights = [h for h in np.linspace(-0.9, -0.2, 200) if pose(h) is not None]
    for low, high in itertools.pairwise(heights):
        if high - low < 0.01 and determinant(low) * determinant(high) < 0.0:
            root = brentq(determinant, low, high, xtol=1e-15)
            return pose(root), pose(root + 0.02) or pose(root - 0.02)
    return None


def test_where_the_moments_are_dependent_the_plate_gains_a_turn(rng):
    tried = (dependent_moments(CATALOGUE, rng) for _ in range(40))
    found = [poses for poses in tried if poses is not None][:4]
    assert len(found) == 4
    for on, beside in found:
        singular = CATALOGUE.singularity(*on)
        assert singular.types.constraint_singularity
        assert singular.types.counts["IIM"] == 1
        assert singular.types.here.twist == 4
        # About the normal of all three: with the motors locked it is free to turn so.
        turn = np.linalg.svd(CATALOGUE.moments(*on))[2][-1]
        angular = singular.free_twists[3:]
        assert np.linalg.norm(np.cross(turn, angular.T)) < 1e-6 < 1e-2 < np.linalg.norm(angular)
        assert not CATALOGUE.singularity(*beside).types.constraint_singularity


def level_rods(delta):
    """Poses with all rods level: the plate is in the middle of the circle through the elbows.

    One arm points inwards where the two others point outwards, their ends at R − x and R + x:
    |3R² + x²| = rod |3R − x|, the radius of that circle. Or all three: R + x = ±rod.
    """
    R, found = delta.offset, []
    for sign in (1.0, -1.0):
        for x in np.roots([1.0, sign * delta.rod, 3 * R**2 - sign * 3 * R * delta.rod]):
            if np.isreal(x) and abs(x.real) <= delta.arm:
                found += [(leg, x.real) for leg in range(3)]
        if abs(sign * delta.rod - R) <= delta.arm:
            found.append((None, sign * delta.rod - R))
    for inwards, x in found:
        outwards = np.array([-x if leg == inwards else x for leg in range(3)])
        ends = (R + outwards)[:, None] * OUT[:, :2]
        middle = np.linalg.solve(
            2 * (ends[1:] - ends[0]), (ends[1:] ** 2).sum(axis=1) - (ends[0] ** 2).sum()
        )
        for up in (1.0, -1.0):
            height = up * sqrt(delta.arm**2 - x**2)
            yield np.append(middle, height), np.arctan2(-height, outwards)


@pytest.mark.parametrize(("delta", "count"), [(CATALOGUE, 6), (Delta(0.09, 0.75, 0.7, 0.06), 22)])
def test_where_all_rods_are_level_it_gains_two(delta, count):
    poses = list(level_rods(delta))
    assert len(poses) == count
    for point, thetas in poses[:6]:
        assert np.abs(delta.rods(point, thetas)[:, 2]).max() < 1e-9
        found = delta.singularity(point, thetas)
        assert found.types.constraint_singularity
        assert found.types.counts["IIM"] == 2
        assert found.types.here.twist == 5
