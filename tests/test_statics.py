"""Efforts and forces in the loops that balance a load."""

from __future__ import annotations

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from test_dynamics import away, heavy, parallelogram
from transformed import moved, rebuilt

import pmjac_pin as pj


def left_over(configuration, statics, wrench, springs=()):
    """What is not balanced on the tree's freedoms, by Pinocchio."""
    mechanism = configuration.mechanism
    model, split = mechanism.model, configuration.split_jacobian()
    load = pin.computeGeneralizedGravity(model, model.createData(), configuration.q)
    for column, stiffness, stretched in springs:
        load[column] += stiffness * stretched
    held = split.tool_jacobian.T @ wrench + split.constraint_jacobian.T @ statics.loop_forces
    held[mechanism.problem.partition.actuated] += statics.efforts
    return held - load


def column_size(mechanism):
    return mechanism.problem.partition.column_scale


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_everything_is_in_equilibrium(name, rng):
    configuration = away(heavy(name, rng), rng)
    wrench = rng.normal(size=6)
    statics = configuration.statics(wrench)
    np.testing.assert_allclose(left_over(configuration, statics, wrench), 0, atol=1e-9)
    J_eq, gravity = configuration.jacobian().J_eq, configuration.dynamics().gravity
    np.testing.assert_allclose(statics.efforts, gravity - J_eq.T @ wrench, atol=1e-9)
    lonely = configuration.statics(wrench, gravity=False).efforts
    np.testing.assert_allclose(lonely, -J_eq.T @ wrench, atol=1e-9)


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_what_redundant_rows_may_do_to_each_other(name, rng):
    configuration = away(heavy(name, rng), rng)
    statics = configuration.statics()
    constraint = configuration.split_jacobian().constraint_jacobian
    redundant = len(constraint) - configuration.singularity().constraint_rank
    assert statics.self_stress.shape == (len(constraint), redundant)
    np.testing.assert_allclose(constraint.T @ statics.self_stress, 0, atol=1e-9)
    assert statics.determinate == (redundant == 0)
    row = configuration.mechanism.problem.partition.row_scale
    across = (statics.self_stress / row[:, None]).T @ (statics.loop_forces / row)
    np.testing.assert_allclose(
        across, 0, atol=1e-9 * max(1.0, np.abs(statics.loop_forces).max(initial=0.0))
    )


@pytest.mark.parametrize(
    ("name", "more"), [("five_bar", "phi1"), ("three_rps", "theta1"), ("four_bar", "phi1")]
)
def test_motors_against_each_other(name, more, rng):
    """The smallest efforts of all that balance a load; the others are told."""
    mechanism = pj.load(name)
    tied = pj.load(name, actuated=[*mechanism.actuated, more])
    wrench = rng.normal(size=6)
    configuration = tied.configuration(mechanism.home.q)
    statics = configuration.statics(wrench, gravity=False)
    assert statics.internal_efforts.shape == (len(tied.actuated), 1)
    one = np.append(mechanism.home.statics(wrench, gravity=False).efforts, 0.0)
    scale = column_size(tied)[tied.problem.partition.actuated]
    apart = statics.efforts - one
    way = statics.internal_efforts[:, 0]
    np.testing.assert_allclose(apart, way * (apart @ way) / (way @ way), atol=1e-9)
    assert np.linalg.norm(scale * statics.efforts) <= np.linalg.norm(scale * one) + 1e-12
    np.testing.assert_allclose((scale * statics.efforts) @ (scale * way), 0, atol=1e-9)
    np.testing.assert_allclose(left_over(configuration, statics, wrench), 0, atol=1e-9)


def some_frames(mechanism, rng, count=3):
    """Frames of moving bodies, each in one place of its name."""
    model = mechanism.model
    names = {frame.name: frame.parentJoint for frame in model.frames}
    chosen = rng.permutation(sorted(name for name, joint in names.items() if joint))[:count]
    return [str(name) for name in chosen]


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_wrenches_on_several_frames_do_the_work_of_the_motors(name, rng):
    """τ δθ + Σ wᵀ δx = 0, of poses by Pinocchio that are closed on both sides; and they add up."""
    configuration = away(heavy(name, rng), rng)
    mechanism, h = configuration.mechanism, 1e-4
    model, data = mechanism.model, mechanism.model.createData()
    wrenches = {frame: rng.normal(size=6) for frame in some_frames(mechanism, rng)}
    statics = configuration.statics(wrenches, gravity=False)

    def poses(theta):
        there = mechanism.close(theta, guess=configuration, enforce_limits=False)
        pin.framesForwardKinematics(model, data, there.q)
        return {frame: data.oMf[model.getFrameId(frame)].copy() for frame in wrenches}

    def way(step, frame):
        one, other = (poses(configuration.actuated + by)[frame] for by in (-step, step))
        turned = pin.log3(other.rotation @ one.rotation.T)
        return np.r_[other.translation - one.translation, turned]

    for k in range(len(mechanism.actuated)):
        step = np.zeros(configuration.actuated.size)
        step[k] = h
        slope = {f: (8 * way(step, f) - way(2 * step, f)) / (12 * h) for f in wrenches}
        work = sum(wrenches[frame] @ slope[frame] for frame in wrenches)
        assert statics.efforts[k] == pytest.approx(-work, rel=1e-7, abs=1e-7)
    alone = [configuration.statics({f: w}, gravity=False) for f, w in wrenches.items()]
    for what in ("efforts", "loop_forces"):
        added = sum(getattr(each, what) for each in alone)
        size = max(1.0, np.abs(added).max(initial=0.0))
        np.testing.assert_allclose(getattr(statics, what), added, atol=1e-10 * size)


@pytest.mark.parametrize("name", ["agile_eye", "bennett", "four_bar", "three_rps", "watt_six_bar"])
def test_the_loops_hold_wrenches_on_both_of_their_ends(name, rng):
    """Forces on every freedom of the tree, by Pinocchio's own Jacobians of the frames."""
    configuration = away(heavy(name, rng), rng)
    mechanism = configuration.mechanism
    model, data = mechanism.model, mechanism.model.createData()
    wrenches = {frame: rng.normal(size=6) for frame in mechanism.spec.loops[0].frames}
    aligned = pin.LOCAL_WORLD_ALIGNED
    pushed = sum(
        pin.computeFrameJacobian(model, data, configuration.q, model.getFrameId(frame), aligned).T
        @ wrench
        for frame, wrench in wrenches.items()
    )
    left = left_over(configuration, configuration.statics(wrenches), np.zeros(6))
    np.testing.assert_allclose(left + pushed, 0, atol=1e-9)


FRAMES = ("LOCAL_WORLD_ALIGNED", "LOCAL", "WORLD")


@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.parametrize("name", ["three_rps", "five_bar", "ur5", "ankle"])
def test_a_wrench_is_written_in_a_frame(name, frame, rng):
    """Of a machine that stands elsewhere, by the Jacobian of the tool in that frame."""
    place = pin.SE3(pin.exp3(rng.normal(size=3)), rng.normal(size=3) * 100.0)
    configuration = moved(pj.load(name), place).home
    wrench = rng.normal(size=6)
    found = configuration.statics(wrench, frame=frame, gravity=False)
    wanted = -configuration.jacobian(frame).J_eq.T @ wrench
    np.testing.assert_allclose(found.efforts, wanted, atol=1e-10 * max(1.0, np.abs(wanted).max()))
    tool = configuration.tool_pose()
    turned = np.r_[tool.rotation @ wrench[:3], tool.rotation @ wrench[3:]]
    aligned = {
        "LOCAL": turned,
        "WORLD": wrench - np.r_[np.zeros(3), np.cross(tool.translation, wrench[:3])],
        "LOCAL_WORLD_ALIGNED": wrench,
    }[frame]
    same = configuration.statics(aligned, gravity=False).loop_forces
    size = 1e-9 * max(1.0, np.abs(same).max(initial=0.0), np.abs(aligned).max())
    np.testing.assert_allclose(found.loop_forces, same, atol=size)


def test_a_wrench_on_three_frames_is_forces_at_their_origins(rng):
    configuration = away(pj.load("three_rps"), rng)
    tops = tuple(loop.frames[0] for loop in configuration.mechanism.spec.loops)
    force, wrench = np.r_[rng.normal(size=3), np.zeros(3)], rng.normal(size=6)
    one = configuration.statics({tops: force}, gravity=False)
    other = configuration.statics(dict.fromkeys(tops, force / 3.0), gravity=False)
    np.testing.assert_allclose(one.efforts, other.efforts, atol=1e-12)
    np.testing.assert_allclose(one.loop_forces, other.loop_forces, atol=1e-12)
    J_eq = configuration.jacobian(tool=tops).J_eq
    found = configuration.statics({tops: wrench}, gravity=False).efforts
    np.testing.assert_allclose(found, -J_eq.T @ wrench, atol=1e-12)


def test_without_a_tool_there_is_weight_and_what_acts_on_named_frames(rng):
    whole = heavy("four_bar", rng)
    model, spec = whole.model, whole.spec
    bare = pj.Mechanism.from_pinocchio(model, spec.loops, spec.actuated, home=whole.home.q).home
    np.testing.assert_allclose(bare.statics().efforts, whole.home.statics().efforts, atol=1e-12)
    frame, wrench = spec.tool.frame, rng.normal(size=6)
    wanted = whole.home.statics(wrench)
    np.testing.assert_allclose(bare.statics({frame: wrench}).efforts, wanted.efforts, atol=1e-12)
    with pytest.raises(pj.NoToolError):
        bare.statics(wrench)


def test_a_spring_in_a_passive_joint():
    """τ = Φ k (x − x₀): of a parallelogram's rocker, Φ = 1."""
    configuration = parallelogram(0.7).home
    statics = configuration.statics(gravity=False, springs={"rocker": (5.0, 0.2)})
    assert statics.efforts[0] == pytest.approx(5.0 * 0.5, abs=1e-12)
    column = configuration.mechanism.coordinates.columns(["rocker"])[0]
    model = configuration.mechanism.model
    model.gravity = pin.Motion.Zero()
    still = rebuilt(configuration.mechanism, model)
    resting = left_over(still.home, statics, np.zeros(6), [(column, 5.0, 0.5)])
    np.testing.assert_allclose(resting, 0, atol=1e-12)


def some_springs(mechanism, rng, count=4):
    """Springs of some joints of one freedom, motors or not, and what they stretch."""
    model, home = mechanism.model, mechanism.home.joint_values
    single = [name for name, value in home.items() if isinstance(value, float)]
    chosen = [str(name) for name in rng.permutation(sorted(single))[:count]]
    springs = {name: (rng.uniform(1.0, 9.0), home[name] + rng.normal()) for name in chosen}
    entries = {name: model.joints[model.getJointId(name)].idx_q for name in chosen}

    def energy(configuration):
        return sum(
            0.5 * stiffness * (configuration.q[entries[name]] - rest) ** 2
            for name, (stiffness, rest) in springs.items()
        )

    assert all(model.joints[model.getJointId(name)].nq == 1 for name in chosen)
    return springs, energy


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_efforts_against_springs_are_the_slope_of_their_energy(name, rng):
    """Through the closure, weight by Pinocchio's potential energy."""
    configuration = away(heavy(name, rng), rng)
    mechanism, h = configuration.mechanism, 1e-3
    model, data = mechanism.model, mechanism.model.createData()
    springs, of_springs = some_springs(mechanism, rng)

    def energies(theta):
        there = mechanism.close(theta, guess=configuration, enforce_limits=False)
        return np.array([of_springs(there), pin.computePotentialEnergy(model, data, there.q)])

    statics = configuration.statics(gravity=False, springs=springs)
    whole = configuration.statics(springs=springs)
    for k, step in enumerate(h * np.eye(len(mechanism.actuated))):
        near, far = (
            energies(configuration.actuated + t * step)
            - energies(configuration.actuated - t * step)
            for t in (1, 2)
        )
        found = (8 * near - far) / (12 * h)
        assert statics.efforts[k] == pytest.approx(found[0], rel=1e-6, abs=1e-6)
        assert whole.efforts[k] == pytest.approx(found.sum(), rel=1e-6, abs=1e-6)
    resting = configuration.dynamics(springs=springs).bias
    np.testing.assert_allclose(whole.efforts, resting, atol=1e-9 * max(1.0, np.abs(resting).max()))


def test_a_spring_of_what_turns_without_end_goes_the_shorter_way():
    model = pin.Model()
    joint = model.addJoint(0, pin.JointModelRUBZ(), pin.SE3.Identity(), "wheel")
    model.addFrame(pin.Frame("tip", joint, 0, pin.SE3.Identity(), pin.FrameType.OP_FRAME))
    wheel = pj.Mechanism.from_pinocchio(model, [], ["wheel"], "tip")
    efforts = wheel.close([-3.0]).statics(springs={"wheel": (2.0, 3.0)}).efforts
    assert efforts[0] == pytest.approx(2.0 * (2.0 * np.pi - 6.0), abs=1e-12)


def test_a_rod_pulls_along_itself():
    """RSSR: the crank's torque is the moment of the rod's force, 2 l λ along the rod."""
    mechanism = mechanisms.rssr(rod=False)
    configuration, wrench = mechanism.close([0.9]), np.array([3.0, -2.0, 1.0, 0, 0, 0])
    statics = configuration.statics(wrench, gravity=False)
    model, data = mechanism.model, mechanism.model.createData()
    pin.framesForwardKinematics(model, data, configuration.q)
    one, other = (
        data.oMf[model.getFrameId(name)].translation for name in ("crank_tip", "rocker_tip")
    )
    way = (one - other) / mechanisms.RSSR["rod"]
    pull = 2 * mechanisms.RSSR["rod"] * statics.loop_forces[0] * way  # on the crank
    assert statics.efforts[0] == pytest.approx(-np.cross(one, pull)[2], abs=1e-12)
    hub = np.array([1.5, 0.5, 0.2])
    about = np.cross(other - hub, wrench[:3] - pull)  # of the rocker, about its axis
    assert about[1] == pytest.approx(0.0, abs=1e-12)


def test_a_cubic_hexapod():
    """Legs along a closed path of six edges of a cube: √2 four times and 1/√2 twice, published."""
    path = np.array([[1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1], [1, 0, 1]]) - 0.5
    legs = [(path[k], path[(k + 1) % 6])[:: 1 if k % 2 == 0 else -1] for k in range(6)]
    base, top = (np.array(ends) for ends in zip(*legs, strict=True))
    mechanism = pj.stewart(base, top, pin.SE3.Identity())
    statics = [mechanism.home.statics(wrench, gravity=False).efforts for wrench in np.eye(6)]
    values = np.linalg.svd(np.linalg.inv(statics), compute_uv=False)
    np.testing.assert_allclose(values, [2**0.5] * 4 + [0.5**0.5] * 2, atol=1e-12)


def test_what_idles_under_its_own_weight_is_in_no_equilibrium():
    mechanism = mechanisms.rssr()
    model = mechanism.model
    rod = model.getJointId("rz")
    model.inertias[rod] = pin.Inertia(2.0, np.array([1.0, 0.2, 0.0]), 0.02 * np.eye(3))
    mechanism = rebuilt(mechanism, model)
    with pytest.raises(pj.NoEquilibriumError, match=r"drives what idles \(r"):
        mechanism.home.statics()
    assert mechanism.home.statics(gravity=False).efforts == pytest.approx(0.0)
    model.gravity = pin.Motion(1e-12 * model.gravity.linear, np.zeros(3))  # little is not nothing
    with pytest.raises(pj.NoEquilibriumError, match="drives what idles"):
        rebuilt(mechanism, model).home.statics()


def test_what_idles_may_carry_the_tool_where_nothing_drives_it(rng):
    """A force on the rod's own line does not spin it; one beside it does."""
    configuration = mechanisms.rssr("rod_side").home
    model, data = configuration.mechanism.model, configuration.mechanism.model.createData()
    pin.framesForwardKinematics(model, data, configuration.q)
    ends, side = (
        [data.oMf[model.getFrameId(name)].translation for name in names]
        for names in (("crank_tip", "rocker_tip"), ("rod_side",))
    )
    way = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    lever = side[0] - ends[0]
    outwards = lever - (lever @ way) * way
    for force in (way, outwards, rng.normal() * way + rng.normal() * outwards):
        statics = configuration.statics(np.r_[force, np.zeros(3)], gravity=False)
        wrench = np.r_[force, np.zeros(3)]
        np.testing.assert_allclose(left_over(configuration, statics, wrench), 0, atol=1e-12)
    with pytest.raises(pj.NoEquilibriumError, match="drives what idles"):
        configuration.statics(np.r_[np.cross(way, outwards), np.zeros(3)], gravity=False)


def test_at_a_singular_pose_nothing_is_half_computed():
    mechanism = mechanisms.rocker_rocker()
    l0, l1, l2, l3 = mechanism.parameters.values()
    fold = np.arccos((l0**2 + l1**2 - (l2 + l3) ** 2) / (2 * l0 * l1))
    with pytest.raises(pj.SingularError):
        mechanism.close([fold], enforce_limits=False).statics()


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"wrench": [1.0, 2.0]}, r"a wrench: 6 numbers expected, got shape \(2,\)"),
        ({"springs": {"phi3": (1.0, 0.0)}}, "unknown joint 'phi3'"),
        ({"springs": {"phi1": 3.0}}, r"takes \(stiffness, value at rest\)"),
        ({"springs": [1]}, "springs are a mapping"),
        ({"gravity": "no"}, "gravity"),
        ({"wrench": {"rocker_tp": np.zeros(6)}}, "unknown frame 'rocker_tp'; did you mean"),
        ({"wrench": {"rocker_tip": [1.0]}}, r"the wrench on 'rocker_tip': 6 numbers expected"),
        ({"wrench": {3: np.zeros(6)}}, "a tool is one frame or three, got 3"),
        ({"wrench": {("rocker_tip",) * 2: np.zeros(6)}}, "a tool is one frame or three"),
        ({"frame": "TOOL"}, "frame must be LOCAL, WORLD or LOCAL_WORLD_ALIGNED, got 'TOOL'"),
    ],
)
def test_loads_that_are_none(asked, message):
    with pytest.raises(pj.PmjacError, match=message):
        pj.load("four_bar").home.statics(**asked)


@pytest.mark.parametrize(
    "name", ["four_bar", "watt_six_bar", "three_rps", "stewart_gough", "delta"]
)
def test_no_cut_is_special(name, rng):
    """Efforts do not depend on where the loops are cut; nor do forces in loops that are in both."""
    mechanism = heavy(name, rng, rotors=False)
    load = {mechanism.spec.tool.frame: rng.normal(size=6)}
    spring = {mechanism.actuated[0]: (rng.uniform(1.0, 9.0), rng.normal())}
    known, cuts = mechanism.home.statics(load, springs=spring), 0
    joints = [joint for joint in mechanism.passive if joint in mechanism.coordinates.names]
    for joint in joints[:4]:
        try:
            cut = pj.recut(mechanism, joint)
        except pj.ArgumentError:
            continue
        found = cut.home.statics(load, springs=spring).efforts
        np.testing.assert_allclose(found, known.efforts, atol=1e-9 * np.abs(known.efforts).max())
        cuts += 1
    assert cuts


def test_reactions_in_a_four_bar_by_its_free_bodies(rng):
    """Three bodies in the plane, four pins and a torque: nine equations by hand."""
    theta = 0.9
    mechanism = parallelogram(theta)
    model = mechanism.model
    for joint in range(1, model.njoints):
        lever = np.append(rng.normal(size=2) * 0.3, 0.0)
        model.inertias[joint] = pin.Inertia(rng.uniform(1, 4), lever, 0.1 * np.eye(3))
    configuration = rebuilt(mechanism, model).home
    push = rng.normal(size=2) * 10.0
    statics = configuration.statics({"coupler": np.r_[push, np.zeros(4)]})
    data = model.createData()
    pin.forwardKinematics(model, data, configuration.q)
    pins = {"A": (0.0, 0.0), "B": data.oMi[2].translation[:2], "D": (1.0, 0.0)}
    pins["C"] = data.oMi[2].act(np.array([1.0, 0.0, 0.0]))[:2]
    # Unknown: forces at A on the crank, at B on the coupler, at C on the coupler, at D on the
    # rocker, and the motor's torque on the crank.
    matrix, right = np.zeros((9, 9)), np.zeros(9)
    acting = {0: {"A": 1, "B": -1}, 1: {"B": 1, "C": 1}, 2: {"C": -1, "D": 1}}
    for body, forces in acting.items():
        rows = slice(3 * body, 3 * body + 3)
        for letter, sign in forces.items():
            column = 2 * "ABCD".index(letter)
            x, y = pins[letter]
            matrix[rows, column : column + 2] = sign * np.array([[1, 0], [0, 1], [-y, x]])
        inertia = model.inertias[body + 1]
        centre = data.oMi[body + 1].act(inertia.lever)[:2]
        weight = inertia.mass * model.gravity.linear[:2]
        right[rows] = -np.r_[weight, centre[0] * weight[1] - centre[1] * weight[0]]
    x, y = pins["B"]  # where the coupler's frame is
    right[3:6] -= np.r_[push, x * push[1] - y * push[0]]
    matrix[2, 8] = 1.0
    solved = np.linalg.solve(matrix, right)
    assert statics.efforts[0] == pytest.approx(solved[8], abs=1e-9)
    # The loop's row is p(tip) − p(end): λ acts on the coupler's tip, and against it on the rocker.
    np.testing.assert_allclose(statics.loop_forces[:2], solved[4:6], atol=1e-9)
