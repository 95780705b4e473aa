"""Reach: motor values that put a tool at a target, and every other answer by its name."""

from __future__ import annotations

import hand_reach as hand
import numpy as np
import pinocchio as pin
import pytest
import transformed
from mechanisms import CATALOGUE, loaded, random_closed
from scipy.optimize import minimize

import pmjac_pin as pj
from pmjac_pin.model.tool_rows import TWIST_ROWS

TURN = pin.SE3(pin.exp3(np.array([0.4, -1.1, 0.7])), np.array([0.2, -0.1, 0.4]))
FAR = pin.SE3(np.eye(3), np.array([5.1e6, -4.3e6, 120.0]))


def nearby(name, rng, spread=0.1):
    """Two closed poses of a machine, the motors at most `spread` apart."""
    mechanism = loaded(name)
    while True:
        [start] = random_closed(mechanism, rng, 1, 0.2)
        step = spread * rng.uniform(-1.0, 1.0, len(mechanism.actuated))
        try:
            return start, mechanism.close(start.actuated + step, guess=start)
        except (pj.ClosureError, pj.LimitError):
            continue


@pytest.mark.parametrize("guess", ["near", "home"])
@pytest.mark.parametrize("name", CATALOGUE)
def test_reach_takes_back_what_close_does(name, guess, rng):
    start, wanted = nearby(name, rng)
    mechanism = wanted.mechanism
    guessed = start if guess == "near" else "home"
    found = pj.reach(mechanism, wanted.tool_pose(), guess=guessed)
    assert found.status == "reached"
    assert max(found.error) < 1e-9
    np.testing.assert_allclose(found.actuated, wanted.actuated, rtol=0.0, atol=1e-9)
    assert found.configuration.mechanism is mechanism


@pytest.mark.parametrize("name", CATALOGUE)
def test_a_position_is_met_whatever_freedom_it_leaves(name, rng):
    start, wanted = nearby(name, rng, 0.03)
    found = pj.reach(wanted.mechanism, wanted.tool_pose().translation, guess=start)
    assert found.status == "reached"
    there = found.configuration.tool_pose().translation
    length = wanted.mechanism.characteristic_length
    np.testing.assert_allclose(there, wanted.tool_pose().translation, atol=1e-9 * length)


WAYS = {
    "far": lambda mechanism: transformed.moved(mechanism, FAR),
    "turned": lambda mechanism: transformed.moved(mechanism, TURN),
    "in mm": lambda mechanism: transformed.scaled(mechanism, 1e3),
    "in km": lambda mechanism: transformed.scaled(mechanism, 1e-3),
}


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", ["five_bar", "head_6rss", "planar_3rrr", "three_rps", "ur5"])
def test_wherever_a_machine_stands_and_however_large_it_is(name, way, rng):
    mechanism = WAYS[way](loaded(name))
    length = mechanism.characteristic_length
    slides = [mechanism.units[one] == "m" for one in mechanism.actuated]
    size = np.where(slides, length, 1.0)
    step = 0.1 * size * rng.uniform(-1.0, 1.0, size.size)
    wanted = mechanism.close(mechanism.home.actuated + step, enforce_limits=False)
    found = pj.reach(mechanism, wanted.tool_pose(), limits=False)
    assert found.status == "reached"
    apart = np.abs(found.actuated - wanted.actuated) / size
    assert apart.max() < (1e-9 if way != "far" else 1e3 * mechanism.tolerance / length)


@pytest.mark.parametrize("beside", [1e-3, 1e-6, 1e-9])
def test_beside_where_a_leg_is_straight(beside):
    """The first arm of the five-bar but for a share of its length: angles change as its root."""
    bar = loaded("five_bar")
    lengths = list(bar.parameters.values())
    tip = (lengths[1] + lengths[2]) * (1.0 - beside) * np.array([np.cos(1.2), np.sin(1.2)])
    found = pj.reach(bar, {"x": tip[0], "y": tip[1]})
    assert found.status == "reached"
    by_hand = hand.five_bar_angles(tip, *lengths)
    apart = np.abs(np.exp(1j * found.actuated)[:, None] - np.exp(1j * by_hand))
    assert apart.min(axis=1).max() < 1e-13 / np.sqrt(beside)


def test_a_machine_that_is_singular_at_home_starts_from_there():
    """At home the 3-RPS moves its tool up and down alone: its position tells nothing there."""
    machine = loaded("three_rps")
    wanted = machine.close(machine.home.actuated + np.array([0.05, -0.03, 0.02]))
    found = pj.reach(machine, wanted.tool_pose())
    assert found.status == "reached"
    np.testing.assert_allclose(found.actuated, wanted.actuated, atol=1e-9)


# --- Ways of the motors past singular poses of the tool's -----------------------------------------

LEGS = np.array([[0.12341784, 0.21453378], [0.75866957, 0.0324598], [0.22517956, 0.43032779]])
CORNERS = np.array([[0.0, 0.0], [-0.46960217, -0.39316454], [-0.24451585, -0.45161321]])


def legs_of(place):
    """The legs (3, 2) of a 3-RPR whose plate is at x, y, angle, and its corners from its middle."""
    x, y, angle = place
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    corners = CORNERS @ turn.T
    return corners + np.array([x, y]) - LEGS, corners


def determinant(place):
    """Of the lines of the legs, in Plücker coordinates: 0 where they meet in one point."""
    legs, corners = legs_of(place)
    along = legs / np.linalg.norm(legs, axis=1)[:, None]
    moments = corners[:, 0] * along[:, 1] - corners[:, 1] * along[:, 0]
    return np.linalg.det(np.column_stack([along, moments]))


def plate_on_three_legs(place):
    """The 3-RPR, its plate hung on the first leg."""
    model, home = pin.Model(), {}
    limits = [np.array([one]) for one in (10.0, 10.0, -50.0, 50.0)]
    for k, leg in enumerate(legs_of(place)[0]):
        base = pin.SE3(np.eye(3), np.array([*LEGS[k], 0.0]))
        turn = model.addJoint(0, pin.JointModelRZ(), base, f"turn{k}", *limits)
        end = model.addJoint(turn, pin.JointModelPX(), pin.SE3.Identity(), f"slide{k}", *limits)
        home |= {f"turn{k}": np.arctan2(leg[1], leg[0]), f"slide{k}": np.linalg.norm(leg)}
        if not k:
            plate = model.addJoint(end, pin.JointModelRZ(), pin.SE3.Identity(), "plate", *limits)
        ends = [(f"end{k}", end, np.zeros(2)), (f"corner{k}", plate, CORNERS[k])]
        for name, joint, at in ends:
            pose = pin.SE3(np.eye(3), np.array([*at, 0.0]))
            model.addFrame(pin.Frame(name, joint, pose, pin.FrameType.OP_FRAME))
    home["plate"] = place[2] - home["turn0"]
    loops = [pj.PointLoop(frames=(f"corner{k}", f"end{k}")) for k in (1, 2)]
    motors = ["slide0", "slide1", "slide2"]
    rows = ["vx", "vy", "wz"]
    return pj.Mechanism.from_pinocchio(model, loops, motors, "corner0", home=home, tool_rows=rows)


@pytest.mark.parametrize(("share", "told"), [(0.04, "straight"), (1.0, "the motors lose it")])
def test_motors_lead_past_singular_poses_of_the_straight_way(share, told):
    """Where the lines of the legs meet in one point twice on the tool's way, that is told."""
    start, end = (
        np.array([0.192892687, 0.144578369, -0.0894170812]),
        np.array([-2.753, 0.26, -3.09]),
    )
    ways = [determinant(start + share * s * (end - start)) for s in np.linspace(0.0, 1.0, 200)]
    crossings = np.count_nonzero(np.diff(np.sign(ways)))
    assert crossings == (0 if told == "straight" else 2)
    place = start + share * (end - start)
    target = pin.SE3(pin.exp3(np.array([0.0, 0.0, place[2]])), np.array([*place[:2], 0.0]))
    found = pj.reach(plate_on_three_legs(start), target)
    assert found.status == "reached"
    assert found.message.endswith(told)
    lengths = np.linalg.norm(legs_of(place)[0], axis=1)
    np.testing.assert_allclose(found.actuated, lengths, rtol=0.0, atol=1e-9)


# --- Out of reach ---------------------------------------------------------------------------------


@pytest.mark.parametrize("radius", [0.05, 1.9, 4.0])
def test_an_arm_of_two_links_reaches_an_annulus(radius):
    arm = loaded("serial_2r")
    l1, l2 = arm.parameters.values()
    target = radius * np.array([np.cos(0.7), np.sin(0.7), 0.0])
    found = pj.reach(arm, target)
    assert found.status == "out of reach"
    assert found.error.linear == pytest.approx(max(radius - l1 - l2, l1 - l2 - radius), abs=1e-12)
    assert found.error.angular == 0.0
    straight = 0.0 if radius > l1 else np.pi
    assert abs(abs(found.actuated[1]) - straight) < 1e-6
    assert not found


def test_at_its_end_the_arm_is_straight():
    arm = loaded("serial_2r")
    found = pj.reach(arm, [sum(arm.parameters.values()), 0.0, 0.0])
    assert found.status == "reached"
    np.testing.assert_allclose(found.actuated, 0.0, atol=1e-6)


@pytest.mark.parametrize("tip", [(0.15, 0.9), (-0.6, 0.5)])
def test_a_five_bar_reaches_where_two_annuli_meet(tip):
    """Beyond both, the nearest point is where their outer circles meet, or on one of them."""
    bar = loaded("five_bar")
    l0, l1, l2, l3, l4 = bar.parameters.values()
    found = pj.reach(bar, {"x": tip[0], "y": tip[1]})
    corner = np.array([l0 / 2, np.sqrt((l1 + l2) ** 2 - l0**2 / 4)])
    first, second = np.zeros(2), np.array([l0, 0.0])
    on_second = second + (l3 + l4) * (tip - second) / np.linalg.norm(tip - second)
    on_first = first + (l1 + l2) * (tip - first) / np.linalg.norm(tip - first)
    candidates = [corner]
    candidates += [on_second] if np.linalg.norm(on_second - first) <= l1 + l2 else []
    candidates += [on_first] if np.linalg.norm(on_first - second) <= l3 + l4 else []
    nearest = min(np.linalg.norm(tip - one) for one in candidates)
    assert found.status == "out of reach"
    assert found.error.linear == pytest.approx(nearest, abs=1e-9)


def test_what_the_tool_never_does_must_fit():
    found = pj.reach(loaded("serial_2r"), [1.0, 1.0, 0.1])
    assert found.status == "out of reach"
    assert found.error.linear == pytest.approx(0.1, abs=1e-12)
    delta = loaded("delta_rods")
    tilted = delta.home.tool_pose() * pin.SE3(pin.exp3(np.array([0.2, 0.0, 0.0])), np.zeros(3))
    found = pj.reach(delta, tilted)
    assert found.status == "out of reach"
    assert found.error == pytest.approx((0.0, 0.2), abs=1e-9)


# --- Limits, singular poses, other branches -------------------------------------------------------


def test_a_leg_ends_where_its_limit_is():
    platform = loaded("stewart_gough")
    start = platform.home.tool_pose()
    found = pj.reach(platform, pin.SE3(start.rotation, start.translation + 3.0 * np.eye(3)[2]))
    assert found.status == "at a limit"
    [joint] = found.joints
    longest = platform.limits(joint)[1]
    assert found.actuated.max() == pytest.approx(longest, abs=2e-9)
    assert found.configuration.joint_values[joint] == found.actuated.max()
    # It has gone straight up until there, and its legs are as long as the pose says.
    there = found.configuration.tool_pose()
    np.testing.assert_allclose(there.rotation, start.rotation, atol=1e-12)
    np.testing.assert_allclose(there.translation[:2], start.translation[:2], atol=1e-12)
    assert (there.translation - start.translation)[2] == pytest.approx(3.0 * found.share, abs=1e-9)
    beyond = pj.reach(platform, there * pin.SE3(np.eye(3), np.array([0, 0, 0.1])), limits=False)
    assert beyond.status == "reached"


def limited(name, joint, lower, upper):
    """A machine of the catalogue, one joint kept between two values."""
    mechanism = loaded(name)
    model = mechanism.model
    entry = model.joints[model.getJointId(joint)].idx_q
    model.lowerPositionLimit[entry], model.upperPositionLimit[entry] = lower, upper
    return transformed.rebuilt(mechanism, model)


def test_a_passive_joint_ends_the_way_at_its_limit():
    longest = loaded("slider_crank").home.joint_values["x"] + 0.05
    machine = limited("slider_crank", "x", 0.5, longest)
    target = machine.home.tool_pose()
    target.translation += 0.1 * np.eye(3)[0]
    found = pj.reach(machine, target)
    assert (found.status, found.joints) == ("at a limit", ("x",))
    assert found.configuration.joint_values["x"] == pytest.approx(longest, abs=2e-9)
    assert found.share == pytest.approx(0.5, abs=1e-8)
    assert pj.reach(machine, target, limits=False).status == "reached"


def test_motors_lose_the_tip_of_a_five_bar_where_its_distal_links_are_in_line():
    """Straight down from home, the tip comes to lie between its elbows."""
    bar = loaded("five_bar")
    l0, l1, l2, _, _ = bar.parameters.values()
    found = pj.reach(bar, {"x": l0 / 2, "y": -0.35})
    lost = np.sqrt(l1**2 - (l2 - l0 / 2) ** 2)
    assert found.status == "singular"
    assert found.configuration.tool_pose().translation[1] == pytest.approx(lost, abs=1e-8)
    assert found.configuration.singularity().kind == "gain"


def signs(bar, pose):
    """How both arms of a five-bar are bent, and on which side of its elbows the tip is."""
    l0, l1, _, _, l4 = bar.parameters.values()
    (theta1, theta2), tip = pose.actuated, pose.tool_pose().translation[:2]
    first = l1 * np.array([np.cos(theta1), np.sin(theta1)])
    second = np.array([l0, 0.0]) + l4 * np.array([np.cos(theta2), np.sin(theta2)])
    one, other = tip - first, tip - second
    bends = [joint > 0.0 for joint in np.sin(pose.passive)]
    return (*bends, one[0] * other[1] - one[1] * other[0] > 0.0)


@pytest.mark.slow
def test_what_is_reached_is_on_the_branch_of_the_guess(rng):
    """Beyond where the annuli of a five-bar meet nothing is reached, and no way changes a mode."""
    bar = loaded("five_bar")
    l0, l1, l2, l3, l4 = bar.parameters.values()
    statuses = set()
    for x, y in rng.uniform([-0.6, -0.7], [0.9, 0.75], (16, 2)):
        found = pj.reach(bar, {"x": x, "y": y})
        within = abs(l1 - l2) <= np.hypot(x, y) <= l1 + l2
        within &= abs(l3 - l4) <= np.hypot(x - l0, y) <= l3 + l4
        if found:
            assert signs(bar, found.configuration) == signs(bar, bar.home)
        assert within or found.status in ("out of reach", "singular")
        assert not (within and found.status == "out of reach")
        statuses.add(found.status)
    assert {"reached", "out of reach"} <= statuses


def test_another_branch_is_told_with_a_pose_on_it():
    """Across the hole of its annulus, an arm's shoulder has no room for the elbow that it has."""
    arm, (l1, l2) = (
        limited("serial_2r", "theta1", -1.0, 3.0),
        loaded("serial_2r").parameters.values(),
    )
    near, far = np.array([0.9, 0.05, 0.0]), np.array([-0.9, 0.05, 0.0])
    bend = np.arccos((near @ near - l1**2 - l2**2) / (2 * l1 * l2))
    aside = np.arctan2(l2 * np.sin(bend), l1 + l2 * np.cos(bend))
    start = arm.close([np.arctan2(0.05, 0.9) + aside, -bend])
    np.testing.assert_allclose(start.tool_pose().translation, near, atol=1e-12)
    found = pj.reach(arm, far, guess=start)
    other = [np.arctan2(0.05, -0.9) - aside, bend]
    assert np.arctan2(0.05, -0.9) + aside > 3.0 > other[0]
    assert found.status == "on another branch"
    turned = np.exp(1j * (found.elsewhere.actuated - other))
    np.testing.assert_allclose(turned, 1.0, atol=1e-8)
    # The last pose on the way is at the hole, the elbow folded.
    last = found.configuration.tool_pose().translation
    np.testing.assert_allclose(last, [np.sqrt((l1 - l2) ** 2 - 0.05**2), 0.05, 0.0], atol=1e-6)
    assert pj.reach(arm, far, guess=start, limits=False).status == "reached"


# --- Tasks ----------------------------------------------------------------------------------------


def test_a_self_motion_is_the_least(rng):
    """θ₀ − θ is a combination of the rows of J: no self-motion brings it nearer."""
    arm = loaded("ur5")
    start = arm.close(arm.home.actuated + rng.uniform(-0.2, 0.2, 6))
    target = start.tool_pose().translation + np.array([0.05, -0.1, 0.07])
    for posture in (None, arm.home.actuated):
        found = pj.reach(arm, target, guess=start, posture=posture)
        assert found.status == "reached"
        assert found.error.linear < 1e-9
        wanted = start.actuated if posture is None else posture
        away, rows = wanted - found.actuated, found.configuration.jacobian().Jv_eq
        along = away - np.linalg.pinv(rows) @ rows @ away
        np.testing.assert_allclose(along, 0.0, atol=1e-9)


def limited_arm(lengths, limits, home):
    """An arm in a plane, its joints within limits."""
    model, joint = pin.Model(), 0
    for k, (lower, upper) in enumerate(limits):
        place = pin.SE3(np.eye(3), np.array([lengths[k - 1] if k else 0.0, 0.0, 0.0]))
        bounds = [np.array([one]) for one in (10.0, 10.0, lower, upper)]
        joint = model.addJoint(joint, pin.JointModelRZ(), place, f"joint{k}", *bounds)
    tip = pin.SE3(np.eye(3), np.array([lengths[-1], 0.0, 0.0]))
    model.addFrame(pin.Frame("tip", joint, tip, pin.FrameType.OP_FRAME))
    names = [f"joint{k}" for k in range(len(limits))]
    return pj.Mechanism.from_pinocchio(model, [], names, "tip", home=home)


def test_within_limits_a_self_motion_is_the_least_or_said_not_to_be():
    """Beside another minimiser, of another kind, which starts from the answer."""
    rng, least = np.random.default_rng(1), 0
    while least < 20:
        lengths, postures = rng.uniform(0.3, 1.0, 4), rng.uniform(-2.0, 2.0, 4)
        limits = np.sort(rng.uniform(-2.0, 2.0, (4, 2)), axis=1)
        inside = limits[:, :1] + rng.uniform(0.05, 0.95, (4, 2)) * np.ptp(limits, axis=1)[:, None]
        arm = limited_arm(lengths, limits.tolist(), inside[:, 0])

        def tip(q, lengths=lengths):
            return lengths @ np.column_stack([np.cos(np.cumsum(q)), np.sin(np.cumsum(q))])

        target = tip(inside[:, 1])
        found = pj.reach(arm, {"x": target[0], "y": target[1]}, posture=postures)
        if not found or "may move less" in found.message:
            continue
        assert not found.configuration.limits_violated
        least += 1
        other = minimize(
            lambda q, wanted=postures: np.sum((q - wanted) ** 2),
            found.actuated,
            constraints=[{"type": "eq", "fun": lambda q, t=target, tip=tip: tip(q) - t}],
            bounds=limits,
            method="SLSQP",
            options={"ftol": 1e-13},
        )
        meets = other.success and np.abs(tip(other.x) - target).max() < 1e-8
        away = np.linalg.norm(found.actuated - postures)
        assert not (meets and np.sqrt(other.fun) < away - 1e-5)


def test_a_posture_beyond_a_limit_leads_up_to_it():
    limits = [(-1.0, 1.0)] * 4
    arm = limited_arm([1.0, 0.8, 0.6, 0.5], limits, [0.3, 0.4, 0.2, 0.1])
    found = pj.reach(arm, {"x": 1.5, "y": 1.2}, posture=[5.0, 0.4, 0.2, 0.1])
    assert found.message == "the target is met, straight"
    np.testing.assert_array_equal(found.actuated[2:], 1.0)  # q₁ and q₂ follow from the target


def test_pointing_and_headings():
    arm = loaded("ur5")
    towards = np.array([0.3, -0.2, -0.9])
    found = pj.reach(arm, towards, task=pj.Task.pointing())
    pointing = found.configuration.tool_pose().rotation[:, 2]
    np.testing.assert_allclose(pointing, towards / np.linalg.norm(towards), atol=1e-9)
    at = arm.home.tool_pose().translation
    found = pj.reach(arm, {"x": at[0], "y": at[1] + 0.05, "angle": 0.4})
    there = found.configuration.tool_pose()
    assert np.arctan2(there.rotation[1, 0], there.rotation[0, 0]) == pytest.approx(0.4, abs=1e-9)
    np.testing.assert_allclose(there.translation[:2], at[:2] + np.array([0.0, 0.05]), atol=1e-9)


def two_arms():
    """Two arms of two links each, on one motor that moves both: five motors, two tools."""
    model = pin.Model()
    base = model.addJoint(0, pin.JointModelPX(), pin.SE3.Identity(), "base")
    for side, y in (("left", 0.3), ("right", -0.3)):
        place = pin.SE3(np.eye(3), np.array([0.0, y, 0.0]))
        upper = model.addJoint(base, pin.JointModelRZ(), place, f"{side} 1")
        link = pin.SE3(np.eye(3), np.array([1.0, 0.0, 0.0]))
        lower = model.addJoint(upper, pin.JointModelRZ(), link, f"{side} 2")
        model.addFrame(pin.Frame(f"{side}_hand", lower, link, pin.FrameType.OP_FRAME))
    motors = ["base", "left 1", "left 2", "right 1", "right 2"]
    home = {"left 1": 0.5, "left 2": 0.7, "right 1": -0.5, "right 2": -0.7}
    return pj.Mechanism.from_pinocchio(model, [], motors, "left_hand", home=home, name="two arms")


@pytest.mark.parametrize("named", [False, True])
def test_several_tools_at_once(named):
    arms, tools = two_arms(), ["left_hand", "right_hand"]
    targets = [[1.0, 1.2, 0.0], [1.1, -1.1, 0.0]]
    if named:
        found = pj.reach(arms, dict(zip(tools, targets, strict=True)))
    else:
        found = pj.reach(arms, targets, tool=tools)
    assert found.status == "reached"
    for tool, target in zip(tools, targets, strict=True):
        there = found.configuration.tool_pose(tool).translation
        np.testing.assert_allclose(there, target, atol=1e-9)


@pytest.mark.parametrize("mask", [[1, 0, 1, 0, 0, 0], [1, 1, 1, 1, 1, 0], [0, 1, 0, 0, 0, 1]])
def test_a_mask_is_the_task_of_its_rows(mask):
    arm = loaded("ur5")
    target = arm.close(arm.home.actuated + 0.1).tool_pose()
    rows = [name for name, counts in zip(TWIST_ROWS, mask, strict=True) if counts]
    found = pj.reach(arm, target, mask=np.array(mask, dtype=bool))
    by_rows = pj.reach(arm, target, task=pj.Task.of(rows))
    assert found.status == by_rows.status == "reached"
    np.testing.assert_array_equal(found.actuated, by_rows.actuated)
    whole = pj.reach(arm, target)
    assert np.abs(found.actuated - whole.actuated).max() > 1e-3  # what is free moves less


def test_a_mask_tells_working_modes_what_counts():
    """The five-bar's position has 4; a coupler that is turned as wanted leaves one of its arm."""
    bar = loaded("five_bar")
    target = bar.home.tool_pose()
    count = {True: 2, False: 4}
    for turned, modes in count.items():
        found = pj.working_modes(bar, target, mask=[1, 1, 0, 0, 0, turned], rng=0)
        assert (len(found), found.evidence.kind) == (modes, "proof")


def test_an_ankles_joints_are_its_transmissions(rng):
    ankle = loaded("humanoid_ankle")
    transmission = pj.transmission(ankle, ["pitch", "roll"])
    for joints in rng.uniform([-0.4, -0.15], [0.25, 0.15], (4, 2)):
        found = pj.reach(ankle, dict(zip(["pitch", "roll"], joints.tolist(), strict=True)))
        np.testing.assert_allclose(found.actuated, transmission.at_joints(joints).motors, atol=1e-9)
        assert found.error.angular < 1e-12


BAD = {
    "two numbers": (lambda m: pj.reach(m, [1.0, 2.0]), "coordinates by name.*; got 2 numbers"),
    "shape": (lambda m: pj.reach(m, np.ones((3, 2))), "shape"),
    "no rotation": (lambda m: pj.reach(m, np.ones((4, 4))), "rotation"),
    "no coordinate": (lambda m: pj.reach(m, {"tip": {"u": 1.0}}), "coordinates"),
    "empty": (lambda m: pj.reach(m, {}), "names nothing"),
    "tools": (lambda m: pj.reach(m, [[0, 0, 0]], tool=["tip", "tip2"]), "2 tools"),
    "unknown coordinate": (
        lambda m: pj.reach(m, {"x": 0.2, "thet1": 0.1}),
        "unknown coordinate or joint 'thet1'; did you mean 'theta1'",
    ),
    "a coordinate and a joint": (
        lambda m: pj.reach(m, {"x": 0.2, "theta1": 0.1}),
        "not both: 'x' is the tool's",
    ),
    "one tool twice": (
        lambda m: pj.reach(m, [[0, 0.4, 0], [0, 0.3, 0]], tool=["tip", "tip"]),
        "the tool 'tip' has two targets",
    ),
    "task": (lambda m: pj.reach(m, [0, 0, 0], task=pj.Task.pose()), "give a pose"),
    "mask and task": (
        lambda m: pj.reach(m, [0, 0, 0], task=pj.Task.position(), mask=[1, 1, 1, 0, 0, 0]),
        "`task` and `mask`",
    ),
    "five booleans": (lambda m: pj.reach(m, [0, 0, 0], mask=[True] * 5), "six booleans, of vx"),
    "no booleans": (lambda m: pj.reach(m, [0, 0, 0], mask=[1, 2, 0, 0, 0, 0]), "six booleans"),
    "mask of text": (lambda m: pj.reach(m, [0, 0, 0], mask="111000"), "six booleans"),
    "mask of nothing": (lambda m: pj.reach(m, [0, 0, 0], mask=[False] * 6), "leaves nothing"),
    "mask of a turn": (lambda m: pj.reach(m, [0, 0, 0], mask=[1, 1, 1, 0, 0, 1]), "give a pose"),
    "mask of a coordinate": (lambda m: pj.reach(m, {"x": 0.2}, mask=[1, 1, 1, 0, 0, 0]), "`mask`"),
    "task of joints": (
        lambda m: pj.reach(m, {"theta1": 0.2}, task=pj.Task.position()),
        "values of joints say themselves",
    ),
    "text": (lambda m: pj.reach(m, "far"), "shape|numbers"),
    "machine": (lambda m: pj.reach("five_bar", [0, 0, 0]), "Mechanism"),
    "posture": (lambda m: pj.reach(m, [0, 0.4, 0], posture=[1.0]), "expected"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_told(case):
    asked, told = BAD[case]
    error = pj.UnknownNameError if case == "unknown coordinate" else pj.ArgumentError
    with pytest.raises(error, match=told):
        asked(loaded("five_bar"))
