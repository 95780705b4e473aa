"""MJCF files: names, motors, home poses, notes, pictures, and bad input."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from mjcf_models import FOUR_BAR, GEARS, MODELS, SITES, body, four_bar, mjcf, motor
from mutations import mutations

import pmjac_pin as pj
from pmjac_pin.closing.assembly import build_parts
from pmjac_pin.files.foreign_model import ForeignModel
from pmjac_pin.files.mjcf.reader import read_mjcf
from pmjac_pin.files.visuals import read_visuals
from pmjac_pin.model.linkage import with_spherical


@pytest.fixture
def read(tmp_path: Path):
    def _read(text: str) -> ForeignModel:
        path = tmp_path / "robot.xml"
        path.write_text(text, encoding="utf-8")
        return read_mjcf(path)

    return _read


def built(found: ForeignModel) -> pin.Model:
    model = pin.buildModelFromXML(found.urdf.kinematic_xml())
    return with_spherical(model, found.spherical) if found.spherical else model


HINGED = body("a", '<joint name="j"/>')


def test_a_four_bar_by_connect(read) -> None:
    found = read(FOUR_BAR)
    assert found.name == "robot"
    assert found.loops == (pj.PointLoop(frames=("coupler_at_rocker", "rocker_at_coupler")),)
    assert found.actuated == ("t",)
    assert found.home == {}
    assert found.notes == ()
    assert [joint.type for joint in found.urdf.joints if joint.name in "tpr"] == ["continuous"] * 3


def test_a_gear_counts_from_the_references_and_a_single_joint_is_fixed(read) -> None:
    found = read(GEARS)
    x0, y0 = np.radians([40, -25])
    gears = {loop.joints: (loop.ratio, loop.offset) for loop in found.loops}
    assert gears[("x", "y")] == pytest.approx((-1.5, y0 + 0.2 + 1.5 * x0), abs=1e-15)
    assert gears[("x", "s")] == pytest.approx((1.0, 0.7 - x0), abs=1e-15)
    kinds = {joint.name: joint.type for joint in found.urdf.joints}
    assert (kinds["held"], kinds["held2"], kinds["x"]) == ("fixed", "fixed", "revolute")
    assert found.notes[0].startswith("joint 'held' is held at 0.66")
    assert set(found.home) == {"x", "y", "s"}


ROD = """<tendon><spatial name="rod"><site site="s"/><site site="t"/></spatial>{}</tendon>"""
ENDS = body("a", '<joint name="x"/><site name="s" pos="1 0 0"/>') + body(
    "b", '<joint name="y"/><site name="t" pos="0 3 0"/>'
)


def test_a_tendon_held_from_site_to_site_is_a_rod(read) -> None:
    held = '<tendon name="held" tendon1="rod" polycoef="0.25 0 0 0 0"/>'
    found = read(mjcf(ENDS, held, ROD.format("")))
    (loop,) = found.loops
    assert loop.frames == ("s", "t")
    assert loop.length == pytest.approx(np.sqrt(10.0) + 0.25, abs=1e-15)


@pytest.mark.parametrize(
    ("tendons", "held", "message"),
    [
        (
            '<spatial name="v"><site site="s"/><site site="t"/><site site="s"/></spatial>',
            "v",
            "one",
        ),
        (
            '<spatial name="v"><site site="s"/><geom geom="g"/><site site="t"/></spatial>',
            "v",
            "of tendons a <fixed> one of joints, and one from a site straight to another, are read",
        ),
        ("", "rod", "the length between 's' and 't' must be"),
    ],
)
def test_other_spatial_tendons_are_refused(read, tendons, held, message) -> None:
    constraint = f'<tendon name="held" tendon1="{held}" polycoef="-9 0 0 0 0"/>'
    text = mjcf(ENDS + '<geom name="g" size=".1"/>', constraint, ROD.format(tendons))
    with pytest.raises(pj.ModelFileError, match=message):
        read(text)


@pytest.mark.parametrize(
    ("kind", "count", "moved"),
    [("ball", 3, True), ("ball", 2, False), ("free", 6, True), ("free", 5, False)],
)
def test_a_joint_that_actuators_move_every_way_is_a_motor(read, kind, count, moved) -> None:
    rows = np.eye(6)[:count] + np.tri(count, 6, -1)
    motors = "".join(
        f'<motor joint="o" gear="{" ".join(map(str, row))}"/>' for row in rows.tolist()
    )
    found = read(
        mjcf(body("y", f'<joint name="o" type="{kind}"/>'), "", f"<actuator>{motors}</actuator>")
    )
    assert found.actuated == (("o",) if moved else ())
    assert len([note for note in found.notes if "is left out" in note]) == (0 if moved else count)


def test_what_has_no_name_is_called_after_its_body(read) -> None:
    text = mjcf(
        '<body name="arm"><joint/><joint pos="1 0 0"/><joint type="slide"/><site/><site/>'
        '<body><joint type="ball"/><body/></body><body/></body>'
        '<body name="arm_hinge"><freejoint/></body><site name="world" pos="1 2 3"/><site/>'
    )
    found = read(text)
    joints = [joint.name for joint in found.urdf.joints if joint.type != "fixed"]
    assert joints == ["arm_hinge_2", "arm_hinge_3", "arm_slide", "arm_body_ball", "arm_hinge_free"]
    bodies = {"arm_body", "arm_body_2", "arm_body_3"}
    assert {"arm_site", "arm_site_2", *bodies} < set(found.urdf.links)
    assert {"world_site", "world_site_2"} < set(found.urdf.links)


def test_joint_and_body_of_one_name_stay_so(read) -> None:
    found = read(mjcf(body("a", '<joint name="a"/><site name="a"/>')))
    assert [joint.name for joint in found.urdf.joints] == ["a", "a_site_fixed"]
    assert found.urdf.links == ("world", "a", "a_site")


def test_added_names_stay_clear_of_those_further_down(read) -> None:
    text = mjcf(
        body("b", '<site name="s"/><joint name="j" pos="1 0 0"/>')
        + body("j_on_b", '<joint name="s_fixed"/>')
        + body("b_at_c", '<joint name="b_at_c_fixed"/>')
        + body("c", '<joint name="b_fixed"/>'),
        '<connect body1="b" body2="c" anchor="1 2 3"/>',
    )
    assert read(text).loops[0].frames == ("b_at_c_2", "c_at_b")


def test_motors_are_the_hinges_and_slides_that_actuators_move(read) -> None:
    joints = "".join(f'<joint name="{name}"/>' for name in "abc")
    bodies = body("x", joints) + body("y", '<joint name="o" type="ball"/>')
    actuators = (
        '<position joint="c"/><motor joint="a"/><general joint="c" name="again"/>'
        '<motor joint="o" name="on ball"/><velocity jointinparent="b"/><damper joint="a"/>'
        '<motor site="s" name="thruster"/><muscle tendon="t"/>'
    )
    found = read(mjcf(bodies, after=f"<actuator>{actuators}</actuator>"))
    assert found.actuated == ("c", "a", "b")
    assert found.notes == (
        "actuator 'damper' is a brake, and is left out",
        "actuator 'thruster' moves no joint by itself, and is left out",
        "actuator 'muscle' moves no joint by itself, and is left out",
        "actuator 'on ball' moves ball joint 'o', and is left out",
    )


KEYED = mjcf(
    body("f", "<freejoint/>", 'pos="1 2 3"')
    + body("a", '<joint name="j" range="10 20" ref="15"/>')
    + body("b", '<joint name="o" type="ball"/><joint name="k" type="slide" range="-1 0"/>'),
    after='<keyframe><key name="{}" qpos="4 5 6 0 2 0 0  .3  0 0 3 0  .5"/></keyframe>',
)


def test_home_is_qpos0_within_the_ranges(read) -> None:
    found = read(mjcf(body("a", '<joint name="j" range="10 20"/><joint name="k" ref="5"/>')))
    assert found.home == {"j": np.radians(10.0), "k": np.radians(5.0)}
    assert found.notes == ("0 of joint 'j' is outside its range: home starts at 0.174533",)


def test_home_is_the_keyframe_of_that_name(read) -> None:
    found = read(KEYED.format("home"))
    assert found.home == {
        "f_free": (4.0, 5.0, 6.0, 1.0, 0.0, 0.0, 0.0),
        "j": 0.3,
        "o": (0.0, 1.0, 0.0, 0.0),
    }
    assert found.notes == (
        "the home pose is the keyframe 'home'",
        "0.5 of joint 'k' is outside its range: home starts at 0",
    )
    other = read(KEYED.format("away"))
    assert other.home["f_free"] == (1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0)
    assert other.home["j"] == np.radians(15.0)


def test_what_is_left_out_is_noted(read) -> None:
    text = mjcf(
        body("a", '<joint name="o" type="ball" range="0 20"/>')
        + body("m", "", 'mocap="true"')
        + body("b", '<joint name="j"/>'),
        '<weld body1="a" active="false"/><tendon name="t" tendon1="x" active="false"/>',
        after='<tendon><fixed name="x"><joint joint="j" coef="1"/></fixed></tendon>',
    )
    text = text.replace("<worldbody>", '<option><flag equality="disable"/></option><worldbody>')
    assert read(text).notes == (
        "mocap body 'm' stands still",
        "the range of ball joint 'o' is left out",
        "<flag> disables the constraints; they are read all the same",
        "<weld body1='a'> is not active, and left out",
        "tendon 't' is not active, and left out",
    )


def test_masses_far_away_do_not_trouble_mujoco(read) -> None:
    """It has a mass matrix inverted, which nobody reads."""
    far = '<geom type="box" pos="1e5 0 0" size="1 1 1" mass="9e8"/>'
    inner = f'<body name="b" pos="1 0 0"><joint name="j"/>{far}</body>'
    chain = mjcf(f'<body name="a"><joint name="i"/><geom size="1" mass="1"/>{inner}</body>')
    assert read(chain).notes == ()


def test_a_weld_without_torque_is_a_point(read) -> None:
    found = read(four_bar('<weld body1="coupler" body2="rocker" torquescale="0"/>'))
    assert isinstance(found.loops[0], pj.PointLoop)


def test_simple_geoms_are_drawn(read) -> None:
    geoms = (
        '<geom size=".1" rgba="1 0 0 1"/><geom type="box" size=".1 .2 .3" pos="1 0 0"/>'
        '<geom type="capsule" size=".1" fromto="0 0 0 0 0 2"/><geom type="mesh" mesh="../x.stl"/>'
        '<geom type="cylinder" size=".1 .2"/><geom type="box" size=".1" fromto="0 0 0 2 0 0"/>'
        '<geom type="plane" size="1 1 1"/><geom type="ellipsoid" size=".1 .2 .3"/>'
    )
    visuals = read_visuals(read(mjcf(f'<body name="a">{geoms}</body>')).urdf)
    assert [len(visual.pieces) for visual in visuals] == [1, 1, 3, 0, 1, 1, 0, 0]
    visuals = [visual for visual in visuals if visual.pieces]
    assert visuals[0].colour == (1.0, 0.0, 0.0, 1.0)
    sizes = [np.linalg.norm(visual.pieces[0][1][:3, :3], axis=0) for visual in visuals]
    radii = [[0.1] * 3, [0.2, 0.4, 0.6], [0.1, 0.1, 2.0], [0.1, 0.1, 0.4], [0.2, 0.2, 2.0]]
    np.testing.assert_allclose(sizes, radii, atol=1e-15)
    np.testing.assert_allclose(visuals[1].pieces[0][1][:3, 3], [1.0, 0.0, 0.0])


def test_files_are_included(tmp_path) -> None:
    (tmp_path / "parts" / "more").mkdir(parents=True)
    (tmp_path / "robot.xml").write_text(
        '<mujoco model="whole"><include file="parts/common.xml"/><worldbody>'
        '<include file="parts/arm.xml"/></worldbody></mujoco>'
    )
    (tmp_path / "parts" / "common.xml").write_text(
        "<mujocoinclude><default><joint type='slide'/></default></mujocoinclude>"
    )
    (tmp_path / "parts" / "arm.xml").write_text(
        '<any><body name="a"><include file="more/joint.xml"/></body></any>'
    )
    (tmp_path / "parts" / "more" / "joint.xml").write_text('<any><joint name="j"/></any>')
    found = read_mjcf(tmp_path / "robot.xml")
    assert found.name == "whole"
    assert [joint.type for joint in found.urdf.joints] == ["prismatic"]


INCLUDES = {
    "/etc/hostname": "only files in or below",
    "../robot.xml": "only files in or below",
    "..\\robot.xml": "only files in or below",
    "sub/../../secret.xml": "only files in or below",
    "C:\\secret.xml": "only files in or below",
    "link.xml": "only files in or below",
    "missing.xml": "there is no such file",
    "": "there is no such file",
    "robot.xml": "included only once",
    "sub/a.xml": "included only once",
    "sub/broken.xml": r"broken\.xml: not well-formed",
    "sub/bomb.xml": r"bomb\.xml: a <!DOCTYPE> is not read",
    "sub": "there is no such file",
}


@pytest.mark.parametrize(("name", "message"), INCLUDES.items(), ids=range(len(INCLUDES)))
def test_includes_stay_in_the_models_folder(tmp_path, name, message) -> None:
    (tmp_path / "secret.xml").write_text("<mujoco/>")
    folder = tmp_path / "model"
    (folder / "sub").mkdir(parents=True)
    (folder / "link.xml").symlink_to(tmp_path / "secret.xml")
    (folder / "sub" / "a.xml").write_text('<mujoco><include file="sub/b.xml"/></mujoco>')
    (folder / "sub" / "b.xml").write_text('<mujoco><include file="sub/a.xml"/></mujoco>')
    (folder / "sub" / "broken.xml").write_text("<mujoco>")
    (folder / "sub" / "bomb.xml").write_text(BOMB)
    (folder / "robot.xml").write_text(f'<mujoco><include file="{name}"/></mujoco>')
    with pytest.raises(pj.ModelFileError, match=message):
        read_mjcf(folder / "robot.xml")


ATTACHMENTS = {
    "../secret.xml": "only files in or below",
    "missing.xml": "there is no such file",
    "robot.xml": "the model attaches itself",
    "sub/a.xml": "the model attaches itself",
    "sub/urdf.xml": r"urdf\.xml: the root element is <robot>",
    "sub/many.xml": "2000 bodies, sites and joints are too many",
    "sub/curved.xml": r"curved\.xml: <joint> on body .a.: `axis` is 'nan 0 0', not 3",
    "sub/misspelt.xml": r"misspelt\.xml: <worldbody> holds an unknown <bodi>",
}


@pytest.mark.parametrize(("name", "message"), ATTACHMENTS.items(), ids=range(len(ATTACHMENTS)))
def test_attached_models_are_checked_as_the_whole_is(tmp_path, name, message) -> None:
    def attaching(name: str) -> str:
        return world(
            "<attach model='m' prefix='p'/>", f"<asset><model name='m' file='{name}'/></asset>"
        )

    folder = tmp_path / "model"
    (folder / "sub").mkdir(parents=True)
    texts = {
        "../secret.xml": world(""),
        "robot.xml": attaching(name),
        "sub/a.xml": attaching("sub/b.xml"),
        "sub/b.xml": attaching("a.xml"),
        "sub/urdf.xml": "<robot/>",
        "sub/many.xml": world("<replicate count='1000'><body><site/></body></replicate>"),
        "sub/curved.xml": world(body("a", "<joint axis='nan 0 0'/>")),
        "sub/misspelt.xml": world("<bodi/>"),
    }
    for file, text in texts.items():
        (folder / file).write_text(text)
    with pytest.raises(pj.ModelFileError, match=message):
        read_mjcf(folder / "robot.xml")


def test_a_chain_of_included_files_comes_to_an_end(tmp_path) -> None:
    for number in range(120):
        inner = f'<include file="{number + 1}.xml"/>'
        (tmp_path / f"{number}.xml").write_text(f"<mujoco>{inner}</mujoco>")
    (tmp_path / "120.xml").write_text("<mujoco/>")
    with pytest.raises(pj.ModelFileError, match="more than 50 files"):
        read_mjcf(tmp_path / "0.xml")


BOMB = (
    '<!DOCTYPE m [<!ENTITY a "xxxxxxxxxx"><!ENTITY b "&a;&a;&a;&a;">]><mujoco model="&b;"></mujoco>'
)
EXTERNAL = '<!DOCTYPE m [<!ENTITY a SYSTEM "file:///etc/passwd">]><mujoco model="&a;"/>'
NOT_FINITE = "not 3 finite numbers"


def world(inside: str, before: str = "") -> str:
    return mjcf(inside, before=before)


def joined(equality: str) -> str:
    bodies = (
        body("a", '<joint name="j"/><site name="s"/>')
        + body("b", '<joint name="k" range="-10 10"/><site name="t"/>')
        + body("c", '<joint name="o" type="ball"/>')
    )
    return mjcf(bodies, equality)


BAD = {
    "empty": ("", "the file is empty"),
    "no XML": ("hello", "not well-formed XML"),
    "entity bomb": (BOMB, "a <!DOCTYPE> is not read"),
    "external entity": (EXTERNAL, "a <!DOCTYPE> is not read"),
    "deep": ("<mujoco>" + "<body>" * 200 + "</body>" * 200 + "</mujoco>", "nested more than 100"),
    "URDF": ('<robot name="r"/>', "root element is <robot>; an MJCF file's is <mujoco>"),
    "section": ("<mujoco><wordlbody/></mujoco>", "no section of MJCF; did you mean 'worldbody'"),
    "element": (world(body("a", "<jiont/>")), "body 'a' holds an unknown <jiont>.* 'joint'"),
    "element in a frame": (world("<frame><bodi/></frame>"), "unknown <bodi>; did you mean 'body'"),
    "misspelt joint": (world(body("a", '<joint rf="3"/>')), "attribute 'rf'; did you mean 'ref'"),
    "misspelt body": (world(body("a", "", 'Pos="1 2 3"')), "body 'a' has .* 'Pos'; .* 'pos'"),
    "misspelt default": (world("", '<default><joint ais="1 0 0"/></default>'), "mean 'axis'"),
    "misspelt anchor": (mjcf("", '<connect body1="a" achor="1 2 3"/>'), "did you mean 'anchor'"),
    "misspelt option": (world("", '<compiler agle="radian"/>'), "did you mean 'angle'"),
    "replicate": (world("<replicate/>"), "<replicate> has no `count`"),
    "huge replicate": (
        world("<replicate count='1000000000'><body/></replicate>"),
        "1000000000 bodies, sites and joints are too many",
    ),
    "nested replicate": (
        world("<replicate count='999'>" * 3 + "<geom/>" + "</replicate>" * 3),
        r"\d{10} elements are too many",
    ),
    "no replicate": (world("<replicate count='nan'><body/></replicate>"), "not a finite number"),
    "model that is not there": (
        world("<attach model='m' prefix='p'/>"),
        "<attach>: MuJoCo refuses",
    ),
    "composite": (
        world(body("a", "<composite/>")),
        "<composite> is not read: a soft body has no joints",
    ),
    "global": (
        world("", '<compiler coordinate="global"/>'),
        "global coordinates no longer supported",
    ),
    "angle": (world("", '<compiler angle="grad"/>'), "`angle` has the invalid keyword: 'grad'"),
    "eulerseq": (
        world("", '<compiler eulerseq="xy"/>'),
        "<compiler>: MuJoCo refuses it: ",
    ),
    "autolimits": (
        world("", '<compiler autolimits="1"/>'),
        "`autolimits` has the invalid keyword: '1'",
    ),
    "world's joint": (
        world("<joint name='j'/>"),
        "joint 'j': MuJoCo refuses it: World body cannot have joints",
    ),
    "body of the world's name": (world(body("world")), "repeated name 'world' in body"),
    "two bodies": (world(body("a") + body("a")), "repeated name 'a' in body"),
    "two joints": (world(body("a", "<joint name='j'/>") * 2), "repeated name 'a' in body"),
    "two joints in a body": (
        world(body("a", "<joint name='j'/>" * 2)),
        "repeated name 'j' in joint",
    ),
    "nested free": (
        world(body("a", body("b", "<freejoint/>"))),
        "body 'b': .* free joint can only be used on top",
    ),
    "free and more": (world(body("a", "<freejoint/><joint/>")), "more than 6 dofs in body 'a'"),
    "joint type": (
        world(body("a", '<joint type="hinged"/>')),
        "<joint> on body 'a': .* `type` has the invalid keyword: 'hinged'",
    ),
    "axis": (world(body("a", '<joint axis="0 0 0"/>')), "axis too small in joint"),
    "NaN": (world(body("a", '<joint pos="0 nan 0"/>')), NOT_FINITE),
    "infinity": (world(body("a", "", 'pos="0 inf 0"')), NOT_FINITE),
    "overflow": (world(body("a", "", 'pos="0 1e999 0"')), NOT_FINITE),
    "large": (world(body("a", "", 'pos="0 1e300 0"')), "1e\\+09 or less"),
    "comma": (world(body("a", "", 'pos="1,2,3"')), "`pos` is '1,2,3', not a finite number"),
    "too few": (world(body("a", '<joint axis="1 0"/>')), "'axis' does not have enough data"),
    "quaternion": (world(body("a", "", 'quat="0 0 0 0"')), "zero quaternion is not allowed"),
    "xyaxes": (world(body("a", "", 'xyaxes="1 0 0 2 0 0"')), "yaxis too small"),
    "two orientations": (
        world(body("a", "", 'quat="1 0 0 0" euler="1 2 3"')),
        "multiple orientation specifiers are not allowed",
    ),
    "range": (world(body("a", '<joint range="20 10"/>')), "`range` is 20 to 10"),
    "no range": (world(body("a", '<joint limited="true"/>')), "should be smaller than range"),
    "unlimited range": (
        world(body("a", '<joint range="1 2"/>'), '<compiler autolimits="false"/>'),
        "joint has `range` but not `limited`",
    ),
    "limited": (
        world(body("a", '<joint limited="yes"/>')),
        "`limited` has the invalid keyword: 'yes'",
    ),
    "class": (world(body("a", '<joint class="no"/>')), "the default class 'no' does not exist"),
    "childclass": (world(body("a", "", 'childclass="mian"')), "did you mean 'main'"),
    "default without a name": (world("", "<default><default/></default>"), "empty class name"),
    "too many classes": (
        world(
            "",
            "<default>" + "".join(f"<default class='c{k}'/>" for k in range(1500)) + "</default>",
        ),
        "1502 default classes are too many",
    ),
    "long names multiplied": (
        world(f"<replicate count='900' sep='{'x' * 10**6}'><body/></replicate>"),
        "`sep` is a name of 1000000 characters; at most 200",
    ),
    "default twice": (
        world("", '<default><default class="a"/><default class="a"/></default>'),
        "repeated default class name",
    ),
    "main renamed": (world("", '<default class="x"/>'), "'main' cannot be renamed"),
    "too many bodies": (world("<body/>" * 1001), "1001 bodies, sites and joints are too many"),
    "too many freedoms": (
        world("".join(body(f"b{k}", "<freejoint/>") for k in range(40))),
        "240 degrees of freedom",
    ),
    "too deep for Pinocchio": (
        world("<body><joint/><joint/><joint/>" * 60 + "</body>" * 60),
        "more than 150 joints is too long",
    ),
    "reserved": (world(body("universe")), "the name 'universe' is taken"),
    "invisible": (world(body("a&#9;b")), "invisible character"),
    "long name": (world(body("a" * 300)), "a name of 300 characters"),
    "constraint": (joined("<conect/>"), "unknown <conect>; did you mean 'connect'"),
    "tendon": (joined('<tendon tendon1="t"/>'), "the tendon 't' does not exist"),
    "flex": (joined("<flex/>"), "<flex> is not read"),
    "distance": (joined("<distance/>"), 'set active="false" to leave it out'),
    "active": (
        joined('<connect active="no" body1="a" anchor="0 0 0"/>'),
        "`active` has the invalid keyword: 'no'",
    ),
    "no body": (joined('<connect anchor="0 0 0"/>'), "<connect>: MuJoCo refuses it: "),
    "no anchor": (joined('<connect body1="a"/>'), "<connect body1='a'>: MuJoCo refuses it: "),
    "unknown body": (joined('<weld body1="a" body2="bb"/>'), "the body 'bb' does not exist"),
    "unknown site": (joined('<connect site1="s" site2="tt"/>'), "did you mean 't'"),
    "no second site": (joined('<weld site1="s"/>'), "<weld site1='s'>: MuJoCo refuses it: "),
    "site and body": (
        joined('<weld site1="s" body1="a"/>'),
        "<weld body1='a' site1='s'>: MuJoCo refuses it: ",
    ),
    "body with itself": (joined('<weld body1="a" body2="a"/>'), "element 'a' is repeated"),
    "site with itself": (joined('<weld site1="s" site2="s"/>'), "element 's' is repeated"),
    "relpose": (joined('<weld body1="a" relpose="1 2 3"/>'), "'relpose' does not have enough data"),
    "no joint": (joined('<joint polycoef="1"/>'), "attribute missing: 'joint1'"),
    "unknown joint": (joined('<joint joint1="j" joint2="jj"/>'), "the joint 'jj' does not exist"),
    "joint with itself": (joined('<joint joint1="j" joint2="j"/>'), "element 'j' is repeated"),
    "geared ball": (joined('<joint joint1="o" joint2="j"/>'), "only HINGE and SLIDE joint allowed"),
    "curved": (
        joined('<joint joint1="j" joint2="k" polycoef="0 1 2"/>'),
        "`polycoef` is '0 1 2 0 0'; only a linear one is read",
    ),
    "polycoef": (joined('<joint joint1="j" polycoef="0 nan"/>'), "not 2 finite numbers"),
    "long polycoef": (
        joined('<joint joint1="j" polycoef="0 1 2 3 4 5"/>'),
        "'polycoef' has too much data",
    ),
    "held twice": (joined('<joint joint1="j"/>' * 2), "held by another constraint already"),
    "held and geared": (
        joined('<joint joint1="j"/><joint joint1="k" joint2="j"/>'),
        "'j' is geared and held",
    ),
    "held outside": (
        joined('<joint joint1="k" polycoef="1"/>'),
        r"'k' cannot be locked at 1, outside \[-0.17",
    ),
    "unknown motor": (mjcf(HINGED, after=motor("jj")), "the joint 'jj' does not exist"),
    "short keyframe": (
        mjcf(HINGED, after='<keyframe><key name="home" qpos="1 2"/></keyframe>'),
        "invalid qpos size, expected",
    ),
    "too many constraints": (
        joined('<connect body1="a" anchor="0 0 0"/>' * 1001),
        "1001 equality constraints are too many",
    ),
}


@pytest.mark.parametrize(("text", "message"), BAD.values(), ids=BAD)
def test_bad_files_are_refused_in_one_line(tmp_path, text, message) -> None:
    path = tmp_path / "robot.xml"
    path.write_text(text)
    with pytest.raises(pj.ModelFileError, match=message) as caught:
        read_mjcf(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)
    assert caught.value.path == str(path)


def test_files_that_are_too_large_are_not_opened(tmp_path) -> None:
    path = tmp_path / "robot.xml"
    with path.open("wb") as file:
        file.truncate(50_000_000)
    with pytest.raises(pj.ModelFileError, match="50000000 bytes are too many"):
        read_mjcf(path)


def test_no_mujoco(read, monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(pj.MissingDependencyError, match=r'pip install "pmjac_pin\[mjcf\]"'):
        read(FOUR_BAR)


def test_mujoco_leaves_nothing_behind(read, monkeypatch, tmp_path, capfd) -> None:
    """It would write its warnings into the folder where one is."""
    (here := tmp_path / "here").mkdir()
    monkeypatch.chdir(here)
    read(mjcf("<body><joint/>" * 90 + "</body>" * 90))
    with pytest.raises(pj.ModelFileError):
        read(mjcf(body("a", "<joint axis='0 nan 0'/>")))
    assert list(here.iterdir()) == []
    assert capfd.readouterr() == ("", "")


def test_no_file_at_all(tmp_path) -> None:
    for path in (tmp_path / "none.xml", tmp_path):
        with pytest.raises(pj.ModelFileError, match=f"^{path}: "):
            read_mjcf(path)


def test_any_number_of_geoms_is_read(read) -> None:
    found = read(world(body("a", '<geom size=".1"/>' * 3000)))
    assert found.notes == ("only the first 2000 geoms are kept for the picture",)
    drawn = [bool(visual.pieces) for visual in read_visuals(found.urdf)]
    assert drawn == [True] * 2000 + [False]  # what is left out is there to be seen


def swapped(text: str, rng: np.random.Generator) -> str:
    """Return well-formed XML: what is between some quotes is what is between others."""
    parts = text.split('"')
    for _ in range(rng.integers(1, 3)):
        here, there = rng.integers(len(parts) // 2, size=2)
        parts[2 * here + 1] = parts[2 * there + 1]
    return '"'.join(parts)


@pytest.mark.slow
@pytest.mark.parametrize("name", MODELS)
def test_mutilated_files_are_read_or_refused(read, rng, name) -> None:
    """And what is read makes a mechanism, or the reason why it does not is said."""
    refused = 0
    text = MODELS[name].replace("><", ">\n<")
    for changed in (*mutations(text, rng, 20), *(swapped(text, rng) for _ in range(20))):
        try:
            found = read(changed)
            build_parts(built(found), found.spec(tool="world"), {}, found.urdf)
        except pj.PmjacError as error:
            assert str(error)
            refused += 1
    assert refused


def test_sites_give_loops_their_frames(read) -> None:
    frames = [loop.frames for loop in read(SITES).loops]
    assert frames == [("tip", "end"), ("a_site", "ground"), ("tip", "end")]


@pytest.mark.parametrize(
    ("tendon", "told"),
    [
        ('<fixed name="t" range="0 1e-6"><joint joint="j" coef="1"/></fixed>', True),
        ('<fixed name="t"><joint joint="j" coef="1"/></fixed>', False),
        ('<fixed name="t" limited="false" range="0 1"><joint joint="j" coef="1"/></fixed>', False),
        ('<spatial name="t" range="0.5 0.5"><site site="s"/><site site="o"/></spatial>', True),
    ],
)
def test_limits_of_tendons_are_told(tmp_path, tendon, told):
    path = tmp_path / "m.xml"
    body = '<body name="b"><joint name="j"/><site name="s"/><geom size="1"/></body>'
    world = f"<worldbody>{body}<site name='o'/></worldbody>"
    path.write_text(f"<mujoco>{world}<tendon>{tendon}</tendon></mujoco>")
    unread = pj.load(path, actuated=["j"], tool="b").unread
    kind = tendon[1:].split()[0]
    sentence = f"not read: the range of {kind} 't', which may hold joints together"
    assert unread == ((sentence,) if told else ())
