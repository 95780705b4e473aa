"""Margins in metres and radians: textbook angles and distances, play of joints, and invariance."""

from __future__ import annotations

from math import inf, pi

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from hand_planar import unit
from mechanisms import four_bar_cut_at, loaded, random_poses
from test_singularity_types import (
    five_bar_collinear,
    five_bar_stretched,
    homed_at,
    three_rrr_lines_in_a_point,
)
from transformed import moved, rebuilt, scaled

import pmjac_pin as pj


def margins_of(pose):
    return pose.singularity().margins


def acute(a, b):
    """The angle between two lines, up to a right one."""
    a, b = (np.append(v, np.zeros(3 - len(v))) for v in (a, b))
    return np.arctan2(np.linalg.norm(np.cross(a, b)), abs(np.dot(a, b)))


def from_line(point, start, along):
    return abs(along[0] * (point - start)[1] - along[1] * (point - start)[0]) / np.hypot(*along)


def joint_places(pose):
    """Where the joints are, and their axes z, by Pinocchio alone."""
    model = pose.mechanism.model
    data = model.createData()
    pin.computeJointJacobians(model, data, pose.q)
    return {name: data.oMi[k].copy() for k, name in enumerate(model.names)}


@pytest.mark.parametrize("theta", [0.3, 1.4, 2.9, 4.4])
def test_the_four_bar_has_its_transmission_angle(theta):
    """Law of cosines on the diagonal from the crank's tip to the rocker's pivot."""
    l0, l1, l2, l3 = mechanisms.CRANK_ROCKER
    squared = l0**2 + l1**2 - 2 * l0 * l1 * np.cos(theta)
    between = np.arccos((l2**2 + l3**2 - squared) / (2 * l2 * l3))
    found = margins_of(loaded("four_bar").close([theta]))
    for joint, link in (("phi1", l3), ("phi2", l2)):
        assert found.gain[joint].transmission == pytest.approx(min(between, pi - between), abs=1e-9)
        assert found.gain[joint].arm == pytest.approx(link * np.sin(between), abs=1e-9)
        assert found.gain[joint].angle == pytest.approx(pi / 2, abs=1e-9)


@pytest.mark.parametrize("theta", [0.3, 1.4, 2.9, 4.4])
def test_the_four_bars_motor_pushes_its_rocker_along_the_coupler(theta):
    l0, l1, _, l3 = mechanisms.CRANK_ROCKER
    bar = pj.load("four_bar", tool="rocker_tip").close([theta])
    tip = l1 * unit(theta)
    coupler = np.array([l0, 0.0]) + l3 * unit(bar.joint_values["phi1"]) - tip
    margin = margins_of(bar).loss["theta1"]
    assert margin.arm == pytest.approx(from_line(np.zeros(2), tip, coupler), abs=1e-9)
    assert margin.transmission == pytest.approx(acute(tip, coupler), abs=1e-9)


@pytest.mark.parametrize("pose", random_poses("five_bar", 3, 4))
def test_the_five_bar_has_the_angles_between_its_links(pose):
    size, at = pose.mechanism.parameters, pose.joint_values
    tip = pose.tool_pose().translation[:2]
    pivots = np.array([[0.0, 0.0], [size["l0"], 0.0]])
    arms = (size["l1"], size["l4"])
    elbows = [
        p + r * unit(at[f"theta{k + 1}"]) for k, (p, r) in enumerate(zip(pivots, arms, strict=True))
    ]
    distal = [tip - elbow for elbow in elbows]
    found, between = margins_of(pose), acute(*distal)
    for k in (0, 1):
        proximal = elbows[k] - pivots[k]
        passive, motor = found.gain[f"phi{k + 1}"], found.loss[f"theta{k + 1}"]
        assert found.tool[f"theta{k + 1}"].value == pytest.approx(between, abs=1e-9)
        assert found.tool[f"theta{k + 1}"].unit == "rad"
        assert passive.transmission == pytest.approx(between, abs=1e-9)
        assert passive.arm == pytest.approx(from_line(elbows[k], tip, distal[1 - k]), abs=1e-9)
        assert motor.transmission == pytest.approx(acute(proximal, distal[k]), abs=1e-9)
        assert motor.arm == pytest.approx(from_line(pivots[k], tip, distal[k]), abs=1e-9)


def meeting(first, second):
    """Where two lines (point, direction) meet in the plane."""
    (p, a), (q, b) = first, second
    return p + a * np.linalg.solve(np.column_stack([a, -b]), q - p)[0]


def leg_lines(pose, starts):
    """From these joints to the plate's corners, in the plane."""
    places = joint_places(pose)
    ends = [pose.tool_pose(f"P{k}").translation[:2] for k in (1, 2, 3)]
    starts = [places[f"{name}{k}"].translation[:2] for k, name in enumerate([starts] * 3, start=1)]
    return [(end, end - start) for start, end in zip(starts, ends, strict=True)], starts


@pytest.mark.parametrize(
    "pose", [*random_poses("planar_3rpr", 5, 3), loaded("planar_3rpr").pose("shifted")]
)
def test_the_3rpr_has_the_distance_of_a_line_from_where_the_others_meet(pose):
    lines, starts = leg_lines(pose, "theta")
    found = margins_of(pose)
    for k, (end, along) in enumerate(lines):
        others = meeting(*(line for j, line in enumerate(lines) if j != k))
        margin = found.tool[f"l{k + 1}"]
        assert (margin.unit, margin.twist.pitch, margin.wrench.pitch) == ("m", 0.0, 0.0)
        assert margin.value == pytest.approx(from_line(others, end, along), rel=1e-9)
        np.testing.assert_allclose(margin.twist.point[:2], others, atol=1e-9)
        # A torque on the leg: the force at its tip goes through there as well.
        passive = found.gain[f"theta{k + 1}"]
        assert passive.transmission == pytest.approx(acute(along, end - others), abs=1e-9)
        assert passive.arm == pytest.approx(from_line(starts[k], end, end - others), rel=1e-9)
        assert found.loss[f"l{k + 1}"].angle == pytest.approx(pi / 2, abs=1e-9)
        assert found.loss[f"l{k + 1}"].arm == inf


@pytest.mark.parametrize("pose", random_poses("planar_3rrr", 5, 3))
def test_the_3rrr_has_the_same_of_its_distal_links(pose):
    lines, _ = leg_lines(pose, "phi")
    found = margins_of(pose)
    for k, (end, along) in enumerate(lines):
        others = meeting(*(line for j, line in enumerate(lines) if j != k))
        value = found.tool[f"theta{k + 1}"].value
        assert value == pytest.approx(from_line(others, end, along), rel=1e-9)


@pytest.mark.parametrize("pose", random_poses("stewart_gough", 5, 2))
def test_a_stewart_platforms_are_of_its_legs_lines(pose):
    """The screw that five lines leave, and the virtual coefficient of the sixth with it."""
    places, origin = joint_places(pose), pose.tool_pose().translation
    rows = []
    for k in range(1, 7):
        start, end = places[f"alpha{k}"].translation, pose.tool_pose(f"P{k}").translation
        along = (end - start) / np.linalg.norm(end - start)
        rows.append(np.concatenate([along, np.cross(end - origin, along)]))
    twists = np.linalg.inv(np.array(rows))  # columns: five lines do no work on each, one does 1
    for k in range(6):
        margin = margins_of(pose).tool[f"l{k + 1}"]
        assert margin.unit == "m"
        assert margin.value == pytest.approx(1.0 / np.linalg.norm(twists[3:, k]), rel=1e-8)
        assert margin.wrench.pitch == 0.0


@pytest.mark.parametrize("pose", random_poses("ur5", 5, 3))
def test_an_arms_motors_are_held_by_screws_reciprocal_to_the_others(pose):
    model = pose.mechanism.model
    data = model.createData()
    J = pin.computeJointJacobians(model, data, pose.q)  # about the world's origin
    for k, margin in enumerate(margins_of(pose).loss.values()):
        others = np.delete(J, k, axis=1)
        force, moment = np.split(np.linalg.svd(others.T)[2][-1], 2)
        axis, centre = J[3:, k], data.oMi[k + 1].translation
        torque = axis @ (moment - np.cross(centre, force))
        force, moment = force / torque, (moment - np.cross(centre, force)) / torque
        aside = np.cross(axis, force)
        moment = moment - aside * (aside @ moment) / (aside @ aside)
        assert margin.arm == pytest.approx(1.0 / np.linalg.norm(force), rel=1e-8)
        assert np.sin(margin.angle) == pytest.approx(1.0 / np.linalg.norm(moment), rel=1e-8)


@pytest.mark.parametrize("pose", random_poses("slider_crank", 3, 3))
def test_a_slide_has_the_angle_across_which_its_rod_pushes(pose):
    places = joint_places(pose)
    elbow = places["beta"].translation
    rod = pose.tool_pose("rod_tip").translation - elbow
    found = margins_of(pose)
    tilt = acute(rod, [1.0, 0.0, 0.0])
    assert found.gain["x"].angle == pytest.approx(pi / 2 - tilt, abs=1e-9)
    assert found.loss["theta"].transmission == pytest.approx(acute(elbow, rod), abs=1e-9)


def test_an_agile_eye_has_angles_alone():
    """Of a twist about n₂ × n₃ and a moment about n₁, nᵢ normal to a distal link's two axes."""
    pose = loaded("agile_eye").close([0.2, -0.3, 0.25])
    model = pose.mechanism.model
    data = model.createData()
    J = pin.computeJointJacobians(model, data, pose.q)
    axes = {name: J[3:, model.joints[k].idx_v] for k, name in enumerate(model.names) if k}
    sockets = [axes["chi1"]]
    for loop in pose.mechanism.spec.loops:
        sockets.append(pose.tool_pose(loop.frames[0]).rotation @ np.array(loop.axis))
    normals = [np.cross(axes[f"psi{k + 1}"], socket) for k, socket in enumerate(sockets)]
    for k, (name, margin) in enumerate(margins_of(pose).tool.items()):
        turn = np.cross(normals[k - 1], normals[k - 2])
        assert (name, margin.unit) == (f"theta{k + 1}", "rad")
        assert margin.value == pytest.approx(pi / 2 - acute(turn, normals[k]), abs=1e-9)
    assert margins_of(pose).smallest_arm is None


def closed_beside(pose, joint, shift, turn):
    """A passive joint's value, motors held, with the joint put elsewhere, world, by a little."""
    machine = pose.mechanism
    model = machine.model
    index = model.getJointId(joint)
    carrier = joint_places(pose)[model.names[model.parents[index]]].rotation
    place = model.jointPlacements[index]
    spin = pin.exp3(carrier.T @ turn)
    model.jointPlacements[index] = pin.SE3(
        spin @ place.rotation, place.translation + carrier.T @ shift
    )
    there = rebuilt(machine, model, home=pose.q)
    return there.close(pose.actuated, enforce_limits=False).joint_values[joint]


PLAY = [("stewart_gough", "alpha2"), ("stewart_gough", "beta4"), ("three_rps_ss", "theta2")]
PLAY += [("humanoid_ankle", "pitch"), ("humanoid_ankle", "roll")]


@pytest.mark.parametrize(("name", "joint"), mechanisms.mostly_slow(PLAY, PLAY[2:]))
def test_play_in_a_joint_turns_it_by_its_share_of_the_arm(name, joint):
    """With the motors held: by 1/arm rad a metre where the play is worst, so 1/sin(angle)."""
    pose = random_poses(name, 11, 1)[0]
    step, still = 1e-5, np.zeros(3)
    plays = [(u, still) for u in np.eye(3)] + [(still, u) for u in np.eye(3)]
    values = [
        [closed_beside(pose, joint, s * shift, s * turn) for s in (step, -step)]
        for shift, turn in plays
    ]
    slopes = -np.diff(values)[:, 0] / (2 * step)
    force, moment = np.split(slopes, 2)
    model = pose.mechanism.model
    data = model.createData()
    J = pin.computeJointJacobians(model, data, pose.q)
    axis = J[3:, model.joints[model.getJointId(joint)].idx_v]
    aside = np.cross(axis, force)
    moment = moment - aside * (aside @ moment) / (aside @ aside)
    margin = margins_of(pose).gain[joint]
    assert margin.arm == pytest.approx(1.0 / np.linalg.norm(force), rel=1e-5)
    assert np.sin(margin.angle) == pytest.approx(1.0 / np.linalg.norm(moment), rel=1e-5)


def test_at_a_singular_pose_they_are_zero():
    found = margins_of(five_bar_collinear())
    assert max(one.value for one in found.tool.values()) < 1e-6
    assert max(one.arm for one in found.gain.values()) < 1e-6
    assert max(one.transmission for one in found.gain.values()) < 1e-6
    assert min(one.arm for one in found.loss.values()) > 0.01
    found = margins_of(five_bar_stretched())
    assert found.loss["theta1"].arm == found.loss["theta1"].transmission == 0.0
    assert found.loss["theta2"].arm > 0.1
    assert min(one.arm for one in found.gain.values()) > 0.05
    found = margins_of(three_rrr_lines_in_a_point()[0])
    assert max(one.value for one in found.tool.values()) < 1e-6
    assert found.smallest_arm.value < 1e-6


def legs_nearly_parallel(turn):
    """A 3-RPR whose plate is as large as its base, beside it and turned by little; its legs."""
    machine, middle = pj.load("planar_3rpr", {"a": 0.5, "b": 0.5}), np.array([0.4, 0.1])
    starts = [0.5 * unit(2 * pi * k / 3) for k in range(3)]
    ends = [middle + 0.5 * unit(2 * pi * k / 3 + turn) for k in range(3)]
    q = [*middle, np.cos(turn), np.sin(turn)]
    for start, end in zip(starts, ends, strict=True):
        along = end - start
        q += [np.arctan2(along[1], along[0]) - np.arctan2(-start[1], -start[0]), np.hypot(*along)]
    lines = [(end, end - start) for start, end in zip(starts, ends, strict=True)]
    return machine.configuration(np.array(q)), lines


def test_legs_that_are_almost_parallel_meet_far_away_and_hold_nothing_where_ranks_say_so():
    pose, lines = legs_nearly_parallel(1e-3)
    found = margins_of(pose)
    for k, (end, along) in enumerate(lines):
        others = meeting(*(line for j, line in enumerate(lines) if j != k))
        assert found.tool[f"l{k + 1}"].value == pytest.approx(from_line(others, end, along))
        assert found.tool[f"l{k + 1}"].value > 0.1
    assert max(one.arm for one in found.gain.values()) < 1e-2
    pose, lines = legs_nearly_parallel(1e-6)
    assert pose.singularity().kind == "gain"
    others = meeting(*lines[:2])
    assert from_line(others, *lines[2]) > 0.1
    found = margins_of(pose)
    assert max(one.value for one in found.tool.values()) < 1e-6
    assert max(one.arm for one in found.gain.values()) == 0.0


def of_all(found):
    return {
        (kind, name): one
        for kind in ("gain", "loss", "tool")
        for name, one in getattr(found, kind).items()
    }


def assert_alike(found, other, factor=1.0):
    one, two = of_all(found), of_all(other)
    assert one.keys() == two.keys()
    for key, margin in one.items():
        if key[0] == "tool":
            size = factor if margin.unit == "m" else 1.0
            assert two[key].value == pytest.approx(size * margin.value, rel=1e-7, abs=1e-9)
        else:
            named = (margin.arm * factor, margin.angle, margin.transmission)
            there = (two[key].arm, two[key].angle, two[key].transmission)
            np.testing.assert_allclose(there, named, rtol=1e-7, atol=1e-9)


ALL = mechanisms.mostly_slow(
    mechanisms.CATALOGUE, ("five_bar", "serial_2r", "humanoid_ankle", "three_rps_ss")
)


@pytest.mark.parametrize("name", ALL)
def test_they_depend_on_no_place_and_go_with_the_unit_of_length(name):
    machine = homed_at(loaded(name).home)
    place = pin.SE3(pin.utils.rpyToMatrix(0.3, -0.8, 1.9), np.array([4.0, -7.0, 3.0]))
    here = margins_of(rebuilt(machine).home)
    assert_alike(here, margins_of(moved(machine, place).home))
    assert_alike(here, margins_of(scaled(machine, 1000.0).home), 1000.0)


def test_they_do_not_depend_on_the_cut():
    lengths, theta, phi = mechanisms.CRANK_ROCKER, 0.9, loaded("four_bar").close([0.9])
    angles = (phi.joint_values["phi1"], phi.joint_values["phi2"])
    found = {
        joint: margins_of(four_bar_cut_at(joint, theta, angles, lengths).home) for joint in "BCD"
    }
    for joint, own in found.items():
        for name, margin in own.gain.items():
            for other in (one for one in found.values() if name in one.gain):
                assert margin.arm == pytest.approx(other.gain[name].arm, abs=1e-9), joint
                assert margin.transmission == pytest.approx(other.gain[name].transmission, abs=1e-9)
        assert own.loss["theta1"].arm == pytest.approx(found["C"].loss["theta1"].arm, abs=1e-9)


@pytest.mark.parametrize(("one", "other"), [("delta", "delta_rods"), ("three_rps", "three_rps_ss")])
def test_two_models_of_one_machine_agree(one, other):
    first, second = (margins_of(loaded(name).home) for name in (one, other))
    for kind in ("gain", "loss", "tool"):
        mine, theirs = getattr(first, kind), getattr(second, kind)
        for name in mine.keys() & theirs.keys():
            if kind == "tool":
                assert mine[name].value == pytest.approx(theirs[name].value, rel=1e-8)
            else:
                assert mine[name].arm == pytest.approx(theirs[name].arm, rel=1e-8)
    assert first.loss.keys() == second.loss.keys() != set()


@pytest.mark.parametrize("name", ["planar_3rpr", "delta_rods", "planar_3rrr", "three_rps"])
def test_of_equal_margins_the_first_is_named(name):
    """Symmetric machines have the same margins at each leg, but for rounding."""
    found = margins_of(loaded(name).home)
    joints = [*found.gain.items(), *found.loss.items()]
    tool = [(motor, one.value, one.unit) for motor, one in found.tool.items()]
    arms = [(motor, value) for motor, value, unit in tool if unit == "m"]
    angles = [(motor, value) for motor, value, unit in tool if unit == "rad"]
    arms += [(joint, one.arm) for joint, one in joints]
    for of in ("angle", "transmission"):
        angles += [(joint, getattr(one, of)) for joint, one in joints]
    for smallest, named in ((found.smallest_arm, arms), (found.smallest_angle, angles)):
        near = [joint for joint, value in named if value < smallest.value * (1 + 1e-9)]
        assert len(near) == 3
        assert smallest.name == near[0]
