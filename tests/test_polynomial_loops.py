"""The loop equations as polynomials: against the library's own at real poses, and differences."""

from __future__ import annotations

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.studies.homotopy.machines import Machines
from pmjac_pin.studies.modes.closed_pose import closed_pose
from pmjac_pin.studies.modes.search_problem import search_problem


def machines_of(name):
    mechanism = loaded(name)
    try:
        return mechanism, Machines(mechanism)
    except pj.ArgumentError as error:
        assert "no homotopy for this mechanism" in str(error)
        return pytest.skip(str(error))


@pytest.mark.parametrize("name", mechanisms.CLOSED)
def test_closed_poses_solve_them_at_any_motor_values(name, rng):
    mechanism, machines = machines_of(name)
    for configuration in [
        mechanism.home,
        *mechanisms.random_closed(mechanism, rng, 3, spread=0.1),
    ]:
        machine, form = machines.at(configuration.actuated)
        problem = search_problem(mechanism, form.problem.whole)
        row = problem.without_legs(configuration.q)[None]
        x = machines.loops.unknowns(row)
        numbers = machine.numbers[None]
        for size in (1.0, 0.3 - 0.4j):
            ray = size * np.append(x[0], 1.0)[None]
            values, _ = machines.loops.evaluate(ray, numbers, 0 * numbers)
            assert np.abs(values).max() <= 1e-11
        assert machines.loops.unmet(x, machine.p).max() <= 1e-11
        [q] = form.poses(x.real)
        found = closed_pose(mechanism, q, limits=False)
        np.testing.assert_allclose(
            found.tool_pose().homogeneous, configuration.tool_pose().homogeneous, atol=1e-8
        )


@pytest.mark.parametrize("name", mechanisms.CLOSED)
def test_derivatives_by_unknowns_and_motors_are_exact(name, rng):
    _, machines = machines_of(name)
    loops = machines.loops
    machine = machines.offset(machines.home.near(rng), loops.somewhere(rng)).numbers
    X, rate = (
        rng.normal(size=size) + 1j * rng.normal(size=size)
        for size in (loops.count + 1, machine.size)
    )
    _, jacobian = loops.evaluate(X[None], machine[None], rate[None])
    scale = 1e-7 * max(1.0, np.abs(jacobian).max())
    h = 1e-6
    for column in range(loops.count + 2):
        dX = h * np.eye(loops.count + 2)[column, :-1]
        dp = h * rate if column == loops.count + 1 else 0 * rate
        ahead, behind = (
            loops.evaluate((X + sign * dX)[None], (machine + sign * dp)[None], rate[None])[0][0]
            for sign in (1, -1)
        )
        difference = (ahead - behind) / (2 * h)
        np.testing.assert_allclose(jacobian[0, :, column], difference, atol=scale)


@pytest.mark.parametrize("name", mechanisms.CLOSED)
def test_random_unknowns_have_unit_length(name, rng):
    _, machines = machines_of(name)
    loops, machine = machines.loops, machines.home.numbers[None]
    X = np.append(loops.somewhere(rng), 1.0)[None]
    values, _ = loops.evaluate(X, machine, 0 * machine)
    assert np.abs(values[0, : loops.count - loops.rows]).max(initial=0.0) <= 1e-12


@pytest.mark.parametrize("loop", [pj.RevoluteLoop, pj.FrameLoop])
def test_half_a_turn_is_no_closure(loop):
    """A hinge across the loop's axis solves t·a = 0, or R = Rᵀ, at 0 and at half a turn."""
    model = pin.Model()
    motor = model.addJoint(0, pin.JointModelPZ(), pin.SE3.Identity(), "motor")
    hinge = model.addJoint(motor, pin.JointModelRX(), pin.SE3.Identity(), "hinge")
    for name, joint in (("on_motor", motor), ("on_hinge", hinge)):
        model.addFrame(pin.Frame(name, joint, 0, pin.SE3.Identity(), pin.FrameType.OP_FRAME))
    mechanism = pj.Mechanism.from_pinocchio(
        model, [loop(frames=("on_hinge", "on_motor"))], ["motor"], "on_hinge", home=np.zeros(2)
    )
    homotopy = pj.parameter_homotopy(mechanism, rng=0)
    assert homotopy.count == 1
    [mode] = homotopy.at([0.2]).real
    np.testing.assert_allclose(mode.q, [0.2, 0.0], atol=1e-12)
    machines = Machines(mechanism)
    machine, _ = machines.at([0.2])
    x = machines.loops.unknowns(np.array([[0.2, 0.0], [0.2, np.pi]]))
    numbers = np.tile(machine.numbers, (2, 1))
    values, _ = machines.loops.evaluate(np.hstack([x, np.ones((2, 1))]), numbers, 0 * numbers)
    assert np.abs(values).max() <= 1e-12
    closed, turned_over = machines.loops.unmet(x, machine.p)
    assert (closed <= 1e-12, turned_over >= 1.9) == (True, True)


@pytest.mark.parametrize(
    ("mechanism", "why"),
    [
        (mechanisms.rssr, "passive motions that idle"),
    ],
)
def test_what_it_cannot_do_is_refused(mechanism, why):
    with pytest.raises(pj.ArgumentError, match=why):
        Machines(mechanism())
