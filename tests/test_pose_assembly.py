"""Closing the loops of poses that are given wide open."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import mechanisms
import msgspec
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.closing.assembly import build_parts
from pmjac_pin.closing.damped_closure import assemble, motor_weights
from pmjac_pin.closing.pose_assembly import assemble_pose


def four_bar(home, limits=(-100.0, 100.0), loops=None, **changes):
    """The four-bar with its rocker limited, from an open start."""
    model = loaded("four_bar").model
    column = model.joints[model.getJointId("phi1")].idx_q
    model.lowerPositionLimit[column], model.upperPositionLimit[column] = limits
    loops = loops or [pj.PointLoop(frames=("coupler_tip", "rocker_tip"))]
    return pj.Mechanism.from_pinocchio(
        model, loops, ["theta1"], "coupler_midpoint", home=home, name="bar", **changes
    )


@pytest.mark.parametrize("open_by", [1e-6, 1e-3, 0.1, 1.0])
def test_an_open_pose_is_closed_with_the_motors_at_rest(open_by, rng):
    closed = loaded("four_bar").home
    for _ in range(5):
        start = closed.q + open_by * rng.uniform(-1, 1, 3)
        start[list(closed.mechanism.model.names).index("theta1") - 1] = closed.actuated[0]
        mechanism = four_bar(start)
        assert mechanism.home.actuated[0] == closed.actuated[0]
        assert mechanism.home.residual_norm <= 1e-12
        moved = mechanism.moved()
        assert moved["theta1"] == 0.0
        names = list(mechanism.model.names)[1:]
        change = [moved[name] for name in names]
        np.testing.assert_allclose(start + change, mechanism.home.q, atol=1e-12)


def test_the_joints_stay_within_their_limits():
    """From the other side of a limit, the loops close on the mode that respects it."""
    closed = loaded("four_bar").home
    phi1 = closed.joint_values["phi1"]
    other = four_bar({"theta1": closed.actuated[0], "phi1": -phi1 + 0.3, "phi2": -1.0})
    assert other.home.joint_values["phi1"] < 0
    kept = four_bar(
        {"theta1": closed.actuated[0], "phi1": -phi1 + 0.3, "phi2": -1.0}, limits=(0.2, 3.0)
    )
    assert 0.2 <= kept.home.joint_values["phi1"] <= 3.0
    np.testing.assert_allclose(kept.home.tool_pose().translation, closed.tool_pose().translation)


def test_a_limit_that_no_closed_pose_respects_is_named():
    with pytest.raises(
        pj.ClosureError, match=r"closes where 'phi1' = .* is outside its limits \[0\.5, 0\.6\]"
    ):
        four_bar({"theta1": 0.9, "phi1": 2.0, "phi2": 0.0}, limits=(0.5, 0.6))


def test_motors_move_as_little_as_it_takes():
    """A rocker-rocker asked for a crank angle beyond its reach: the nearest that closes."""
    reach = 1.37156
    mechanism = mechanisms.rocker_rocker()
    home = {"theta1": reach + 0.1, "phi1": 2.0, "phi2": 0.5}
    bar = pj.Mechanism.from_pinocchio(
        mechanism.model, mechanism.spec.loops, ["theta1"], "coupler_midpoint", home=home
    )
    moved = bar.moved()["theta1"]
    assert -0.3 < moved < -0.1
    assert bar.home.singularity().kind == "regular"


def test_the_loop_that_stays_open_is_named():
    mechanism = mechanisms.three_crank_parallelogram()
    model = mechanism.model
    frame = model.frames[model.getFrameId("tip3")]
    model.addFrame(
        pin.Frame("far", frame.parentJoint, pin.SE3(np.eye(3), np.array([9.0, 0, 0])), frame.type)
    )
    loops = [mechanism.spec.loops[0], pj.PointLoop(frames=("point3", "far"))]
    with pytest.raises(pj.ClosureError) as caught:
        pj.Mechanism.from_pinocchio(model, loops, ["theta1"], "point3", home=mechanism.home.q)
    assert "most at 'point3-far" in str(caught.value)
    assert caught.value.loop == "point3-far"
    assert caught.value.residual_norm > 1.0


@pytest.mark.parametrize("tilt", [3.7e-6, 1e-4])
def test_rounded_angles_need_a_tolerance_and_say_so(tilt):
    """An axis that is off by the rounding of rpy="1.5708": the loop cannot quite close."""
    model = loaded("four_bar").model
    joint = model.getJointId("phi2")
    model.jointPlacements[joint] = model.jointPlacements[joint] * pin.SE3(
        pin.exp3(np.array([tilt, 0.4 * tilt, 0.0])), np.zeros(3)
    )
    arguments = (model, [pj.PointLoop(frames=("coupler_tip", "rocker_tip"))], ["theta1"])
    home = loaded("four_bar").home
    with pytest.raises(pj.ClosureError, match="`tolerance`"):
        pj.Mechanism.from_pinocchio(*arguments, "coupler_midpoint", home=home.q)
    mechanism = pj.Mechanism.from_pinocchio(
        *arguments, "coupler_midpoint", home=home.q, tolerance=10 * tilt
    )
    assert mechanism.mobility == 1
    expected = home.jacobian().J_eq
    J_eq = mechanism.home.jacobian().J_eq
    np.testing.assert_allclose(J_eq, expected, atol=20 * tilt)
    far = mechanism.close([2.0])
    np.testing.assert_allclose(
        far.jacobian().J_eq, loaded("four_bar").close([2.0]).jacobian().J_eq, atol=20 * tilt
    )


@pytest.mark.parametrize("size", [1.0, 1e-3])
def test_a_flat_start_is_left(size):
    """All joints at zero: the gap points along the links and does not say how to fold them."""
    model = pin.buildModelFromXML(
        mechanisms.tree(
            ("a", "revolute", "ground", "one", (0, 0, 0), (0, 0, 1)),
            ("b", "revolute", "one", "two", (size, 0, 0), (0, 0, 1)),
            ("c", "revolute", "two", "three", (size, 0, 0), (0, 0, 1)),
            ("d", "fixed", "three", "tip", (size, 0, 0)),
            ("e", "fixed", "ground", "wall", (2.2 * size, 0, 0)),
        )
    )
    mechanism = pj.Mechanism.from_pinocchio(
        model, [pj.PointLoop(frames=("tip", "wall"))], ["a"], "two", name="flat"
    )
    assert mechanism.home.residual_norm <= 1e-12
    assert mechanism.home.singularity().kind == "regular"
    assert mechanism.moved()["a"] == 0.0


def guesses(mechanism, rng, count):
    """Poses with the motors of home and passive joints anywhere."""
    passive, angular = mechanism.problem.partition.passive, mechanism.coordinates.rotational
    for _ in range(count):
        v = np.zeros(mechanism.nv)
        v[passive] = rng.uniform(-1, 1, passive.size) * np.where(angular[passive], np.pi, 0.3)
        yield pin.integrate(mechanism.model, mechanism.home.q, v)


def at_guess(mechanism, q):
    return pj.Mechanism(build_parts(mechanism.model, at(mechanism, home=q), {}))


def at(mechanism, **poses):
    """The mechanism's spec with its loops' lengths as they are, and these poses."""
    spec, values = mechanism.spec, mechanism.parameters
    loops = tuple(
        msgspec.structs.replace(loop, length=loop.resolved_length(values))
        if isinstance(loop, pj.DistanceLoop)
        else loop
        for loop in spec.loops
    )
    given = {name: mechanism.coordinates.pose(q) for name, q in poses.items()}
    poses = {"home": spec.poses["home"], **given}
    return msgspec.structs.replace(spec, loops=loops, parameters={}, poses=poses)


# From a guess anywhere, one start in two or three closes; of 24 in a row, all but never none.
@pytest.mark.parametrize("name", ["planar_3rrr", "three_rps"])
def test_motors_keep_their_values_where_the_loops_close_there(name, rng):
    """A poor guess of the passive joints is no reason to move the motors."""
    mechanism = loaded(name)
    homes = [at_guess(mechanism, q).home for q in guesses(mechanism, rng, 30)]
    moved = [np.abs(home.actuated - mechanism.home.actuated).max() > 0.0 for home in homes]
    assert sum(moved) <= 1
    assert all(home.residual_norm <= 1e-12 for home in homes)


def test_a_poor_guess_in_words_is_closed_with_the_motors_at_rest(rng):
    mechanism = loaded("planar_3rrr")
    names = mechanism.spec.passive
    motors, refused = mechanism.home.actuated, 0
    for q in guesses(mechanism, rng, 30):
        values = mechanism.coordinates.joint_values(q, names)
        try:
            assert mechanism.close(motors, guess=values).actuated.tolist() == motors.tolist()
        except pj.ClosureError:
            refused += 1
    assert refused <= 1


def test_a_named_pose_keeps_its_motors_too(rng):
    mechanism = loaded("planar_3rrr")
    poses = {f"p{k}": q for k, q in enumerate(guesses(mechanism, rng, 30))}
    again = pj.Mechanism(build_parts(mechanism.model, at(mechanism, **poses), {}))
    moved = [any(again.moved(name)[motor] for motor in again.spec.actuated) for name in poses]
    assert sum(moved) <= 1


def test_what_closes_at_once_costs_no_more(rng):
    """Counted in evaluations of the loops: further starts are for what stays wide open."""
    mechanism, counts = loaded("planar_3rrr"), []
    parts = build_parts(mechanism.model, mechanism.spec, dict(mechanism.parameters))

    def counted(q):
        counts[-1] += 1
        return mechanism.problem.evaluate(q)

    problem = mechanism.problem
    watched = dataclasses.replace(problem, loops=SimpleNamespace(closure=counted, evaluate=counted))
    start = problem.integrate(mechanism.home.q, 0.1 * rng.normal(size=mechanism.nv))
    room, weights = mechanism.coordinates.room, motor_weights(problem, 0.0)
    parts = dataclasses.replace(parts, split=watched)
    for close in (lambda: assemble(watched, start, weights, room=room),
                  lambda: assemble_pose(parts, start, "home")):  # fmt: skip
        counts.append(0)
        close()
    assert counts[0] == counts[1] < 20


def test_the_end_of_the_reach_is_not_left_for_another_mode():
    """A motor value rounded beyond a fold moves by that much, and the pose stays where it is."""
    mechanism = loaded("planar_3rrr")
    with pytest.raises(pj.ClosureError) as caught:
        mechanism.close(mechanism.home.actuated + 2.0)
    end = caught.value.reached
    beyond = 1e-6 * (mechanism.home.actuated + 2.0 - end.actuated)
    columns = mechanism.problem.partition.actuated
    q = mechanism.coordinates.with_values(end.q, columns, end.actuated + beyond)
    home = at_guess(mechanism, q).home
    assert np.abs(home.q - end.q).max() < 0.01
