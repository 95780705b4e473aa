"""Polytopes in space, by what shares no code with them: supports, box corners and half-spaces."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from mechanisms import CATALOGUE, loaded

import pmjac_pin as pj
from pmjac_pin.rates.polytope import hull_of
from pmjac_pin.rates.solid import force_solid, solid_of, velocity_solid

PLANES = ("zy", "zx", "xy")


def at(name, rng):
    mechanism = loaded(name)
    partition = mechanism.problem.partition
    scale = partition.column_scale[partition.actuated]
    step = 0.05 * mechanism.characteristic_length * scale * rng.uniform(-1, 1, scale.size)
    return mechanism.close(mechanism.home.actuated + step, enforce_limits=False).jacobian()


@pytest.mark.parametrize("name", CATALOGUE)
def test_supports_of_velocities_are_the_sum_over_motors(name, rng):
    """max uᵀv = Σᵢ |uᵀ Jᵢ| limitᵢ, and no corner is beyond."""
    jacobian = at(name, rng)
    block, limits = jacobian.Jv_eq, rng.uniform(0.5, 2.0, jacobian.Jv_eq.shape[1])
    solid = velocity_solid(jacobian.Jv_eq, jacobian.velocity_ellipsoid(), limits)
    for way in rng.normal(size=(30, 3)):
        most = np.abs(way @ block) @ limits
        assert (solid.corners @ way).max() == pytest.approx(most, abs=1e-9 * solid.reach)
    assert solid.unit == "m/s"


@pytest.mark.parametrize("name", CATALOGUE)
def test_corners_of_forces_are_held_by_as_many_motors_at_their_limits(name, rng):
    jacobian = at(name, rng)
    limits = rng.uniform(0.5, 2.0, jacobian.Jv_eq.shape[1])
    solid = force_solid(jacobian.Jv_eq, jacobian.velocity_ellipsoid(), limits)
    moved = np.linalg.matrix_rank(jacobian.Jv_eq, tol=1e-9 * np.abs(jacobian.Jv_eq).max())
    for corner in solid.corners:
        shares = np.abs(jacobian.Jv_eq.T @ corner) / limits
        assert shares.max() == pytest.approx(1.0, abs=1e-8)
        assert (shares > 1.0 - 1e-8).sum() >= moved


@pytest.mark.parametrize("name", CATALOGUE)
def test_faces_are_flat_convex_and_close_by_euler(name, rng):
    jacobian = at(name, rng)
    for make in (velocity_solid, force_solid):
        block, moves = jacobian.Jv_eq, jacobian.velocity_ellipsoid()
        solid = make(block, moves, np.ones(block.shape[1]))
        dimension = np.linalg.matrix_rank(solid.corners, tol=1e-9 * solid.reach)
        if dimension == 1:
            assert (len(solid.corners), solid.faces, solid.edges) == (2, (), ((0, 1),))
            continue
        if dimension == 3:
            assert len(solid.corners) - len(solid.edges) + len(solid.faces) == 2
        for face in solid.faces:
            ring = solid.corners[list(face)]
            turns = np.cross(
                np.roll(ring, -1, 0) - ring, np.roll(ring, -2, 0) - np.roll(ring, -1, 0)
            )
            normal = turns.sum(axis=0) / np.linalg.norm(turns.sum(axis=0))
            assert (turns @ normal > -1e-9 * solid.reach**2).all()
            if dimension == 3:
                height = normal @ ring[0]
                assert height > 0  # outwards
                assert (solid.corners @ normal).max() == pytest.approx(
                    height, abs=1e-8 * solid.reach
                )


@pytest.mark.parametrize("plane", PLANES)
@pytest.mark.parametrize("name", CATALOGUE)
def test_sections_and_shadows_are_those_of_half_spaces_and_supports(name, plane, rng):
    jacobian = at(name, rng)
    limits = rng.uniform(0.5, 2.0, jacobian.Jv_eq.shape[1])
    axes = np.eye(3)[["xyz".index(letter) for letter in plane]]
    block, moves = jacobian.Jv_eq, jacobian.velocity_ellipsoid()
    reach, held = velocity_solid(block, moves, limits), force_solid(block, moves, limits)
    for angle in rng.uniform(0, 2 * np.pi, 20):
        way = np.array([np.cos(angle), np.sin(angle)])
        most = np.abs(way @ axes @ jacobian.Jv_eq) @ limits
        assert (reach.shadow(plane) @ way).max() == pytest.approx(most, abs=1e-9 * reach.reach)
    for corner in held.section(plane):  # in the plane, and on a face
        shares = np.abs(jacobian.Jv_eq.T @ (axes.T @ corner)) / limits
        if np.abs(corner).max() > 1e-9 * held.reach:
            assert shares.max() == pytest.approx(1.0, abs=1e-7)


def test_a_section_of_a_cube_through_its_edges_is_a_rectangle():
    cube = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
    turn = np.array([[1, 0, 0], [0, 1, -1], [0, 1, 1]]) / np.array([1, 2**0.5, 2**0.5])[:, None]
    solid = solid_of(hull_of(cube @ turn.T, "N"))
    for outline in (solid.section("xy"), solid.shadow("xy")):
        np.testing.assert_allclose(np.abs(outline), np.tile([1.0, 2**0.5], (4, 1)), atol=1e-12)
    assert len(solid.faces) == 6


def test_a_tool_that_stands_has_no_polytope():
    moves = loaded("four_bar").with_tool("ground").home.jacobian().velocity_ellipsoid()
    for make in (velocity_solid, force_solid):
        with pytest.raises(pj.ArgumentError, match="does not move"):
            make(np.zeros((3, 1)), moves, [1.0])


@pytest.mark.parametrize("off", [1e-3, 1e-5, 1e-7, 1e-9])
def test_what_is_thin_is_as_exact_as_what_is_thick(off):
    """Beside a symmetric home a platform moves nearly along one line, and forces are huge."""
    jacobian = loaded("three_rps").close([1.0 + off, 1.0, 1.0]).jacobian()
    block, moves, limits = jacobian.Jv_eq, jacobian.velocity_ellipsoid(), [100.0, 70.0, 50.0]
    held, reach = force_solid(block, moves, limits), velocity_solid(block, moves, limits)
    for solid in (held, reach):
        assert len(solid.corners) - len(solid.edges) + len(solid.faces) == 2
    shares = np.abs(held.corners @ block) / limits
    np.testing.assert_allclose(shares.max(axis=1), 1.0, atol=1e-9)
    for way in np.random.default_rng(1).normal(size=(20, 3)):
        most = np.abs(way @ block) @ limits
        assert (reach.corners @ way).max() == pytest.approx(most, rel=1e-9)
