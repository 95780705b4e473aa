"""URDF with loops: one four-bar written in every way gives one J_eq."""

from __future__ import annotations

import math
import re

import looped
import numpy as np
import pytest
from looped import TOOL, joint, link, robot
from mutations import mutations

import pmjac_pin as pj
from pmjac_pin.files.urdf.looped_urdf import read_looped_urdf


@pytest.fixture
def write(tmp_path):
    def write(text, name="machine.urdf"):
        path = tmp_path / name
        path.write_text(text)
        return path

    return write


@pytest.fixture
def read(write):
    return lambda text: read_looped_urdf(write(text))


@pytest.fixture
def refusal(write):
    def refusal(text, **arguments):
        path = write(text)
        with pytest.raises(pj.ModelFileError) as caught:
            read_looped_urdf(path, **arguments)
        message = str(caught.value)
        assert message.startswith(f"{path}: ")
        assert "\n" not in message
        return message.removeprefix(f"{path}: ")

    return refusal


def j_eq(path, **arguments):
    given = {"actuated": ["theta1"], "tool": TOOL, **arguments}
    return pj.load(path, **given).home.jacobian().J_eq


LOOPED = {
    "two parents, hinge cut": looped.two_parents(),
    "two parents, weld cut": looped.two_parents(
        ("hinge", "weld", "theta1", "phi1", "phi2", "tool")
    ),
    "endless hinge": looped.two_parents(kind="continuous"),
    "cycle": looped.cycle(),
    "turned": looped.turned(),
    "loop": looped.with_element(looped.loop_element()),
    "loop, other way": looped.with_element(looped.loop_element(axis='<axis xyz="0 0 -2"/>')),
    "ball": looped.with_element(looped.loop_element("spherical", "")),
    "constraint": looped.with_element(looped.constraint_element()),
    "constraint, turned": looped.with_element(
        looped.constraint_element(child_axis="0 1 0", rpy=f"{math.pi / 2} 0 0")
    ),
    "constraint, exported": looped.with_element(
        looped.loop_element().replace("<loop", "<constraint").replace("</loop", "</constraint")
    ),
    "Gazebo's joint": looped.with_element(looped.gazebo_joint()),
    "Gazebo's joint, other way": looped.with_element(looped.gazebo_joint(parent="rocker")),
    "Gazebo's ball": looped.with_element(looped.gazebo_joint("ball", axis="")),
    "Drake's ball": looped.with_drake(looped.ball_constraint()),
    "loop_joint": looped.with_element(looped.loop_joint()),
    "loop_joint, ball": looped.with_element(looped.loop_joint("spherical")),
    "closing frames": looped.with_element(looped.closing_frames()),
}


@pytest.mark.parametrize("text", LOOPED.values(), ids=LOOPED)
def test_one_four_bar_written_in_every_way(write, text):
    expected = looped.home().jacobian().J_eq
    np.testing.assert_allclose(j_eq(write(text)), expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("order", "cut"),
    [
        (("theta1", "phi2", "phi1", "weld", "hinge", "tool"), "hinge"),
        (("hinge", "weld", "theta1", "phi2", "phi1", "tool"), "weld"),
    ],
)
def test_the_first_joint_to_a_link_keeps_it(read, order, cut):
    model = read(looped.two_parents(order))
    (loop,) = model.loops
    kind = pj.RevoluteLoop if cut == "hinge" else pj.FrameLoop
    parent = "rocker" if cut == "hinge" else "coupler"
    assert isinstance(loop, kind)
    assert loop.frames == (f"{cut}_on_{parent}", "pin")
    assert cut not in [joint.name for joint in model.urdf.joints]
    other = "weld" if cut == "hinge" else "hinge"
    closed = "revolute" if cut == "hinge" else "fixed"
    expected = (
        f"joint {cut!r} leads to link 'pin', which {other!r} holds: cut, and closed as {closed}"
    )
    assert model.notes == (expected,)


@pytest.mark.parametrize(
    ("kind", "loop"),
    [
        ("revolute", pj.RevoluteLoop),
        ("continuous", pj.RevoluteLoop),
        ("prismatic", pj.PrismaticLoop),
        ("planar", pj.PlanarLoop),
        ("fixed", pj.FrameLoop),
        ("spherical", pj.SphericalLoop),
        ("ball", pj.SphericalLoop),
    ],
)
def test_a_cut_joint_becomes_a_loop_of_its_kind(read, kind, loop):
    model = read(looped.two_parents(kind=kind))
    assert [type(loop) for loop in model.loops] == [loop]
    if hasattr(model.loops[0], "axis"):
        assert model.loops[0].axis == (0, 0, 1)


def test_a_floating_joint_closes_nothing(read):
    model = read(looped.two_parents(kind="floating"))
    assert model.loops == ()
    assert model.notes[0] == (
        "joint 'hinge' leads to link 'pin', which 'weld' holds: holds nothing: left out"
    )


def test_in_a_cycle_the_first_link_is_the_base(read):
    model = read(looped.cycle())
    assert model.urdf.links[0] == "ground"
    assert model.notes == (
        "joint 'weld' leads to link 'ground', which is the base: cut, and closed as fixed",
    )


def test_a_turned_joint_keeps_its_value(write):
    """The coupler may hang on a joint of which it is the parent."""
    path = write(looped.turned())
    model = read_looped_urdf(path)
    assert model.notes[0] == "joint 'phi2' is turned round, as none leads to 'coupler'"
    turned = pj.load(path, actuated=["theta1"], tool=TOOL).close([0.2])
    plain = write(looped.two_parents(), "plain.urdf")
    straight = pj.load(plain, actuated=["theta1"], tool=TOOL).close([0.2])
    # One file turns the coupler against the crank by phi2, the other the crank against the coupler.
    assert turned.joint_values["phi2"] == pytest.approx(-straight.joint_values["phi2"])
    np.testing.assert_allclose(turned.jacobian().J_eq, straight.jacobian().J_eq, atol=1e-9)


def test_motors_are_not_cut(write, refusal):
    order = ("weld", "theta1", "phi2", "phi1", "hinge", "tool")
    path = write(looped.two_parents(order))
    mechanism = pj.load(path, actuated=["hinge"], tool=TOOL)
    assert isinstance(mechanism.spec.loops[0], pj.FrameLoop)
    marked = looped.two_parents(order).replace(
        'name="hinge" type="revolute"', 'name="hinge" type="revolute" independent="true"'
    )
    assert isinstance(read_looped_urdf(write(marked)).loops[0], pj.FrameLoop)
    assert refusal(looped.two_parents(), motors=["weld", "hinge"]) == (
        "joint 'hinge' is a motor or geared by <mimic>, and would have to be cut, since another "
        "such joint holds link 'pin', or it is the base"
    )


def test_ball_joints_of_the_tree_turn_only(write):
    """A platform on a ball at the end of a slider, held by nothing else."""
    text = robot(
        *(link(name) for name in ("ground", "slide", "platform")),
        joint("lift", "prismatic", "ground", "slide"),
        joint("socket", "ball", "slide", "platform", (0, 0, 1)),
    )
    mechanism = pj.load(write(text), tool="slide")
    assert (mechanism.nq, mechanism.nv) == (5, 4)
    assert mechanism.spec.spherical == ("socket",)
    assert mechanism.actuated == ("lift",)


def balls_alone(*kinds):
    """A chain of bodies on joints of these kinds."""
    names = ["ground", *(f"body{number}" for number in range(len(kinds)))]
    joints = (
        joint(f"joint{number}", kind, *names[number : number + 2], (0, 0, 1))
        for number, kind in enumerate(kinds)
    )
    return robot(*map(link, names), *joints)


@pytest.mark.parametrize("misspelt", ["sphericl", "Spherical", "spherical_"])
def test_a_misspelt_ball_joint_is_hinted_at(write, misspelt):
    with pytest.raises(pj.ModelFileError, match=f"'{misspelt}'; did you mean 'spherical'"):
        pj.load(write(balls_alone(misspelt)), tool="body0")


@pytest.mark.parametrize("kind", ["spherical", "ball"])
def test_a_model_file_over_a_ball_joint_reads_it_too(write, kind):
    urdf = write(balls_alone("revolute", kind))
    model_file = urdf.with_suffix(".toml")
    model_file.write_text(
        f'urdf = "{urdf.name}"\nactuated = ["joint0", "joint1"]\n'
        'tool.frame = "body1"\n[poses.home]\n'
    )
    loaded, alone = pj.load(model_file), pj.load(urdf, actuated=["joint0", "joint1"], tool="body1")
    assert loaded.spec.spherical == alone.spec.spherical == ("joint1",)
    np.testing.assert_array_equal(loaded.home.jacobian().J_eq, alone.home.jacobian().J_eq)


@pytest.mark.parametrize(
    ("kinds", "offered"),
    [
        (["ball"], ("joint0",)),
        (["floating", "ball"], ("joint0", "joint1")),
    ],
)
def test_where_no_joint_has_one_freedom_the_others_are_offered(write, kinds, offered):
    path = write(balls_alone(*kinds))
    with pytest.raises(pj.NoMotorsError, match=f"give `actuated`, of: {', '.join(offered)}$") as no:
        pj.load(path)
    assert no.value.candidates == offered
    assert pj.load(path, actuated=offered, tool="body0").mobility == {1: 3, 2: 9}[len(offered)]


def test_where_nothing_moves_there_is_nothing_to_offer(write):
    with pytest.raises(pj.ModelFileError, match="no joint of it moves"):
        pj.load(write(balls_alone("fixed")))


# --- what it says of motors, limits and home --------------------------------------------------


def test_independent_joints_are_motors(read):
    model = read(looped.with_element(looped.loop_element(), 'independent="true"'))
    assert model.actuated == ("theta1", "phi2", "phi1")  # URDF+: independent unless it says not
    text = looped.with_element(looped.loop_element(), 'independent="false"')
    assert read(text).actuated == ("phi2", "phi1")
    assert read(looped.with_element(looped.loop_element())).actuated == ()


def test_without_loops_every_joint_is_a_motor(write):
    links, joints = looped.chain()
    mechanism = pj.load(write(robot(*links, *joints.values())), tool=TOOL)
    assert mechanism.actuated == ("theta1", "phi2", "phi1")
    assert mechanism.notes == (
        "no loop closes: every joint of one degree of freedom counts as a motor",
    )


def test_what_the_file_does_not_tell_is_asked_for(write):
    path = write(looped.two_parents())
    with pytest.raises(pj.ModelFileError, match="which joints are motors; give `actuated`, of: t"):
        pj.load(path)
    with pytest.raises(pj.NoToolError, match=r"has no tool: name a frame .*, of: middle"):
        pj.load(path, actuated=["theta1"]).home.jacobian()
    with pytest.raises(pj.UnknownNameError, match="unknown joint 'theta2'; did you mean 'theta1'"):
        pj.load(path, actuated=["theta2"], tool=TOOL)
    with pytest.raises(pj.UnknownNameError, match="unknown frame 'midle'; did you mean 'middle'"):
        pj.load(path, actuated=["theta1"], tool="midle")


def test_mimic_is_a_gear(write):
    """Two fingers on one motor: the second moves twice as far, the other way, from 0.5 on."""
    gear = '<mimic joint="left" multiplier="-2" offset="0.5"/>'
    text = robot(
        *(link(name) for name in ("palm", "a", "b")),
        joint("left", "revolute", "palm", "a"),
        joint("right", "revolute", "palm", "b", (1, 0, 0), inside=gear),
    )
    mechanism = pj.load(write(text), tool="b")
    assert mechanism.spec.loops == (pj.JointLoop(joints=("left", "right"), ratio=-2, offset=0.5),)
    assert (mechanism.actuated, mechanism.passive) == (("left",), ("right",))
    configuration = mechanism.close([0.3])
    assert configuration.passive == pytest.approx([-0.1])
    np.testing.assert_allclose(configuration.jacobian().J_eq[5], [-2.0])


def test_a_range_that_is_not_given_does_not_lock_a_joint(write):
    text = looped.two_parents().replace(' lower="-4" upper="4"', "")
    mechanism = pj.load(write(text), actuated=["theta1"], tool=TOOL)
    assert mechanism.notes[0] == (
        "no limits are given for 'theta1', 'phi2', 'phi1', 'hinge': none are assumed"
    )
    assert mechanism.close([1.0]).actuated == pytest.approx([1.0])


@pytest.mark.parametrize(
    ("limits", "home"),
    [("-1 4", {}), ("1 2", {"lift": 1.5}), ("-5 -3", {"lift": -4.0}), ("1 1e9", {"lift": 1.0})],
)
def test_home_is_within_the_limits(read, limits, home):
    lower, upper = limits.split()
    limit = f'<limit lower="{lower}" upper="{upper}" effort="1" velocity="1"/>'
    text = robot(link("a"), link("b"), joint("lift", "prismatic", "a", "b", inside=limit))
    model = read(text)
    assert model.home == home
    assert any("home starts within" in note for note in model.notes) == bool(home)


def test_meshes_are_not_opened(write):
    mesh = '<visual><geometry><mesh filename="../../../etc/none.stl"/></geometry></visual>'
    text = looped.two_parents().replace('<link name="crank">', f'<link name="crank">{mesh}')
    expected = looped.home().jacobian().J_eq
    np.testing.assert_allclose(j_eq(write(text)), expected, atol=1e-9)


# --- what is wrong -----------------------------------------------------------------------------

GEAR = '<mimic joint="{}"/>'


def fingers(first, second):
    return robot(
        *(link(name) for name in ("palm", "a", "b")),
        joint("left", "revolute", "palm", "a", inside=GEAR.format(first) if first else ""),
        joint("right", "revolute", "palm", "b", inside=GEAR.format(second)),
    )


BAD = {
    "itself": (
        looped.two_parents().replace('<parent link="rocker"/>', '<parent link="pin"/>'),
        "joint 'hinge' joins link 'pin' with itself",
    ),
    "no such link": (
        looped.two_parents().replace('<parent link="rocker"/>', '<parent link="roker"/>'),
        "joint 'hinge': the parent link 'roker' does not exist; did you mean 'rocker'?",
    ),
    "a cut joint's origin": (
        looped.two_parents().replace(looped.numbers(looped.points()["C"] - [4, 0, 0]), "0 nan 0"),
        "joint 'hinge', <origin>: `xyz` is '0 nan 0', not 3 finite numbers",
    ),
    "independent": (
        looped.with_element("", 'independent="maybe"'),
        "joint 'theta1': `independent` is 'maybe', neither true nor false",
    ),
    "mimic of itself": (
        fingers("", "right"),
        "joint 'right', <mimic>: the joint follows itself",
    ),
    "mimic in a circle": (
        fingers("right", "left"),
        "joints follow each other by <mimic>: left -> right -> left",
    ),
    "mimic of nothing": (
        fingers("", "lefft"),
        "joint 'right', <mimic>: the joint 'lefft' does not exist; did you mean 'left'?",
    ),
    "two bases": (
        looped.with_element('<link name="island"/>'),
        "2 links are no joint's child: 'ground', 'island'; join them by joints, fixed ones if "
        "need be",
    ),
    "no links": ('<robot name="r"/>', "there is no <link>; a robot has at least one"),
    "not a robot": ('<sdf name="r"/>', "there is no <link>; a robot has at least one"),
    "an island in a circle": (
        looped.with_element(
            link("x") + link("y") + joint("xy", "fixed", "x", "y") + joint("yx", "fixed", "y", "x")
        ),
        "a cycle of joints: 'xy', 'yx'; cut the loop: remove one of them and declare it as "
        "[[loop]] in the model file",
    ),
    "entities": (
        '<!DOCTYPE r [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]><robot name="&b;"/>',
        "a <!DOCTYPE> is not read, since it could open other files or grow without bound; "
        "remove it",
    ),
    "nested": ("<robot>" * 200 + "</robot>" * 200, "elements are nested more than 100 deep"),
}


@pytest.mark.parametrize(("text", "message"), BAD.values(), ids=BAD)
def test_what_is_refused(refusal, text, message):
    assert refusal(text) == message


def test_too_many_loops_and_joints(refusal):
    anchored = (looped.loop_element().replace("tip", f"tip{k}") for k in range(600))
    assert refusal(looped.with_element("".join(anchored))) == (
        "1205 links are too many; at most 1000 are read"
    )
    ends = '<predecessor link="coupler"/><successor link="rocker"/>'
    bare = f'<loop type="spherical">{ends}</loop>' * 201
    assert refusal(looped.with_element(bare)) == "201 loops are too many; at most 200 are read"
    welds = (joint(f"weld{k}", "fixed", "rocker", "pin") for k in range(3000))
    text = looped.two_parents().replace("</robot>", "".join(welds) + "</robot>")
    assert refusal(text) == "3006 joints are too many; at most 2000 are read"


def test_a_file_of_fifty_megabytes(tmp_path):
    path = tmp_path / "big.urdf"
    with path.open("wb") as file:
        file.truncate(50_000_000)
    with pytest.raises(pj.ModelFileError, match="50000000 bytes are too many"):
        read_looped_urdf(path)


@pytest.mark.parametrize("name", LOOPED)
def test_fuzz_the_whole_way(write, name):
    rng = np.random.default_rng([7, *name.encode()])
    for text in mutations(LOOPED[name], rng, 25):
        try:
            pj.load(write(text), actuated=["theta1"], tool=TOOL)
        except pj.PmjacError as error:
            assert not re.search(r"\n", str(error))
