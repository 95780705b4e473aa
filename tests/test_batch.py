"""Many poses at once are what the single calls say: the same poses, J_eq, and where paths end."""

from __future__ import annotations

import numpy as np
import pandas
import pinocchio as pin
import pytest
import xarray
from humanoid import humanoid
from mechanisms import SAMPLE, loaded, mostly_slow, rssr
from random_machines import random_machine
from recording import unrecorded
from transformed import resolved

import pmjac_pin as pj
from pmjac_pin.batches.pieces import PIECE, pieces_of

NAMES = pj.list_mechanisms()
QUICK = ("four_bar", "five_bar", "bennett", "delta", "random 1")  # whose long paths are short


def machines_and_shares():
    """Short paths, and long ones that meet folds: of some machines these take many seconds."""
    for name in [*NAMES, "humanoid", *(f"random {seed}" for seed in range(10))]:
        quick = name in SAMPLE or name in QUICK or name in ("humanoid", "random 0", "random 2")
        yield pytest.param(name, 0.03, marks=[] if quick else [pytest.mark.slow])
        yield pytest.param(name, 0.6, marks=[] if name in QUICK else [pytest.mark.slow])


def machine(name):
    if name == "humanoid":
        return humanoid()
    return random_machine(int(name.split()[1])) if name.startswith("random ") else loaded(name)


def targets(mechanism, count, share, rng):
    """Motor values around home: where a gear moves much, by as much less."""
    partition = mechanism.problem.partition
    size = share * partition.length * partition.column_scale[partition.actuated]
    return mechanism.home.actuated + size * rng.uniform(-1, 1, (count, size.size))


def single(mechanism, values):
    try:
        pose = mechanism.close(values, enforce_limits=False)
    except pj.ClosureError as error:
        return error.share, error.reached.q
    return 1.0, pose.q


@pytest.mark.parametrize(("name", "share"), list(machines_and_shares()))
def test_the_same_as_one_by_one(name, share, rng):
    mechanism = machine(name)
    many = pj.batch(mechanism)
    count = 4 if "stewart" in name else 12
    values = targets(mechanism, count, share, rng)
    poses = many.close(values, enforce_limits=False)
    jacobians = many.jacobian(poses.q)
    length = mechanism.characteristic_length
    # The single call is made where the program does not know: hardly ever, but for the last two
    # paths that are long.
    start = np.tile(mechanism.home.q, (count, 1))
    ends = np.empty_like(start), np.empty(count)
    settled = many._closing.together(start, values, ends).settled
    assert np.count_nonzero(~settled) <= max(2, 0.1 * count)
    for k, (end, q) in enumerate(single(mechanism, one) for one in values):
        assert poses.share[k] == pytest.approx(end, abs=1e-6)
        assert (poses.status[k] == pj.Status.CLOSED) == (end == 1.0)
        if end < 1.0:
            continue
        np.testing.assert_allclose(poses.q[k], q, atol=1e-10 * max(1.0, length))
        try:
            J_eq = mechanism.configuration(poses.q[k]).jacobian().J_eq
        except pj.SingularError:
            assert jacobians.status[k] == pj.Status.SINGULAR
            continue
        except pj.NoJacobianError:
            assert jacobians.status[k] == pj.Status.NO_JACOBIAN
            continue
        assert jacobians.status[k] == pj.Status.CLOSED
        condition = mechanism.configuration(poses.q[k]).singularity().condition
        np.testing.assert_allclose(
            jacobians.J_eq[k], J_eq, atol=1e-13 * condition * np.abs(J_eq).max()
        )


def test_over_actuated_motors_lead_and_are_led():
    mechanism = pj.load("five_bar", actuated=["theta1", "theta2", "phi1"])
    end = loaded("five_bar").close(loaded("five_bar").home.actuated + 0.1).joint_values
    fits = [float(end[name]) for name in mechanism.actuated]
    forbidden = mechanism.home.actuated + np.array([0.01, 0.01, 0.0])
    poses = pj.batch(mechanism).close([fits, forbidden])
    assert poses.status.tolist() == [pj.Status.CLOSED, pj.Status.STOPPED]
    np.testing.assert_allclose(mechanism.configuration(poses.q[0]).actuated, fits, atol=1e-9)


def test_a_guess_of_another_machine_is_looked_at():
    """One of its own is known to be closed; where another's loops are closed, these are open."""
    mechanism = loaded("five_bar")
    other = mechanism.with_parameters(l1=1.01 * mechanism.parameters["l1"])
    many, values = pj.batch(mechanism), [mechanism.home.actuated]
    with pytest.raises(pj.ClosureError, match="are open by"):
        many.close(values, guess=other.home)
    assert many.close(values, guess=pj.load("five_bar").home).status[0] == pj.Status.CLOSED


def test_guesses_and_limits():
    mechanism = loaded("four_bar")
    many, values = pj.batch(mechanism), np.array([[0.5], [1.0], [7.0]])
    assert many.close(values).status.tolist() == [*[pj.Status.CLOSED] * 2, pj.Status.LIMITS]
    free = many.close(values, enforce_limits=False)
    assert free.status.tolist() == [pj.Status.CLOSED] * 3
    again = many.close(values + 0.1, guess=free.q, enforce_limits=False)
    for q, value in zip(again.q, values + 0.1, strict=True):
        np.testing.assert_allclose(q, mechanism.close(value, enforce_limits=False).q, atol=1e-12)
    with pytest.raises(pj.ArgumentError, match="3 guesses expected"):
        many.close(values, guess=free.q[:2])
    with pytest.raises(pj.ArgumentError, match=r"shape \(N, 1\) for theta1 expected"):
        many.close([0.5, 1.0])
    with pytest.raises(pj.ArgumentError, match=r"q of shape \(N, 3\) expected"):
        many.jacobian(free.q[0])


@pytest.mark.parametrize("frame", ["LOCAL", "WORLD", "LOCAL_WORLD_ALIGNED"])
@pytest.mark.parametrize("name", ["three_rps_ss", "delta", "ur5"])
def test_in_every_frame(name, frame):
    mechanism = loaded(name)
    found = pj.batch(mechanism).jacobian(mechanism.home.q[None], frame)
    expected = mechanism.home.jacobian(frame).J_eq
    np.testing.assert_allclose(found.J_eq[0], expected, atol=1e-12 * np.abs(expected).max())


def test_poses_without_a_jacobian_say_why():
    mechanism = pj.load("four_bar", {"l0": 2.0, "l1": 1.0, "l2": 2.0, "l3": 1.0})
    flat = mechanism.close([0.0], enforce_limits=False).q
    found = pj.batch(mechanism).jacobian([mechanism.home.q, flat, flat + 0.1])
    assert found.status.tolist() == [pj.Status.CLOSED, pj.Status.SINGULAR, pj.Status.OPEN]
    assert np.isnan(found.J_eq[1:]).all()
    assert np.isfinite(found.J_eq[0]).all()


def test_what_idles_agrees_and_a_tool_that_feels_it_is_told():
    """A rod that spins between two balls (`test_idle_paths` has many more)."""
    mechanism = rssr()
    many, values = pj.batch(mechanism), mechanism.home.actuated + np.linspace(-0.3, 0.3, 7)[:, None]
    poses = many.close(values)
    assert (poses.status == pj.Status.CLOSED).all()
    for q, J_eq, one in zip(poses.q, many.jacobian(poses.q).J_eq, values, strict=True):
        pose = mechanism.close(one)
        np.testing.assert_allclose(q, pose.q, atol=1e-12)
        np.testing.assert_allclose(J_eq, pose.jacobian().J_eq, atol=1e-12)
    felt = pj.batch(mechanism.with_tool("rod_side")).jacobian(poses.q)
    assert (felt.status == pj.Status.NO_JACOBIAN).all()


@pytest.mark.parametrize("name", mostly_slow(NAMES))
def test_measures_are_those_of_one_by_one(name, rng):
    mechanism = machine(name)
    many = pj.batch(mechanism)
    q = many.close(targets(mechanism, 3, 0.05, rng), enforce_limits=False).q
    found, jacobians, ellipsoids = many.measures(q), many.jacobian(q), many.ellipsoids(q)
    assert found.status.tolist() == jacobians.status.tolist() == ellipsoids.status.tolist()
    for one in ("J_eq", "velocity_radii", "angular_radii"):
        np.testing.assert_array_equal(getattr(ellipsoids, one), getattr(found, one))
    for k, pose in enumerate(map(mechanism.configuration, q)):
        singularity, tool = pose.singularity(), pose.tool_pose()
        assert found.smallest[k] == pytest.approx(singularity.smallest, rel=1e-9, abs=1e-14)
        if singularity.smallest > 1e-12:
            assert found.condition[k] == pytest.approx(singularity.condition, rel=1e-9)
        size = max(1.0, np.abs(tool.translation).max())
        np.testing.assert_allclose(found.position[k], tool.translation, atol=1e-13 * size)
        np.testing.assert_allclose(found.rotation[k], tool.rotation, atol=1e-13)
        if found.status[k] != pj.Status.CLOSED:
            assert np.isnan(found.velocity_radii[k]).all()
            continue
        jacobian = pose.jacobian()
        for radii, ellipsoid, size in zip(
            (found.velocity_radii[k], found.angular_radii[k]),
            (jacobian.velocity_ellipsoid(), jacobian.angular_ellipsoid()),
            jacobian.sizes,
            strict=True,
        ):
            tolerance = 1e-14 * singularity.condition * size
            np.testing.assert_allclose(radii, ellipsoid.radii, rtol=1e-9, atol=tolerance)


@pytest.mark.parametrize(
    ("count", "share"), [(20, 0.1), pytest.param(500, 0.2, marks=pytest.mark.slow)]
)
def test_a_humanoid_is_what_pinocchio_and_singular_values_say(count, share, rng):
    """To the last digits: poses, J_eq, its singular values, K*'s; and statuses are equal."""
    mechanism, many = unrecorded(humanoid()), pj.batch(humanoid())
    values = targets(mechanism, count, share, rng)
    poses = many.close(values, enforce_limits=False)
    found = many.measures(poses.q)
    ends = [single(mechanism, one)[0] for one in values]
    np.testing.assert_array_equal(poses.status == pj.Status.CLOSED, np.array(ends) == 1.0)
    assert np.mean(ends) > 0.9
    for k in np.flatnonzero(poses.status == pj.Status.CLOSED).tolist():
        q, pose = single(mechanism, values[k])[1], mechanism.configuration(poses.q[k])
        singularity = pose.singularity()
        np.testing.assert_allclose(poses.q[k], q, rtol=0.0, atol=1e-14 / singularity.smallest)
        jacobian = pose.jacobian()
        rounding = 2e-15 * singularity.condition * np.abs(jacobian.J_eq).max()
        np.testing.assert_allclose(found.J_eq[k], jacobian.J_eq, rtol=0.0, atol=rounding)
        blocks = (jacobian.Jv_eq, jacobian.Jw_eq)
        radii = [np.linalg.svd(block, compute_uv=False) for block in blocks]
        told = [found.velocity_radii[k], found.angular_radii[k]]
        np.testing.assert_allclose(told, radii, rtol=0.0, atol=rounding)
        assert found.smallest[k] == pytest.approx(singularity.smallest, rel=1e-12)
        assert found.condition[k] == pytest.approx(singularity.condition, rel=1e-12)


def test_measures_of_open_and_singular_poses():
    mechanism = pj.load("four_bar", {"l0": 2.0, "l1": 1.0, "l2": 2.0, "l3": 1.0})
    flat = mechanism.close([0.0], enforce_limits=False)
    found = pj.batch(mechanism).measures([flat.q, flat.q + 0.1])
    assert found.status.tolist() == [pj.Status.SINGULAR, pj.Status.OPEN]
    np.testing.assert_allclose(found.smallest[0], flat.singularity().smallest, atol=1e-14)
    np.testing.assert_allclose(found.position[0], flat.tool_pose().translation, atol=1e-14)
    assert np.isnan([found.smallest[1], found.position[1, 0], *found.velocity_radii.ravel()]).all()


def test_threads_change_no_bit(rng):
    mechanism = loaded("five_bar")
    many, values = pj.batch(mechanism), targets(mechanism, 9000, 0.1, rng)
    told = []
    alone = many.close(values, threads=1, progress=lambda *done: told.append(done))
    together, parted = many.close(values, threads=3), many.close(values[4096:8192], threads=1)
    for name in ("q", "share", "status"):
        np.testing.assert_array_equal(getattr(together, name), getattr(alone, name))
        np.testing.assert_array_equal(getattr(parted, name), getattr(alone, name)[4096:8192])
    assert told[-1] == (9000, 9000)
    assert len(told) == len(pieces_of(9000))
    for one in (many.jacobian, many.ellipsoids, many.measures):
        first, second = one(alone.q, threads=1), one(alone.q, threads=3)
        for name, array in vars(first).items():
            np.testing.assert_array_equal(getattr(second, name), array)
    with pytest.raises(pj.ArgumentError, match="threads must be"):
        many.close(values, threads=0)


NAMED = {
    "mapping": dict,
    "DataFrame": pandas.DataFrame,
    "records": lambda columns: pandas.DataFrame(columns).to_records(index=False),
    "Dataset": lambda columns: xarray.Dataset({k: ("time", v) for k, v in columns.items()}),
    "DataArray": lambda columns: pandas.DataFrame(columns).to_xarray().to_array("motor").T,
    "DataArray, turned": lambda columns: pandas.DataFrame(columns).to_xarray().to_array("motor"),
}


@pytest.mark.parametrize("kind", NAMED)
def test_motor_values_with_names_go_by_them(kind, rng):
    mechanism = loaded("three_rps")
    values = mechanism.home.actuated + 0.02 * rng.normal(size=(3, 3))
    columns = {name: values[:, mechanism.actuated.index(name)] for name in ("l3", "l1", "l2")}
    many = pj.batch(mechanism)
    np.testing.assert_array_equal(many.close(NAMED[kind](columns)).q, many.close(values).q)
    wrong = {"l1": columns["l1"], "l2": columns["l2"], "l4": columns["l3"]}
    with pytest.raises(pj.UnknownNameError, match="unknown motor 'l4'"):
        many.close(NAMED[kind](wrong))
    with pytest.raises(pj.ArgumentError, match="no value is given for motor 'l3'"):
        many.close(NAMED[kind]({"l1": columns["l1"], "l2": columns["l2"]}))
    with pytest.raises(pj.ArgumentError, match="joint 'theta1' is passive"):
        many.close(NAMED[kind]({**columns, "theta1": columns["l1"]}))


def test_columns_of_unlike_lengths():
    many = pj.batch(loaded("three_rps"))
    with pytest.raises(pj.ArgumentError, match=r"got shapes \(2,\), \(1,\), \(2,\)"):
        many.close({"l1": [1.0, 1.0], "l2": [1.0], "l3": [1.0, 1.0]})
    twice = xarray.DataArray(np.ones((2, 3)), {"m": ["l1", "l1", "l2"]}, ("k", "m"))
    with pytest.raises(pj.ArgumentError, match="by one twice"):
        many.close(twice)


@pytest.mark.parametrize("name", ["five_bar", "three_rps", "serial_2r"])
def test_no_poses_at_all(name):
    mechanism = loaded(name)
    many, n = pj.batch(mechanism), len(mechanism.actuated)
    poses = many.close(np.zeros((0, n)))
    assert poses.q.shape == (0, mechanism.nq)
    assert many.jacobian(poses.q).J_eq.shape == (0, 6, n)
    assert many.measures(poses.q).velocity_radii.shape == (0, 3)


def in_a_row(joint, limits):
    """A joint that carries a hinge, entries of q within ± limits."""
    model = pin.Model()
    one = model.addJoint(0, joint, pin.SE3.Identity(), "first")
    place = pin.SE3(np.eye(3), np.array([1.0, 0.0, 0.0]))
    two = model.addJoint(one, pin.JointModelRZ(), place, "hinge")
    model.addFrame(pin.Frame("tool", two, place, pin.FrameType.OP_FRAME))
    model.lowerPositionLimit, model.upperPositionLimit = -limits, limits
    return pj.Mechanism.from_pinocchio(model, [], ["first", "hinge"], "tool", name="in_a_row")


def turning():
    """A hinge without limits, (cos, sin) in q, that carries another: no loop sees its length."""
    return in_a_row(pin.JointModelRUBZ(), np.full(3, 10.0))


LONGER = np.array([2.0, 2.0, 1.0])


def test_turns_that_are_none_are_refused_by_a_program_as_by_the_single_call():
    mechanism = turning()
    q = np.array([mechanism.close([0.3, 0.4]).q] * 3)
    q[1] *= LONGER
    with pytest.raises(pj.ArgumentError, match="not of unit length"):
        pj.program(mechanism)(q)


def test_turns_in_few_digits_are_made_of_unit_length_wherever_they_are():
    """The caller's array stays as it is."""
    mechanism = turning()
    many, count = pj.batch(mechanism), PIECE + 10
    exact = np.tile(mechanism.close([0.3, 0.4]).q, (count, 1))
    given = exact.copy()
    given[-1] *= np.where(LONGER > 1.0, 1.0 + 1e-8, 1.0)
    before = given.copy()
    found, expected = many.ellipsoids(given).J_eq, many.ellipsoids(exact).J_eq
    np.testing.assert_allclose(found, expected, atol=1e-14)
    np.testing.assert_array_equal(given, before)


def test_turns_in_few_digits_are_made_of_unit_length():
    """Else J_eq is off by far more than its error estimate."""
    mechanism = turning()
    exact = mechanism.close([0.3, 0.4]).q
    expected = mechanism.configuration(exact).jacobian()
    short = exact * np.array([1.0 + 4e-7, 1.0 + 4e-7, 1.0])
    many = pj.batch(mechanism)
    found = many.jacobian([exact, short]).J_eq
    assert (np.abs(found[1] - expected.J_eq) <= expected.error_estimate).all()
    one = mechanism.configuration(short).jacobian()
    assert (np.abs(one.J_eq - expected.J_eq) <= one.error_estimate).all()
    np.testing.assert_array_equal(mechanism.configuration(exact).q, exact)


@pytest.mark.parametrize("elbow", [0.5, 1e-5, 1e-7, 1e-9, 1e-12, 0.0])
def test_points_that_hardly_span_a_tool_are_judged_alike(elbow):
    arm = loaded("serial_2r").with_tool(["base", "forearm", "forearm_end"])
    found = pj.batch(arm).jacobian([[0.3, elbow]])
    try:
        expected = arm.configuration([0.3, elbow]).jacobian().J_eq
    except pj.SingularError:
        assert found.status.tolist() == [pj.Status.SINGULAR]
        return
    assert found.status.tolist() == [pj.Status.CLOSED]
    np.testing.assert_allclose(found.J_eq[0], expected, atol=1e-12)


def test_near_singular_poses_have_the_digits_of_single_calls():
    """Where rates are refined: four of the forty modes are within 1e-5 of a singularity."""
    machine = loaded("stewart_gough_dietmaier")
    modes = pj.assembly_modes(machine, machine.home.actuated, rng=0, proof=False)
    found = pj.batch(machine).jacobian([mode.q for mode in modes])
    near = [k for k, mode in enumerate(modes) if mode.singularity().smallest < 1e-5]
    assert len(near) > 2
    for k in near:
        np.testing.assert_array_equal(found.J_eq[k], modes[k].jacobian().J_eq)


def test_a_target_too_far_away_has_the_share_of_the_single_call():
    mechanism = loaded("five_bar")
    far = mechanism.home.actuated + np.array([1e4, 0.3])
    with pytest.raises(pj.ClosureError) as caught:
        mechanism.close(far, enforce_limits=False)
    found = pj.batch(mechanism).close([far], enforce_limits=False)
    assert (found.status[0], found.share[0]) == (pj.Status.STOPPED, caught.value.share)
    np.testing.assert_array_equal(found.q[0], mechanism.home.q)


@pytest.mark.parametrize("name", SAMPLE)
def test_joints_of_many_poses_go_by_their_names(name, rng):
    mechanism = loaded(name)
    values = targets(mechanism, 3, 0.02, rng)
    poses = pj.batch(mechanism).close(values, enforce_limits=False)
    for joint, first in mechanism.configuration(poses.q[0]).joint_values.items():
        found = poses.joint(joint)
        assert found.shape == (3, *np.shape(first))
        for q, value in zip(poses.q, found, strict=True):
            alone = mechanism.configuration(q).joint_values[joint]
            np.testing.assert_allclose(value, alone, rtol=0, atol=1e-12)
    with pytest.raises(pj.UnknownNameError, match="joint"):
        poses.joint("nobody")


def test_what_is_learnt_of_one_guess_is_not_taken_for_another(rng):
    """Guesses on two assembly modes, in turn, by one batch."""
    mechanism = loaded("five_bar")
    many, home = pj.batch(mechanism), mechanism.home
    modes = pj.assembly_modes(mechanism, home.actuated)
    other = max(modes, key=lambda mode: np.abs(mode.q - home.q).max())
    values = targets(mechanism, 5, 0.05, rng)
    for guess in (home, other, home, other):
        found = many.close(values, guess=guess)
        expected = [mechanism.close(one, guess=guess).q for one in values]
        np.testing.assert_allclose(found.q, expected, atol=1e-10)
    assert np.abs(other.q - home.q).max() > 0.1


def geared_crank(ratio):
    """A crank that turns fully, geared to its motor; all joints turn for ever."""
    model, still = pin.Model(), pin.SE3.Identity()

    def along(x):
        return pin.SE3(np.eye(3), np.array([x, 0.0, 0.0]))

    model.addJoint(0, pin.JointModelRUBZ(), along(-2.0), "motor")
    crank = model.addJoint(0, pin.JointModelRUBZ(), still, "crank")
    coupler = model.addJoint(crank, pin.JointModelRUBZ(), along(1.0), "coupler")
    rocker = model.addJoint(0, pin.JointModelRUBZ(), along(4.0), "rocker")
    model.addFrame(pin.Frame("tip", coupler, along(3.0), pin.FrameType.OP_FRAME))
    model.addFrame(pin.Frame("end", rocker, along(3.5), pin.FrameType.OP_FRAME))
    gear = pj.JointLoop(joints=("motor", "crank"), ratio=ratio)
    loops, home = [pj.PointLoop(frames=("tip", "end")), gear], {"crank": 0.9, "rocker": 1.8}
    home["motor"] = 0.9 / ratio
    return pj.Mechanism.from_pinocchio(model, loops, ["motor"], "tip", home=home, name="geared")


@pytest.mark.parametrize("ratio", [-2.0, 1.0, 3.0, -5.0])
def test_a_gear_between_endless_joints_counts_their_turns(ratio, rng):
    """To seven turns of the crank; the program leaves none of them to the single call."""
    many, mechanism = pj.batch(geared_crank(ratio)), unrecorded(geared_crank(ratio))
    values = np.append(rng.uniform(-9.0, 9.0, 14), [-9.0, 9.0])[:, None]
    poses = many.close(values, enforce_limits=False)
    assert (poses.status == pj.Status.CLOSED).all()
    start = np.tile(mechanism.home.q, (len(values), 1))
    ends = np.empty_like(start), np.empty(len(values))
    assert many._closing.together(start, values, ends).settled.all()
    for joint, turns in (("motor", values[:, 0]), ("crank", ratio * values[:, 0])):
        index = mechanism.model.joints[mechanism.model.getJointId(joint)].idx_q
        expected = np.column_stack([np.cos(turns), np.sin(turns)])
        np.testing.assert_allclose(poses.q[:, index : index + 2], expected, atol=1e-12)
    for value, q, J_eq in zip(values, poses.q, many.jacobian(poses.q).J_eq, strict=True):
        pose = mechanism.close(value, enforce_limits=False)
        np.testing.assert_allclose(q, pose.q, atol=1e-10)
        np.testing.assert_allclose(J_eq, pose.jacobian().J_eq, atol=1e-10)


@pytest.mark.parametrize("led", ["elbow1", "sway1a"])
def test_where_some_motors_lead_the_others_single_calls_know_the_way(led, rng):
    """A Delta with a further motor, which loops lead: half of the targets agree with each other."""
    given = loaded("delta")
    mechanism = pj.Mechanism.from_pinocchio(
        given.model,
        resolved(given),
        [*given.actuated, led],
        given.spec.tool.frame,
        home=given.home.q,
    )
    partition, home = mechanism.problem.partition, given.home.actuated
    assert partition.constraint_rank > partition.passive_rank
    ways = rng.uniform(-0.2, 0.2, (12, home.size))
    values = np.array([mechanism.configuration(given.close(home + way).q).actuated for way in ways])
    values[::2] += rng.uniform(-0.1, 0.1, values[::2].shape)
    found = pj.batch(mechanism).close(values)
    assert set(found.status) == {pj.Status.CLOSED, pj.Status.STOPPED}
    for k, target in enumerate(values):
        if found.status[k] == pj.Status.CLOSED:
            np.testing.assert_allclose(mechanism.close(target).q, found.q[k], atol=1e-10)
        else:
            with pytest.raises(pj.ClosureError):
                mechanism.close(target)
