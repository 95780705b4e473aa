"""Following the tool: the machine driven by it, against inverse kinematics by hand."""

from math import acos, atan2, cos, hypot, pi, sin, sqrt

import numpy as np
import pytest
from mechanisms import loaded, mostly_slow
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

import pmjac_pin as pj
from pmjac_pin.cli import main


def arm_angles(x, y, elbow):
    """Both angles of the two-link arm (1 and 0.8 m) with its tip there."""
    bent = elbow * acos((x * x + y * y - 1.64) / 1.6)
    return atan2(y, x) - atan2(0.8 * sin(bent), 1.0 + 0.8 * cos(bent)), bent


def circle(centre, size=0.3):
    return lambda t: [centre[0] + size * sin(t), centre[1] + size * (cos(t) - 1.0)]


def test_an_arm_goes_along_a_circle():
    arm = loaded("serial_2r")
    x, y, _ = arm.home.tool_pose().translation
    way = circle((x, y))
    path = pj.follow(arm, way, times=(0.0, 2.0 * pi), coordinates=("x", "y"), samples=25)
    assert path.reached
    elbow = np.sign(arm.home.actuated[1])
    for t, values in zip(path.t, path.actuated, strict=True):
        assert values == pytest.approx(arm_angles(*way(t), elbow), abs=1e-9)
    assert path.homecoming.same_mode
    assert path.q.shape == (25, arm.nq)
    assert path.mechanism is arm


def test_rates_and_accelerations_are_those_of_the_tool():
    arm = loaded("serial_2r")
    x, y, _ = arm.home.tool_pose().translation
    path = pj.follow(
        arm, circle((x, y)), times=(0.0, 5.0), coordinates=("x", "y"), samples=[1.0, 2.0, 3.0]
    )
    for k in range(3):
        t, pose = path.t[k], path[k]
        motion = pose.motion(path.rates[k], path.accelerations[k])
        assert motion.twist[:2] == pytest.approx([0.3 * cos(t), -0.3 * sin(t)], abs=1e-9)
        assert motion.acceleration[:2] == pytest.approx([-0.3 * sin(t), -0.3 * cos(t)], abs=1e-7)
        assert path.v[k] == pytest.approx(motion.v, abs=1e-12)


def test_an_arm_is_stretched_where_its_reach_ends():
    arm = loaded("serial_2r")
    start = arm.home.tool_pose().translation[:2]
    way = [3.0, 0.0] - start
    path = pj.follow(arm, [start, [3.0, 0.0]], coordinates=("x", "y"))
    ends = brentq(lambda t: hypot(*(start + t * way)) - 1.8, 0.0, 1.0, xtol=1e-15)
    assert path.status == "fold"
    assert path.events[-1].t == pytest.approx(ends, abs=1e-11)
    assert path.end.singularity().kind == "loss"
    assert "working mode" in path.reason


def test_a_five_bar_is_lost_by_its_motors_where_its_rods_are_in_line():
    """Straight down through the line between the cranks' tips: both rods along it."""
    machine = loaded("five_bar")
    x, y, _ = machine.home.tool_pose().translation
    path = pj.follow(machine, [[x, y], [x, y - 0.6]], coordinates=("x", "y"), enforce_limits=False)
    assert path.reached
    [event] = path.events
    assert event.kind == "gain"
    values = event.configuration.joint_values
    tips = [
        np.array([base + 0.3 * cos(values[name]), 0.3 * sin(values[name])])
        for base, name in ((0.0, "theta1"), (0.3, "theta2"))
    ]
    assert np.linalg.norm(tips[0] - tips[1]) == pytest.approx(0.8, abs=1e-10)
    height = event.configuration.tool_pose().translation[1]
    # Symmetric: each crank's tip is 0.4 from the middle at 0.15, as high as the tool.
    assert height == pytest.approx(sqrt(0.3**2 - (0.4 - 0.15) ** 2), abs=1e-10)


def test_motors_stop_at_their_limits():
    whole = loaded("serial_2r")
    model = whole.model
    entry = model.joints[model.getJointId(whole.actuated[1])].idx_q
    model.upperPositionLimit[entry] = whole.home.actuated[1] + 0.3
    arm = pj.Mechanism.from_pinocchio(
        model, [], whole.actuated, whole.spec.tool.names[0], home=dict(whole.home.joint_values)
    )
    start = arm.home.tool_pose().translation[:2]
    path = pj.follow(arm, [start, 0.3 * start], coordinates=("x", "y"))
    assert path.status == "limit"
    limit = whole.home.actuated[1] + 0.3
    assert path.end.actuated[1] == pytest.approx(limit, abs=1e-11)
    events = {event.kind: event for event in path.events}
    assert events["motor limit"].name == arm.actuated[1]
    assert pj.follow(
        arm, [start, 0.3 * start], coordinates=("x", "y"), enforce_limits=False
    ).reached


CASES = [
    ("delta", ("x", "y", "z"), [0.02, 0.03, -0.04]),
    ("planar_3rrr", ("x", "y", "angle"), [0.02, -0.03, 0.2]),
    ("planar_3rpr", ("x", "y", "angle"), [0.02, -0.03, 0.1]),
    ("five_bar", ("x", "y"), [0.05, -0.1]),
    ("five_bar", ("y", "x"), [0.05, -0.1]),
]


@pytest.mark.parametrize(("name", "coordinates", "far"), mostly_slow(CASES, quick=("five_bar",)))
def test_coordinates_are_where_they_are_to_be_with_proof(name, coordinates, far):
    machine = loaded(name)

    def here(pose):
        tool = pose.tool_pose()
        known = dict(zip("xyz", tool.translation, strict=True))
        known["angle"] = atan2(tool.rotation[1, 0], tool.rotation[0, 0])
        return np.array([known[one] for one in coordinates])

    first = here(machine.home)
    way = CubicSpline([0.0, 1.0, 2.0], [first, first + np.array(far), first - 0.5 * np.array(far)])
    path = pj.follow(machine, way, coordinates=coordinates, samples=9, certified=True)
    assert path.reached, path.reason
    assert path.evidence.kind == "proof"
    for t, pose in zip(path.t, path.configurations, strict=True):
        assert here(pose) == pytest.approx(way(t), abs=1e-9)


def test_columns_by_name_and_the_command_line(tmp_path, capsys):
    arm = loaded("serial_2r")
    x, y, _ = arm.home.tool_pose().translation
    table = {"y": [y, y - 0.2], "x": [x, x + 0.1]}
    named = pj.follow(arm, table, coordinates=("x", "y"))
    listed = pj.follow(arm, [[x, y], [x + 0.1, y - 0.2]], coordinates=("x", "y"))
    assert (named.q == listed.q).all()
    file = tmp_path / "way.csv"
    file.write_text(f"x,y\n{x},{y}\n3,0\n")
    assert main(["follow", "serial_2r", "--waypoints", str(file)]) == 1
    assert "this working mode ends" in capsys.readouterr().out


def test_what_is_no_path_of_the_tool_is_told():
    arm, bar = loaded("serial_2r"), loaded("four_bar")
    for machine, path, coordinates, said in (
        (arm, [[1.0, 1.0], [1.0, 1.1]], ("x", "w"), "is called 'w'"),
        (arm, [[1.0, 1.0], [1.0, 1.1]], ("x", "x"), "each once"),
        (arm, [[1.0, 1.0], [1.0, 1.1]], ("x",), r"shape \(N, 1\)"),
        (arm, {"x": [1.0, 1.1]}, ("x", "y"), "columns x, y"),
        (bar, [[2.0, 1.0], [2.0, 1.1]], ("x", "y"), "do not tell where"),
    ):
        with pytest.raises(pj.ArgumentError, match=said):
            pj.follow(machine, path, coordinates=coordinates)
    with pytest.raises(pj.ClosureError, match="does not go straight"):
        pj.follow(arm, [[9.0, 1.0], [1.0, 1.0]], coordinates=("x", "y"))
