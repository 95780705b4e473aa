"""Direct kinematics: it closes, it stays on its mode, and says why when it cannot."""

from __future__ import annotations

import hand_derived as hand
import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded

import pmjac_pin as pj


def follow_by_hand(start, theta, target, steps=1000):
    """Tiny Newton steps with the closed formulas; None where det K* changes sign."""
    sign = np.sign(np.linalg.det(hand.rps_K_star(start, theta)))
    for share in np.linspace(0, 1, steps + 1)[1:]:
        lengths = start + share * (target - start)
        for _ in range(3):
            step = np.linalg.solve(
                hand.rps_K_star(lengths, theta), hand.rps_residual(lengths, theta, 0.5)
            )
            theta = theta - step
        if np.sign(np.linalg.det(hand.rps_K_star(lengths, theta))) != sign:
            return None
        if np.abs(hand.rps_residual(lengths, theta, 0.5)).max() > 1e-10:
            return None
    return theta


@pytest.mark.slow
@pytest.mark.parametrize("start", ["home", "lecture_a", "lecture_b"])
def test_it_never_jumps_to_another_mode(start, rng):
    mechanism = loaded("three_rps_ss")
    pose = mechanism.pose(start)
    outcomes = {"closed": 0, "stopped": 0}
    for _ in range(25):
        target = rng.uniform(0.3, 2.0, 3)
        expected = follow_by_hand(pose.actuated, pose.passive, target)
        try:
            configuration = mechanism.close(target, guess=pose)
        except pj.ClosureError as error:
            assert expected is None
            assert error.reached.residual_norm < 1e-12
            outcomes["stopped"] += 1
        else:
            np.testing.assert_allclose(configuration.passive, expected, atol=1e-9)
            outcomes["closed"] += 1
    assert min(outcomes.values()) > 3


def in_short_steps(start, target, steps=250):
    """Close one short step after the other; where that ends, and at which share of the path."""
    mechanism, begin, pose = start.mechanism, start.actuated, start
    for step in range(1, steps + 1):
        theta = begin + step / steps * (target - begin)
        try:
            pose = mechanism.close(theta, guess=pose, enforce_limits=False)
        except pj.ClosureError as error:
            return error.reached, (step - 1 + error.share) / steps
    return pose, 1.0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["rocker_rocker", "five_bar", "planar_3rrr", "three_rps"])
def test_long_steps_end_where_short_ones_do(name, rng):
    """Beside singularities, too, and beyond the limits: at the target or at the same fold."""
    mechanism = mechanisms.rocker_rocker() if name == "rocker_rocker" else loaded(name)
    start, outcomes = mechanism.home, {"closed": 0, "stopped": 0}
    for _ in range(25):
        target = start.actuated + rng.uniform(-1.5, 1.5, len(mechanism.actuated))
        expected, share = in_short_steps(start, target)
        try:
            reached = mechanism.close(target, guess=start, enforce_limits=False)
        except pj.ClosureError as error:
            assert error.share == pytest.approx(share, abs=1e-5)
            reached = error.reached
            outcomes["stopped"] += 1
        else:
            assert share == 1.0
            outcomes["closed"] += 1
            start = reached
        apart = pin.difference(mechanism.model, reached.q, expected.q)
        np.testing.assert_allclose(apart, 0.0, atol=1e-9 if share == 1.0 else 1e-3)
    assert min(outcomes.values()) > 1


@pytest.mark.slow
def test_a_path_along_a_singularity_takes_long_steps():
    """The plate stays near the base's plane, σ at 4e-4; what changes is not what is weak."""
    mechanism = loaded("delta")
    target = mechanism.home.actuated + np.array([2.07, 4.93, 1.98])
    assert mechanism.close(target, enforce_limits=False).iterations < 6000


def test_the_lectures_poses_are_not_joined_by_a_straight_path():
    """The path from A's printed mode ends at a fold just before B; large Newton steps jump it."""
    mechanism = loaded("three_rps_ss")
    with pytest.raises(pj.ClosureError, match="on another assembly mode") as caught:
        mechanism.close(hand.POSE_B_L, guess="lecture_a")
    assert caught.value.share == pytest.approx(0.9893, abs=1e-4)
    assert caught.value.residual_norm < 1e-12
    with pytest.raises(pj.ClosureError) as caught:
        mechanism.close(hand.POSE_B_L)
    assert caught.value.share == pytest.approx(0.286, abs=1e-3)


def test_the_symmetric_mode_of_pose_a():
    configuration = loaded("three_rps").close(hand.POSE_A_L)
    np.testing.assert_allclose(configuration.passive[:3], hand.POSE_A_MODES[1], atol=1e-8)


def test_steps_are_those_of_a_path_not_of_a_search():
    """There and back again, by many small closures or by one, gives the same pose."""
    mechanism = loaded("three_rps")
    target = np.array([0.9, 1.1, 1.2])
    at_once = mechanism.close(target)
    in_steps = mechanism.home
    for share in np.linspace(0, 1, 40)[1:]:
        in_steps = mechanism.close(1 + share * (target - 1), guess=in_steps)
    np.testing.assert_allclose(at_once.q, in_steps.q, atol=1e-11)
    back = mechanism.close([1, 1, 1], guess=at_once)
    np.testing.assert_allclose(back.q, mechanism.home.q, atol=1e-11)


def test_it_says_iterations_and_residual():
    configuration = loaded("three_rps").close([1.0, 1.03, 1.0])
    assert 1 <= configuration.iterations <= 6
    assert configuration.residual_norm < 1e-12
    assert configuration.residual_norm == pytest.approx(
        np.linalg.norm(configuration.residual), abs=1e-15
    )
    assert configuration.residual.shape == (9,)


@pytest.mark.parametrize(
    "guess",
    ["home", {"theta1": 0.9, "phi1": 2.0, "phi2": 0.1}, {"phi1": 2.0, "phi2": 0.1}, {}],
)
def test_guesses(guess):
    configuration = loaded("four_bar").close([1.0], guess=guess)
    np.testing.assert_allclose(
        configuration.passive, hand.four_bar_closure(1.0, mechanisms.CRANK_ROCKER, 1), atol=1e-12
    )


def test_the_other_mode_by_its_guess():
    phi = hand.four_bar_closure(1.0, mechanisms.CRANK_ROCKER, -1)
    guess = {"phi1": phi[0] + 0.1, "phi2": phi[1] - 0.1}
    configuration = loaded("four_bar").close([1.0], guess=guess)
    np.testing.assert_allclose(configuration.passive, phi, atol=1e-12)


def endless_four_bar():
    joints = [
        ("theta1", "continuous", "ground", "crank", (0, 0, 0), (0, 0, 1)),
        ("phi2", "continuous", "crank", "coupler", (1.0, 0, 0), (0, 0, 1)),
        ("phi1", "continuous", "ground", "rocker", (4.0, 0, 0), (0, 0, 1)),
        ("ce", "fixed", "coupler", "C1", (3.0, 0, 0)),
        ("re", "fixed", "rocker", "C2", (3.5, 0, 0)),
    ]
    home = {"theta1": 3.0, "phi1": 2.0, "phi2": -2.0}
    return mechanisms.build(joints, [("C1", "C2")], ["theta1"], "coupler", home)


def test_an_endless_joint_goes_the_shorter_way():
    mechanism = endless_four_bar()
    assert (mechanism.nq, mechanism.nv) == (6, 3)
    start = mechanism.close([3.0])
    beyond = mechanism.close([3.3], guess=start)
    assert beyond.actuated[0] == pytest.approx(3.3 - 2 * np.pi, abs=1e-12)
    assert beyond.iterations <= 16
    around = mechanism.close([3.3 + 4 * np.pi], guess=beyond)
    np.testing.assert_allclose(around.q, beyond.q, atol=1e-12)


@pytest.mark.parametrize("turned", [1e4, 1e6])
def test_after_many_turns_a_motor_may_stay_where_it_is(turned, rng):
    """Of such values differences have few digits, and what these leave over is no way to go."""
    mechanism = endless_four_bar()
    for value in rng.uniform(-turned, turned, 30):
        pose = mechanism.close([value])
        np.testing.assert_allclose(np.exp(1j * pose.actuated), np.exp(1j * value), atol=1e-14)
        again = mechanism.close([value], guess=pose)
        np.testing.assert_allclose(again.q, pose.q, atol=1e-12)
        found = pj.batch(mechanism).close([[value]], guess=pose)
        assert found.status[0] == pj.Status.CLOSED


@pytest.mark.parametrize(
    ("actuated", "message"),
    [
        ([1.0, 2.0], "3 motor values (l1, l2, l3) expected, got 2"),
        ([[1.0, 1.0, 1.0]], "3 motor values (l1, l2, l3) expected, got shape (1, 3)"),
        (["a", "b", "c"], "motor values must be real numbers, got ['a', 'b', 'c']"),
        ("home", "motor values must be real numbers, got 'home'"),
        ([1.0, np.nan, 1.0], "motor values must be finite, got [1.0, nan, 1.0]"),
        ([1.0, None, 1.0], "motor values must be real numbers, got [1.0, None, 1.0]"),
        ([1.0, 1j, 1.0], "motor values must be real numbers, got [1.0, 1j, 1.0]"),
        ([True, True, False], "motor values must be real numbers, got [True, True, False]"),
        ([[1.0], [1.0, 2.0]], "motor values must be real numbers, got [[1.0], [1.0, 2.0]]"),
    ],
)
def test_bad_motor_values(actuated, message):
    with pytest.raises(pj.ArgumentError) as caught:
        loaded("three_rps").close(actuated)
    assert str(caught.value) == message


def test_limits():
    mechanism = loaded("three_rps")
    with pytest.raises(pj.LimitError) as caught:
        mechanism.close([1.0, 0.05, 1.0])
    assert str(caught.value) == (
        "motor 'l2' = 0.05 m is outside its limits [0.1, 3] m; "
        "enforce_limits=False turns this check off"
    )
    error = caught.value
    assert (error.joint, error.value, error.lower, error.upper) == ("l2", 0.05, 0.1, 3.0)
    beyond = pj.load("three_rps", parameters={"a": 3.0, "b": 3.0}).close(
        [3.5, 3.5, 3.5], enforce_limits=False
    )
    np.testing.assert_allclose(beyond.actuated, 3.5)


@pytest.mark.parametrize(
    ("guess", "kind", "message"),
    [
        ("lecture_c", pj.UnknownNameError, "unknown pose 'lecture_c'; did you mean"),
        ({"theta9": 1.0}, pj.UnknownNameError, "unknown joint 'theta9'; did you mean"),
        ({"theta1": "x"}, pj.ArgumentError, "the value of joint 'theta1' must be real numbers"),
        (3, pj.ArgumentError, "guess must be the name of a pose, a Configuration or a mapping"),
        (None, pj.ArgumentError, "guess must be the name of a pose, a Configuration or a mapping"),
    ],
)
def test_bad_guesses(guess, kind, message):
    with pytest.raises(kind) as caught:
        loaded("three_rps").close([1, 1, 1], guess=guess)
    assert str(caught.value).startswith(message)


def test_a_guess_from_another_mechanism():
    with pytest.raises(pj.ArgumentError, match="is a pose of 'four_bar', not of 'three_rps'"):
        loaded("three_rps").close([1, 1, 1], guess=loaded("four_bar").home)


def test_out_of_reach():
    mechanism = pj.load("four_bar", parameters={"l0": 7.0})
    with pytest.raises(pj.ClosureError, match="out of reach") as caught:
        mechanism.close([np.pi])
    # Stretched out, coupler and rocker are 8 − 6.5 m short.
    assert caught.value.residual_norm == pytest.approx(1.5, abs=1e-6)
    assert caught.value.reached.residual_norm <= mechanism.tolerance


def test_an_open_q_is_refused():
    mechanism = loaded("four_bar")
    q = mechanism.home.q + 1e-3
    with pytest.raises(pj.ClosureError, match="are open by") as caught:
        mechanism.configuration(q)
    assert 1e-4 < caught.value.residual_norm < 1e-2


def test_errors_survive_pickling():
    import pickle

    with pytest.raises(pj.ClosureError) as caught:
        loaded("three_rps_ss").close(hand.POSE_B_L)
    error = pickle.loads(pickle.dumps(caught.value))
    assert str(error) == str(caught.value)
    assert error.share == caught.value.share
    np.testing.assert_array_equal(error.reached.q, caught.value.reached.q)


def test_it_does_not_change_branch_where_branches_cross():
    """The kite and the parallelogram of equal opposite sides meet when all bars are in one line.

    Past the flat pose, the sign of det K* is kept by changing the branch: no reason to do so.
    """
    lengths = dict(zip(("l0", "l1", "l2", "l3"), (1.0, 2.0, 1.0, 2.0), strict=True))
    mechanism = pj.load("four_bar", parameters=lengths)
    for theta1 in (2.7, 2.9):
        for branch in (1, -1):
            phi = hand.four_bar_closure(theta1, tuple(lengths.values()), branch)
            start = mechanism.close([theta1], guess={"phi1": phi[0], "phi2": phi[1]})
            with pytest.raises(pj.ClosureError, match="meets a singularity") as caught:
                mechanism.close([theta1 + 1.5], guess=start)
            assert caught.value.reached.actuated[0] == pytest.approx(np.pi, abs=1e-4)


@pytest.mark.parametrize("name", ["three_rps", "three_rps_ss"])
def test_operation_modes_are_not_changed_in_passing(name):
    """A path through a pose where the 3-RPS's two operation modes meet stops there."""
    start = [1.7726105440804094, 0.8605549706046565, 1.1859230524887547]
    theta = [-0.8173586751759838, -1.3630438010446992, -0.40704419190327223]
    target = [1.5204306972966755, 2.1370696635997426, 2.616488539783912]
    mechanism = loaded("three_rps_ss")
    values = dict(zip(mechanism.actuated + mechanism.passive, (*start, *theta), strict=True))
    pose = mechanism.close(start, guess=values)
    if name == "three_rps":
        turn = pin.SE3(pin.AngleAxis(-5 * np.pi / 6, np.array([0.0, 0, 1])).matrix(), np.zeros(3))
        values["platform"] = pin.SE3ToXYZQUAT(pose.tool_pose() * turn)
        mechanism = loaded("three_rps")
        pose = mechanism.close(start, guess=values)
    with pytest.raises(pj.ClosureError, match="meets a singularity") as caught:
        mechanism.close(target, guess=pose)
    assert caught.value.share == pytest.approx(0.8338, abs=1e-3)
