"""More motors than freedom: close returns, with a pose where the values fit or saying why not."""

from __future__ import annotations

import mechanisms
import numpy as np
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.closing.over_actuation import lead, ties_in_words
from pmjac_pin.kinematics.pinocchio import Kinematics
from pmjac_pin.rates.actuation import analyse_actuation

ENOUGH = 600  # evaluations of the loop equations: a closure takes some tens


@pytest.fixture
def evaluations(monkeypatch):
    """The number of evaluations of the loop equations so far, as a list of one."""
    count, evaluate = [0], Kinematics.evaluate

    def counted(self, q):
        count[0] += 1
        return evaluate(self, q)

    monkeypatch.setattr(Kinematics, "evaluate", counted)
    return count


@pytest.mark.slow
@pytest.mark.parametrize("name", mechanisms.CLOSED)
def test_one_motor_too_many_is_told_soon_and_values_that_fit_close(name, evaluations):
    """With each passive joint of the catalogue as a further motor."""
    mechanism = loaded(name)
    way = np.full(len(mechanism.actuated), 0.01)
    fitting = mechanism.close(mechanism.home.actuated + way, enforce_limits=False)
    for joint in set(mechanism.passive) & set(mechanism.model.names):
        if mechanism.model.joints[mechanism.model.getJointId(joint)].nv > 1:
            continue
        machine = pj.load(name, actuated=[*mechanism.actuated, joint])
        rates_that_the_loops_allow_are_those_of_the_ties(machine)
        evaluations[0] = 0
        try:
            reached = machine.close([*fitting.actuated, machine.home.actuated[-1]])
        except pj.LimitError:
            pass
        except pj.ClosureError as error:
            assert error.reached is not None
            assert error.share < 1.0
            assert error.ties in str(error)
            assert bool(error.ties) == bool(machine.home.singularity().forbidden_rates.size)
        else:
            assert reached.residual_norm <= machine.tolerance
        assert evaluations[0] < ENOUGH
        evaluations[0] = 0
        values = [*fitting.actuated, fitting.joint_values[joint]]
        reached = machine.close(values, enforce_limits=False)
        np.testing.assert_allclose(reached.actuated, values, atol=1e-12)
        assert evaluations[0] < ENOUGH


def rates_that_the_loops_allow_are_those_of_the_ties(machine):
    split = machine.home.split_jacobian()
    matrices = split.constraint_jacobian, split.tool_jacobian
    allowed = analyse_actuation(*matrices, split.partition).allowed
    found = lead(machine.problem, machine.home._point)
    followed = found.ratios @ allowed[found.leading]
    np.testing.assert_allclose(allowed[found.led], followed, atol=1e-8 * np.abs(allowed).max())


def test_the_first_thing_told_is_which_motors_are_tied_and_how():
    machine = mechanisms.with_motors(loaded("four_bar"), ["theta1", "phi2"])
    with pytest.raises(pj.ClosureError) as caught:
        machine.close(machine.home.actuated + np.array([0.3, 0.0]))
    rate = loaded("four_bar").home.jacobian().passive_rates[1, 0]
    tie = f"the rate of 'theta1' is {1.0 / rate:+.3g} that of 'phi2'"
    turned = f"the rate of 'phi2' is {rate:+.3g} that of 'theta1'"
    told = "over-actuated by 1, the loops tie motors to each other: here "
    assert caught.value.ties in (told + tie, told + turned)
    assert str(caught.value).startswith(f"{machine.name}: {caught.value.ties}. The loops forbid")


def test_a_motor_that_the_loops_hold_is_told_to_be_held():
    joints = [
        ("a", "revolute", "ground", "arm", (0, 0, 0), mechanisms.Z),
        ("tip", "fixed", "arm", "end", (1, 0, 0)),
        ("anchor", "fixed", "ground", "pin", (1, 0, 0)),
    ]
    machine = mechanisms.build(joints, [("end", "pin")], ["a"], "end", {})
    with pytest.raises(
        pj.ClosureError, match=r"no motor move: here 'a' cannot move\. The loops forbid"
    ):
        machine.close([0.1])


def test_motors_that_are_free_are_not_called_tied():
    home = loaded("four_bar").home
    assert ties_in_words(home.mechanism.problem, home._point) == ""


def test_it_says_where_the_loops_lead_the_motor_that_does_not_fit():
    machine = pj.load("five_bar", actuated=["theta1", "theta2", "phi1"])
    with pytest.raises(pj.ClosureError) as caught:
        machine.close(machine.home.actuated + np.array([0.01, 0.01, 0.0]))
    message = str(caught.value)
    told = "five_bar: over-actuated by 1, the loops tie motors to each other: here the rate of"
    assert message.startswith(told)
    assert "The loops forbid these motors to move so together: with" in message
    assert "from its target; give values that fit, or make one of them passive" in message
    np.testing.assert_array_equal(caught.value.reached.q, machine.home.q)
    assert caught.value.share == 0.0


def test_a_target_that_no_path_of_so_many_steps_reaches_is_refused_at_once():
    mechanism = loaded("four_bar")
    with pytest.raises(pj.ClosureError, match=r"is too long for the 20000 steps .*; go there by m"):
        mechanism.close([1e9], enforce_limits=False)


def test_values_that_fit_but_on_no_straight_path_of_some_motors_are_told_so():
    """theta1 and phi2 lead, straight, past where the five-bar of two motors goes: theta2 strays."""
    five_bar, machine = (
        loaded("five_bar"),
        pj.load("five_bar", actuated=["theta1", "theta2", "phi2"]),
    )
    far = five_bar.close([0.7683, 1.6913], enforce_limits=False)
    with pytest.raises(pj.ClosureError) as caught:
        machine.close([far.joint_values[name] for name in machine.actuated], enforce_limits=False)
    message = str(caught.value)
    assert "The loops close at these values, but no straight path of the other motors" in message
    assert message.endswith("from its target; go there by motor values in between")


def test_a_path_that_is_too_long_for_one_call_goes_on_from_where_it_ended(monkeypatch):
    monkeypatch.setattr("pmjac_pin.closing.straight_path.MOST_STEPS", 600)
    mechanism = loaded("four_bar")
    target = mechanism.home.actuated + 2 * np.pi * 20
    calls, guess = 0, mechanism.home
    while True:
        calls += 1
        try:
            end = mechanism.close(target, guess=guess, enforce_limits=False)
            break
        except pj.ClosureError as error:
            assert "go on from there, the error's `reached`, as guess" in str(error)
            assert 0.0 < error.share < 1.0
            guess = error.reached
    assert calls > 1
    # A crank-rocker turns all the way round: phi1 comes back.
    assert end.joint_values["phi1"] == pytest.approx(mechanism.home.joint_values["phi1"], abs=1e-9)
