"""Loop equations that are not square: redundant rows, idle motions, forbidden motor rates."""

from __future__ import annotations

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded

import pmjac_pin as pj


def test_the_planar_loops_third_row_is_left_out():
    jacobian = loaded("four_bar").home.jacobian()
    assert jacobian.constraint_jacobian.shape == (3, 3)
    assert jacobian.rows.tolist() == [0, 1]
    assert jacobian.K.shape == (2, 1)
    assert jacobian.K_star.shape == (2, 2)


def test_a_redundant_direction_that_turns_with_the_mechanism():
    mechanism = mechanisms.yawing_four_bar()
    flat = mechanism.home
    rows = []
    for yaw in np.linspace(0.0, np.pi, 25):
        configuration = mechanism.close([yaw, 0.9])
        jacobian = configuration.jacobian()
        rows.append(tuple(jacobian.rows))
        # Yawing turns the four-bar's own column and leaves the yaw's one a rotation.
        turn = pin.SE3(pin.AngleAxis(yaw, np.array([0.0, 0.0, 1.0])).matrix(), np.zeros(3))
        np.testing.assert_allclose(jacobian.J_eq, turn.action @ flat.jacobian().J_eq, atol=1e-10)
        assert jacobian.K_star.shape == (2, 2)
        assert configuration.singularity().kind == "regular"
        assert abs(jacobian.det_K_star) > 1e-12
    # Home's rows x, z are kept as long as they are independent: all but yaw = 90°.
    assert set(rows) == {(0, 2), (1, 2)}
    assert rows.count((1, 2)) == 1
    assert rows[12] == (1, 2)


def test_j_eq_does_not_rest_on_the_kept_rows():
    """A hair away from where the kept rows lose rank, J_eq is as exact as anywhere."""
    mechanism = mechanisms.yawing_four_bar()
    at_home = mechanism.home.jacobian().J_eq
    for offset in (1e-3, 1e-5, 1e-7, 1e-9):
        yaw = np.pi / 2 - offset
        turn = pin.SE3(pin.AngleAxis(yaw, np.array([0.0, 0.0, 1.0])).matrix(), np.zeros(3))
        J_eq = mechanism.close([yaw, 0.9]).jacobian().J_eq
        np.testing.assert_allclose(J_eq, turn.action @ at_home, atol=1e-11)


def test_geometrically_redundant_loops():
    mechanism = mechanisms.three_crank_parallelogram()
    assert mechanism.mobility == 1
    assert len(mechanism.rows) == 6
    for theta in np.linspace(0.2, 2.9, 10):
        configuration = mechanism.close([theta])
        # All cranks turn alike, the coupler does not turn.
        rates = configuration.jacobian().passive_rates[:, 0]
        rates = dict(zip(mechanism.passive, rates, strict=True))
        assert rates == pytest.approx({"theta2": 1.0, "theta3": 1.0, "beta": -1.0}, abs=1e-9)


def test_idle_spin_is_counted_and_not_felt():
    configuration = mechanisms.rssr().home
    singularity = configuration.singularity()
    assert (singularity.idle, singularity.gained, singularity.kind) == (1, 0, "regular")
    assert configuration.mechanism.mobility == 2
    assert singularity.free_motions.shape == (4, 0)
    assert singularity.free_motion() == {}
    [idle] = singularity.idle_motions.T
    assert idle[0] == pytest.approx(0.0, abs=1e-12)  # the rocker rests
    constraint = configuration.split_jacobian()
    np.testing.assert_allclose(constraint.K_star @ idle, 0.0, atol=1e-12)
    expected = mechanisms.rssr(rod=False).home.jacobian().J_eq
    np.testing.assert_allclose(configuration.jacobian().J_eq, expected, atol=1e-11)


def test_idle_spin_that_the_tool_feels_is_refused():
    with pytest.raises(pj.IdleMotionError) as caught:
        mechanisms.rssr("rod_side").home.jacobian()
    idle, split = caught.value.idle_motion, mechanisms.rssr("rod_side").home.split_jacobian()
    columns = [split.partition.columns[name] for name in idle]
    twist = split.tool_jacobian[:, columns] @ list(idle.values())
    by_m, by_rad = (f"{np.linalg.norm(part):.3g}" for part in (twist[:3], twist[3:]))
    assert str(caught.value) == (
        "the tool is moved by a passive motion that no motor commands: rx, ry, rz move freely "
        f"with all motors locked, which moves the tool by {by_m} m and {by_rad} rad for each unit "
        "of rx; make one of them actuated, or put the tool on a body that stays at rest"
    )
    assert abs(caught.value.idle_motion["psi"]) < 1e-12


def test_forbidden_motor_rates_are_named():
    configuration = mechanisms.over_actuated_four_bar().home
    with pytest.raises(pj.ForbiddenRatesError, match="the loops forbid the motor rates") as caught:
        configuration.jacobian()
    forbidden = caught.value.forbidden_rates[:, 0]
    # The rates that the four-bar allows are orthogonal to what is forbidden.
    ratio = loaded("four_bar").home.jacobian().passive_rates[0, 0]
    assert forbidden @ [1.0, ratio] == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(configuration.singularity().forbidden_rates[:, 0], forbidden)
    assert configuration.singularity().kind == "regular"


@pytest.mark.parametrize("yaw", [0.3, 1.1, 2.0])
def test_a_motor_that_takes_no_part_in_what_is_forbidden_is_not_named(yaw):
    flat = mechanisms.yawing_four_bar()
    pose = flat.close([yaw, 0.9])
    motors = ["yaw", "theta1", "phi1"]
    mechanism = pj.Mechanism.from_pinocchio(
        flat.model, flat.spec.loops, motors, "tool", home=pose.q
    )
    with pytest.raises(pj.ForbiddenRatesError) as caught:
        mechanism.home.jacobian()
    still, *moving = caught.value.forbidden_rates[:, 0]
    assert abs(still) < 1e-12
    named = ", ".join(f"{n} {rate:+.3g}" for n, rate in zip(motors[1:], moving, strict=True))
    assert f"motor rates ({named}): 3 motors are too many" in str(caught.value)


def test_forbidden_targets_are_not_closed():
    mechanism = mechanisms.over_actuated_four_bar()
    with pytest.raises(pj.ClosureError, match="The loops forbid these motors to move so together"):
        mechanism.close(mechanism.home.actuated + np.array([0.0, 0.1]))
