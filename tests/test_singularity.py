"""Singularities: K* below its generic rank, what moves freely there, and how near one can go."""

from __future__ import annotations

import hand_derived as hand
import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.model.tool_rows import TWIST_ROWS
from pmjac_pin.rates.factorisation import RANK_TOLERANCE, factorise

STRETCHED = (4.0, 3.0, 2.5, 2.0)
FOLDED = (2.0, 1.5, 2.6, 1.0)
SQUARE_SIDE_UP = (3.0, 2.0, 2.2, 1.9)


def four_bar_with(lengths):
    return pj.load("four_bar", parameters=dict(zip(("l0", "l1", "l2", "l3"), lengths, strict=True)))


def four_bar_at_limit(lengths):
    theta1, (phi1, phi2) = hand.four_bar_crank_limit(lengths)
    mechanism = four_bar_with(lengths)
    values = {"theta1": theta1, "phi1": phi1, "phi2": phi2}
    return mechanism, theta1, values


def as_q(mechanism, values):
    model, q = mechanism.model, pin.neutral(mechanism.model)
    for name, value in values.items():
        q[model.joints[model.getJointId(name)].idx_q] = value
    return q


@pytest.mark.parametrize("lengths", [STRETCHED, FOLDED, SQUARE_SIDE_UP])
def test_four_bar_at_the_end_of_the_cranks_range(lengths):
    mechanism, _, values = four_bar_at_limit(lengths)
    configuration = mechanism.configuration(as_q(mechanism, values))
    with pytest.raises(pj.SingularError, match="with all motors locked") as caught:
        configuration.jacobian()
    assert caught.value.singular_value < RANK_TOLERANCE == caught.value.tolerance
    # The exact null vector of K*, by hand.
    K_star = hand.four_bar_K_star(values["theta1"], (values["phi1"], values["phi2"]), lengths)
    free = np.array([caught.value.free_motion[name] for name in ("phi1", "phi2")])
    np.testing.assert_allclose(K_star @ free, 0.0, atol=1e-7)
    assert np.abs(free).max() == pytest.approx(1.0)
    singularity = configuration.singularity()
    assert singularity.kind == "gain"
    assert (singularity.rank, singularity.generic_rank, singularity.gained) == (1, 2, 1)
    assert singularity.free_motion() == caught.value.free_motion
    # The crank itself cannot move there.
    np.testing.assert_allclose(singularity.forbidden_rates, [[1.0]])
    assert configuration.split_jacobian().det_K_star == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("lengths", [STRETCHED, FOLDED, SQUARE_SIDE_UP])
@pytest.mark.parametrize("distance", [1e-2, 1e-4, 1e-6])
def test_close_reaches_four_bar_poses_near_the_limit(lengths, distance):
    mechanism, limit, _ = four_bar_at_limit(lengths)
    start = mechanism.home
    branch = np.sign(start.jacobian().det_K_star)
    target = limit - distance
    configuration = mechanism.close([target])
    phi = hand.four_bar_closure(target, lengths, branch)
    turns = (configuration.passive - phi) / (2 * np.pi)
    np.testing.assert_allclose(turns, np.round(turns), atol=1e-8)
    jacobian = configuration.jacobian()
    by_hand = np.linalg.solve(
        hand.four_bar_K_star(target, phi, lengths), hand.four_bar_K(target, phi, lengths)
    )
    np.testing.assert_allclose(jacobian.passive_rates, -by_hand, rtol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("distance", [1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 1e-15, 0.0])
def test_close_reaches_the_fold_itself(distance):
    """Whatever rounding makes of the last 1e-10 rad: reached, and singular where it is."""
    rng = np.random.default_rng(13)
    reached = 0
    while reached < 8:
        lengths = rng.uniform(0.5, 4.0, 4)
        try:
            limit, _ = hand.four_bar_crank_limit(tuple(lengths))
            mechanism = four_bar_with(lengths)
        except (ValueError, pj.ClosureError):
            continue
        if mechanism.home.actuated[0] > limit:
            continue
        configuration = mechanism.close([limit - distance], enforce_limits=False)
        assert configuration.residual_norm < 1e-12
        assert configuration.singularity().smallest < 1e-5 + 2 * np.sqrt(distance)
        reached += 1


def test_close_at_the_limit_itself_and_beyond():
    mechanism, limit, values = four_bar_at_limit(STRETCHED)
    configuration = mechanism.close([limit])
    np.testing.assert_allclose(configuration.passive, [values["phi1"], values["phi2"]], atol=1e-6)
    assert configuration.singularity().kind == "gain"
    with pytest.raises(pj.SingularError):
        configuration.jacobian()
    with pytest.raises(pj.ClosureError, match="meets a singularity") as caught:
        mechanism.close([limit + 0.1])
    assert caught.value.reached.actuated[0] == pytest.approx(limit, abs=1e-9)
    assert caught.value.residual_norm > 1e-3
    assert caught.value.q.shape == (3,)


@pytest.mark.parametrize("distance", [0.0, 1e-12, 1e-9])
def test_a_guess_on_a_singularity_gives_no_path(distance):
    mechanism, limit, _ = four_bar_at_limit(STRETCHED)
    start = mechanism.close([limit])
    with pytest.raises(pj.ClosureError, match="singularity"):
        mechanism.close([limit - 0.1 - distance], guess=start)


def test_a_singular_pose_closes_on_itself():
    mechanism, limit, _ = four_bar_at_limit(STRETCHED)
    start = mechanism.close([limit])
    again = mechanism.close([limit], guess=start)
    np.testing.assert_allclose(again.q, start.q, atol=1e-5)


def test_the_rockers_dead_point_is_no_error():
    l0, l1, l2, l3 = mechanisms.CRANK_ROCKER
    # Crank and coupler in one line: the rocker is at the end of its swing.
    reach = l1 + l2
    theta1 = np.arccos((l0**2 + reach**2 - l3**2) / (2 * l0 * reach))
    configuration = loaded("four_bar").close([theta1])
    assert configuration.passive[1] == pytest.approx(0.0, abs=1e-9)
    jacobian = configuration.jacobian()
    assert jacobian.passive_rates[0, 0] == pytest.approx(0.0, abs=1e-9)
    assert configuration.singularity().kind == "regular"


@pytest.fixture(scope="module")
def singular_rps():
    return hand.rps_singular_poses(np.random.default_rng(5), 6)


def test_three_rps_ss_at_singular_poses(singular_rps):
    mechanism = loaded("three_rps_ss")
    for lengths, theta in singular_rps:
        values = dict(zip(mechanism.actuated + mechanism.passive, (*lengths, *theta), strict=True))
        configuration = mechanism.configuration(as_q(mechanism, values))
        with pytest.raises(pj.SingularError) as caught:
            configuration.jacobian()
        free = np.array(list(caught.value.free_motion.values()))
        K_star = hand.rps_K_star(lengths, theta)
        assert np.abs(K_star @ free).max() < 1e-9
        singularity = configuration.singularity()
        whole = np.hstack([hand.rps_K(lengths, theta), K_star])
        meeting = np.linalg.svd(whole)[1][-1] < 1e-6  # the two operation modes meet here
        assert singularity.kind == "configuration space" if meeting else "gain"
        assert singularity.smallest < 1e-9
        assert singularity.condition > 1e6


def test_three_rps_is_singular_where_three_rps_ss_is(singular_rps):
    """The contact-constraint model sees the same singularities, though its K* is 9 × 9."""
    legs, platform = loaded("three_rps_ss"), loaded("three_rps")
    for lengths, theta in singular_rps:
        values = dict(zip(legs.actuated + legs.passive, (*lengths, *theta), strict=True))
        tool = legs.configuration(as_q(legs, values)).tool_pose()
        turn = pin.SE3(
            pin.AngleAxis(-5 * np.pi / 6, np.array([0.0, 0.0, 1.0])).matrix(), np.zeros(3)
        )
        q = pin.neutral(platform.model)
        q[:7] = pin.SE3ToXYZQUAT(tool * turn)
        model = platform.model
        assert model.joints[1].idx_q == 0
        for name, value in values.items():
            q[model.joints[model.getJointId(name)].idx_q] = value
        configuration = platform.configuration(q)
        with pytest.raises(pj.SingularError) as caught:
            configuration.jacobian()
        free = [caught.value.free_motion[name] for name in legs.passive]
        K_star = hand.rps_K_star(lengths, theta)
        np.testing.assert_allclose(K_star @ free, 0.0, atol=1e-8)


def test_three_rps_is_reached_close_to_its_singular_poses():
    mechanism = loaded("three_rps_ss")
    with pytest.raises(pj.ClosureError) as caught:
        mechanism.close(hand.POSE_B_L, guess="lecture_a")
    start, end = mechanism.pose("lecture_a").actuated, caught.value.reached.actuated
    for short in (1e-4, 1e-6):
        direction = (end - start) / np.linalg.norm(end - start)
        near = mechanism.close(end - short * direction, guess="lecture_a")
        assert near.singularity().smallest < 30 * np.sqrt(short)
        assert near.jacobian().J_eq.shape == (6, 3)


def test_loss_of_a_tool_motion_is_told_apart():
    stretched = loaded("serial_2r").close([0.3, 0.0])
    singularity = stretched.singularity()
    # Its tip moves along one line only; as a whole twist the arm keeps both motions.
    assert (singularity.kind, singularity.lost) == ("loss", 1)
    assert stretched.jacobian().velocity_ellipsoid().rank == 1
    whole = pj.load("serial_2r", tool_rows=TWIST_ROWS).close([0.3, 0.0])
    assert (whole.singularity().kind, whole.singularity().lost) == ("regular", 0)
    wrist = loaded("ur5")
    straight = wrist.close([0.3, -1.2, 1.4, -0.9, 0.0, 0.2])
    assert straight.singularity().kind == "loss"
    assert straight.singularity().lost == 1
    assert straight.jacobian().J_eq.shape == (6, 6)


def test_flat_parallelogram_is_a_configuration_space_singularity():
    mechanism = mechanisms.three_crank_parallelogram()
    flat = mechanism.configuration(np.zeros(4))
    singularity = flat.singularity()
    assert singularity.kind == "configuration space"
    with pytest.raises(pj.SingularError):
        flat.jacobian()


@pytest.mark.parametrize("scale", [1e-3, 1e3])
@pytest.mark.parametrize("joint", "ABCD")
def test_verdicts_do_not_depend_on_the_unit_of_length(scale, joint):
    phi = hand.four_bar_closure(1.3, mechanisms.CRANK_ROCKER, 1)
    lengths = scale * np.array(mechanisms.CRANK_ROCKER)
    scaled = mechanisms.four_bar_cut_at(joint, 1.3, phi, lengths.tolist())
    reference = mechanisms.four_bar_cut_at(joint, 1.3, phi)
    np.testing.assert_allclose(
        scaled.home.singularity().singular_values,
        reference.home.singularity().singular_values,
        atol=1e-9,
    )
    assert scaled.mobility == 1
    np.testing.assert_allclose(
        scaled.home.jacobian().passive_rates, reference.home.jacobian().passive_rates, atol=1e-9
    )


def test_a_home_pose_that_is_itself_singular():
    """The generic rank is looked for near home too, so that a singular home is seen as one."""
    regular = mechanisms.three_crank_parallelogram()
    flat = pj.Mechanism.from_pinocchio(
        regular.model, regular.spec.loops, ["theta1"], "point3", home=np.zeros(4)
    )
    assert flat.mobility == regular.mobility == 1
    assert flat.home.singularity().kind == "configuration space"
    mechanism, _, values = four_bar_at_limit(STRETCHED)
    at_limit = pj.Mechanism.from_pinocchio(
        mechanism.model, mechanism.spec.loops, ["theta1"], "coupler_midpoint", home=values
    )
    assert at_limit.mobility == 1
    assert at_limit.home.singularity().kind == "gain"


def test_a_path_through_a_branch_point_stops_there():
    """Beyond the flat pose the parallelogram could fold either way: nothing says which."""
    mechanism = mechanisms.three_crank_parallelogram()
    with pytest.raises(pj.ClosureError, match="meets a singularity") as caught:
        mechanism.close([4.0])
    assert caught.value.reached.actuated[0] == pytest.approx(np.pi, abs=1e-4)
    # The path ends beside the generic size of [K K*], the value is told beside the size here.
    assert caught.value.singular_value < 10.0 * RANK_TOLERANCE


@pytest.mark.parametrize("name", ["four_bar", "three_rps", "delta"])
def test_jacobian_and_singularity_share_one_factorisation_of_K_star(name, monkeypatch):
    home = loaded(name).home
    partition = home.mechanism.problem.partition
    scaled = partition.scaled(home.split_jacobian().constraint_jacobian)
    configuration, looked_at = home.mechanism.configuration(home.q), []

    def counted(matrix, *others):
        looked_at.append(np.array_equal(matrix, scaled[:, partition.passive]))
        return factorise(matrix, *others)

    monkeypatch.setattr("pmjac_pin.rates.partition.factorise", counted)
    configuration.jacobian()
    configuration.singularity()
    configuration.jacobian("LOCAL")
    assert sum(looked_at) == 1
