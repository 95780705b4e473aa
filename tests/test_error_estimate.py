"""The error of J_eq that is told, against machines by hand with fifty digits."""

from __future__ import annotations

import contextlib
import pickle

import hand_precise as hand
import mechanisms
import mpmath as mp
import numpy as np
import pinocchio as pin
import pytest
import transformed

import pmjac_pin as pj

DISTANCES = (1e-3, 1e-5, 1e-7, 1e-9, 1e-10)
TURN = 2.0943951023931953  # of the legs of the 3-RPS, as the URDF writes it


def joint(mechanism, name):
    return mechanism.model.jointPlacements[mechanism.model.getJointId(name)].translation


def frame(mechanism, name):
    return mechanism.model.frames[mechanism.model.getFrameId(name)].placement.translation


def four_bar(pose):
    mechanism = pose.mechanism
    l0, l1 = joint(mechanism, "phi1")[0], joint(mechanism, "phi2")[0]
    names = ("coupler_tip", "rocker_tip", "coupler_midpoint")
    machine = hand.FourBar(l0, l1, *(frame(mechanism, name)[0] for name in names))
    return machine.jacobian(pose.actuated, pose.passive)


def slider_crank(pose):
    mechanism = pose.mechanism
    sizes = joint(mechanism, "beta")[0], frame(mechanism, "rod_tip")[0], joint(mechanism, "x")[1]
    return hand.SliderCrank(*sizes).jacobian(pose.actuated, pose.passive)


def three_rps(pose):
    mechanism, legs = pose.mechanism, (1, 2, 3)
    feet = [joint(mechanism, f"theta{k}") for k in legs]
    corners = [frame(mechanism, f"S{k}") for k in legs]
    place, quaternion = np.split(np.array(platform(pose)), [3])
    machine = hand.ThreeRPS(feet, (0.0, TURN, -TURN), corners, quaternion)
    leans = [pose.joint_values[f"theta{k}"] for k in legs]
    return machine.jacobian(pose.actuated, [*leans, *place, 0.0, 0.0, 0.0])


def platform(pose):
    start = pose.mechanism.model.joints[pose.mechanism.model.getJointId("platform")].idx_q
    return pose.q[start : start + 7]


def check(poses, oracle, frame="LOCAL_WORLD_ALIGNED", turned=lambda J, pose: J):
    """Never below the error; return how far above it, for each pose, and the relative errors."""
    above, relative = [], []
    for pose in poses:
        jacobian = pose.jacobian(frame)
        estimate = jacobian.error_estimate
        errors = hand.errors(jacobian.J_eq, turned(oracle(pose), pose))
        assert (errors <= estimate).all()
        above.append(estimate.max() / max(errors.max(), 1e-300))
        relative.append(errors.max() / np.abs(jacobian.J_eq).max())
    return np.array(above), np.array(relative)


def beside(mechanism, fold, rng, count):
    """Poses of a machine of one motor beside its fold, and how far away each is."""
    for distance in DISTANCES:
        for _ in range(count):
            away = mp.mpf(distance * rng.uniform(0.5, 1.5))
            yield mechanism.close([float(fold - away)])


def rocker(l0, l1, l2, l3):
    """A four-bar whose crank cannot turn around, and where it stops, with all digits."""
    mechanism = pj.load("four_bar", {"l0": l0, "l1": l1, "l2": l2, "l3": l3})
    with mp.workdps(hand.DIGITS):
        sides = (joint(mechanism, "phi1")[0], joint(mechanism, "phi2")[0])
        l0, l1 = (mp.mpf(float(x)) for x in sides)
        reach = sum(mp.mpf(float(frame(mechanism, n)[0])) for n in ("coupler_tip", "rocker_tip"))
        return mechanism, mp.acos((l0**2 + l1**2 - reach**2) / (2 * l0 * l1))


@pytest.mark.parametrize(
    "lengths", [(4.0, 3.0, 2.5, 2.0), (4.1, 3.3, 1.7, 2.9), (5.0, 3.9, 2.0, 2.3)]
)
def test_a_four_bar_beside_its_fold(lengths, rng):
    mechanism, fold = rocker(*lengths)
    with mp.workdps(hand.DIGITS):
        poses = list(beside(mechanism, fold, rng, 4))
    above, relative = check(poses, four_bar)
    assert np.median(above) < 1e3
    assert above.min() > 1.0
    # The square of the condition: near the fold, far more than cond(K*) 1e-16.
    conditions = np.array([pose.singularity().condition for pose in poses])
    assert np.median(relative / (1e-16 * conditions)) > 10.0
    assert np.median(relative / (1e-16 * conditions**2)) < 10.0


@pytest.mark.slow
@pytest.mark.parametrize("sizes", [(1.3, 0.7, 0.1), (0.8, 0.5, 0.0), (1.0, 0.6, -0.2)])
def test_a_slider_crank_beside_its_fold(sizes, rng):
    r, length, e = sizes
    mechanism = pj.load("slider_crank", {"r": r, "l": length, "e": e})
    with mp.workdps(hand.DIGITS):
        rod, crank = frame(mechanism, "rod_tip")[0], joint(mechanism, "beta")[0]
        line = joint(mechanism, "x")[1]
        fold = mp.asin((mp.mpf(float(rod)) + mp.mpf(float(line))) / mp.mpf(float(crank)))
        poses = list(beside(mechanism, fold, rng, 4))
    assert np.median(check(poses, slider_crank)[0]) < 1e3


def towards_a_singularity(mechanism, rng):
    """Poses on the way from a singularity where a random path ends, nearer and nearer to it."""
    start = mechanism.pose("lecture_a")
    way = rng.normal(size=3)
    with pytest.raises(pj.ClosureError) as caught:
        mechanism.close(start.actuated + 4.0 * way, guess="lecture_a", enforce_limits=False)
    end = caught.value.reached.actuated
    back = (start.actuated - end) / np.linalg.norm(start.actuated - end)
    for distance in (1e-1, 1e-3, 1e-5, 1e-7):
        pose = mechanism.close(end + distance * back, guess="lecture_a")
        if not pose.singularity().is_singular:
            yield pose


def test_a_spatial_machine(rng):
    """The 3-RPS anywhere, and beside its singularities."""
    mechanism = pj.load("three_rps")
    poses = []
    for name in mechanism.poses:
        start = mechanism.pose(name)
        for _ in range(3):
            with contextlib.suppress(pj.ClosureError):
                motors = start.actuated + rng.uniform(-0.1, 0.1, 3)
                poses.append(mechanism.close(motors, guess=name))
    assert len(poses) > 3
    poses += towards_a_singularity(mechanism, rng)
    assert np.median(check(poses, three_rps)[0]) < 1e3


@pytest.mark.parametrize("frame", ["LOCAL", "WORLD"])
def test_other_frames_turn_with_the_error_of_the_pose(frame, rng):
    """In LOCAL, the axes themselves are off; in WORLD, what is at the origin."""
    mechanism, fold = rocker(4.0, 3.0, 2.5, 2.0)

    def turned(J, pose):
        lengths = joint(mechanism, "phi2")[0], frame_of("coupler_midpoint")
        with mp.workdps(hand.DIGITS):
            place = precise_place(pose, *lengths)
            if frame == "LOCAL":
                c, s = mp.cos(place[2]), mp.sin(place[2])
                vx, vy = c * J[0, 0] + s * J[1, 0], -s * J[0, 0] + c * J[1, 0]
            else:
                vx, vy = J[0, 0] + place[1] * J[5, 0], J[1, 0] - place[0] * J[5, 0]
            return mp.matrix([vx, vy, 0, 0, 0, J[5, 0]])

    def frame_of(name):
        return mechanism.model.frames[mechanism.model.getFrameId(name)].placement.translation[0]

    def precise_place(pose, crank, half):
        names = ("coupler_tip", "rocker_tip", "coupler_midpoint")
        machine = hand.FourBar(joint(mechanism, "phi1")[0], crank, *map(frame_of, names))
        x = machine.solved(pose.actuated, pose.passive)
        tool = machine.tool(mp.matrix([float(pose.actuated[0])]), x)
        return tool[0], tool[1], tool[5]

    with mp.workdps(hand.DIGITS):
        poses = list(beside(mechanism, fold, rng, 3))
    assert np.median(check(poses, four_bar, frame, turned)[0]) < 1e3


def test_a_pose_that_is_given_is_as_far_off_as_its_gap(rng):
    """Within the tolerance, but not to the last digits, as from a file."""
    mechanism, fold = rocker(4.0, 3.0, 2.5, 2.0)
    passive = mechanism.problem.partition.passive
    poses = []
    with mp.workdps(hand.DIGITS):
        for pose in beside(mechanism, fold - mp.mpf("0.01"), rng, 4):
            q = pose.q.copy()
            q[passive] += 1e-13 * rng.normal(size=2)
            poses.append(mechanism.configuration(q))
    above, relative = check(poses, four_bar)
    assert np.median(above) < 1e3
    assert relative.max() > 1e-13


@pytest.mark.parametrize("away", ["0.3", "0.01", "0.001"])
def test_all_rows_may_be_open_at_once(away):
    """Each row of a pose that is given is open by its own gap, to whichever side."""
    mechanism, fold = rocker(4.0, 3.0, 2.5, 2.0)
    passive = mechanism.problem.partition.passive
    with mp.workdps(hand.DIGITS):
        pose = mechanism.close([float(fold - mp.mpf(away))])
    K_star = pose.jacobian().K_star
    poses = []
    for sides in ((1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)):
        q = pose.q.copy()
        q[passive] += np.linalg.solve(K_star, 1e-12 * np.array(sides))
        poses.append(mechanism.configuration(q))
    above, _ = check(poses, four_bar)
    assert above.min() < 10.0


def test_without_loops_only_rounding_is_left():
    pose = pj.load("serial_2r").close([0.3, 0.4])
    estimate = pose.jacobian().error_estimate
    assert estimate.shape == (6, 2)
    assert 0.0 < estimate.max() < 1e-13


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_two_ways_to_one_pose_differ_by_no_more(name, rng):
    """Closed from another start, and cut elsewhere: the same J_eq, as exactly as is told."""
    mechanism = pj.load(name)
    try:
        one = mechanism.home.jacobian()
    except pj.NoJacobianError:
        pytest.skip("no J_eq at home")
    estimate = one.error_estimate
    assert np.isfinite(estimate).all()
    assert not estimate.flags.writeable
    assert (estimate.max(axis=1).reshape(2, 3).max(axis=1) <= 1e-9 * (one.sizes + 1.0)).all()
    for pose in mechanisms.random_closed(mechanism, rng, 2, spread=0.05):
        again = mechanism.close(mechanism.home.actuated, guess=pose)
        other = again.jacobian()
        if (
            np.abs(again.tool_pose().homogeneous - mechanism.home.tool_pose().homogeneous).max()
            < 1e-6
        ):
            assert (np.abs(one.J_eq - other.J_eq) <= estimate + other.error_estimate).all()


@pytest.mark.parametrize(
    ("name", "cut"), [("four_bar", "phi1"), ("watt_six_bar", "B"), ("three_rps", "theta1")]
)
def test_two_cuts_differ_by_no_more(name, cut):
    mechanism = pj.load(name)
    one, other = mechanism.home.jacobian(), pj.recut(mechanism, cut).home.jacobian()
    bound = one.error_estimate + other.error_estimate
    assert (np.abs(one.J_eq - other.J_eq) <= bound).all()


TURNED = pin.SE3(pin.exp3(np.array([0.4, -1.1, 0.7])), np.zeros(3))
WAYS = {
    "1 km away": lambda m: transformed.moved(m, pin.SE3(np.eye(3), np.array([1e3, -300.0, 7.0]))),
    "1e7 m away": lambda m: transformed.moved(m, pin.SE3(np.eye(3), np.array([1e6, 1e7, 0.0]))),
    "turned": lambda m: transformed.moved(m, TURNED),
    "fewer frames": transformed.with_needed_frames_only,
}


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", [name for name in mechanisms.CATALOGUE if name != "ur5"])
def test_the_same_machine_written_another_way_differs_by_no_more(name, way):
    """Far away its coordinates are rounded, and the estimate knows."""
    mechanism = pj.load(name)
    one, other = mechanism.home.jacobian(), WAYS[way](mechanism).home.jacobian()
    turn = np.kron(np.eye(2), TURNED.rotation if way == "turned" else np.eye(3))
    bound = np.abs(turn) @ one.error_estimate + other.error_estimate
    assert (np.abs(turn @ one.J_eq - other.J_eq) <= bound).all()


def test_nothing_is_told_of_matrices_from_elsewhere(rng):
    C, J = rng.normal(size=(2, 3)), rng.normal(size=(6, 3))
    partition = pj.Partition.from_matrices(C, J, [0], [1, 2])
    jacobian = pj.equivalent_jacobian(pj.SplitJacobian(C, J, "LOCAL", partition))
    assert np.isnan(jacobian.error_estimate).all()
    assert jacobian.error_estimate.shape == (6, 1)


def test_too_near_to_a_fold_nothing_is_known():
    """Numbers that are rounded, and a fold: whether it closes there at all is not known."""
    mechanism, fold = rocker(4.0, 3.0, 2.5, 2.0)
    near = mechanism.close([float(fold) - 1e-6])
    loose = pj.Mechanism.from_pinocchio(
        mechanism.model,
        mechanism.spec.loops,
        ["theta1"],
        "coupler_midpoint",
        home=near.q,
        tolerance=1e-5,
    )
    q = near.q.copy()
    q[loose.problem.partition.passive] += 1e-6
    pose = loose.configuration(q)
    assert np.isinf(pose.jacobian().error_estimate).all()
    assert np.isfinite(near.jacobian().error_estimate).all()


def test_it_is_found_when_asked_for_and_kept():
    home = pj.load("three_rps").home
    jacobian = home.jacobian()
    assert "error_estimate" not in vars(jacobian)
    assert jacobian.error_estimate is jacobian.error_estimate
    again = pickle.loads(pickle.dumps(home.jacobian("LOCAL")))
    np.testing.assert_allclose(
        again.error_estimate, home.jacobian("LOCAL").error_estimate, rtol=1e-3
    )


def on_a_rail(size):
    """A four-bar of this size whose ground, crank's pivot and rocker's, is on a slide."""
    model = pin.Model()
    for name, parent, kind, x in (
        ("rail", 0, pin.JointModelPX(), 0.0),
        ("crank", 1, pin.JointModelRZ(), 0.0),
        ("coupler", 2, pin.JointModelRZ(), 0.25 * size),
        ("rocker", 1, pin.JointModelRZ(), size),
    ):
        place = pin.SE3(np.eye(3), np.array([x, 0.0, 0.0]))
        model.addJointFrame(model.addJoint(parent, kind, place, name))
    for name, joint, x in (("tip", 3, 0.75 * size), ("end", 4, 0.625 * size)):
        place = pin.SE3(np.eye(3), np.array([x, 0.0, 0.0]))
        model.addFrame(pin.Frame(name, joint, place, pin.FrameType.OP_FRAME), False)
    loops = [pj.PointLoop(frames=("tip", "end"))]
    home = {"crank": 0.9, "coupler": -0.6, "rocker": 1.2}
    return pj.Mechanism.from_pinocchio(model, loops, ["rail", "crank"], "tip", home=home)


@pytest.mark.parametrize(("size", "far"), [(1.0, 1e3), (1.0, 1e6), (1e-3, 50.0), (1e-3, 1e3)])
def test_a_machine_that_a_slide_carries_far_away(size, far, rng):
    """There, J_eq is that of home's place but for the estimate, and no other mode is met."""
    machine = on_a_rail(size)
    met = 0
    for crank in rng.uniform(-3.0, 3.0, 20):
        here = machine.close([0.0, crank])
        guess = {**here.joint_values, "rail": far}
        try:
            there = machine.close([far, crank], guess=guess)
        except pj.ClosureError as error:
            assert "tolerance" in str(error)
            continue
        met += 1
        near, away = here.jacobian(), there.jacobian()
        apart = np.abs(away.J_eq - near.J_eq)
        assert (apart <= near.error_estimate + away.error_estimate).all()
        assert (apart <= 1e-3 * np.abs(near.J_eq).max() + 1e-15 * far / size).all()
    assert met > 10


@pytest.mark.parametrize("gear", [1.0, 50.0])
@pytest.mark.parametrize("away", [1e-2, 1e-5, 1e-8, 1e-10])
def test_an_arm_beside_its_fold_leaves_the_others_exact(gear, away):
    """A motor geared to a crank that moves a slide with the tool, and a lever near its fold."""
    model = pin.Model()
    for name, kind, x in (
        ("motor", pin.JointModelRZ(), -1.0),
        ("crank", pin.JointModelRZ(), 0.0),
        ("slide", pin.JointModelPX(), 0.0),
        ("lever", pin.JointModelRZ(), 1.9),
    ):
        place = pin.SE3(np.eye(3), np.array([x, 0.0, 0.0]))
        model.addJointFrame(model.addJoint(0, kind, place, name))
    for name, joint, x in (("pin", 2, 0.3), ("end", 4, 0.5)):
        place = pin.SE3(np.eye(3), np.array([x, 0.0, 0.0]))
        model.addFrame(pin.Frame(name, joint, place, pin.FrameType.OP_FRAME), False)
    rod = 1.3  # the lever is in line with it where the pin is at 1.8 m from its pivot
    loops = [
        pj.JointLoop(joints=("motor", "crank"), ratio=gear),
        pj.DistanceLoop(frames=("pin", "slide"), length=1.0),
        pj.DistanceLoop(frames=("pin", "end"), length=rod),
    ]
    fold = float(np.arccos((1.9**2 + 0.3**2 - (rod + 0.5) ** 2) / (2 * 1.9 * 0.3)))

    def values(turn):
        x, y = 0.3 * np.cos(turn), 0.3 * np.sin(turn)
        reach = np.hypot(1.9 - x, y)
        bend = np.arccos((0.25 + reach**2 - rod**2) / reach)
        lever = np.arctan2(y, x - 1.9) - bend
        return {
            "motor": turn / gear,
            "crank": turn,
            "slide": x + np.sqrt(1 - y * y),
            "lever": lever,
        }

    machine = pj.Mechanism.from_pinocchio(model, loops, ["motor"], "slide", home=values(0.5 * fold))
    pose = machine.close([(fold - away) / gear])
    turn = pose.joint_values["crank"]
    x, y = 0.3 * np.cos(turn), 0.3 * np.sin(turn)
    jacobian = pose.jacobian()
    expected = -gear * y * (1.0 + x / np.sqrt(1.0 - y * y))
    error = abs(jacobian.J_eq[0, 0] - expected)
    assert error <= jacobian.error_estimate[0, 0] + 1e-15 * abs(expected)
    assert error <= 1e-13 * abs(expected)
