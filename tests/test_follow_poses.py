"""Following whole poses of the tool, against inverse kinematics by hand."""

from math import cos, pi, sin

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.studies.reach.gimbal import gimbal_for

WAYS = {  # rotation vector in the tool's axes, and a way in the world's
    "stewart_gough": ([0.2, -0.1, 0.15], [0.05, 0.02, 0.03]),
    "head_6rss": ([0.1, 0.05, -0.1], [0.003, 0.0, 0.002]),
    "ur5": ([0.3, 0.8, -0.5], [0.05, -0.03, 0.05]),
}


def moved(pose, share, turn, slide):
    rotation = pose.rotation @ pin.exp3(share * np.array(turn))
    return pin.SE3(rotation, pose.translation + share * np.array(slide))


def straight(name):
    """A machine, the pose of its tool at home, and the way of `WAYS` as a function."""
    machine = loaded(name)
    home = machine.home.tool_pose()
    return machine, lambda t: moved(home, t, *WAYS[name])


def places(machine, q):
    data = machine.model.createData()
    pin.framesForwardKinematics(machine.model, data, q)
    return data


def ends_of_legs(machine, names, corners):
    """Where legs begin, in the world, and where they end, in the tool."""
    data, model = places(machine, machine.home.q), machine.model
    tool = machine.home.tool_pose()
    starts = [data.oMi[model.getJointId(name)].translation for name in names]
    ends = [tool.actInv(data.oMf[model.getFrameId(name)].translation) for name in corners]
    return np.array(starts), np.array(ends)


def test_a_stewart_platforms_legs_are_as_long_as_they_have_to_be():
    machine, way = straight("stewart_gough")
    starts, ends = ends_of_legs(
        machine, [f"alpha{k}" for k in range(1, 7)], [f"P{k}" for k in range(1, 7)]
    )
    path = pj.follow(machine, [way(0.0), way(1.0)], samples=7)
    assert path.reached
    for t, values in zip(path.t, path.actuated, strict=True):
        tips = np.array([way(t).act(end) for end in ends])
        assert values == pytest.approx(np.linalg.norm(tips - starts, axis=1), abs=1e-11)


def test_a_heads_rods_keep_their_length_where_its_plate_is_as_wanted():
    """By arms alone, the plate where it is to be: with each arm on its side, all the way."""
    machine, way = straight("head_6rss")
    loops = machine.spec.loops
    tool = machine.home.tool_pose()
    model = machine.model
    path = pj.follow(machine, [way(0.0), way(1.0)], samples=5)
    assert path.reached
    for loop in loops:
        on_plate, on_arm = (model.getFrameId(name) for name in loop.frames)
        if model.frames[on_plate].parentJoint != model.getJointId("head"):
            on_plate, on_arm = on_arm, on_plate
        end = tool.actInv(places(machine, machine.home.q).oMf[on_plate].translation)
        for t, q in zip(path.t, path.q, strict=True):
            rod = places(machine, q).oMf[on_arm].translation - way(t).act(end)
            assert np.linalg.norm(rod) == pytest.approx(
                loop.resolved_length(machine.parameters), abs=1e-11
            )


def test_an_arms_flange_is_where_it_is_to_be():
    machine, way = straight("ur5")
    path = pj.follow(machine, [way(0.0), way(1.0)], times=[2.0, 4.0], samples=5)
    assert path.reached
    for t, pose in zip(path.t, path, strict=True):
        assert pose.tool_pose().isApprox(way(t / 2.0 - 1.0), 1e-10)


@pytest.mark.parametrize("name", mechanisms.mostly_slow(WAYS, ("stewart_gough",)))
def test_the_tool_slides_and_turns_evenly(name):
    machine, way = straight(name)
    turn, slide = (np.array(part) for part in WAYS[name])
    path = pj.follow(machine, [way(0.0), way(1.0)], samples=[0.25, 0.75])
    for k, t in enumerate(path.t[:2].tolist()):
        motion = path[k].motion(path.rates[k], path.accelerations[k])
        assert motion.twist == pytest.approx(
            np.concatenate([slide, way(t).rotation @ turn]), abs=1e-9
        )
        assert motion.acceleration == pytest.approx(np.zeros(6), abs=1e-7)


@pytest.mark.parametrize("name", mechanisms.mostly_slow(WAYS, ("head_6rss",)))
def test_with_proof(name):
    machine, way = straight(name)
    path = pj.follow(machine, [way(0.0), way(1.0)], certified=True)
    assert path.reached
    assert path.evidence.kind == "proof"


def test_a_function_of_poses_comes_home():
    """A plate nods around: its axis goes around a cone of 0.15 rad."""
    machine = loaded("stewart_gough")
    home = machine.home.tool_pose()

    def nodding(t):
        turn = 0.15 * np.array([cos(t) - 1.0, sin(t), 0.0])
        return pin.SE3(pin.exp3(turn) @ home.rotation, home.translation)

    path = pj.follow(machine, nodding, times=(0.0, 2.0 * pi), coordinates="pose", samples=9)
    assert path.reached
    assert path.homecoming.same_mode
    for t, pose in zip(path.t, path, strict=True):
        assert pose.tool_pose().isApprox(nodding(t), 1e-10)


@pytest.mark.slow
def test_a_tool_may_turn_round_and_round():
    """Two turns about a slanted axis, by waypoints less than half a turn apart."""
    machine = pj.load("agile_eye")
    small = loaded("ur5")
    home = small.home.tool_pose()
    ways = [moved(home, k, [0.0, 0.0, 2.0], [0.0, 0.0, 0.0]) for k in range(7)]
    path = pj.follow(small, ways, enforce_limits=False)
    assert path.reached
    turned = path.actuated[-1] - path.actuated[0]
    assert turned[5] == pytest.approx(12.0, abs=1e-9)
    assert turned[:5] == pytest.approx(np.zeros(5), abs=1e-9)
    eye = machine.home.tool_pose()
    up = [moved(eye, k, [0.2, 0.1, 0.3], [0.0, 0.0, 0.0]) for k in range(2)]
    seen = pj.follow(machine, up, coordinates=pj.Task.orientation())
    assert np.allclose(seen.end.tool_pose().rotation, up[1].rotation, atol=1e-11)


def test_rows_that_a_machine_has_are_named_by_a_task():
    machine = loaded("three_rps")
    home = machine.home.tool_pose()
    spin, tilt = (moved(home, 1.0, turn, np.zeros(3)) for turn in ([0, 0, 0.1], [0.05, 0.02, 0]))
    with pytest.raises(pj.ArgumentError, match="off the path"):
        pj.follow(loaded("delta"), [loaded("delta").home.tool_pose(), spin])
    plane = loaded("planar_3rrr")
    for way in (0.0, 0.02):
        poses = [moved(plane.home.tool_pose(), s, [0, 0, 0.2], [0.02, 0, way]) for s in (0.0, 1.0)]
        if way:
            with pytest.raises(pj.ArgumentError, match="off the path"):
                pj.follow(plane, poses)
        assert pj.follow(plane, poses, coordinates=pj.Task.planar()).reached
    for task in (None, pj.Task.pose()):
        with pytest.raises(pj.ArgumentError):
            pj.follow(machine, [home, tilt], coordinates=task)


def test_what_is_no_path_of_poses_is_refused():
    machine, way = straight("ur5")
    ends = [way(0.0), way(1.0)]
    refused = [
        ([way(0.0)], {}, "two waypoints"),
        ([way(0.0), moved(way(0.0), 1.0, [pi, 0, 0], [0, 0, 0])], {}, "half a turn"),
        (ends, {"times": [0.0, 1.0, 2.0]}, "do not fit"),
        ([way(0.0), np.eye(4) * 2.0], {}, "a pose is a rotation"),
        ([way(0.0), 3.0], {}, "waypoint 1 is no pose"),
        (lambda t: t, {"coordinates": "pose", "times": (0, 1)}, "no pose"),
        (way, {"coordinates": "pose"}, "needs `times`"),
        ([[0.0] * 6, [0.1] * 6], {"coordinates": "pose"}, "poses are wanted"),
        (ends, {"coordinates": pj.Task.pointing(position=True)}, "points leaves"),
    ]
    for path, options, told in refused:
        with pytest.raises(pj.ArgumentError, match=told):
            pj.follow(machine, path, **options)


def test_hinges_are_chosen_where_they_do_not_lock(rng):
    """About any axis all the way round, and about any two of them by far."""
    for _ in range(20):
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        other = pin.exp3(rng.normal(size=3))
        turns = np.array([other @ pin.exp3(angle * axis) for angle in np.linspace(0.0, 2 * pi, 90)])
        gimbal = gimbal_for(turns)
        for turn in turns:
            pitch = pin.rpy.matrixToRpy(gimbal.before.T @ turn @ gimbal.after)[1]
            assert cos(pitch) > 0.5
    everywhere = np.array([pin.exp3(rng.normal(size=3) * 3.0) for _ in range(4000)])
    assert gimbal_for(everywhere) is None
