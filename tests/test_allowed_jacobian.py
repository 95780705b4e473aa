"""J_eq where motors are tied to each other: on the rates that the loops allow."""

from __future__ import annotations

import mechanisms
import numpy as np
import pytest

import pmjac_pin as pj


def single(mechanism):
    """The passive joints of one degree of freedom."""
    model = mechanism.model
    joints = [joint for joint in mechanism.passive if joint in set(model.names)]
    return [joint for joint in joints if model.joints[model.getJointId(joint)].nv == 1]


ALL = pytest.param(slice(None), marks=pytest.mark.slow, id="all joints")


@pytest.mark.parametrize("name", mechanisms.CLOSED)
@pytest.mark.parametrize("joints", [pytest.param(slice(None, None, 12), id="some joints"), ALL])
def test_rates_that_fit_move_the_tool_as_those_of_the_motors_that_suffice(name, joints, rng):
    """θ̇ of the machine's own motors, and the rate at which a passive joint as one more follows."""
    mechanism = pj.load(name)
    for joint in single(mechanism)[joints]:
        machine = pj.load(name, actuated=[*mechanism.actuated, joint])
        jacobian = mechanism.home.jacobian()
        follows = jacobian.motion_map[mechanism.problem.partition.columns[joint]]
        found = machine.configuration(mechanism.home.q).allowed_jacobian()
        its_motions_keep_the_loops_closed(found, machine)
        if len(found.leading) == len(machine.actuated):  # an idle joint: a freedom of its own
            np.testing.assert_array_equal(found.motor_rates, np.eye(len(machine.actuated)))
            continue
        assert len(found.leading) == len(mechanism.actuated)
        rates = rng.normal(size=len(mechanism.actuated))
        given = np.array([*rates, follows @ rates])
        wanted = jacobian.J_eq @ rates
        size = np.abs(jacobian.J_eq).max() * np.abs(given).max()
        np.testing.assert_allclose(found.twist(given), wanted, rtol=0, atol=1e-9 * size)
        with pytest.raises(
            pj.ForbiddenRatesError, match=r"allowed_jacobian\(\) for the rates that"
        ):
            machine.home.jacobian()


def its_motions_keep_the_loops_closed(found, machine):
    size = np.abs(found.constraint_jacobian).max() * np.abs(found.motion_map).max()
    left = found.constraint_jacobian @ found.motion_map
    np.testing.assert_allclose(left, 0.0, atol=1e-9 * size)
    moved = found.tool_jacobian @ found.motion_map
    np.testing.assert_allclose(moved, found.J_eq, rtol=0, atol=1e-9 * np.abs(moved).max())
    leading = [machine.actuated.index(one) for one in found.leading]
    np.testing.assert_allclose(found.motor_rates[leading], np.eye(len(leading)), atol=1e-12)


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_where_no_motor_is_tied_it_is_the_equivalent_jacobian(name):
    home = pj.load(name).home
    for frame in ("LOCAL", "WORLD", "LOCAL_WORLD_ALIGNED"):
        found, wanted = home.allowed_jacobian(frame), home.jacobian(frame)
        order = [home.mechanism.actuated.index(one) for one in found.leading]
        expected = wanted.J_eq[:, order]
        np.testing.assert_allclose(found.J_eq, expected, atol=1e-10 * np.abs(expected).max())


def test_another_tool():
    home = pj.load("five_bar", actuated=["theta1", "theta2", "phi1"]).home
    given = home.allowed_jacobian(tool="ground").J_eq
    np.testing.assert_allclose(given, 0.0, atol=1e-12)


def test_rates_that_do_not_fit_are_refused_and_those_that_would_are_told():
    found = pj.load("four_bar", actuated=["theta1", "phi1"]).home.allowed_jacobian()
    with pytest.raises(
        pj.ForbiddenRatesError, match="those that theta1 lead to are theta1 1, phi1"
    ):
        found.twist([1.0, 1.0])
    with pytest.raises(pj.ArgumentError, match="2 motor rates are needed"):
        found.twist([1.0])


def test_a_structure_allows_none():
    joints = [
        ("a", "revolute", "ground", "arm", (0, 0, 0), mechanisms.Z),
        ("tip", "fixed", "arm", "end", (1, 0, 0)),
        ("anchor", "fixed", "ground", "pin", (1, 0, 0)),
    ]
    home = mechanisms.build(joints, [("end", "pin")], ["a"], "end", {}).home
    with pytest.raises(pj.NoJacobianError):
        home.jacobian()
    try:
        found = home.allowed_jacobian()
    except pj.SingularError:
        return
    assert found.J_eq.shape == (6, 0)
    np.testing.assert_array_equal(found.twist([0.0]), np.zeros(6))


def test_a_tool_that_feels_an_idle_motion_is_refused_all_the_same():
    """Without a motor the tool of the crank moves freely: tied motors are no answer to that."""
    bar = pj.load("five_bar", actuated=["theta1"])
    with pytest.raises(pj.IdleMotionError):
        bar.home.allowed_jacobian()


def test_check_says_that_there_is_an_answer():
    diagnosis = pj.check("four_bar", actuated=["theta1", "phi1"])
    [found] = [one for one in diagnosis.findings if one.code == "over-actuated"]
    assert "What they allow is spanned by theta1 +1, phi1 " in found.message
    assert "`configuration.allowed_jacobian()` is that of the rates that fit" in found.advice
