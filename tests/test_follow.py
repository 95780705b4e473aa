"""Following: poses, rates and events against formulas, differences and closures of other kinds."""

from math import acos, cos, pi, sin, sqrt

import numpy as np
import pytest
from mechanisms import (
    loaded,
    mostly_slow,
    over_actuated_four_bar,
    rocker_rocker,
    rssr,
    with_motors,
)
from scipy.interpolate import CubicHermiteSpline, CubicSpline
from scipy.optimize import brentq

import pmjac_pin as pj

CASES = mostly_slow(
    [
        "agile_eye",
        "ankle",
        "bennett",
        "bricard",
        "delta",
        "five_bar",
        "humanoid_ankle",
        "planar_3rpr",
        "planar_3rrr",
        "serial_2r",
        "slider_crank",
        "stewart_gough",
        "three_rps",
        "three_rps_ss",
        "ur5",
        "watt_six_bar",
    ],
    quick=("bennett", "five_bar", "serial_2r", "three_rps_ss"),
)


def wavy(mechanism, size=0.02):
    """A curved path from home that comes back to it after t = 2 π."""
    home, n = mechanism.home.actuated, len(mechanism.actuated)
    shifts = np.arange(n)
    return lambda t: home + size * (np.sin(t + shifts) - np.sin(shifts))


@pytest.mark.parametrize("name", CASES)
def test_poses_are_those_of_close(name):
    """A straight walk to the same motor values, near enough for the same mode."""
    mechanism = loaded(name)
    trajectory = pj.follow(mechanism, wavy(mechanism), times=(0.0, 2.0 * pi), samples=9)
    assert trajectory.reached
    for pose in trajectory.configurations:
        direct = mechanism.close(pose.actuated)
        here, there = (one.tool_pose().homogeneous for one in (pose, direct))
        assert here == pytest.approx(there, abs=1e-9)
    assert trajectory.homecoming.same_mode
    assert not trajectory.homecoming.cuspidal
    assert trajectory.actuated[-1] == pytest.approx(mechanism.home.actuated, abs=1e-12)


@pytest.mark.parametrize("name", CASES)
def test_rates_and_accelerations_are_those_of_differences(name):
    mechanism, h = loaded(name), 1e-3
    at = (1.0, 2.5, 4.0)
    times = [t + k * h for t in at for k in (-2, -1, 0, 1, 2)]
    trajectory = pj.follow(mechanism, wavy(mechanism), times=(0.0, 6.0), samples=times)
    columns = mechanism.problem.partition.columns
    values = np.array([mechanism.coordinates.values(q) for q in trajectory.q[:-1]])
    plain = [k for k in columns.values() if not mechanism.coordinates.curved[k]]
    for k in range(len(at)):
        a, b, c, d, e = values[5 * k : 5 * k + 5, plain]
        slope, bend = (a - 8 * b + 8 * d - e) / (12 * h), (-a + 16 * b - 30 * c + 16 * d - e)
        assert trajectory.v[5 * k + 2, plain] == pytest.approx(slope, abs=1e-8)
        assert trajectory.a[5 * k + 2, plain] == pytest.approx(bend / (12 * h * h), abs=1e-5)


def test_arrays_belong_together():
    mechanism = loaded("five_bar")
    trajectory = pj.follow(mechanism, wavy(mechanism), times=(0.0, 2.0), samples=[0.5, 1.0, 1.5])
    assert trajectory.t.tolist() == [0.5, 1.0, 1.5, 2.0]
    assert trajectory.rates[0] == pytest.approx(0.02 * np.cos(0.5 + np.arange(2)), abs=1e-10)
    motion = trajectory[0].motion(trajectory.rates[0], trajectory.accelerations[0])
    assert trajectory.v[0] == pytest.approx(motion.v, abs=1e-12)
    assert trajectory.a[0] == pytest.approx(motion.a, abs=1e-12)
    assert (trajectory.tool_poses[2] == trajectory[2].tool_pose().homogeneous).all()
    found = trajectory.to_xarray()
    assert found.v.sel(joint="phi1").values == pytest.approx(trajectory.v[:, 1])
    assert found.attrs["status"] == "end"
    assert repr(trajectory).startswith("Trajectory(five_bar, 4 poses, t=0.5 to 2")


def fold_of_rocker_rocker():
    return acos((4.0**2 + 3.0**2 - 4.5**2) / 24.0)


def test_a_fold_ends_the_path_where_the_rods_are_in_line():
    trajectory = pj.follow(rocker_rocker(), [[0.9], [2.0]])
    assert trajectory.status == "fold"
    [event] = trajectory.events
    assert event.kind == "fold"
    assert event.t == pytest.approx((fold_of_rocker_rocker() - 0.9) / 1.1, abs=1e-11)
    assert event.configuration.singularity().kind == "gain"
    assert trajectory.t[-1] == event.t
    assert np.isnan(trajectory.v[-1]).all()
    assert "turn back" in trajectory.reason


@pytest.mark.parametrize("singularity", ["stop", "pass"])
def test_driven_by_its_slider_the_crank_turns_no_further(singularity):
    machine = with_motors(loaded("slider_crank"), ["x"])
    start = machine.home.actuated[0]
    trajectory = pj.follow(machine, [[start], [1.5]], singularity=singularity)
    assert trajectory.status == "fold"
    x = trajectory.events[-1].configuration.actuated[0]
    assert x == pytest.approx(0.3 + 0.9, abs=1e-11)


def test_a_five_bar_folds_where_its_rods_are_in_line():
    """|P1 P2| = l2 + l3, along a curved path of both cranks."""
    machine = loaded("five_bar")
    first, second = machine.home.actuated

    def path(t):
        return [first + 0.3 * t, second - 0.5 * t + 0.2 * t**2]

    def apart(t):
        a, b = path(t)
        ends = 0.3 * np.array([cos(a), sin(a)]), np.array([0.3 + 0.3 * cos(b), 0.3 * sin(b)])
        return float(np.linalg.norm(ends[0] - ends[1])) - 0.8

    trajectory = pj.follow(machine, path, times=(0.0, 3.0), enforce_limits=False)
    expected = next(
        (
            brentq(apart, a, a + 0.05, xtol=1e-15)
            for a in np.arange(0.0, 3.0, 0.05)
            if apart(a) < 0.0 < apart(a + 0.05)
        ),
        None,
    )
    folds = [event.t for event in trajectory.events if event.kind == "fold"]
    assert folds == ([] if expected is None else [pytest.approx(expected, abs=1e-10)])
    assert trajectory.status == ("end" if expected is None else "fold")


def test_a_path_that_ends_at_a_fold_reaches_it():
    end = fold_of_rocker_rocker()
    trajectory = pj.follow(rocker_rocker(), [[0.9], [end]])
    assert trajectory.status == "end"
    assert trajectory.t[-1] == pytest.approx(1.0, abs=1e-10)
    assert trajectory.events[-1].kind == "fold"


def limited(name, **limits):
    """A machine of the catalogue with other limits of joints."""
    whole = loaded(name)
    model = whole.model
    for joint, (lower, upper) in limits.items():
        entry = model.joints[model.getJointId(joint)].idx_q
        model.lowerPositionLimit[entry], model.upperPositionLimit[entry] = lower, upper
    home = dict(whole.home.joint_values)
    return pj.Mechanism.from_pinocchio(
        model, whole.spec.loops, whole.actuated, whole.spec.tool.names[0], home=home
    )


def slider(theta):
    return 0.3 * cos(theta) + sqrt(0.81 - 0.09 * sin(theta) ** 2)


def test_limits_are_passed_where_formulas_say():
    machine = limited("slider_crank", x=(0.7, 1.1))
    trajectory = pj.follow(machine, [[0.9], [6.0]])
    out = brentq(lambda t: slider(t) - 0.7, 0.9, pi, xtol=1e-15)
    back = brentq(lambda t: slider(t) - 0.7, pi, 5.0, xtol=1e-15)
    over = brentq(lambda t: slider(t) - 1.1, 4.0, 6.0, xtol=1e-15)
    events = [event for event in trajectory.events if event.kind == "passive limit"]
    times = [(theta - 0.9) / 5.1 for theta in (out, back, over)]
    assert [event.t for event in events] == pytest.approx(times, abs=1e-11)
    assert [event.leaves for event in events] == [True, False, True]
    assert events[0].what == "'x' passes its lower limit 0.7 m, outwards"
    stopped = pj.follow(machine, [[0.9], [6.0]], enforce_limits="all")
    assert stopped.status == "limit"
    assert stopped.t[-1] == pytest.approx(times[0], abs=1e-11)


def test_a_limit_that_is_passed_for_a_moment_only():
    """Within one step: the slider's lowest place is beyond the limit for 2e-3 rad."""
    least = slider(pi - 1e-3)
    machine = limited("slider_crank", x=(least, 2.0))
    events = pj.follow(machine, [[0.9], [6.0]]).events
    found = [event.t * 5.1 + 0.9 for event in events if event.kind == "passive limit"]
    assert found == pytest.approx([pi - 1e-3, pi + 1e-3], abs=1e-10)


def test_a_motor_stops_at_its_limit():
    machine = loaded("slider_crank")
    trajectory = pj.follow(machine, [[0.9], [7.0]])
    assert trajectory.status == "limit"
    assert trajectory.t[-1] == pytest.approx((2.0 * pi - 0.9) / 6.1, abs=1e-12)
    assert trajectory.reason == "'theta' passes its upper limit 6.28318531 rad, outwards"
    free = pj.follow(machine, [[0.9], [7.0]], enforce_limits=False)
    assert free.reached
    assert "motor limit" in [event.kind for event in free.events]


def test_dead_points_are_losses():
    machine = loaded("slider_crank")
    events = pj.follow(machine, [[0.9], [4.0]]).events
    assert [event.kind for event in events] == ["loss"]
    assert events[0].t == pytest.approx((pi - 0.9) / 3.1, abs=1e-11)
    assert events[0].configuration.singularity().lost == 1


@pytest.mark.parametrize("waypoints", [[0.0, 1.0], [0.9, pi], [0.9, pi, 4.0], [0.9, pi, 1.0]])
def test_dead_points_where_pieces_begin_and_end(waypoints):
    path = pj.follow(loaded("slider_crank"), [[theta] for theta in waypoints])
    assert path.reached
    [event] = path.events
    assert (event.kind, event.t) == ("loss", 0.0 if waypoints[0] == 0.0 else 1.0)


def test_where_the_tool_is_as_slow_in_two_ways():
    """A Delta on its axis: two singular values are one, and no vectors are told."""
    machine = loaded("delta")
    home = machine.home.actuated.mean()
    path = pj.follow(machine, [3 * [home], 3 * [home + 0.3]])
    assert path.reached
    assert path.events == ()


def test_motors_that_start_and_stop_gently():
    clamped = CubicSpline([0.0, 1.0, 2.0], [[0.9], [1.5], [1.2]], bc_type="clamped")
    path = pj.follow(loaded("four_bar"), clamped, certified=True)
    assert path.reached
    assert path.rates[0] == pytest.approx([0.0], abs=1e-12)


def test_a_dead_point_that_is_touched():
    machine = loaded("slider_crank")
    path = pj.follow(machine, lambda t: [pi - t * t], times=(-1.0, 0.9))
    assert [event.kind for event in path.events] == ["loss"]
    assert path.events[0].t == pytest.approx(0.0, abs=1e-10)
    assert "touches zero" in path.events[0].what
    beside = pj.follow(machine, lambda t: [pi - 1e-4 - t * t], times=(-1.0, 0.9))
    assert beside.events == ()


def test_events_of_the_caller():
    machine = loaded("slider_crank")
    watched = {"middle": lambda pose: pose.joint_values["x"] - 0.9}
    events = pj.follow(machine, [[0.9], [6.0]], events=watched).events
    found = [event for event in events if event.kind == "user"]
    roots = [brentq(lambda t: slider(t) - 0.9, a, b, xtol=1e-15) for a, b in ((1, 2), (4, 5))]
    assert [event.t * 5.1 + 0.9 for event in found] == pytest.approx(roots, abs=1e-10)
    assert [event.what for event in found] == [
        "middle falls through zero",
        "middle rises through zero",
    ]


def test_how_large_a_watched_number_is_does_not_count():
    """Products of such values are 0: their signs are compared."""
    arm = loaded("serial_2r")
    home = arm.home.actuated
    watched = {"first": lambda pose: 1e-200 * (pose.actuated[0] - home[0])}
    [event] = pj.follow(arm, [home - 0.5, home + 0.7], events=watched).events
    assert event.t == pytest.approx(0.5 / 1.2, abs=1e-10)
    assert event.what == "first rises through zero"


def test_what_turns_back_at_zero_does_not_pass_it():
    arm = loaded("serial_2r")
    home = np.zeros(2)
    watched = {"first": lambda pose: pose.actuated[0]}
    events = pj.follow(arm, [home - 0.5, home, home - 0.5], events=watched).events
    [event] = [one for one in events if one.kind == "user"]
    assert (event.t, event.what) == (1.0, "first rises to zero")


@pytest.mark.parametrize("width", [0.05, 0.02, 0.01])
@pytest.mark.parametrize("middle", [5.55, 1.3, 9.3])
def test_a_short_motion_of_a_function_is_seen(middle, width):
    """All nodes of one polynomial over the whole range see a function that rests."""
    arm = loaded("serial_2r")
    home = arm.home.actuated

    def path(t):
        return home + np.array([0.3 * np.exp(-(((t - middle) / width) ** 2)), 0.0])

    trajectory = pj.follow(arm, path, times=(0.0, 10.0))
    assert np.ptp(trajectory.actuated[:, 0]) > 0.2


def test_a_short_jump_of_a_function_is_refused():
    arm = loaded("serial_2r")
    home = arm.home.actuated
    with pytest.raises(pj.ArgumentError, match=r"not smooth near t = 5\.[47]"):
        pj.follow(arm, lambda t: home + 0.3 * (5.4 < t < 5.7), times=(0.0, 10.0))


def test_motors_that_loops_tie():
    machine = over_actuated_four_bar()
    led = pj.follow(loaded("four_bar"), [[0.9], [2.0]], samples=400)
    columns = list(machine.problem.partition.actuated)
    together = CubicHermiteSpline(led.t, led.q[:, columns], led.v[:, columns])
    followed = pj.follow(machine, together)
    assert followed.reached
    assert followed.q[-1] == pytest.approx(led.q[-1], abs=1e-9)
    apart = CubicHermiteSpline(
        led.t, led.q[:, columns] + [0.0, 0.1] * led.t[:, None], led.v[:, columns]
    )
    strayed = pj.follow(machine, apart)
    assert strayed.status == "forbidden"
    assert "lead motors elsewhere" in strayed.reason


def test_a_rod_that_spins_is_followed():
    machine = rssr()
    trajectory = pj.follow(machine, wavy(machine, 0.3), times=(0.0, 2.0 * pi), samples=5)
    assert trajectory.reached
    rod = rssr(rod=False)
    other = pj.follow(rod, wavy(rod, 0.3), times=(0.0, 2.0 * pi), samples=5)
    assert trajectory.tool_poses == pytest.approx(other.tool_poses, abs=1e-9)


def test_what_is_no_question_is_told():
    machine = loaded("four_bar")
    for keywords, said in (
        ({"singularity": "jump"}, "singularity is stop or pass, got 'jump'"),
        ({"samples": 1}, "2 or more"),
        ({"samples": [0.5, 3.0]}, "samples ascend from 0 to 1"),
        ({"events": [abs]}, "by their names"),
        ({"events": {"x": 3}}, "something to be called"),
        ({"certified": "no"}, "True or False"),
        ({"progress": 3}, "something to be called"),
    ):
        with pytest.raises(pj.ArgumentError, match=said):
            pj.follow(machine, [[0.9], [1.0]], **keywords)
    with pytest.raises(pj.LimitError):
        pj.follow(machine, [[7.0], [8.0]])
    with pytest.raises(pj.ClosureError):
        pj.follow(rocker_rocker(), [[3.0], [2.0]])


def test_an_interrupt_keeps_what_is_done():
    machine = loaded("four_bar")

    def stop(t, end):
        assert t <= end
        if t > 0.5:
            raise KeyboardInterrupt

    with pytest.raises(pj.Interrupted) as caught:
        pj.follow(machine, [[0.9], [2.0]], progress=stop)
    done = caught.value.done
    assert done.status == "interrupted"
    assert 0.5 < done.t[-1] < 1.0
    assert done[-1].actuated[0] == pytest.approx(0.9 + 1.1 * done.t[-1])


def test_a_start_at_a_singular_pose_is_told():
    machine = pj.load("four_bar", {"l0": 2.0, "l1": 1.0, "l2": 2.0, "l3": 1.0})
    flat = pj.follow(machine, [[0.9], [pi]]).end
    trajectory = pj.follow(machine, [[pi], [4.0]], start=flat)
    assert trajectory.status == "singular"
    assert "begins at t = 0" in trajectory.reason
    assert len(trajectory) == 1
