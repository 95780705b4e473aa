"""Assembly modes: all of them, each once, and an honest word on what that rests on."""

from __future__ import annotations

import hand_derived as hand
import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded
from random_machines import Tree

import pmjac_pin as pj
from pmjac_pin.studies.modes import find
from pmjac_pin.studies.modes.closed_pose import closed_pose

LECTURE_A = np.array(
    [
        (0.75931201, 0.28510144, 0.80278893),
        (0.74709682, 0.48093603, 0.81110182),
        (0.66831139, 0.64666409, -0.21037810),
        (0.03951542, -0.69420756, -0.74615223),
    ]
)
LECTURE_B = np.array([(0.4000, 0.7535, 0.2402), (1.0907, 0.5736, 0.2572)])


def angles(modes):
    """θ1, θ2, θ3 of the 3-RPS, by its own names."""
    return np.array([[mode.joint_values[f"theta{k}"] for k in (1, 2, 3)] for mode in modes])


def same_sets(found, expected, atol):
    assert len(found) == len(expected)
    for row in expected:
        assert np.abs(np.asarray(found) - row).max(axis=1).min() <= atol


@pytest.mark.parametrize("name", ["three_rps_ss", "three_rps"])
def test_the_lectures_modes(name):
    mechanism = loaded(name)
    modes = pj.assembly_modes(mechanism, [2 / 3, 3 / 5, 3 / 4], rng=1)
    same_sets(angles(modes), np.vstack([LECTURE_A, -LECTURE_A]), 1e-8)
    modes = pj.assembly_modes(mechanism, [0.5, 1.0, 2.0], rng=1)
    same_sets(angles(modes), np.vstack([LECTURE_B, -LECTURE_B]), 6e-5)


def test_mirror_images_have_opposite_angles():
    modes = pj.assembly_modes(loaded("three_rps_ss"), [2 / 3, 3 / 5, 3 / 4], rng=2)
    found = angles(modes)
    for index, image in enumerate(modes.mirror_images):
        np.testing.assert_allclose(found[image], -found[index], atol=1e-9)
        assert modes.mirror_images[image] == index


@pytest.mark.parametrize("theta1", [0.9, -2.0, 3.0])
def test_the_four_bars_two_modes(theta1):
    modes = pj.assembly_modes(loaded("four_bar"), [theta1], rng=3)
    expected = [
        hand.four_bar_closure(theta1, mechanisms.CRANK_ROCKER, branch)[:2] for branch in (1, -1)
    ]
    found = np.array([mode.passive for mode in modes])
    turned = np.array(expected)
    for row in turned:
        apart = np.abs(np.exp(1j * found) - np.exp(1j * row)).max(axis=1)
        assert apart.min() <= 1e-11
    assert len(modes) == 2


def test_out_of_reach_there_are_none():
    modes = pj.assembly_modes(mechanisms.rocker_rocker(), [2.5], rng=0)
    assert (len(modes), modes.evidence.kind) == (0, "proof")
    assert list(modes) == []


@pytest.mark.parametrize("name", ["serial_2r", "ur5"])
def test_an_open_chain_has_one(name):
    home = loaded(name).home
    [mode] = pj.assembly_modes(home.mechanism, home.actuated, rng=0)
    np.testing.assert_allclose(
        mode.tool_pose().homogeneous, home.tool_pose().homogeneous, atol=1e-12
    )


def test_the_order_does_not_depend_on_the_seed():
    mechanism = loaded("three_rps")
    one, other = (pj.assembly_modes(mechanism, [0.9, 1.0, 1.1], rng=seed) for seed in (1, 2))
    assert len(one) == len(other)
    for a, b in zip(one, other, strict=True):
        np.testing.assert_allclose(a.tool_pose().homogeneous, b.tool_pose().homogeneous, atol=1e-9)


def test_every_mode_is_closed_at_these_motors_and_certified():
    theta = np.array([0.9, 1.0, 1.1])
    for mode in pj.assembly_modes(loaded("three_rps"), theta, rng=0):
        np.testing.assert_array_equal(mode.actuated, theta)
        assert mode.residual_norm <= 1e-12


def test_idle_motions_make_no_modes_of_their_own():
    """The S–S rod spins about itself: as many modes as with a distance in its place."""
    with_body = pj.assembly_modes(mechanisms.rssr(), [0.4], rng=0)
    as_distance = pj.assembly_modes(mechanisms.rssr(rod=False), [0.4], rng=0)
    assert len(with_body) == len(as_distance) == 2
    for one, other in zip(with_body, as_distance, strict=True):
        np.testing.assert_allclose(
            one.tool_pose().homogeneous, other.tool_pose().homogeneous, atol=1e-9
        )


@pytest.mark.slow
def test_the_modes_do_not_depend_on_the_cut():
    mechanism = loaded("three_rps")
    theta = [0.9, 1.0, 1.1]
    expected = pj.assembly_modes(mechanism, theta, rng=0)
    found = pj.assembly_modes(pj.recut(mechanism, "theta1"), theta, rng=0)
    assert len(found) == len(expected)
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_allclose(
            one.tool_pose().homogeneous, other.tool_pose().homogeneous, atol=1e-9
        )


def test_limits_leave_modes_out():
    mechanism = loaded("three_rps_ss")
    model = mechanism.model
    for name in ("theta1", "theta2", "theta3"):
        entry = model.joints[model.getJointId(name)].idx_q
        model.lowerPositionLimit[entry], model.upperPositionLimit[entry] = 0.0, 3.0
    limited = pj.Mechanism.from_pinocchio(
        model,
        [
            pj.DistanceLoop(frames=pair, length=0.75**0.5)
            for pair in (("S1", "S2"), ("S2", "S3"), ("S3", "S1"))
        ],
        mechanism.actuated,
        ["S1", "S2", "S3"],
        home={"l1": 1, "l2": 1, "l3": 1, "theta1": 1.0, "theta2": 1.0, "theta3": 1.0},
    )
    theta = [2 / 3, 3 / 5, 3 / 4]
    assert len(pj.assembly_modes(limited, theta, rng=0)) == 2
    assert len(pj.assembly_modes(limited, theta, rng=0, limits=False)) == 8


@pytest.mark.parametrize(
    ("name", "count", "kind"),
    [
        ("four_bar", 2, "proof"),
        ("watt_six_bar", 4, "proof"),
        ("three_rps", 8, "proof"),
        ("bricard", 2, "proof"),
        ("stewart_gough", 8, "statistics"),
    ],
)
def test_what_completeness_rests_on(name, count, kind):
    mechanism = loaded(name)
    modes = pj.assembly_modes(mechanism, mechanism.home.actuated, rng=0)
    assert len(modes) == count
    assert modes.evidence.kind == kind
    assert str(modes.evidence).startswith(f"{kind}: ")
    bound = pj.assembly_modes(mechanism, mechanism.home.actuated, rng=0, proof=False).evidence
    assert (bound.kind, bound.confidence) == ("statistics", 0.99)
    assert 0.0 < bound.unseen <= 2e-3


def test_a_universal_joint_turned_over_makes_no_mode_of_its_own():
    """The proof counts joint values: sixteen of them are the ankle's four modes."""
    mechanism = loaded("ankle")
    theta = mechanism.home.actuated
    modes = pj.assembly_modes(mechanism, theta, rng=0, limits=False)
    assert (len(modes), modes.evidence.kind) == (4, "proof")
    assert "exactly 16, by" in str(modes.evidence)
    assert str(modes.evidence).endswith(
        ": 4 modes, all bodies of some being where those of others are, to 1e-5"
    )
    within = pj.assembly_modes(mechanism, theta, rng=0)
    assert (len(within), within.evidence.kind) == (4, "proof")
    assert "exactly 4, by" in str(within.evidence)


def test_a_small_budget_is_admitted():
    modes = pj.assembly_modes(loaded("three_rps"), [1, 1, 1.1], rng=0, most_starts=10, proof=False)
    assert modes.evidence.kind == "nothing"
    assert "new modes were met among the last of" in str(modes.evidence)


def test_the_bound_holds_where_it_can_be_checked():
    """A mode that few starts lead to: runs that stop without it are as rare as promised."""
    from pmjac_pin.studies.modes.search import unseen_share

    rng, share, missed, runs = np.random.default_rng(0), 0.01, 0, 4000
    for _ in range(runs):
        first = rng.geometric(share)  # the start that meets it
        starts = 0
        while unseen_share(starts, 1, 0.9) > share:
            starts += 1
        missed += first > starts
    assert missed / runs <= 0.1


def test_a_machine_that_moves_by_itself_has_no_separate_modes():
    mechanism = loaded("planar_3rrr")
    loose = mechanisms.with_motors(mechanism, mechanism.actuated[:1])
    with pytest.raises(pj.IdleMotionError, match="the tool is moved by a passive motion"):
        pj.assembly_modes(loose, mechanism.home.actuated[:1], rng=0, limits=False)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"unseen": 0.0}, "unseen is a share between 0 and 1, got 0.0"),
        ({"confidence": 1.0}, "confidence is a share between 0 and 1"),
        ({"most_starts": 0}, "most_starts must be positive"),
        ({"rng": "dice"}, "rng is a numpy Generator or a whole number"),
        ({"actuated": [1.0]}, r"3 motor values \(l1, l2, l3\) expected, got 1"),
        ({"actuated": [1.0, 1.0, 9.0]}, "motor 'l3' = 9 m is outside its limits"),
    ],
)
def test_bad_arguments(arguments, message):
    arguments = {"actuated": [1.0, 1.0, 1.0], "rng": 0, **arguments}
    with pytest.raises(pj.ArgumentError, match=message):
        pj.assembly_modes(loaded("three_rps"), arguments.pop("actuated"), **arguments)


@pytest.mark.parametrize("limits", [True, False])
def test_dietmaiers_forty(limits):
    """All forty are real, twenty with each sign of the determinant (Dietmaier 1998)."""
    mechanism = loaded("stewart_gough_dietmaier")
    modes = pj.assembly_modes(mechanism, mechanism.home.actuated, rng=1, limits=limits)
    assert len(modes) == 40
    signs = [np.sign(np.linalg.det(mode.split_jacobian().K_star)) for mode in modes]
    assert sum(signs) == 0
    places = np.array([mode.tool_pose().homogeneous.ravel() for mode in modes])
    for index, place in enumerate(places):
        assert np.abs(np.delete(places, index, axis=0) - place).max(axis=1).min() > 1e-4


def test_a_leg_is_a_rod_only_where_it_can_point_everywhere():
    """The 3-RPS's legs swing in a plane, the Gough platform's anywhere."""
    from pmjac_pin.studies.modes.legs import find_legs

    for name, count in (("three_rps", 0), ("four_bar", 0), ("ur5", 0), ("stewart_gough", 6)):
        mechanism = loaded(name)
        legs = find_legs(mechanism, mechanism.home.q)
        assert len(legs) == count
        lengths = [leg.length for leg in legs]
        np.testing.assert_allclose(lengths, mechanism.home.actuated[:count], atol=1e-12)


def test_poses_that_pinocchio_closes_to_one_are_one_mode(monkeypatch):
    """Beside a fold the search may keep two poses apart that are the same when closed exactly."""
    mechanism = loaded("four_bar")
    expected = pj.assembly_modes(mechanism, [0.9], rng=0, proof=False)
    one = closed_pose(mechanism, expected[0].q, limits=True)
    monkeypatch.setattr(find, "closed_pose", lambda *_: one)
    [mode] = pj.assembly_modes(mechanism, [0.9], rng=0, proof=False)
    assert mode is one
    [share] = pj.assembly_modes(mechanism, [0.9], rng=0, proof=False).shares
    assert share == pytest.approx(sum(expected.shares))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("lengths", "theta"),
    [
        ((2.0, 2.0, 3.0, 3.0), 1e-6),
        ((2.0, 2.0, 3.0, 3.0), 1e-5),
        ((2.0, 2.0, 3.0, 3.0), 1e-4),
        ((3.0, 1.0, 3.0, 1.0), 1e-5),
    ],
)
def test_beside_a_singularity_there_are_two_modes_still(lengths, theta):
    """A kite's and a parallelogram's modes meet where all bars are in line."""
    names = ("l0", "l1", "l2", "l3")
    mechanism = pj.load("four_bar", dict(zip(names, lengths, strict=True)))
    assert len(pj.assembly_modes(mechanism, [theta], rng=0, most_starts=20_000)) == 2


@pytest.mark.slow
def test_a_motion_with_locked_motors_is_told_and_left_out():
    """Sarrus' linkage folded flat: one panel spins; the two modes beside that are found."""
    modes = pj.assembly_modes(loaded("sarrus"), [0.7], rng=0)
    assert (len(modes), modes.evidence.kind) == (2, "nothing")
    assert "the loops also move with all motors locked" in str(modes.evidence)
    assert all(not mode.singularity().is_singular for mode in modes)


@pytest.mark.parametrize(
    ("height", "seed"),
    mechanisms.mostly_slow([(h, s) for h in (0.3, 0.8) for s in range(4)], [(0.3, 0)]),
)
def test_a_joint_that_moves_the_loops_nowhere_where_they_close_hides_no_mode(height, seed):
    """A plate that lies on a turning table, by a slide, which idles, and two hinges: one elbow."""
    tree = Tree()
    along, across = (
        pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), np.array(axis)).matrix()
        for axis in ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    )
    table = tree.joint(0, "table", pin.SE3.Identity())
    slide = tree.joint(table, "slide", pin.SE3(along, np.zeros(3)), "prismatic")
    first = tree.joint(slide, "first", pin.SE3(across, np.zeros(3)))
    second = tree.joint(first, "second", pin.SE3(across, np.array([1.0, 0.0, 0.0])))
    tree.frame(0, "plane", pin.SE3(np.eye(3), np.array([0.0, 0.0, height])))
    tree.frame(second, "plate", pin.SE3(np.eye(3), np.array([1.0, 0.2, 0.0])))
    turn = float(np.arcsin(height))
    mechanism = pj.Mechanism.from_pinocchio(
        tree.model,
        [pj.PlanarLoop(frames=("plane", "plate"))],
        ["table"],
        "plane",
        home=[0.4, 0.0, -turn, turn],
    )
    modes = pj.assembly_modes(mechanism, [0.4], rng=seed, limits=False)
    assert len(modes) == 2
    assert min(modes.shares) > 0.05
