"""Published robots with closed chains: each is read, assembled, and differentiated."""

from __future__ import annotations

import numpy as np
import pytest
from differences import difference_quotient
from peer_models import peer_model

import pmjac_pin as pj
from pmjac_pin.files.source import read_source

# nq, nv, rows, rank [K K*], rank K*, mobility, idle passive motions, each with its tool
URDF_PLUS = {
    "four_bar": ("link3", 3, 3, 5, 2, 2, 1, 0),
    "six_bar": ("link3", 10, 5, 5, 2, 2, 3, 0),
}
EXTENDED = {
    "5bar_linkage": ("effector", 6, 6, 6, 3, 3, 3, 1),
    "5bar_linkage_iso3d": ("effector", 5, 5, 3, 3, 3, 2, 0),
    "robot_delta": ("eff", 14, 14, 18, 9, 9, 5, 3),
    "cassie_like": ("foot", 19, 19, 12, 12, 12, 7, 2),
    "digit_like_2legs": ("foot", 54, 48, 36, 36, 36, 12, 0),
}
FILES = {
    **{f"urdf_plus/{name}.urdf": sizes for name, sizes in URDF_PLUS.items()},
    **{f"extended_urdf/{name}/robot.urdf": sizes for name, sizes in EXTENDED.items()},
}


@pytest.fixture(params=FILES, ids=[name.split("/")[1] for name in FILES])
def sample(request):
    tool, *sizes = FILES[request.param]
    return pj.load(peer_model(request.param), tool=tool), sizes


def closed_poses(mechanism, rng):
    """Poses at random motor values near home; URDF+'s four-bar is flat there, and singular."""
    start = "home"
    if mechanism.home.singularity().kind != "regular":
        start = {"joint1": 0.5, "joint2": -0.5, "joint3": 0.5}
    poses = []
    for _ in range(3):
        step = 0.05 * rng.normal(size=len(mechanism.actuated))
        at = mechanism.home.actuated if start == "home" else np.array([0.5])
        poses.append(mechanism.close(at + step, guess=start))
    return poses


def test_sizes(sample):
    mechanism, sizes = sample
    partition = mechanism.home.split_jacobian().partition
    idle = mechanism.home.singularity().idle
    ranks = [partition.constraint_rank, partition.passive_rank]
    found = [mechanism.nq, mechanism.nv, len(mechanism.rows), *ranks, mechanism.mobility, idle]
    assert found == sizes


def test_home_is_closed(sample):
    mechanism, _ = sample
    assert mechanism.home.residual_norm <= 1e-12


def test_j_eq_is_the_derivative_through_the_closure(sample, rng):
    mechanism, _ = sample
    for configuration in closed_poses(mechanism, rng):
        J_eq = configuration.jacobian().J_eq
        quotient = difference_quotient(configuration, 1e-4)
        np.testing.assert_allclose(quotient, J_eq, rtol=0, atol=1e-7 * np.abs(J_eq).max())


def test_every_joint_and_loop_of_the_six_bar_is_read():
    source = read_source(peer_model("urdf_plus/six_bar.urdf"), tool="link3")
    ends = ("constraint1_on_link3", "constraint1_on_link5")
    assert source.spec.loops == (pj.RevoluteLoop(frames=ends),)
    assert source.spec.actuated == ("joint1", "joint2", "joint3")
    assert [joint.name for joint in source.urdf.joints if joint.type == "continuous"] == [
        f"joint{k}" for k in range(1, 6)
    ]


def test_what_digit_replaces():
    source = read_source(peer_model("extended_urdf/digit_like_2legs/robot.urdf"), tool="foot_left")
    assert source.spec.name == "digit_like_2legs"
    assert len(source.spec.spherical) == 6
    crosses = [link for link in source.urdf.links if link.endswith("_cross")]
    assert len(crosses) == 6
    assert source.spec.actuated[:2] == ("motor_hip_x", "motor_hip_z")
    assert any(note.startswith("UJOINT_XY instead") for note in source.notes)


def test_each_leg_of_digit_moves_its_own_foot():
    path = peer_model("extended_urdf/digit_like_2legs/robot.urdf")
    for tool, own in (("foot", slice(0, 6)), ("foot_left", slice(6, 12))):
        J_eq = pj.load(path, tool=tool).home.jacobian().J_eq
        others = np.delete(J_eq, own, axis=1)
        assert np.abs(others).max() <= 1e-12
        assert np.linalg.matrix_rank(J_eq[:, own]) == 6
