"""SDFormat files: what the reader makes of poses, axes, joints that close loops, and bad input."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import pmjac_pin as pj
from pmjac_pin.closing.assembly import build_parts
from pmjac_pin.files.foreign_model import ForeignModel
from pmjac_pin.files.sdf.reader import read_sdf
from pmjac_pin.files.visuals import read_visuals
from pmjac_pin.kinematics.loop_system import LoopSystem
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.linkage import with_spherical

AXIS = "<axis><xyz>0 0 1</xyz></axis>"


def sdf(body: str, version: str = "1.9", model: str = 'name="m"') -> str:
    return f'<sdf version="{version}"><model {model}>{body}</model></sdf>'


def link(name: str, pose: str = "", attributes: str = "") -> str:
    return f'<link name="{name}"><pose {attributes}>{pose}</pose></link>'


def joint(name: str, parent: str, child: str, kind: str = "revolute", inside: str = AXIS) -> str:
    ends = f"<parent>{parent}</parent><child>{child}</child>"
    return f'<joint name="{name}" type="{kind}">{ends}{inside}</joint>'


@pytest.fixture
def read(tmp_path: Path):
    def _read(text: str) -> ForeignModel:
        path = tmp_path / "robot.sdf"
        path.write_text(text)
        return read_sdf(path)

    return _read


def built(found: ForeignModel) -> pin.Model:
    model = pin.buildModelFromXML(found.urdf.kinematic_xml())
    return with_spherical(model, found.spherical) if found.spherical else model


def placements(found: ForeignModel, **values: float) -> dict[str, pin.SE3]:
    """Where all links are, in the world, at these joint values."""
    model = built(found)
    q = pin.neutral(model)
    for name, value in values.items():
        entry = model.joints[model.getJointId(name)]
        assert entry.nq == 1
        q[entry.idx_q] = value
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    return {frame.name: data.oMf[k] for k, frame in enumerate(model.frames)}


def pose(x: float, y: float, z: float, *rpy: float) -> pin.SE3:
    return pin.SE3(pin.rpy.rpyToMatrix(np.array(rpy or (0.0, 0.0, 0.0))), np.array([x, y, z]))


def assert_close(found: pin.SE3, wanted: pin.SE3) -> None:
    np.testing.assert_allclose(found.homogeneous, wanted.homogeneous, atol=1e-13)


def test_links_are_where_the_file_puts_them(read) -> None:
    body = (
        "<pose>0 0 1 0 0 0.5</pose>"
        + link("a", "1 0 0 0.1 1.5708 -2")
        + link("b", "0 2 0 0 0 0.3", 'relative_to="a"')
        + link("c", "90 0 0 0 0 90", 'degrees="true" relative_to="j"')
        + link("d", "1 2 3 0 0 0.6 0.8", 'rotation_format="quat_xyzw"')
        + '<frame name="f" attached_to="b"><pose>0 0 0.5 0 0 0</pose></frame>'
        + joint("i", "a", "b", inside="<pose>0.1 0.2 0.3 1 2 3</pose>" + AXIS)
        + joint("j", "b", "c", inside='<pose relative_to="b">0 0 0.25 0 0 0</pose>' + AXIS)
        + joint("k", "c", "d", "fixed", "")
    )
    found, model = placements(read(sdf(body))), pose(0, 0, 1, 0, 0, 0.5)
    a = model * pose(1, 0, 0, 0.1, 1.5708, -2)
    b = a * pose(0, 2, 0, 0, 0, 0.3)
    assert_close(found["a"], a)
    assert_close(found["b"], b)
    assert_close(found["f"], b * pose(0, 0, 0.5))
    assert_close(found["c"], b * pose(0, 0, 0.25) * pose(90, 0, 0, 0, 0, np.pi / 2))
    assert_close(found["d"], model * pose(1, 2, 3, 0, 0, 2 * np.arctan2(0.6, 0.8)))


def test_the_model_is_placed_by_the_frame_that_it_names(read) -> None:
    body = "<pose>0 0 1 0 0 0.5</pose>" + link("a") + link("b", "1 2 0 0.1 0.2 0.3")
    text = sdf(body + joint("j", "a", "b"), model='name="m" placement_frame="b"')
    assert_close(placements(read(text))["b"], pose(0, 0, 1, 0, 0, 0.5))


JOINT_POSE = "<pose>0.1 -0.2 0.3 0.4 -0.5 0.6</pose>"
IN_MODEL = "<axis><xyz>1 2 3</xyz><use_parent_model_frame>{}</use_parent_model_frame></axis>"
AXES = {
    "the joint's": ("1.9", "<axis><xyz>1 2 3</xyz></axis>", "j"),
    "the joint's by default": ("1.6", "<axis><xyz>1 2 3</xyz></axis>", "j"),
    "the joint's when the model's is declined": ("1.5", IN_MODEL.format("false"), "j"),
    "the model's on request": ("1.6", IN_MODEL.format(1), "__model__"),
    "the model's before 1.5": ("1.4", "<axis><xyz>1 2 3</xyz></axis>", "__model__"),
    "a named frame's": ("1.8", '<axis><xyz expressed_in="a">1 2 3</xyz></axis>', "a"),
    "the model's by name": (
        "1.8",
        '<axis><xyz expressed_in="__model__">1 2 3</xyz></axis>',
        "__model__",
    ),
}


@pytest.mark.parametrize("kind", ["revolute", "prismatic", "turned revolute", "turned prismatic"])
@pytest.mark.parametrize(("version", "axis", "frame"), AXES.values(), ids=AXES)
def test_a_joint_moves_its_child_along_its_axis(read, version, axis, frame, kind) -> None:
    """The child's motion against its parent, by the exponential of the joint's screw."""
    turned, kind = kind.startswith("turned"), kind.removeprefix("turned ")
    a, b = pose(1, 0, 0, 0.1, 1.5708, -2), pose(0, 1, 2, 0.7, 0.2, 0.3)
    body = link("a", "1 0 0 0.1 1.5708 -2") + link("b", "0 1 2 0.7 0.2 0.3")
    root = joint("held", "world", "b" if turned else "a", "fixed", "")
    text = sdf(body + root + joint("j", "a", "b", kind, JOINT_POSE + axis), version)
    found, still = placements(read(text), j=0.7), placements(read(text))
    frames = {"a": a, "j": b * pose(0.1, -0.2, 0.3, 0.4, -0.5, 0.6), "__model__": pose(0, 0, 0)}
    direction = frames[frame].rotation @ np.array([1, 2, 3]) / np.sqrt(14)
    if kind == "prismatic":
        screw = pin.Motion(direction, np.zeros(3))
    else:
        screw = pin.Motion(np.cross(frames["j"].translation, direction), direction)
    assert_close(still["a"].actInv(still["b"]), a.actInv(b))
    assert_close(found["a"].actInv(found["b"]), a.actInv(pin.exp6(0.7 * screw) * b))


CROSS = "<axis><xyz>1 0 0</xyz></axis><axis2><xyz>{}</xyz></axis2>"


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("kind", ["universal", "revolute2"])
def test_a_universal_joint_turns_about_its_first_axis_then_its_second(read, kind, turned) -> None:
    second = "0 1 0" if kind == "universal" else "0 1 1"
    root = joint("held", "world", "b" if turned else "a", "fixed", "")
    cross = joint("j", "a", "b", kind, JOINT_POSE + CROSS.format(second))
    text = sdf(link("a") + link("b", "0 1 2 0 0 0.3") + root + cross)
    found = placements(read(text), j_axis=0.4, j_axis2=-0.8)
    offset = pose(0.1, -0.2, 0.3, 0.4, -0.5, 0.6)
    other = np.array([float(word) for word in second.split()])
    turn = pin.exp3(np.array([0.4, 0, 0])) @ pin.exp3(-0.8 * other / np.linalg.norm(other))
    wanted = pose(0, 1, 2, 0, 0, 0.3) * offset * pin.SE3(turn, np.zeros(3)) * offset.inverse()
    assert_close(found["a"].actInv(found["b"]), wanted)


FOUR_BAR = (
    joint("crank", "world", "a")
    + joint("knee", "a", "b")
    + joint("rocker", "world", "c")
    + joint("{name}", "{parent}", "{child}", "{kind}", "{inside}")
)
LINKS = link("a") + link("b", "0 1 0 0 0 0") + link("c", "3 0 0 0 0 0")
TIP = '<pose relative_to="b">2.5 1.5 0 0 0 0</pose>'
LOOPS = {
    "ball": ("", pj.SphericalLoop, 3),
    "fixed": ("", pj.FrameLoop, 6),
    "revolute": (AXIS, pj.RevoluteLoop, 5),
    "continuous": (AXIS, pj.RevoluteLoop, 5),
    "prismatic": ("<axis><xyz>1 0 0</xyz></axis>", pj.PrismaticLoop, 5),
    "universal": (CROSS.format("0 0 1"), pj.UniversalLoop, 4),
    "revolute2": (CROSS.format("0 0 1"), pj.UniversalLoop, 4),
}


@pytest.mark.parametrize("kind", LOOPS)
def test_the_later_of_two_joints_with_one_child_becomes_a_loop_of_its_kind(read, kind) -> None:
    inside, loop, rows = LOOPS[kind]
    text = FOUR_BAR.format(name="tip", parent="b", child="c", kind=kind, inside=TIP + inside)
    found = read(sdf(LINKS + text))
    assert [type(item) for item in found.loops] == [loop]
    assert found.loops[0].ends == ("tip_on_b", "tip_on_c")
    assert any("'tip'" in note and "'rocker'" in note for note in found.notes)
    model = built(found)
    system = LoopSystem(model, found.loops, {})
    assert len(system.row_names) == rows
    assert [item.name for item in found.urdf.joints if item.type != "fixed"] == [
        "crank",
        "rocker",
        "knee",
    ]
    assert_close(placements(found)["tip_on_c"], pose(2.5, 2.5, 0))


def mechanism(found: ForeignModel, actuated: list[str], tool: str) -> Mechanism:
    spec = found.spec(actuated, tool)
    return Mechanism(build_parts(built(found), spec, {}, found.urdf))


@pytest.mark.parametrize("turned", [False, True])
def test_a_four_bar_moves_as_its_closed_formula_says(read, turned: bool) -> None:
    """ω_coupler and the tip's velocity from the two links' equations alone."""
    parent, child = ("c", "b") if turned else ("b", "c")
    text = FOUR_BAR.format(
        name="tip", parent=parent, child=child, kind="revolute", inside=TIP + AXIS
    )
    found = read(sdf(LINKS + text))
    assert found.loops[0].ends == (f"tip_on_{parent}", f"tip_on_{child}")
    jacobian = mechanism(found, ["crank"], "tip_on_b").home.jacobian().J_eq[:, 0]
    a, b, c, d = np.array([[0, 0], [0, 1], [2.5, 2.5], [3, 0]], dtype=float)

    def across(v: np.ndarray) -> np.ndarray:
        return np.array([-v[1], v[0]])

    # across(b − a) + ω_b across(c − b) = ω_c across(c − d)
    coupler, rocker = np.linalg.solve(
        np.column_stack([across(c - b), -across(c - d)]), -across(b - a)
    )
    np.testing.assert_allclose(jacobian[:2], rocker * across(c - d), atol=1e-9)
    np.testing.assert_allclose(jacobian[5], coupler, atol=1e-9)


def test_the_order_of_the_joints_moves_the_cut_and_leaves_the_jacobian(read) -> None:
    text = FOUR_BAR.format(name="tip", parent="b", child="c", kind="revolute", inside=TIP + AXIS)
    joints = text.split("</joint>")[:-1]
    found, cuts = [], set()
    for shift in range(4):
        shifted = "</joint>".join(joints[shift:] + joints[:shift]) + "</joint>"
        model = read(sdf(LINKS + shifted))
        cuts.add(model.loops[0].ends)
        found.append(mechanism(model, ["crank"], "b").home.jacobian().J_eq)
    assert len(cuts) == 2
    for other in found[1:]:
        np.testing.assert_allclose(other, found[0], atol=1e-9)


def test_what_nothing_holds_is_held_or_left_out(read) -> None:
    body = link("a") + link("b") + link("c") + link("d")
    found = read(sdf(body + joint("j", "b", "a") + joint("k", "c", "d")))
    assert "b" in found.urdf.links
    assert not {"c", "d"} & set(found.urdf.links)
    assert any("'b' is held" in note for note in found.notes)
    assert any("c, d" in note for note in found.notes)
    named = read(sdf(body + joint("j", "b", "a"), model='name="m" canonical_link="a"'))
    assert any("'a' is held" in note for note in named.notes)


def test_limits_move_the_start_only_where_they_leave_zero_out(read) -> None:
    limits = "<axis><xyz>0 0 1</xyz><limit><lower>{}</lower><upper>{}</upper></limit></axis>"
    body = (
        link("a") + link("b") + link("c") + link("d")
        + joint("j", "a", "b", inside=limits.format(-2, -0.5))
        + joint("k", "b", "c", inside=limits.format(-1e16, "inf"))
        + joint("l", "c", "d", "prismatic", limits.format("-inf", 0.5))
    )  # fmt: skip
    found = read(sdf(body))
    assert dict(found.home) == {"j": -0.5}
    model = built(found)
    assert model.lowerPositionLimit.tolist() == [-2.0, -1e16, -1e16]
    assert model.upperPositionLimit.tolist() == [-0.5, 1e16, 0.5]


@pytest.mark.parametrize("signs", [(1, 1), (1, -1), (-1, -1)])
def test_a_gearbox_couples_two_turns_about_its_axes(read, signs) -> None:
    """θ₂ = −ratio·θ₁, seen along the gearbox's axes, whichever way the joints' own axes point."""
    z = "<axis><xyz>0 0 {}</xyz></axis>"
    gears = "<gearbox_reference_body>a</gearbox_reference_body><gearbox_ratio>0.25</gearbox_ratio>"
    text = sdf(
        link("a") + link("b") + link("c")
        + joint("first", "a", "b", inside=z.format(signs[0]))
        + joint("second", "a", "c", inside=z.format(signs[1]))
        + joint("gears", "b", "c", "gearbox", gears + AXIS + "<axis2><xyz>0 0 1</xyz></axis2>")
    )  # fmt: skip
    (loop,) = read(text).loops
    assert loop == pj.JointLoop(
        joints=("first", "second"), ratio=-0.25 * signs[0] * signs[1], offset=0.0
    )


def test_one_model_in_a_world_is_read(read) -> None:
    text = f'<sdf version="1.6"><world name="w"><model name="m">{link("a")}</model></world></sdf>'
    assert read(text).name == "m"


def test_before_names_had_to_differ_a_link_and_a_joint_may_share_one(read) -> None:
    body = (
        link("a")
        + link("b", "0 1 0 0 0 0")
        + joint("b", "a", "b", inside="<pose>1 0 0 0 0 0</pose>" + AXIS)
    )
    found = placements(read(sdf(body, "1.6")))
    assert_close(found["b_on_b"], pose(1, 1, 0))


def test_names_that_the_reader_makes_up_are_not_those_of_the_file(read) -> None:
    body = link("a") + link("j_on_b", "1 0 0 0 0 0") + link("b", "0 1 0 0 0 0")
    pose_of_j = "<pose>0 0 1 0 0 0</pose>"
    text = body + joint("j", "a", "b", inside=pose_of_j + AXIS) + joint("k", "b", "j_on_b")
    found = placements(read(sdf(text)))
    assert_close(found["j_on_b"], pose(1, 0, 0))
    assert_close(found["j_on_b_2"], pose(0, 1, 1))
    assert_close(found["b"], pose(0, 1, 0))


def test_a_motor_is_not_cut(read, tmp_path: Path) -> None:
    read(
        sdf(
            LINKS + FOUR_BAR.format(name="tip", parent="b", child="c", kind="revolute", inside=AXIS)
        )
    )
    (loop,) = read_sdf(tmp_path / "robot.sdf", motors=["tip"]).loops
    assert loop.ends == ("rocker_on_world", "rocker_on_c")


TWO = link("a") + link("b")
ERRORS = {
    "root": ("<robot name='r'/>", "the root element is <robot>; an SDF's is <sdf>"),
    "no version": ("<sdf/>", "<sdf> has no version; 1.4 to 1.12 are read"),
    "version": (sdf(TWO, "1.3"), "the version '1.3'"),
    "no model": ('<sdf version="1.6"/>', "there are 0 models"),
    "two models": (sdf(TWO).replace("</sdf>", '<model name="n"/></sdf>'), "there are 2 models"),
    "nested": (sdf(TWO + '<model name="n"/>'), "a <model> within a <model> is not read"),
    "include": (sdf(TWO + "<include><uri>file:///etc/passwd</uri></include>"), "<include>"),
    "no link": (sdf(""), "the model has no <link>"),
    "unnamed": (sdf("<link/>"), "<link> number 1 has no name"),
    "same name": (sdf(link("a") * 2), "two links are named 'a'"),
    "reserved": (sdf(link("world")), "the name 'world' is SDFormat's own"),
    "kind": (sdf(TWO + joint("j", "a", "b", "revolut")), "did you mean 'revolute'"),
    "screw": (sdf(TWO + joint("j", "a", "b", "screw")), "'j' is a screw and has no <screw_thread"),
    "no pitch": (
        sdf(TWO + joint("j", "a", "b", "screw", AXIS + "<thread_pitch>0</thread_pitch>")),
        "joint 'j', <thread_pitch> is 0; a screw's is of magnitude",
    ),
    "no child": (sdf(TWO + '<joint name="j" type="ball"><parent>a</parent></joint>'), "no <child>"),
    "unknown child": (sdf(TWO + joint("j", "a", "bb")), "the frame 'bb' does not exist"),
    "world as child": (sdf(TWO + joint("j", "a", "world")), "the world cannot be a joint's child"),
    "itself": (sdf(TWO + joint("j", "a", "a")), "joint 'j' joins link 'a' to itself"),
    "no axis": (sdf(TWO + joint("j", "a", "b", inside="")), "joint 'j' has no <axis>"),
    "zero axis": (sdf(TWO + joint("j", "a", "b", inside=AXIS.replace("1", "0"))), "length zero"),
    "NaN axis": (sdf(TWO + joint("j", "a", "b", inside=AXIS.replace("1", "nan"))), "not 3 finite"),
    "two poses": (sdf(link("a").replace("</link>", "<pose/></link>")), "has 2 <pose>; give one"),
    "short pose": (sdf(link("a", "1 2 3")), "<pose> is '1 2 3', not 6 finite numbers"),
    "infinite pose": (sdf(link("a", "1 2 inf 0 0 0")), "not 6 finite numbers"),
    "huge pose": (sdf(link("a", "1 2 1e300 0 0 0")), "of magnitude 1e+09 or less"),
    "quaternion": (sdf(link("a", "0 " * 7, 'rotation_format="quat_xyzw"')), "has length 0, not 1"),
    "rotation": (sdf(link("a", "", 'rotation_format="dcm"')), "euler_rpy and quat_xyzw are read"),
    "joint on itself": (sdf(TWO + joint("j", "a", "j")), "each other: 'j' -> 'j'"),
    "degrees": (sdf(link("a", "", 'degrees="perhaps"')), "'perhaps' is neither true nor false"),
    "relative to": (sdf(TWO + link("c", "", 'relative_to="aa"')), "the frame 'aa' does not exist"),
    "relative to itself": (sdf(link("a", "", 'relative_to="a"')), "each other: 'a' -> 'a'"),
    "relative cycle": (
        sdf(link("a", "", 'relative_to="b"') + link("b", "", 'relative_to="a"')),
        "frames are relative to each other: 'a' -> 'b' -> 'a'",
    ),
    "attached cycle": (
        sdf(TWO + '<frame name="f" attached_to="g"/><frame name="g" attached_to="f"/>'),
        "each other",
    ),
    "canonical": (sdf(TWO, model='name="m" canonical_link="c"'), "canonical link 'c' does not"),
    "limits": (
        sdf(
            TWO
            + joint(
                "j",
                "a",
                "b",
                inside=AXIS.replace(
                    "</xyz>", "</xyz><limit><lower>2</lower><upper>1</upper></limit>"
                ),
            )
        ),
        "lower 2 exceeds upper 1",
    ),
    "expressed in": (
        sdf(TWO + joint("j", "a", "b", inside='<axis><xyz expressed_in="cc">0 0 1</xyz></axis>')),
        "the frame 'cc' does not exist",
    ),
    "oblique loop": (
        sdf(
            LINKS
            + FOUR_BAR.format(
                name="t", parent="b", child="c", kind="revolute2", inside=CROSS.format("1 1 0")
            )
        ),
        "its axes are not perpendicular",
    ),
    "gearbox": (
        sdf(TWO + joint("j", "a", "b") + joint("g", "a", "b", "gearbox", CROSS.format("1 0 0"))),
        "has no <gearbox_reference_body>",
    ),
    "entities": ('<!DOCTYPE x [<!ENTITY a "b">]>' + sdf(TWO), "DOCTYPE"),
    "external": ('<!DOCTYPE x [<!ENTITY a SYSTEM "file:///etc/passwd">]>' + sdf("&a;"), "DOCTYPE"),
    "deep": ("<sdf version='1.6'>" + "<model>" * 200 + "</model>" * 200 + "</sdf>", "nested more"),
    "truncated": (sdf(TWO)[:-9], "not well-formed XML"),
    "too many links": (sdf("".join(map(link, map(str, range(1001))))), "at most 1000 are read"),
}


@pytest.mark.parametrize(("text", "message"), ERRORS.values(), ids=ERRORS)
def test_what_is_wrong_is_said_in_one_line(read, tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(pj.ModelFileError) as caught:
        read(text)
    said = str(caught.value)
    assert message in said
    assert said.startswith(f"{tmp_path / 'robot.sdf'}: ")
    assert "\n" not in said
    assert len(said) < 500
    assert caught.value.path == str(tmp_path / "robot.sdf")


def test_a_file_that_is_too_large_is_not_opened(tmp_path: Path) -> None:
    path = tmp_path / "large.sdf"
    with path.open("wb") as file:
        file.truncate(50_000_000)
    with pytest.raises(pj.ModelFileError, match="at most 20000000 are read"):
        read_sdf(path)


def test_a_long_chain_of_frames_is_followed(read) -> None:
    chain = "".join(
        f'<frame name="f{k}" attached_to="f{k + 1}"><pose>0 0 1 0 0 0</pose></frame>'
        for k in range(990)
    )
    found = read(sdf(link("a") + chain.replace("f990", "a")))
    assert found.urdf.links


SEEDS = sdf(
    LINKS
    + FOUR_BAR.format(
        name="tip", parent="b", child="c", kind="universal", inside=TIP + CROSS.format("0 0 1")
    )
    + '<frame name="f" attached_to="b"><pose relative_to="c">1 2 3 0 0 0</pose></frame>'
)
SCRAPS = [
    "",
    " ",
    "<",
    ">",
    "/",
    '"',
    "a",
    "0",
    "-",
    "nan",
    "1e999",
    "world",
    "__model__",
    "\x00",
    "é",
    "fixed",
    "<pose>",
    "</pose>",
    'relative_to="tip"',
    "child",
    "\ud7ff",
]


def mutilated(rng: np.random.Generator) -> str:
    """A few scraps in the text, which may end early."""
    text = SEEDS
    for _ in range(rng.integers(1, 6)):
        start = int(rng.integers(len(text)))
        end = start + int(rng.integers(0, 12))
        text = text[:start] + str(rng.choice(SCRAPS)) + text[end:]
    return text[: rng.integers(len(text))] if rng.random() < 0.2 else text


def swapped(rng: np.random.Generator) -> str:
    """A few words of the file replaced by other words of it: well-formed."""
    words = [
        *("revolute", "ball", "fixed", "gearbox", "prismatic", "universal", "world"),
        *("a", "b", "c", "f", "tip", "crank", "knee", "1e16", "-1", "1e-9"),
    ]
    text = SEEDS
    for _ in range(rng.integers(1, 5)):
        old, new = rng.choice(words, 2)
        text = text.replace(f">{old}<", f">{new}<").replace(
            f'"{old}"', f'"{new}"', int(rng.integers(1, 3))
        )
    return text


@pytest.mark.parametrize(("changed", "count"), [(mutilated, 300), (swapped, 200)])
def test_changed_files_give_a_model_or_one_of_our_errors(read, changed, count) -> None:
    for seed in range(count):
        try:
            built(read(changed(np.random.default_rng(seed))))
        except pj.PmjacError as error:
            assert "\n" not in str(error), seed


VISUALS = {
    "box": ("<box><size>1 0.1 0.2</size></box>", [(1.0, 0.1, 0.2)]),
    "sphere": ("<sphere><radius>0.3</radius></sphere>", [(0.3, 0.3, 0.3)]),
    "cylinder": (
        "<cylinder><radius>0.1</radius><length>2</length></cylinder>",
        [(0.1, 0.1, 2.0)],
    ),
    "capsule": (
        "<capsule><radius>0.1</radius><length>2</length></capsule>",
        [(0.1, 0.1, 2.0), (0.1, 0.1, 0.1), (0.1, 0.1, 0.1)],
    ),
    "mesh": ("<mesh><uri>model://arm.stl</uri></mesh>", []),
    "not to be drawn": ("<ellipsoid><radii>1 2 3</radii></ellipsoid>", []),
    "broken": ("<sphere><radius>none</radius></sphere>", []),
}


@pytest.mark.parametrize(("geometry", "sizes"), VISUALS.values(), ids=VISUALS)
def test_visuals_are_where_the_file_has_them(tmp_path, geometry, sizes):
    """Those that are not drawn are there all the same: their bodies do not look turned over."""
    material = "<material><diffuse>1 0 0</diffuse></material>"
    visual = '<visual name="v"><pose relative_to="there">0 0 1 0 0 0</pose>'
    visual += f"{material}<geometry>{geometry}</geometry></visual>"
    arm = f'<link name="arm"><pose>1 2 3 0.4 0.5 0.6</pose>{visual}<visual name="w"><geometry>'
    arm += "<empty/></geometry></visual></link>"
    there = '<frame name="there"><pose>7 8 9 1.5707963267948966 0 0</pose></frame>'
    base = link("base") + joint("hold", "world", "base", "fixed", "")
    turn = joint("turn", "base", "arm", inside=f"<pose>0.1 0.2 0.3 0.4 0 0</pose>{AXIS}")
    path = tmp_path / "machine.sdf"
    path.write_text(sdf(base + arm + there + turn))
    mechanism = pj.load(path, actuated=["turn"], tool="arm")
    [found] = read_visuals(mechanism.urdf)
    assert (found.link, found.colour) == ("arm", (1.0, 0.0, 0.0, 1.0))
    assert mechanism.unread == ()
    placed = mechanism.home.tool_pose().homogeneous
    given = [placed @ transform for _, transform in found.pieces]
    assert len(given) == len(sizes)
    for transform, size in zip(given, sizes, strict=True):
        np.testing.assert_allclose(np.linalg.norm(transform[:3, :3], axis=0), size)
    if given:
        np.testing.assert_allclose(given[0][:3, 3], [7.0, 7.0, 9.0], atol=1e-12)
        np.testing.assert_allclose(given[0][:3, 2] / sizes[0][2], [0.0, -1.0, 0.0], atol=1e-12)


def test_a_misspelt_visual_is_an_error(read):
    visual = '<visual name="v"><geometry><bxo/></geometry></visual>'
    with pytest.raises(pj.ModelFileError, match="<geometry> holds an unknown <bxo>; did you mean"):
        read(sdf(f'<link name="a">{visual}</link>'))
