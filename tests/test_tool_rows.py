"""Which rows of the tool's twist are judged: losses of a point, of a camera, of a plate."""

from __future__ import annotations

import json
import pickle
from math import acos, atan2, cos, hypot, pi, sin

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded
from test_tables import drawn

import pmjac_pin as pj
from pmjac_pin.cli import main
from pmjac_pin.model.spec import decode_spec, encode_spec
from pmjac_pin.model.tool_rows import TWIST_ROWS, WHOLE_TWIST, ToolRows
from pmjac_pin.words.diagnosis_tables import diagnosis_blocks
from pmjac_pin.words.plain import to_json
from pmjac_pin.words.tables import report_blocks

PLANAR = ("five_bar", "planar_3rpr", "planar_3rrr", "serial_2r")
STATED = {
    "agile_eye": "wx wy wz",
    "ankle": "wx wy wz",
    "humanoid_ankle": "wx wy wz",
    "delta": "vx vy vz",
    "delta_rods": "vx vy vz",
    "five_bar": "vx vy",
    "planar_3rpr": "vx vy wz",
    "planar_3rrr": "vx vy wz",
    "serial_2r": "vx vy",
}


def with_joint_at(name, **values):
    """A closed pose with passive joints at these values: the leg straight, for instance."""
    mechanism = loaded(name)
    held = pj.Mechanism.from_pinocchio(
        mechanism.model,
        mechanism.spec.loops,
        list(values),
        mechanism.spec.tool.frame,
        home=dict(mechanism.home.joint_values) | values,
    )
    assert all(held.home.joint_values[joint] == value for joint, value in values.items())
    return mechanism.configuration(held.home.q)


def stretched_five_bar():
    """Both links of the first leg in one line, the second leg by hand."""
    theta1, (l0, l1, l2) = 1.2, (0.3, 0.3, 0.4)
    x, y = (l1 + l2) * cos(theta1) - l0, (l1 + l2) * sin(theta1)
    reach = hypot(x, y)
    theta2 = atan2(y, x) - acos((l1**2 + reach**2 - l2**2) / (2 * l1 * reach))
    phi2 = acos((reach**2 - l1**2 - l2**2) / (2 * l1 * l2))
    mechanism = loaded("five_bar")
    q, model = np.zeros(4), mechanism.model
    for name, value in {"theta1": theta1, "phi1": 0.0, "theta2": theta2, "phi2": phi2}.items():
        q[model.joints[model.getJointId(name)].idx_q] = value
    return mechanism.configuration(q)


def delta_rods_stretched():
    """The plate and the motors of the Delta with hinges, its first leg straight."""
    values = with_joint_at("delta", elbow1=0.0).joint_values
    mechanism = loaded("delta_rods")
    motors = [values[name] for name in mechanism.actuated]
    return mechanism.close(motors, guess={"platform": values["platform"]})


LOSSES = {
    "five_bar": stretched_five_bar,
    "five_bar, both legs": lambda: with_joint_at("five_bar", phi1=0.0, phi2=0.0),
    "serial_2r": lambda: loaded("serial_2r").close([0.3, 0.0]),
    "serial_2r, folded": lambda: loaded("serial_2r").close([0.3, pi]),
    "planar_3rrr": lambda: with_joint_at("planar_3rrr", phi1=0.0),
    "delta": lambda: with_joint_at("delta", elbow1=0.0),
    "delta_rods": delta_rods_stretched,
    "agile_eye": lambda: with_joint_at("agile_eye", psi1=-pi / 2, theta3=0.5),
    "slider_crank": lambda: loaded("slider_crank").close([0.0]),
    "ur5": lambda: loaded("ur5").close([0.3, -1.2, 1.4, -0.9, 0.0, 0.2]),
}


def judged_by_hand(pose):
    """Singular values of the judged rows of J_eq, without dimension, from arrays alone."""
    mechanism, split = pose.mechanism, pose.split_jacobian(pose.mechanism.spec.tool.axes)
    names = list(mechanism.actuated) + list(mechanism.passive)
    columns = [split.partition.columns[name] for name in names]
    length, motors = mechanism.characteristic_length, len(mechanism.actuated)
    unit = np.array([1 / length if mechanism.units[name] == "rad" else 1.0 for name in names])
    C, J = split.constraint_jacobian[:, columns] * unit, split.tool_jacobian[:, columns] * unit
    J = J * np.repeat([1.0, length], 3)[:, None]
    J_eq = J[:, :motors] - J[:, motors:] @ np.linalg.pinv(C[:, motors:], 1e-8) @ C[:, :motors]
    rows = [TWIST_ROWS.index(name) for name in mechanism.spec.tool.rows or TWIST_ROWS]
    values = np.linalg.svd(J_eq[rows], compute_uv=False)
    return np.count_nonzero(values > 1e-6 * np.linalg.norm(J)), values


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_the_catalogue_states_what_counts(name):
    rows = STATED.get(name)
    tool = loaded(name).spec.tool
    assert tool.rows == (tuple(rows.split()) if rows else None)
    assert tool.axes == ("LOCAL" if name in PLANAR else "LOCAL_WORLD_ALIGNED")


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_regular_poses_are_told_as_the_judged_rows_of_j_eq_have_it(name, rng):
    """And the generic rank is the largest of all."""
    for pose in mechanisms.random_closed(loaded(name), rng, 3, spread=0.1):
        singularity = pose.singularity()
        rank, _ = judged_by_hand(pose)
        assert singularity.tool_rank == rank == singularity.generic_tool_rank
        assert singularity.kind == "regular"


@pytest.mark.parametrize("name", LOSSES)
def test_a_pose_where_the_judged_rows_lose_rank_is_a_loss(name):
    pose = LOSSES[name]()
    singularity = pose.singularity()
    rank, _ = judged_by_hand(pose)
    assert rank == singularity.tool_rank < singularity.generic_tool_rank
    assert (singularity.kind, singularity.lost) == ("loss", singularity.generic_tool_rank - rank)
    assert singularity.tool_rows == pose.mechanism.spec.tool.judged
    assert pose.jacobian().J_eq.shape == (6, len(pose.mechanism.actuated))


def test_both_legs_of_a_five_bar_in_line_leave_its_point_no_motion():
    singularity = with_joint_at("five_bar", phi1=0.0, phi2=0.0).singularity()
    assert (singularity.kind, singularity.lost, singularity.tool_rank) == ("loss", 2, 0)


@pytest.mark.parametrize("offset", [1e-2, 1e-4])
def test_beside_a_loss_there_is_none(offset):
    pose = with_joint_at("five_bar", phi1=offset)
    assert pose.singularity().kind == "regular"
    assert judged_by_hand(pose)[0] == 2


@pytest.mark.parametrize("axes", ["LOCAL", "LOCAL_WORLD_ALIGNED"])
@pytest.mark.parametrize("name", mechanisms.mostly_slow(mechanisms.CATALOGUE))
def test_any_rows_of_any_machine_are_judged_as_they_are(name, axes, rng):
    rows = tuple(np.array(TWIST_ROWS)[np.sort(rng.choice(6, rng.integers(1, 6), replace=False))])
    mechanism = pj.load(name, tool_rows=rows, tool_axes=axes)
    assert mechanism.spec.tool.judged == ToolRows(rows, axes)
    for pose in mechanisms.random_closed(mechanism, rng, 2, spread=0.1):
        singularity = pose.singularity()
        rank, values = judged_by_hand(pose)
        if values[min(values.size, max(rank, 1)) - 1] > 1e-4 * mechanism.characteristic_length:
            assert singularity.tool_rank == rank
        plain = loaded(name).configuration(pose.q)
        np.testing.assert_array_equal(pose.jacobian().J_eq, plain.jacobian().J_eq)
        assert singularity.linear_rank == plain.singularity().linear_rank


def turned(mechanism, rotation):
    """The machine on another base, its motors, tool and rows the same."""
    model, spec = mechanism.model, mechanism.spec
    base = pin.SE3(rotation, np.array([0.4, -0.2, 0.7]))
    for joint in range(1, model.njoints):
        if model.parents[joint] == 0:
            model.jointPlacements[joint] = base * model.jointPlacements[joint]
    for frame in model.frames:
        if frame.parentJoint == 0:
            frame.placement = base * frame.placement
    return pj.Mechanism.from_pinocchio(
        model,
        spec.loops,
        mechanism.actuated,
        spec.tool.frame,
        home=mechanism.home.q,
        tool_rows=spec.tool.rows,
        tool_axes=spec.tool.axes,
    )


@pytest.mark.parametrize("name", ["five_bar", "serial_2r", "planar_3rrr", "delta"])
def test_a_machine_on_a_tilted_base_is_judged_alike(name, rng):
    rotation = pin.Quaternion(*rng.normal(size=4)).normalized().matrix()
    pose = LOSSES[name]()
    tilted = turned(pose.mechanism, rotation)
    assert tilted.home.singularity().kind == "regular"
    assert tilted.home.singularity().generic_tool_rank == pose.singularity().generic_tool_rank
    there = tilted.configuration(pose.q).singularity()
    assert (there.kind, there.lost) == ("loss", pose.singularity().lost)


def test_in_the_worlds_axes_a_tilted_plane_is_another():
    upright = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    arm = turned(loaded("serial_2r"), upright)
    given = (arm.model, [], arm.actuated, "tip")
    world = pj.Mechanism.from_pinocchio(*given, home=[0.5, 1.0], tool_rows=["vx", "vy"])
    assert world.home.singularity().generic_tool_rank == 1
    [finding] = [f for f in pj.check(world).findings if f.code == "tool-rows"]
    assert finding.severity == "note"
    assert finding.message == (
        "Judged on vx, vy in the world's axes, the tool moves in 1 way, where 2 would be possible."
    )
    resting = pj.Mechanism.from_pinocchio(*given, home=[0.5, 1.0], tool_rows=["vy"])
    [finding] = [f for f in pj.check(resting).findings if f.code == "tool-rows"]
    assert finding.severity == "warning"
    assert "the tool moves in no way, where 1 would be possible" in finding.message


@pytest.mark.parametrize(
    ("rows", "axes", "words"),
    [
        ([], None, "rows are empty"),
        ("vx,vy", None, "rows are a list, of vx, vy, vz, wx, wy, wz, got 'vx,vy'"),
        (["vx", "vx"], None, "the row 'vx' is listed twice"),
        (["v_x"], None, "unknown row 'v_x' of the tool's twist; did you mean 'vx'?"),
        (["WZ"], None, "did you mean 'wz'?"),
        ([3], None, "it holds 3"),
        (7, None, "rows are a list"),
        (["vx"], "WORLD", "LOCAL_WORLD_ALIGNED .the world's. or LOCAL .the tool's own., got"),
        (["vx"], 5, "got 5"),
        (None, "LOCAL", "`axes` but no `rows`"),
        (["x" * 10_000], None, "unknown row 'x+[.]{3}x+' of"),
    ],
)
def test_rows_that_are_none_are_refused(rows, axes, words):
    with pytest.raises(pj.ArgumentError, match=words) as caught:
        pj.load("four_bar", tool_rows=rows, tool_axes=axes)
    assert len(str(caught.value)) < 300
    model = loaded("four_bar").model
    with pytest.raises(pj.ArgumentError, match=words):
        pj.Mechanism.from_pinocchio(
            model, [], ["theta1"], "coupler_midpoint", tool_rows=rows, tool_axes=axes
        )


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ('rows = ["vx", "vu"]', "unknown row 'vu' of the tool's twist.* - at `tool`"),
        ("rows = []", "rows are empty"),
        ('rows = ["vx", "vx"]', "listed twice"),
        ('rows = "vx"', "Expected `array"),
        ("rows = [1]", "Expected `str`"),
        ('row = ["vx"]', "unknown key `row`.*did you mean 'rows'"),
        ('axes = "LOCAL"', "`axes` but no `rows`"),
        ('rows = ["vx"]\naxes = "local"', "got 'local'"),
    ],
)
def test_a_model_file_says_it_right_or_is_refused(lines, words, tmp_path):
    text = loaded("serial_2r").urdf.text
    (tmp_path / "arm.urdf").write_text(text)
    (tmp_path / "arm.toml").write_text(
        f'urdf = "arm.urdf"\nactuated = ["theta1", "theta2"]\n[tool]\nframe = "tip"\n{lines}\n'
        "[poses.home]\ntheta1 = 0.5\ntheta2 = 1.0\n"
    )
    with pytest.raises(pj.ModelFileError, match=words):
        pj.load(tmp_path / "arm.toml")


def test_rows_are_in_the_twists_order_whatever_order_they_are_given_in():
    one, other = (pj.load("five_bar", tool_rows=rows) for rows in (["wz", "vx"], ("vx", "wz")))
    assert one == other
    assert one.spec.tool.rows == ("vx", "wz")
    # The file's axes stay, as long as others are not asked for.
    assert one.spec.tool.axes == "LOCAL"
    world = pj.load("five_bar", tool_axes="LOCAL_WORLD_ALIGNED")
    assert world.spec.tool.judged == ToolRows(("vx", "vy"))


def test_another_tool_has_rows_of_its_own():
    """What the file states is about its own tool."""
    assert pj.load("five_bar", tool="distal2").spec.tool.judged == WHOLE_TWIST
    rows = pj.load("five_bar", tool="distal2", tool_rows=["vx", "vy"]).spec.tool.judged
    assert rows == ToolRows(("vx", "vy"))


@pytest.mark.parametrize("name", ["five_bar", "delta"])
def test_they_survive_whatever_is_done_to_a_mechanism(name, tmp_path):
    mechanism = loaded(name)
    tool = mechanism.spec.tool
    assert decode_spec(encode_spec(mechanism.spec)).tool == tool
    assert pickle.loads(pickle.dumps(mechanism)).spec.tool == tool
    assert pj.load(pj.convert(name, tmp_path / "mine.toml")[0]).spec.tool == tool
    written = pj.convert(name, tmp_path / "x.toml", tool_rows=["vx"], tool_axes="LOCAL")[0]
    assert pj.load(written).spec.tool.judged == ToolRows(("vx",), "LOCAL")
    recut = pj.recut(mechanism, {"five_bar": "phi1", "delta": "elbow1"}[name])
    assert recut.spec.tool == tool
    here, there = mechanism.home.singularity(), recut.home.singularity()
    assert (there.generic_tool_rank, there.tool_rank) == (here.generic_tool_rank, here.tool_rank)


def test_every_report_says_what_was_judged():
    pose = stretched_five_bar()
    assert "kind='loss'" in repr(pose.singularity())
    assert repr(pose.singularity()).endswith("judged on vx, vy in the tool's own axes)")
    report = pj.report(pose)
    found = json.loads(to_json(report.told()))["singularity"]
    assert (found["tool_rows"], found["tool_axes"]) == (["vx", "vy"], "LOCAL")
    assert (found["tool_rank"], found["generic_tool_rank"], found["lost"]) == (1, 2, 1)
    text = drawn(report_blocks(report), 100)
    assert "judged on" in text
    assert "vx, vy in the tool's own axes" in text
    whole = drawn(report_blocks(pj.report(loaded("four_bar").home)), 100)
    assert "the whole twist" in whole


def test_check_says_what_was_judged():
    """A mechanism whose home is its stretched pose."""
    pose = stretched_five_bar()
    mechanism = pose.mechanism
    at_loss = pj.Mechanism.from_pinocchio(
        mechanism.model,
        mechanism.spec.loops,
        mechanism.actuated,
        "tip",
        home=pose.q,
        tool_rows=["vx", "vy"],
    )
    assert at_loss.home.singularity().kind == "loss"
    diagnosis = pj.check(at_loss)
    messages = [finding.message for finding in diagnosis.findings]
    expected = "At 'home' the tool loses a motion, judged on vx, vy in the world's axes."
    assert expected in messages
    assert diagnosis.tool_rows == ("vx", "vy")
    assert diagnosis.tool_rank == 2
    assert "tool: tip, judged on vx, vy in the world's axes" in drawn(
        diagnosis_blocks(diagnosis), 100
    )


def test_the_command_line_takes_them(capsys):
    command = ["report", "serial_2r", "--at", "0.3,0", "--json"]
    told = []
    for rows in ([], ["--tool-rows", "vx, vy,wz"], ["--tool-rows", "wz", "--tool-axes", "local"]):
        assert main([*command, *rows]) == 0
        found = json.loads(capsys.readouterr().out)["singularity"]
        told.append((found["kind"], ",".join(found["tool_rows"]), found["tool_axes"]))
    assert told == [
        ("loss", "vx,vy", "LOCAL"),
        ("regular", "vx,vy,wz", "LOCAL"),
        ("regular", "wz", "LOCAL"),
    ]
    assert main([*command, "--tool-rows", "vx,va"]) == 2
    error = capsys.readouterr().err
    assert "unknown row 'va' of the tool's twist" in error
    assert error.count("\n") == 1
