"""Another tool at no reload, and machines whose files name none."""

from __future__ import annotations

import pickle

import numpy as np
import pinocchio as pin
import pytest
from mechanisms import CATALOGUE, loaded, mostly_slow
from transformed import resolved

import pmjac_pin as pj
from pmjac_pin.batches.batch import Batch
from pmjac_pin.batches.few_poses import FewPoses

FOUR_BAR = """
<robot name="bar">
  <link name="ground"/><link name="crank"/><link name="coupler"/><link name="rocker"/>
  <link name="far_end"/>
  <joint name="a" type="continuous"><parent link="ground"/><child link="crank"/>
    <axis xyz="0 0 1"/></joint>
  <joint name="b" type="continuous"><parent link="crank"/><child link="coupler"/>
    <origin xyz="1 0 0"/><axis xyz="0 0 1"/></joint>
  <joint name="c" type="continuous"><parent link="ground"/><child link="rocker"/>
    <origin xyz="3 0 0"/><axis xyz="0 0 1"/></joint>
  <joint name="end" type="fixed"><parent link="coupler"/><child link="far_end"/>
    <origin xyz="2.5 0 0"/></joint>
  <loop name="d" type="revolute">
    <predecessor link="coupler"><origin xyz="2.5 0 0"/></predecessor>
    <successor link="rocker"><origin xyz="0 2 0"/></successor><axis xyz="0 0 1"/>
  </loop>
</robot>
"""


def frames(mechanism, count):
    """Some frames of a model, from its whole length."""
    names = [frame.name for frame in mechanism.model.frames if frame.name != "universe"]
    chosen = np.linspace(0, len(names) - 1, count).astype(int)
    return [names[k] for k in dict.fromkeys(chosen.tolist())]


def jacobian_or_error(configuration):
    try:
        return configuration.jacobian().J_eq
    except pj.NoJacobianError as error:
        return str(error)


@pytest.mark.parametrize("name", mostly_slow(CATALOGUE))
def test_another_tool_is_that_of_a_mechanism_loaded_with_it(name):
    mechanism = loaded(name)
    for frame in frames(mechanism, 3):
        other, expected = mechanism.with_tool(frame), pj.load(name, tool=frame)
        np.testing.assert_array_equal(other.home.q, expected.home.q)
        assert other.problem.partition.generic_ranks == expected.problem.partition.generic_ranks
        assert other.home.singularity().kind == expected.home.singularity().kind
        one, two = jacobian_or_error(other.home), jacobian_or_error(expected.home)
        np.testing.assert_array_equal(one, two)


@pytest.mark.parametrize("name", ["three_rps", "delta_rods", "watt_six_bar"])
@pytest.mark.parametrize("frame", ["LOCAL_WORLD_ALIGNED", "LOCAL", "WORLD"])
def test_its_jacobian_is_the_derivative_of_its_pose(name, frame):
    mechanism = loaded(name)
    home = mechanism.home
    for tool in frames(mechanism, 3)[1:]:
        try:
            J_eq = home.jacobian(frame, tool=tool).J_eq
        except pj.IdleMotionError:
            continue
        step = 1e-6
        for column in range(len(mechanism.actuated)):
            ends = []
            for sign in (1.0, -1.0):
                values = home.actuated.copy()
                values[column] += sign * step
                ends.append(mechanism.close(values).with_tool(tool).tool_pose())
            here = home.with_tool(tool).tool_pose()
            turn = pin.log3(ends[0].rotation @ ends[1].rotation.T) / (2.0 * step)
            move = (ends[0].translation - ends[1].translation) / (2.0 * step)
            if frame == "WORLD":
                move = move + np.cross(here.translation, turn)
            if frame == "LOCAL":
                move, turn = here.rotation.T @ move, here.rotation.T @ turn
            np.testing.assert_allclose(J_eq[:, column], [*move, *turn], atol=1e-7)


@pytest.mark.parametrize("name", ["four_bar", "three_rps", "delta_rods", "ur5"])
def test_the_pose_of_any_frame_is_pinocchios(name):
    mechanism = loaded(name)
    data = mechanism.model.createData()
    pin.framesForwardKinematics(mechanism.model, data, mechanism.home.q)
    for frame in frames(mechanism, 4):
        placed = data.oMf[mechanism.model.getFrameId(frame)]
        found = mechanism.home.tool_pose(frame)
        np.testing.assert_allclose(found.homogeneous, placed.homogeneous, atol=1e-13)
    own = mechanism.home.tool_pose(tool=mechanism.spec.tool.frame or mechanism.spec.tool.points)
    np.testing.assert_array_equal(own.homogeneous, mechanism.home.tool_pose().homogeneous)


def test_three_frames_span_a_tool():
    mechanism = loaded("three_rps")
    spanned = mechanism.with_tool(["S1", "S2", "S3"])
    data = mechanism.model.createData()
    pin.framesForwardKinematics(mechanism.model, data, spanned.home.q)
    points = [data.oMf[mechanism.model.getFrameId(f"S{k}")].translation for k in (1, 2, 3)]
    found = spanned.home.tool_pose().translation
    np.testing.assert_allclose(found, np.mean(points, axis=0), atol=1e-12)
    asked = mechanism.home.tool_pose(["S1", "S2", "S3"]).translation
    np.testing.assert_array_equal(asked, found)


def test_a_tool_is_made_once_and_its_own_is_itself():
    mechanism = loaded("five_bar")
    assert mechanism.with_tool("tip2") is mechanism.with_tool("tip2")
    own = mechanism.spec.tool
    assert mechanism.with_tool(own.frame, rows=own.rows, axes=own.axes) is mechanism
    again = pickle.loads(pickle.dumps(mechanism.with_tool("tip2")))
    np.testing.assert_array_equal(
        again.home.jacobian().J_eq, mechanism.home.jacobian(tool="tip2").J_eq
    )


@pytest.mark.parametrize(
    ("tool", "kind", "said"),
    [
        ("tipp", pj.UnknownNameError, "did you mean 'tip'"),
        (["tip", "tip2"], pj.ArgumentError, "a tool is one frame or three"),
        (3, pj.ArgumentError, "a tool is one frame or three"),
        (["tip", "tip", "tip2"], pj.ArgumentError, "must differ"),
        (["tip", 3, "tip2"], pj.PmjacError, "3"),
    ],
)
def test_what_is_no_tool(tool, kind, said):
    mechanism = loaded("five_bar")
    for ask in (mechanism.with_tool, mechanism.home.with_tool):
        with pytest.raises(kind, match=said):
            ask(tool)
    with pytest.raises(kind, match=said):
        mechanism.home.jacobian(tool=tool)
    with pytest.raises(kind, match=said):
        mechanism.home.tool_pose(tool)


# --- files that name no tool ---------------------------------------------------------------------


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "bar.urdf").write_text(FOUR_BAR)
    return tmp_path


def test_check_needs_no_tool(folder):
    diagnosis = pj.check(folder / "bar.urdf", actuated=["a"])
    told = {finding.code: finding for finding in diagnosis.findings}
    assert told["no-tool"].severity == "warning"
    assert "'far_end'" in told["no-tool"].message
    named = pj.check(folder / "bar.urdf", actuated=["a"], tool="far_end")
    others = [finding for finding in diagnosis.findings if finding.code != "no-tool"]
    assert others == list(named.findings)
    assert diagnosis.mobility == named.mobility


def test_elsewhere_the_error_names_the_ends_of_chains_first(folder):
    home = pj.load(folder / "bar.urdf", actuated=["a"]).home
    with pytest.raises(pj.NoToolError, match=r"bar has no tool: .*jacobian\(tool=.*, of: far_e"):
        home.jacobian()


def test_a_model_of_joints_alone_says_that_it_has_no_frame():
    model = pin.Model()
    model.addJoint(0, pin.JointModelRX(), pin.SE3.Identity(), "a")
    bare = pj.Mechanism.from_pinocchio(model, [], ["a"])
    for ask in (bare.home.jacobian, bare.home.tool_pose, lambda: pj.check(bare)):
        with pytest.raises(
            pj.NoToolError, match="has no link that could be one; add a frame"
        ) as no:
            ask()
        assert no.value.frames == ()


def test_check_of_a_joint_that_is_named_as_its_link_is(tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text(
        '<robot name="arm"><link name="base"/><link name="hand"/>'
        '<joint name="hand" type="continuous"><parent link="base"/><child link="hand"/></joint>'
        "</robot>"
    )
    assert "'hand'" in pj.check(path).findings[0].message
    assert pj.load(path).possible_tools == ("hand", "base")


@pytest.mark.parametrize("name", CATALOGUE)
def test_a_mechanism_without_a_tool_is_the_same_machine(name, rng):
    """It closes, has ranks and modes; J_eq comes with a frame that is named then."""
    whole = loaded(name)
    spec = whole.spec
    alone = pj.Mechanism.from_pinocchio(
        whole.model,
        resolved(whole),
        spec.actuated,
        passive=spec.passive,
        home=whole.home.q,
        tolerance=spec.tolerance,
    )
    assert alone.mobility == whole.mobility
    for one in (alone.home, alone.close(alone.home.actuated)):
        here, there = one.singularity(), whole.configuration(one.q).singularity()
        assert (here.kind, here.rank, here.generic_rank) == (
            there.kind,
            there.rank,
            there.generic_rank,
        )
    tool = spec.tool.frame or spec.tool.points
    found = alone.home.jacobian(tool=tool).J_eq
    np.testing.assert_allclose(found, whole.home.jacobian().J_eq, atol=1e-13)
    split = alone.home.split_jacobian()
    assert np.isfinite(split.K_star).all()
    assert np.isnan(split.Jv).all()
    for ask in (
        alone.home.jacobian,
        alone.home.allowed_jacobian,
        alone.home.dynamics,
        lambda: alone.home.statics(np.zeros(6)),
        alone.home.tool_pose,
        lambda: str(pj.report(alone.home)),
        lambda: pj.view(alone.home, open_browser=False, port=0),
        lambda: pj.batch(alone).jacobian([alone.home.q]),
    ):
        with pytest.raises(pj.NoToolError, match="has no tool"):
            ask()
    assert {f.code for f in pj.check(alone).findings} >= {"no-tool"}


@pytest.mark.parametrize("count", [0, 1])
@pytest.mark.parametrize("kind", [Batch, FewPoses])
@pytest.mark.parametrize("call", ["jacobian", "ellipsoids", "measures"])
def test_many_poses_need_a_tool_where_one_does(kind, call, count):
    whole = loaded("five_bar")
    alone = pj.Mechanism.from_pinocchio(
        whole.model, resolved(whole), whole.actuated, home=whole.home.q
    )
    many, q, values = kind(alone), alone.home.q, alone.home.actuated
    of_rows = {call: np.tile(q, (count, 1))}
    if call != "jacobian":
        of_rows[f"{call}_at"] = np.tile(values, (count, 1))
    for name, rows in of_rows.items():
        with pytest.raises(pj.NoToolError, match="has no tool"):
            getattr(many, name)(rows)


@pytest.mark.parametrize("name", ["four_bar", "five_bar"])
def test_modes_without_a_tool(name):
    whole = loaded(name)
    alone = pj.Mechanism.from_pinocchio(
        whole.model, resolved(whole), whole.spec.actuated, home=whole.home.q
    )
    modes = pj.assembly_modes(alone, alone.home.actuated, rng=0)
    assert len(modes) == len(pj.assembly_modes(whole, whole.home.actuated, rng=0))
    assert "mode" in modes._repr_html_()


def test_a_folder_or_its_yaml_stands_for_the_urdf_in_it(folder):
    expected = pj.load(folder / "bar.urdf", actuated=["a"], tool="far_end").home.jacobian().J_eq
    found = pj.load(folder, actuated=["a"], tool="far_end")
    np.testing.assert_array_equal(found.home.jacobian().J_eq, expected)
    (folder / "other.urdf").write_text(FOUR_BAR)
    with pytest.raises(pj.ModelFileError, match=r"which file is meant\? There are: bar.urdf, oth"):
        pj.load(folder, tool="far_end")
    (folder / "robot.urdf").write_text(FOUR_BAR.replace('"bar"', '"robot"'))
    assert pj.load(folder, actuated=["a"], tool="far_end").name == "robot"
    (folder / "empty").mkdir()
    with pytest.raises(pj.ModelFileError, match=r"no URDF in this folder$"):
        pj.load(folder / "empty")
    (folder / "empty" / "robot.urdf.xacro").write_text("<robot/>")
    with pytest.raises(pj.ModelFileError, match=r"this folder; there are: robot\.urdf\.xacro"):
        pj.load(folder / "empty")


def test_the_yaml_of_an_extended_urdf_stands_for_it(tmp_path):
    tree = FOUR_BAR[: FOUR_BAR.index("  <loop")] + "</robot>"
    tree = tree.replace(
        "</robot>",
        '<link name="rocker_tip"/><joint name="f" type="fixed"><parent link="rocker"/>'
        '<child link="rocker_tip"/><origin xyz="0 2 0"/></joint></robot>',
    )
    (tmp_path / "robot.urdf").write_text(tree)
    (tmp_path / "robot.yaml").write_text(
        "closed_loop: [[far_end, rocker_tip]]\ntype: [3d]\nname_mot: [a]\n"
    )
    by_yaml, by_urdf, by_folder = (
        pj.load(path, tool="far_end")
        for path in (tmp_path / "robot.yaml", tmp_path / "robot.urdf", tmp_path)
    )
    assert by_yaml.actuated == by_folder.actuated == by_urdf.actuated
    np.testing.assert_array_equal(by_yaml.home.q, by_urdf.home.q)


@pytest.mark.parametrize("name", ["loops.yaml", "robot.yml"])
def test_a_yaml_file_that_is_not_read_with_the_urdf_is_refused(folder, name):
    """Its loops would be left out without a word."""
    (folder / name).write_text("closed_loop: [[far_end, rocker]]\ntype: [3d]\nname_mot: [a]\n")
    with pytest.raises(pj.ModelFileError, match=r"bar\.urdf is not read with this file; name it"):
        pj.load(folder / name, tool="far_end")


@pytest.mark.parametrize("name", ["bar.toml", "bar.sdf"])
def test_a_folder_with_files_that_may_say_more_asks_which_is_meant(folder, name):
    (folder / name).write_text("")
    with pytest.raises(pj.ModelFileError, match="which file is meant"):
        pj.load(folder, actuated=["a"], tool="far_end")


@pytest.mark.parametrize(
    ("suffix", "said"),
    [(".xacro", "xacro FILE"), (".wbt", "export the robot as URDF"), (".usd", "USD is not read")],
)
def test_formats_that_are_not_read_say_what_makes_them_readable(tmp_path, suffix, said):
    path = tmp_path / f"robot{suffix}"
    path.write_text("<robot/>")
    with pytest.raises(pj.ModelFileError, match=said):
        pj.load(path)
