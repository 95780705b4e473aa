"""How far the nearest singularity is: found from above, proven from below, and known by hand."""

from __future__ import annotations

from math import pi

import hand_derived as hand
import hand_planar
import mechanisms
import numpy as np
import pytest
from hand_planar import unit
from mechanisms import loaded, with_motors
from scipy.optimize import minimize

import pmjac_pin as pj

GAINS = ("five_bar", "planar_3rpr", "planar_3rrr", "ankle", "humanoid_ankle", "three_rps_ss")
BALLS = (*GAINS, "bennett", "four_bar", "slider_crank", "stewart_gough", "agile_eye", "delta_rods")


def local_minima(distance, constraint, starts):
    """The distances that are locally least with the constraint zero, of many starts, sorted."""
    found = (
        minimize(
            lambda x: distance(x) @ distance(x),
            x,
            constraints={"type": "eq", "fun": constraint},
            method="SLSQP",
            options={"maxiter": 300, "ftol": 1e-15},
        )
        for x in starts
    )
    good = [one.x for one in found if one.success and abs(constraint(one.x)) < 1e-8]
    return np.sort([np.linalg.norm(distance(x)) for x in good])


def elbows(thetas):
    return 0.3 * unit(thetas[0]), np.array([0.3, 0.0]) + 0.3 * unit(thetas[1])


def test_of_a_five_bar_the_elbows_are_as_far_apart_as_both_distal_links_are_long(rng):
    home = loaded("five_bar").home
    nearest = pj.nearest_singularity(home, kind="gain", rng=0)
    theta = home.actuated
    starts = theta + rng.uniform(-1.5, 1.5, (12, 2))
    by_hand = local_minima(
        lambda x: x - theta, lambda x: np.linalg.norm(np.subtract(*elbows(x))) - 0.8, starts
    )[0]
    assert nearest.straight
    assert nearest.distance == pytest.approx(by_hand, abs=1e-7)
    assert np.linalg.norm([*nearest.motor_change.values()]) == pytest.approx(nearest.distance)
    assert nearest.configuration.singularity().types.gosselin_angeles == "II"


def test_of_a_five_bar_an_arm_is_stretched_or_folded(rng):
    """The tip 0.7 or 0.1 from a motor, along its link, and as far from the other elbow as ever."""
    home = loaded("five_bar").home
    nearest = pj.nearest_singularity(home, kind="loss", rng=0)
    theta, by_hand = home.actuated, []
    for arm, reach in ((0, 0.7), (0, -0.1), (1, 0.7), (1, -0.1)):

        def gap(x, arm=arm, reach=reach):
            tip = np.array([0.3 * arm, 0.0]) + reach * unit(x[arm])
            return np.linalg.norm(tip - elbows(x)[1 - arm]) - 0.4

        begun = theta + rng.uniform(-1.5, 1.5, (12, 2))
        by_hand += [*local_minima(lambda x: x - theta, gap, begun)]
    assert nearest.distance >= min(by_hand) - 1e-7
    assert np.abs(np.array(by_hand) - nearest.distance).min() < 1e-6
    assert nearest.straight
    assert nearest.configuration.singularity().types.gosselin_angeles == "I"


def test_of_a_2r_arm_the_elbow_is_stretched_or_folded():
    for elbow in (0.9, -1.3, 2.4):
        nearest = pj.nearest_singularity(loaded("serial_2r").close([0.3, elbow]), rng=0)
        assert (nearest.freed, nearest.straight) == ("loss", True)
        assert nearest.distance == pytest.approx(min(abs(elbow), pi - abs(elbow)), abs=1e-9)


def test_of_a_slider_crank_driven_by_its_piston_it_is_a_dead_centre():
    home = with_motors(loaded("slider_crank"), ["x"]).home
    nearest = pj.nearest_singularity(home, kind="gain", rng=0)
    x = home.actuated[0]
    assert (nearest.unit, nearest.straight) == ("m", True)
    assert nearest.distance == pytest.approx(min(1.2 - x, x - 0.6), abs=1e-9)
    assert 0.0 < pj.singularity_free(home).radius < nearest.distance


def test_of_a_four_bar_it_is_the_end_of_the_cranks_range():
    lengths = (4.0, 3.0, 2.5, 2.0)
    machine = pj.load("four_bar", dict(zip(("l0", "l1", "l2", "l3"), lengths, strict=True)))
    limit, _ = hand.four_bar_crank_limit(lengths)
    home = machine.home
    nearest = pj.nearest_singularity(home, rng=0)
    assert nearest.freed == "gain"
    assert nearest.distance == pytest.approx(limit - home.actuated[0], abs=1e-9)
    assert 0.0 < pj.singularity_free(home).radius < nearest.distance


@pytest.mark.slow
def test_of_a_3rpr_the_legs_lines_meet(rng):
    """Over the plates' poses: the determinant of the lines' moments."""
    machine = loaded("planar_3rpr")
    size, home = machine.parameters, machine.home

    def lengths_and_lines(pose):
        rows, lengths = hand_planar.inverse_3rpr(pose, size["a"], size["b"])
        return lengths, np.linalg.det(rows)

    x, y, turn = home.joint_values["platform"]
    pose = np.array([x, y, turn])
    np.testing.assert_allclose(lengths_and_lines(pose)[0], home.actuated, atol=1e-9)
    starts = pose + rng.uniform(-1.0, 1.0, (16, 3)) * [0.2, 0.2, 2.0]
    by_hand = local_minima(
        lambda p: lengths_and_lines(p)[0] - home.actuated, lambda p: lengths_and_lines(p)[1], starts
    )[0]
    nearest = pj.nearest_singularity(home, kind="gain", rng=0)
    assert nearest.unit == "m"
    assert nearest.distance == pytest.approx(by_hand, abs=1e-6)


@pytest.mark.parametrize("space", ["motors", "joints"])
@pytest.mark.parametrize("name", mechanisms.mostly_slow(GAINS, ("five_bar",)))
def test_what_is_found_is_closed_singular_and_stationary(name, space):
    for here in mechanisms.random_poses(name, 4, 2):
        nearest = pj.nearest_singularity(here, kind="gain", space=space, starts=3, rng=0)
        found = nearest.configuration.singularity()
        assert found.gained > 0
        assert found.smallest < 1e-10
        assert nearest.evidence.kind == "tolerance"
        motors = np.array([*nearest.motor_change.values()])
        np.testing.assert_allclose(
            here.actuated + motors, nearest.configuration.actuated, atol=1e-9
        )
        if space == "motors":
            assert np.linalg.norm(motors) == pytest.approx(nearest.distance, rel=1e-9)


@pytest.mark.parametrize("name", mechanisms.mostly_slow(GAINS, ("five_bar",)))
def test_no_singularity_is_met_nearer_on_straight_ways(name, rng):
    home = loaded(name).home
    nearest = pj.nearest_singularity(home, kind="gain", rng=0)
    assert nearest.straight
    for way in rng.normal(size=(12, home.actuated.size)):
        target = home.actuated + 0.95 * nearest.distance * way / np.linalg.norm(way)
        there = home.mechanism.close(target, guess=home, enforce_limits=False)
        assert there.singularity().kind in {"regular", "loss"}


@pytest.mark.parametrize("name", BALLS)
def test_within_what_is_proven_loops_close_and_k_star_is_regular(name, rng):
    home = loaded(name).home
    proven = pj.singularity_free(home)
    assert proven
    assert proven.evidence.kind == "proof"
    partition = home.mechanism.problem.partition
    for _ in range(5):
        motors = home.actuated + proven.radius * rng.choice([-1.0, 1.0], home.actuated.size)
        there = home.mechanism.close(motors, guess=home, enforce_limits=False)
        assert there.singularity().rank == partition.passive_rank
        scale = np.where(
            [u == "m" for u in partition.units_of(partition.passive)], partition.length, 1
        )
        assert (np.abs(there.passive - home.passive) <= scale * proven.passive_radius).all()


@pytest.mark.parametrize("name", mechanisms.mostly_slow(GAINS, ("five_bar", "three_rps_ss")))
def test_what_is_proven_is_less_than_what_is_found(name):
    home = loaded(name).home
    proven, nearest = (
        pj.singularity_free(home),
        pj.nearest_singularity(home, kind="gain", starts=2, rng=0),
    )
    assert proven.unit == nearest.unit
    assert 0.0 < proven.radius <= max(map(abs, nearest.motor_change.values()))


@pytest.mark.parametrize(
    ("name", "cells"),
    [
        pytest.param("five_bar", 100, marks=pytest.mark.slow),
        ("four_bar", 50),
        pytest.param("five_bar", 1000, marks=pytest.mark.slow),
        pytest.param("ankle", 200, marks=pytest.mark.slow),
        pytest.param("planar_3rrr", 200, marks=pytest.mark.slow),
        pytest.param("planar_3rpr", 200, marks=pytest.mark.slow),
    ],
)
def test_with_many_cells_more_is_proven_and_it_holds_all_over_the_box(name, cells, rng):
    home = loaded(name).home
    one, many = pj.singularity_free(home), pj.singularity_free(home, most_cells=cells)
    assert many.radius > 1.4 * one.radius
    assert one.cells == 1 < many.cells <= cells
    if nearest := pj.nearest_singularity(home, kind="gain", starts=3, rng=0):
        assert many.radius < max(map(abs, nearest.motor_change.values()))
    partition = home.mechanism.problem.partition
    slides = np.array([unit == "m" for unit in partition.units_of(partition.passive)])
    scale = np.where(slides, partition.length, 1.0)
    for _ in range(20):
        way = rng.uniform(-1.0, 1.0, home.actuated.size)
        motors = home.actuated + many.radius * way / np.abs(way).max()
        there = home.mechanism.close(motors, guess=home, enforce_limits=False)
        assert there.singularity().rank == partition.passive_rank
        assert (np.abs(there.passive - home.passive) <= scale * many.passive_radius).all()


def test_of_a_five_bar_nearly_all_is_proven_up_to_where_the_distal_links_are_in_line():
    """The nearest singular pose has both motors moved by 0.368: nothing beyond may be proven."""
    home = loaded("five_bar").home
    corner = next(
        d
        for d in np.linspace(0.0, 1.0, 10_001)
        if np.linalg.norm(np.subtract(*elbows(home.actuated + d * np.array([1, -1])))) >= 0.8
    )
    assert 0.3 * corner < pj.singularity_free(home, most_cells=60).radius < corner


def test_beside_a_singularity_little_is_proven_and_at_it_nothing():
    limit, _ = hand.four_bar_crank_limit((4.0, 3.0, 2.5, 2.0))
    sizes = dict(zip(("l0", "l1", "l2", "l3"), (4.0, 3.0, 2.5, 2.0), strict=True))
    machine = pj.load("four_bar", sizes)
    radii = [pj.singularity_free(machine.close([limit - d])).radius for d in (1e-1, 1e-3, 1e-5)]
    assert all(0.0 < r < d for r, d in zip(radii, (1e-1, 1e-3, 1e-5), strict=True))
    at = pj.nearest_singularity(machine.home, rng=0).configuration
    nothing = pj.singularity_free(at)
    assert not nothing
    assert nothing.evidence.kind == "nothing"


def test_what_weighs_more_is_moved_less():
    """A five-bar's elbows come apart by one motor more than by the other; joints have names too."""
    home = loaded("five_bar").home
    even = pj.nearest_singularity(home, kind="gain", rng=0)
    heavy = pj.nearest_singularity(home, kind="gain", weights={"theta1": 5.0}, rng=0)
    first, second = heavy.motor_change.values()
    assert abs(first) < abs(even.motor_change["theta1"]) < abs(second)
    assert heavy.distance == pytest.approx(np.hypot(5.0 * first, second), abs=1e-9)
    assert even.distance < heavy.distance < 5.0 * even.distance
    with pytest.raises(pj.UnknownNameError, match="unknown motor 'thet1'; did you mean 'theta1'"):
        pj.nearest_singularity(home, weights={"thet1": 1.0}, rng=0)
    with pytest.raises(pj.UnknownNameError, match="unknown motor 'phi1'"):
        pj.nearest_singularity(home, weights={"phi1": 1.0}, rng=0)
    assert pj.nearest_singularity(home, kind="gain", space="joints", weights={"phi1": 2.0}, rng=0)


def test_an_arm_without_loops_is_free_of_them():
    assert pj.singularity_free(loaded("ur5").home).radius == np.inf


def test_none_is_found_where_there_is_none():
    none = pj.nearest_singularity(loaded("bennett").home, kind="gain", starts=2, rng=0)
    assert not none
    assert (none.configuration, none.distance, none.straight) == (None, np.inf, False)
    assert none.evidence.kind == "nothing"


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"space": "tool"}, "space is motors or joints"),
        ({"kind": "III"}, "kind is gain or loss"),
        ({"starts": -1}, "starts is a whole number"),
        ({"rng": "seed"}, "rng is"),
        ({"weights": {"theta1": 0.0}}, "the weight of theta1 is positive"),
    ],
)
def test_what_is_no_question_is_refused(asked, message):
    with pytest.raises(pj.ArgumentError, match=message):
        pj.nearest_singularity(loaded("five_bar").home, **asked)


@pytest.mark.parametrize("cells", [0, -3, 1.5, "many"])
def test_a_number_of_cells_is_a_whole_number(cells):
    with pytest.raises(pj.ArgumentError, match="most_cells is a whole number"):
        pj.singularity_free(loaded("five_bar").home, most_cells=cells)
    with pytest.raises(pj.ArgumentError):
        pj.singularity_free(loaded("five_bar"))


LOSSES = ("five_bar", "serial_2r", "ur5", "slider_crank", "humanoid_ankle", "planar_3rrr", "delta")


def motions_of_all(pose):
    """The smallest singular value of [K K*] above the judged rows of the tool, per unit rates."""
    partition = pose.mechanism.problem.partition
    split = pose.split_jacobian(partition.tool_rows.axes)
    rows = partition.tool_rows.linear + partition.tool_rows.angular
    matrix = np.vstack([split.constraint_jacobian, split.tool_jacobian[rows]])
    values = np.linalg.svd(matrix, compute_uv=False)
    return values[partition.constraint_rank + partition.tool_rank - 1]


@pytest.mark.parametrize("name", mechanisms.mostly_slow(LOSSES, ("five_bar", "ur5")))
def test_within_what_is_proven_the_tool_loses_nothing(name, rng):
    home = loaded(name).home
    proven, gains = (pj.singularity_free(home, kind=kind) for kind in ("loss", "gain"))
    assert proven
    assert 0.0 < proven.radius <= gains.radius
    assert proven.evidence.kind == "proof"
    assert f"moves in {home.mechanism.problem.partition.tool_rank} ways" in str(proven.evidence)
    nearest = pj.nearest_singularity(home, kind="loss", starts=2, rng=0)
    if nearest:
        assert proven.radius < max(map(abs, nearest.motor_change.values()))
    least = motions_of_all(home)
    for _ in range(20):
        way = rng.uniform(-1.0, 1.0, home.actuated.size)
        motors = home.actuated + proven.radius * way / np.abs(way).max()
        there = home.mechanism.close(motors, guess=home, enforce_limits=False)
        assert there.singularity().kind == "regular"
        assert motions_of_all(there) > 0.2 * least


def test_of_an_arm_the_loss_where_its_elbow_is_stretched_bounds_the_proof():
    """Nothing may be proven beyond: θ₂ is 0 there."""
    arm = loaded("serial_2r")
    for elbow in (1.0, 0.1, 0.01):
        proven = pj.singularity_free(arm.close([0.5, elbow]), kind="loss")
        assert 0.0 < proven.radius < elbow
    assert not pj.singularity_free(arm.close([0.5, 0.0]), kind="loss")


def test_losses_are_proven_by_cells_too():
    home = loaded("five_bar").home
    one, many = (pj.singularity_free(home, kind="loss", most_cells=n) for n in (1, 40))
    assert many.radius > 1.4 * one.radius
    with pytest.raises(pj.ArgumentError, match="kind is gain or loss, got 'both'"):
        pj.singularity_free(home, kind="both")
    assert (
        "three points span" in pj.singularity_free(loaded("three_rps_ss").home, kind="loss").failed
    )


ORDERS = [("five_bar", "gain"), ("slider_crank", "loss"), ("serial_2r", "loss"), ("ankle", "gain")]
ORDERS += [("bennett", "gain"), ("planar_3rrr", "loss"), ("ur5", "loss"), ("delta_rods", "loss")]
ORDERS += [("head_6rss", "gain"), ("agile_eye", "loss"), ("stewart_gough", "gain")]


@pytest.mark.parametrize(("name", "kind"), mechanisms.mostly_slow(ORDERS, ORDERS[:3]))
def test_along_polynomials_more_is_proven_and_it_holds(name, kind, rng):
    """Nothing in it is singular, and all poses are as near as is said; ranks and signs are kept."""
    home = loaded(name).home
    one, two = (pj.singularity_free(home, kind=kind, order=order) for order in (1, 2))
    assert two.evidence.kind == "proof"
    assert two.radius > 1.3 * one.radius
    nearest = pj.nearest_singularity(home, kind=kind, starts=3, rng=0)
    if nearest:
        assert two.radius < max(map(abs, nearest.motor_change.values()))
    partition = home.mechanism.problem.partition
    slides = np.array([unit == "m" for unit in partition.units_of(partition.passive)])
    scale = np.where(slides, partition.length, 1.0)
    least = motions_of_all(home)
    for _ in range(40):
        way = rng.uniform(-1.0, 1.0, home.actuated.size)
        motors = home.actuated + two.radius * way / np.abs(way).max()
        there = home.mechanism.close(motors, guess=home, enforce_limits=False)
        assert there.singularity().kind in {"regular", *({"loss"} if kind == "gain" else set())}
        assert kind == "gain" or motions_of_all(there) > 0.01 * least
        moved = np.abs(there.passive - home.passive) / scale
        assert moved.max(initial=0.0) <= two.passive_radius


def test_an_order_is_one_or_two():
    with pytest.raises(pj.ArgumentError, match="order is 1 or 2, got 3"):
        pj.singularity_free(loaded("five_bar").home, order=3)


@pytest.mark.parametrize("number", [2, 3])
def test_what_motors_meet_stands_before_what_is_nearer_on_another_mode(number):
    """Arm 2 is folded 0.02 or 0.19 rad away with the tip on the other side of the elbows."""
    here = mechanisms.random_poses("five_bar", 4, 6)[number]
    gain, loss = (pj.nearest_singularity(here, kind=kind, starts=0) for kind in ("gain", "loss"))
    assert (gain.straight, loss.straight) == (True, False)
    assert loss.distance < gain.distance
    either = pj.nearest_singularity(here, starts=0)
    assert (either.freed, either.straight) == ("gain", True)
    assert either.distance == pytest.approx(gain.distance, rel=1e-9)

    def side(pose):
        """The sign of the area from elbow to elbow to tip: the assembly mode."""
        at = pose.joint_values
        one, other = (
            np.array([x, 0.0]) + 0.3 * unit(at[name])
            for x, name in ((0, "theta1"), (0.3, "theta2"))
        )
        tip = pose.tool_pose().translation[:2]
        return np.sign(np.linalg.det([other - one, tip - one]))

    assert side(
        either.configuration.mechanism.close(
            here.actuated + 0.9 * np.array([*either.motor_change.values()]), guess=here
        )
    ) == side(here)
    assert side(loss.configuration) == -side(here)


def test_of_a_gain_and_a_loss_that_are_as_far_the_gain_is_named():
    """Where the Agile Eye's motors are a quarter turn away, it is singular by both."""
    home = loaded("agile_eye").home
    gain, loss = (pj.nearest_singularity(home, kind=kind, rng=0) for kind in ("gain", "loss"))
    assert gain.distance == pytest.approx(loss.distance, rel=1e-9) == np.pi / 2
    assert pj.nearest_singularity(home, rng=0).freed == "gain"
