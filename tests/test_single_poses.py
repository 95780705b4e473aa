"""A single pose by a recorded program is what singular values say, and so is what is said of it."""

from __future__ import annotations

import copy
import pickle
import re
import threading

import numpy as np
import pinocchio as pin
import pytest
from mechanisms import CATALOGUE, SAMPLE, loaded, mostly_slow, random_closed
from random_machines import random_machine
from recording import recorded, unrecorded

import pmjac_pin as pj
from pmjac_pin.closing.path_kernel import path_kernel

pytestmark = pytest.mark.skipif(path_kernel() is None, reason="no kernel was built")
QUICK = ("four_bar", "five_bar", "bennett", "three_rps_ss", "delta_rods", "random 1", "random 4")
PROGRAMS = (recorded, unrecorded)
LONG = ("four_bar", "five_bar", "random 1")
MACHINES = [*CATALOGUE, *(f"random {seed}" for seed in range(10))]


def machine(name):
    return random_machine(int(name.split()[1])) if name.startswith("random ") else loaded(name)


def cases():
    """Few targets at once, or many."""
    for name in MACHINES:
        yield pytest.param(name, 12, 0.3, marks=[] if name in QUICK else [pytest.mark.slow])
        yield pytest.param(name, 200, 0.1, marks=pytest.mark.slow)
    for name in LONG:
        yield pytest.param(name, 12, 2.0)


def targets(mechanism, count, share, rng):
    partition = mechanism.problem.partition
    size = share * partition.length * partition.column_scale[partition.actuated]
    return mechanism.home.actuated + size * rng.uniform(-1, 1, (count, size.size))


def answer(call):
    try:
        return call()
    except pj.PmjacError as error:
        return error


def words(error):
    """What an error says, but for its numbers, which may differ by rounding."""
    return re.sub(r"[-+]?[\d.]+(e[-+]?\d+)?", "#", str(error))


@pytest.mark.parametrize(("name", "count", "share"), list(cases()))
def test_paths_end_where_and_as_they_do_by_singular_values(name, count, share, rng):
    mechanism, by_values = recorded(machine(name)), unrecorded(machine(name))
    length = mechanism.characteristic_length
    for values in targets(mechanism, count, share, rng):
        found, expected = (
            answer(lambda one=one, values=values: one.close(values, enforce_limits=False))
            for one in (mechanism, by_values)
        )
        assert type(found) is type(expected)
        if isinstance(expected, pj.Configuration):
            near = by_values.configuration(expected.q).singularity().smallest
            np.testing.assert_allclose(
                found.q, expected.q, atol=1e-13 * max(1.0, length) / max(near, 1e-8)
            )
            assert found.residual_norm <= mechanism.tolerance
            assert (found.iterations > 0) == (expected.iterations > 0)
            continue
        assert words(found) == words(expected)
        assert found.share == pytest.approx(expected.share, abs=1e-6)
        np.testing.assert_allclose(found.reached.q, expected.reached.q, atol=1e-3 * length)
        assert found.singular_value == pytest.approx(expected.singular_value, abs=1e-5)


def near_and_at_folds(mechanism, rng):
    """Poses along paths, and beside where these end."""
    poses = []
    for values in targets(mechanism, 8, 0.6, rng):
        found = answer(lambda values=values: mechanism.close(values, enforce_limits=False))
        if isinstance(found, pj.Configuration):
            poses.append(found)
            continue
        poses.append(found.reached)
        motors = mechanism.home.actuated
        for left in (1e-12, 1e-8, 1e-4):
            on_the_way = motors + (1.0 - left) * found.share * (values - motors)
            one = answer(lambda on_the_way=on_the_way: mechanism.close(on_the_way))
            poses += [one] if isinstance(one, pj.Configuration) else []
    return poses


@pytest.mark.parametrize("name", mostly_slow(MACHINES, {*SAMPLE, *LONG, "random 4"}))
def test_jacobians_are_those_by_singular_values(name, rng):
    mechanism, by_values = recorded(machine(name)), unrecorded(machine(name))
    values = targets(by_values, 12, 0.03, rng)
    poses = [answer(lambda v=v: by_values.close(v, enforce_limits=False)) for v in values]
    if name in QUICK:
        poses += near_and_at_folds(by_values, rng)
    poses = [pose for pose in poses if isinstance(pose, pj.Configuration)]
    known, regular = 0, 0
    for pose in poses:
        one, other = mechanism.configuration(pose.q), by_values.configuration(pose.q)
        known += one._known is not None
        regular += other.singularity().smallest > 0.03
        assert one.residual_norm == pytest.approx(other.residual_norm, abs=1e-13)
        for frame in ("LOCAL", "WORLD", "LOCAL_WORLD_ALIGNED"):
            found, expected = (answer(lambda c=c: c.jacobian(frame)) for c in (one, other))  # noqa: B023
            if isinstance(expected, pj.PmjacError):
                assert (type(found), str(found)) == (type(expected), str(expected))
                continue
            condition = other.singularity().condition
            np.testing.assert_allclose(
                found.J_eq, expected.J_eq, atol=1e-14 * condition * expected.sizes.max()
            )
            np.testing.assert_allclose(
                found.passive_rates, expected.passive_rates, rtol=1e-9, atol=1e-12
            )
            assert (np.abs(found.J_eq - expected.J_eq) <= expected.error_estimate).all()
    assert known >= 0.5 * regular


def assert_same_ellipsoids(found, expected, atol):
    """Radii of velocities and forces, and which of them are none."""
    for kind in ("velocity_ellipsoid", "angular_ellipsoid", "force_ellipsoid"):
        one, other = (getattr(jacobian, kind)() for jacobian in (found, expected))
        assert (one.unit, one.motor_unit) == (other.unit, other.motor_unit)
        assert (one.radii == 0.0).tolist() == (other.radii == 0.0).tolist()
        assert np.isinf(one.radii).tolist() == np.isinf(other.radii).tolist()
        if kind != "force_ellipsoid":
            np.testing.assert_allclose(one.radii, other.radii, atol=atol)
            shape, like = (e.axes * e.radii**2 @ e.axes.T for e in (one, other))
            np.testing.assert_allclose(shape, like, atol=4.0 * atol * max(1.0, other.radii[0]))


def flat_machines():
    """Tools that never turn, or never move, or move in fewer ways than motors."""
    yield "agile_eye", {"front": 0.0}
    for name in ("bennett", "delta", "delta_rods", "four_bar", "sarrus", "serial_2r"):
        yield name, {}


def assert_ellipsoids_agree(mechanism, by_values, poses):
    """With a program, and without; return of how many poses the program told."""
    known = 0
    for q in poses:
        one, other = mechanism.configuration(q), by_values.configuration(q)
        known += one._known is not None
        for frame in ("LOCAL_WORLD_ALIGNED", "LOCAL", "WORLD"):
            found, expected = one.jacobian(frame), other.jacobian(frame)
            atol = 1e-14 * other.singularity().condition * expected.sizes.max()
            assert_same_ellipsoids(found, expected, atol)
            np.testing.assert_allclose(found.sizes, expected.sizes, rtol=1e-9)
            told = one._known is not None and frame != "WORLD"
            assert ("_found" in vars(found)) != told  # Pinocchio's matrices
    return known


@pytest.mark.parametrize("name", mostly_slow(MACHINES, {*SAMPLE, "random 4"}))
def test_ellipsoids_are_those_by_singular_values(name, rng):
    mechanism, by_values = recorded(machine(name)), unrecorded(machine(name))
    near = targets(by_values, 8, 0.03, rng)
    poses = [answer(lambda v=v: by_values.close(v, enforce_limits=False)) for v in near]
    nearness = {
        tuple(pose.q): pose.singularity().smallest
        for pose in poses
        if isinstance(pose, pj.Configuration)
        and isinstance(answer(pose.jacobian), pj.EquivalentJacobian)
    }
    known = assert_ellipsoids_agree(mechanism, by_values, [np.array(q) for q in nearness])
    regular = sum(smallest > 0.03 for smallest in nearness.values())
    assert known >= (regular if mechanism.recorded._pose() is not None else 0)


@pytest.mark.parametrize(("name", "dimensions"), list(flat_machines()))
def test_what_the_tool_cannot_do_is_zero_by_the_program_too(name, dimensions, rng):
    mechanism, by_values = (programs(pj.load(name, dimensions)) for programs in PROGRAMS)
    found = random_closed(by_values, rng, 4, spread=0.1)
    poses = [by_values.home.q, *(pose.q for pose in found)]
    assert assert_ellipsoids_agree(mechanism, by_values, poses) == len(poses)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-8, 1e-6, 1e-3])
def test_links_in_line_have_the_rank_that_they_have_by_singular_values(angle):
    mechanism, by_values = (programs(loaded("serial_2r")) for programs in PROGRAMS)
    poses = [np.array([first, angle]) for first in (0.0, 0.3, 2.0)]
    assert assert_ellipsoids_agree(mechanism, by_values, poses) == 3
    jacobian = mechanism.configuration(poses[1]).jacobian()
    assert jacobian.velocity_ellipsoid().rank == (2 if angle >= 1e-8 else 1)


def test_shares_of_limits_are_those_by_singular_values():
    mechanism, by_values = (programs(loaded("three_rps")) for programs in PROGRAMS)
    q, limits = by_values.home.q, [0.1, 2.0, 30.0]
    found, expected = (one.configuration(q).jacobian() for one in (mechanism, by_values))
    for kind in ("velocity_ellipsoid", "angular_ellipsoid", "force_ellipsoid"):
        one, other = (getattr(jacobian, kind)(limits) for jacobian in (found, expected))
        assert one.rank == other.rank
        np.testing.assert_allclose(one.radii, other.radii, rtol=1e-9)


def test_what_is_not_certain_is_said_by_singular_values():
    mechanism = pj.load("four_bar", {"l0": 2.0, "l1": 1.0, "l2": 2.0, "l3": 1.0})
    flat = mechanism.close([0.0], enforce_limits=False)
    recorded(mechanism)
    with pytest.raises(pj.SingularError, match="no J_eq exists"):
        mechanism.configuration(flat.q).jacobian()
    with pytest.raises(pj.ClosureError, match="are open by"):
        mechanism.configuration(flat.q + 0.1)
    assert mechanism.recorded._pose() is not None


def test_half_a_turn_away_is_open():
    """Where tilts and turns vanish by mistake."""
    mechanism = recorded(loaded("delta"))
    home = mechanism.home.q
    mechanism.configuration(home)
    assert mechanism.configuration(home)._known is not None
    rows = [k for k, unit in enumerate(mechanism.row_units) if unit == "rad"]
    assert rows
    for joint in range(mechanism.nv):
        v = np.zeros(mechanism.nv)
        v[joint] = np.pi
        assert mechanism.recorded.pose(mechanism.problem.integrate(home, v)) is None


def test_the_other_matrices_are_found_when_asked_for():
    mechanism = recorded(loaded("three_rps"))
    jacobian = mechanism.configuration(mechanism.home.q).jacobian()
    assert not {"tool_jacobian", "constraint_jacobian"} & set(vars(jacobian))
    expected = unrecorded(loaded("three_rps")).home.jacobian()
    assert repr(jacobian) == repr(expected)
    for name in ("K", "K_star", "Jv_star", "motion_map", "sizes"):
        np.testing.assert_allclose(getattr(jacobian, name), getattr(expected, name), rtol=1e-9)
    # Of the gap there is only rounding.
    np.testing.assert_allclose(jacobian.error_estimate, expected.error_estimate, rtol=0.5)
    for other in (pickle.loads(pickle.dumps(jacobian)), copy.copy(jacobian)):
        np.testing.assert_array_equal(other.J_eq, jacobian.J_eq)
        np.testing.assert_array_equal(other.passive_rates, jacobian.passive_rates)
    with pytest.raises(AttributeError, match="no attribute 'J_q'"):
        jacobian.J_q  # noqa: B018
    with pytest.raises(ValueError, match="read-only"):
        jacobian.J_eq[0, 0] = 1.0


def test_without_a_kernel_nothing_is_recorded(monkeypatch):
    monkeypatch.setattr("pmjac_pin.closing.path_kernel.path_kernel", lambda: None)
    mechanism = recorded(loaded("four_bar"))
    pose = mechanism.close([1.0])
    assert pose._known is None
    assert not {"rates", "point", "step"} & set(vars(mechanism.recorded))
    np.testing.assert_allclose(pose.q, loaded("four_bar").close([1.0]).q, atol=0.0)


def test_after_a_batch_the_first_call_goes_by_the_program():
    mechanism = loaded("four_bar")
    pj.batch(mechanism)
    assert mechanism.configuration(mechanism.home.q)._known is not None
    assert "_point" not in vars(mechanism.close([1.0]))


def test_joints_that_pinocchio_alone_knows_are_closed_without():
    """And motors that loops tie, and motions that idle."""
    tied = pj.load("five_bar", actuated=["theta1", "theta2", "phi1"])
    for mechanism in map(recorded, (tied, pj.load("five_bar", actuated=["theta1"]))):
        assert mechanism.configuration(mechanism.home.q)._known is None
        assert mechanism.recorded._path() is None


def test_few_calls_record_nothing():
    mechanism = loaded("stewart_gough")
    for _ in range(20):
        mechanism.close(mechanism.home.actuated).jacobian()
    assert not {"rates", "point", "step"} & set(vars(mechanism.recorded))


def test_many_calls_record_once_and_pickles_record_anew():
    mechanism = loaded("four_bar")
    for _ in range(200):
        mechanism.configuration(mechanism.home.q)
        mechanism.close([1.0])
    assert mechanism.recorded._pose() is not None
    assert mechanism.recorded._path() is not None
    again = pickle.loads(pickle.dumps(mechanism))
    assert again.recorded._path() is None
    np.testing.assert_allclose(again.close([1.0]).q, mechanism.close([1.0]).q, atol=1e-14)


def test_threads_do_not_share_memory():
    mechanism = recorded(loaded("three_rps"))
    mechanism.close(mechanism.home.actuated)
    values = [mechanism.home.actuated + 0.002 * k for k in range(40)]
    expected = [mechanism.close(one) for one in values]
    J_eqs = [one.jacobian().J_eq for one in expected]
    wrong = []

    def work():
        for _ in range(20):
            for one, pose, J_eq in zip(values, expected, J_eqs, strict=True):
                found = mechanism.close(one)
                if (found.q != pose.q).any() or (found.jacobian().J_eq != J_eq).any():
                    wrong.append(one)

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong


def test_loose_joints_of_any_kind_move_as_pinocchio_moves_them(rng):
    """Endless motors, planar and free bodies: the same poses a full turn on."""
    for name in ("planar_3rrr", "three_rps", "delta"):
        mechanism, by_values = recorded(loaded(name)), unrecorded(loaded(name))
        for values in targets(mechanism, 3, 0.05, rng):
            found, expected = (
                m.close(values, enforce_limits=False) for m in (mechanism, by_values)
            )
            np.testing.assert_allclose(found.q, expected.q, atol=1e-12)
            back = mechanism.close(mechanism.home.actuated, found)
            np.testing.assert_allclose(back.q, mechanism.home.q, atol=1e-11)


def crank(joint):
    """A four-bar of endless joints, its coupler carried by another kind of joint."""
    model, still = pin.Model(), pin.SE3.Identity()

    def along(x):
        return pin.SE3(np.eye(3), np.array([x, 0.0, 0.0]))

    first = model.addJoint(0, pin.JointModelRUBZ(), still, "motor")
    second = model.addJoint(first, joint, along(1.0), "coupler")
    rocker = model.addJoint(0, pin.JointModelRUBZ(), along(4.0), "rocker")
    model.addFrame(pin.Frame("tip", second, along(3.0), pin.FrameType.OP_FRAME))
    model.addFrame(pin.Frame("end", rocker, along(3.5), pin.FrameType.OP_FRAME))
    ends = {"frames": ("tip", "end")}
    loop = pj.PointLoop(**ends) if joint.nv == 1 else pj.RevoluteLoop(axis=(0, 0, 1), **ends)
    home = {"motor": 0.9, "rocker": 1.8}
    return pj.Mechanism.from_pinocchio(model, [loop], ["motor"], "tip", home=home, name="crank")


@pytest.mark.parametrize("joint", [pin.JointModelRUBZ(), pin.JointModelRZ()])
def test_endless_motors_go_the_shorter_way(joint, rng):
    mechanism, by_values = recorded(crank(joint)), unrecorded(crank(joint))
    for value in (3.0, 3.3, -3.0, 12.0, *rng.uniform(-7, 7, 10)):
        found, expected = (
            one.close([value], enforce_limits=False) for one in (mechanism, by_values)
        )
        assert mechanism.recorded._path() is not None
        np.testing.assert_allclose(found.q, expected.q, atol=1e-11)
        again = mechanism.close([value + 0.3], found)
        np.testing.assert_allclose(again.q, by_values.close([value + 0.3], expected).q, atol=1e-11)
    inexact = found.q.copy()
    inexact[:2] *= 1.0 + 1e-9  # Pinocchio takes it as it is
    assert mechanism.recorded.pose(inexact) is None


def test_balls_turn_as_pinocchio_turns_them(rng):
    mechanism, by_values = (programs(crank(pin.JointModelSpherical())) for programs in PROGRAMS)
    for value in rng.uniform(0.2, 2.5, 10):
        found, expected = (
            one.close([value], enforce_limits=False) for one in (mechanism, by_values)
        )
        assert mechanism.recorded._path() is not None
        np.testing.assert_allclose(found.q, expected.q, atol=1e-11)
        J_eqs = [one.configuration(found.q).jacobian().J_eq for one in (mechanism, by_values)]
        np.testing.assert_allclose(*J_eqs, atol=1e-11)
