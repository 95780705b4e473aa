"""Masses and inertias of every format: against MuJoCo, by hand, and where there are none."""

from __future__ import annotations

import looped
import mjcf_models
import numpy as np
import pinocchio as pin
import pytest
from mujoco_oracle import Pair, mujoco
from peer_models import peer_model
from test_sdf_ties import RHOMBUS, sdf
from test_sdf_ties import joint as sdf_joint

import pmjac_pin as pj
from pmjac_pin.files.mjcf.reader import read_mjcf
from pmjac_pin.files.sdf.reader import read_sdf
from pmjac_pin.files.urdf.looped_urdf import read_looped_urdf
from pmjac_pin.files.xml_text import parse_xml

POSED = 'pos=".1 -.2 .3" euler="20 30 40"'
SOLIDS = {
    "sphere": f'<geom size=".3" {POSED}/>',
    "capsule": f'<geom type="capsule" size=".2 .5" {POSED}/>',
    "cylinder": f'<geom type="cylinder" size=".2 .5" {POSED}/>',
    "box": f'<geom type="box" size=".2 .5 .1" {POSED}/>',
    "ellipsoid": f'<geom type="ellipsoid" size=".2 .5 .1" {POSED}/>',
    "capsule between": '<geom type="capsule" size=".2" fromto="0 1 2 1 .5 0"/>',
    "cylinder between": '<geom type="cylinder" size=".2" fromto="0 1 2 1 .5 0"/>',
    "box between": '<geom type="box" size=".2" fromto="0 1 2 1 .5 0"/>',
    "ellipsoid between": '<geom type="ellipsoid" size=".2" fromto="0 1 2 1 .5 0"/>',
    "mass": f'<geom type="box" size=".2 .5 .1" mass="7" density="3" {POSED}/>',
    "density": f'<geom type="box" size=".2 .5 .1" density="3" {POSED}/>',
    "several": f'<geom size=".3" {POSED}/><geom type="box" size=".2 .1 .3" pos="1 0 0"/>'
    '<geom size=".4" mass="0"/><geom size=".2" density="0"/>',
    "in a frame": f'<frame {POSED}><geom type="box" size=".2 .5 .1" {POSED}/></frame>',
    "inertial": f'<inertial mass="3" diaginertia="1 2 2.5" {POSED}/><geom size="1"/>',
    "full inertia": '<inertial mass="3" pos=".1 .2 .3" fullinertia="3 2.5 2 .1 .2 -.3"/>',
}
COMPILERS = {
    "none": "",
    "always": 'inertiafromgeom="true"',
    "never": 'inertiafromgeom="false"',
    "groups": 'inertiagrouprange="1 2"',
    "bounds": 'boundmass="4" boundinertia="1.7"',
    "balance": 'balanceinertia="true"',
    "total": 'settotalmass="2.5"',
}
GROUPS = (
    '<inertial mass="3" diaginertia="1 2 2.5" pos="1 0 0"/><geom size=".3" group="1"/>'
    '<geom size=".2" group="3" pos="0 1 0"/>'
)


@pytest.fixture
def pair(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # MuJoCo writes its log into the working directory

    def pair(text):
        path = tmp_path / "robot.xml"
        path.write_text(text)
        return Pair(path)

    return pair


def inertias(found):
    """Mass, centre and moments about the centre of each link that has them, in its frame."""
    masses = {}
    for link in parse_xml(found.urdf.text).iterfind("link"):
        if (inertial := link.find("inertial")) is not None:
            given = inertial.find("inertia").attrib
            moments = [[given[f"i{min(a, b)}{max(a, b)}"] for b in "xyz"] for a in "xyz"]
            masses[link.get("name")] = (
                float(inertial.find("mass").get("value")),
                np.array(inertial.find("origin").get("xyz").split(), dtype=float),
                np.array(moments, dtype=float),
            )
    return masses


def assert_inertias_are_mujocos(pair):
    found = inertias(pair.found)
    for number in range(1, pair.mj.nbody):
        body = pair.mj.body(number)
        mass, centre, moments = found.get(body.name, (0.0, np.zeros(3), np.zeros((3, 3))))
        axes = pin.Quaternion(*body.iquat).toRotationMatrix()
        theirs = axes @ np.diag(body.inertia) @ axes.T
        np.testing.assert_allclose(mass, body.mass[0], rtol=1e-12)
        np.testing.assert_allclose(centre, body.ipos, atol=1e-12)
        np.testing.assert_allclose(moments, theirs, atol=1e-10 * max(1.0, np.abs(theirs).max()))


@pytest.mark.parametrize("inside", SOLIDS.values(), ids=SOLIDS)
def test_a_bodys_inertia_is_mujocos(pair, inside):
    joint = '<joint name="j" pos=".1 .2 .3" ref="20" axis="1 2 3"/>'
    assert_inertias_are_mujocos(pair(mjcf_models.mjcf(f'<body name="a">{joint}{inside}</body>')))


@pytest.mark.parametrize("compiler", COMPILERS.values(), ids=COMPILERS)
@pytest.mark.parametrize("inside", [GROUPS, SOLIDS["several"]], ids=["groups", "several"])
def test_the_compilers_rules_are_mujocos(pair, compiler, inside):
    bodies = f'<body name="a"><joint name="j"/>{inside}</body>'
    other = '<body name="b"><joint name="k"/><inertial mass="1" pos="0 0 1" diaginertia="1 1 1"/>'
    text = mjcf_models.mjcf(f"{bodies}{other}</body>", before=f"<compiler {compiler}/>")
    if compiler == COMPILERS["groups"] and "group=" not in text:
        text = text.replace("<geom", '<geom group="1"')
    if compiler == COMPILERS["never"]:  # MuJoCo wants a mass for all that moves
        inertial = '<inertial mass="2" pos="0 0 0" diaginertia="1 1 1"/>'
        text = text if 'mass="3"' in text else text.replace("<geom", f"{inertial}<geom", 1)
    if compiler == COMPILERS["always"]:
        text = text.replace("</body></worldbody>", '<geom size=".1"/></body></worldbody>')
    assert_inertias_are_mujocos(pair(text))


@pytest.mark.parametrize("name", mjcf_models.MODELS)
def test_inertias_of_all_models_are_mujocos(pair, name):
    assert_inertias_are_mujocos(pair(mjcf_models.MODELS[name]))


def inertia_matrix(pair):
    """MuJoCo's joint space inertia matrix, by Pinocchio's v, rotors aside."""
    columns = np.eye(pair.mj.nv)
    for column in columns:
        mujoco.mj_mulM(pair.mj, pair.data, result := np.zeros(pair.mj.nv), column.copy())
        column[:] = result
    return columns


@pytest.mark.parametrize("name", mjcf_models.MODELS)
def test_the_model_has_mujocos_inertia_matrix(pair, rng, name):
    """That of `mechanism.model`, at random poses."""
    pair = pair(mjcf_models.MODELS[name])
    pair.mj.dof_armature[:] = 0.0
    data = pair.pin.createData()
    for _ in range(3):
        qpos = pair.random(rng)
        pair.forward(qpos)
        rates = pair.rates(qpos)
        theirs = rates.T @ inertia_matrix(pair) @ rates
        ours = np.triu(pin.crba(pair.pin, data, pair.q(qpos)))
        np.testing.assert_allclose(ours, np.triu(theirs), atol=1e-9 * np.abs(theirs).max())


def test_cassies_inertias_are_mujocos(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert_inertias_are_mujocos(Pair(peer_model("mjcf/cassie_closed_chain.xml")))


def test_defaults_give_geoms_their_mass(pair):
    inner = '<default class="x"><geom mass="2"/></default>'
    defaults = f'<default><geom density="30"/>{inner}</default>'
    geoms = '<geom size=".2"/><geom class="x" size=".3" pos="1 0 0"/>'
    bodies = f'<body name="a"><joint name="j"/>{geoms}</body>'
    assert_inertias_are_mujocos(pair(mjcf_models.mjcf(bodies, before=defaults)))


def test_what_is_not_known_of_masses_is_said(tmp_path):
    path = tmp_path / "robot.xml"
    joint = '<joint name="{}"/>'
    path.write_text(
        mjcf_models.mjcf(
            f'<body name="a">{joint.format("j")}<geom type="mesh" mesh="m"/></body>'
            f'<body name="b">{joint.format("k")}<body name="c"/></body>'
            f'<body name="d">{joint.format("l")}<geom size=".1" shellinertia="true"/></body>'
            f'<body name="e">{joint.format("m")}<inertial pos="0 0 0" mass="1"/></body>'
            f'<body name="f">{joint.format("n")}<geom type="mesh" mesh="m"/>'
            '<geom type="capsule" mesh="m" fromto="0 0 0 1 1 1"/>'
            '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body>'
            '<geom type="hfield" hfield="land"/>'
        )
    )
    assert read_mjcf(path).notes == (
        "the mass of meshes, which are not opened, is left out of 'a'",
        "no moments of inertia are given for 'e': they are 0 in `model`",
        "no mass is given for 'b': it is 0 in `model`",
    )


@pytest.mark.parametrize(
    ("inside", "message"),
    [
        ('<inertial mass="-1" pos="0 0 0" diaginertia="1 1 1"/>', "the mass is -1; it must not"),
        ('<inertial mass="1" pos="0 0 0" diaginertia="1 -1 1"/>', "a moment of inertia is -1, be"),
        ('<inertial pos="0 0 0" diaginertia="1 1 1"/>', "required attribute missing: 'mass'"),
        ('<geom size=".1" density="-1"/>', "mass, inertia or density are negative"),
        (
            '<inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/>' * 2,
            "unique element 'inertial' found 2 times",
        ),
    ],
)
def test_masses_that_no_body_has(tmp_path, inside, message):
    path = tmp_path / "robot.xml"
    path.write_text(mjcf_models.mjcf(f'<body name="a">{inside}</body>'))
    with pytest.raises(pj.ModelFileError, match=message):
        read_mjcf(path)


SDF = """
<sdf version="1.9"><model name="m">
  <link name="a"><pose>1 2 3 0.1 0.2 0.3</pose>
    <inertial><mass>2</mass><pose>0.1 0 0.2 0.3 0 0.4</pose><inertia>
      <ixx>2</ixx><ixy>0.1</ixy><ixz>0.2</ixz><iyy>3</iyy><iyz>-0.3</iyz><izz>4</izz>
    </inertia></inertial></link>
  <link name="b"><inertial><mass>3</mass><pose relative_to="a">0 0 1 0 0 0</pose></inertial></link>
  <link name="c"/><link name="d"><inertial auto="true"/></link>
  <joint name="i" type="revolute"><parent>a</parent><child>b</child>
    <pose>0.5 0 0 0 0 1</pose><axis><xyz>0 1 0</xyz></axis></joint>
  <joint name="j" type="ball"><parent>a</parent><child>c</child></joint>
  <joint name="k" type="fixed"><parent>a</parent><child>d</child></joint>
</model></sdf>"""


def test_inertias_of_sdf(tmp_path):
    path = tmp_path / "robot.sdf"
    path.write_text(SDF)
    found = read_sdf(path)
    masses = inertias(found)
    turn = pin.rpy.rpyToMatrix(0.3, 0.0, 0.4)
    given = np.array([[2, 0.1, 0.2], [0.1, 3, -0.3], [0.2, -0.3, 4]])
    mass, centre, moments = masses["a"]
    assert mass == 2.0
    np.testing.assert_allclose(centre, [0.1, 0, 0.2], atol=1e-15)
    np.testing.assert_allclose(moments, turn @ given @ turn.T, atol=1e-14)
    placed = pin.SE3(pin.rpy.rpyToMatrix(0.1, 0.2, 0.3), np.array([1.0, 2, 3]))
    np.testing.assert_allclose(masses["b"][1], placed.act(np.array([0.0, 0, 1])), atol=1e-15)
    assert (masses["b"][0], masses["c"][0], "d" in masses) == (3.0, 1.0, False)
    np.testing.assert_allclose(masses["c"][2], np.eye(3))
    default = "SDFormat's default, 1 kg and 1 kg m², is taken"
    assert found.notes[0].startswith("no <ixx>, <iyy>, <izz> is given for 'b': SDFormat's default")
    assert found.notes[1] == f"no <inertial> is given for 'c': {default}"
    assert found.notes[2].startswith("the <inertial> of 'd' is to be computed from shapes")
    model = pj.load(path, actuated=["i"], tool="b").model
    assert model.inertias[model.getJointId("i")].mass == 3.0


@pytest.mark.parametrize(
    ("inertial", "message"),
    [
        ("<mass>-1</mass>", "the mass is -1; it must not be negative"),
        ("<mass>nan</mass>", "<mass> is 'nan', not a finite number"),
        ("<inertia><ixx>-1</ixx></inertia>", "a moment of inertia is -1, below zero"),
        ("<inertia><ixy>2</ixy></inertia>", "a moment of inertia is -1, below zero"),
        ("<inertia><ixxx>2</ixxx></inertia>", "unknown <ixxx>; did you mean 'ixx'"),
    ],
)
def test_inertias_that_no_link_has(tmp_path, inertial, message):
    path = tmp_path / "robot.sdf"
    text = f'<link name="a"><inertial>{inertial}</inertial></link>'
    path.write_text(f'<sdf version="1.9"><model name="m">{text}</model></sdf>')
    with pytest.raises(pj.ModelFileError, match=message):
        read_sdf(path)


def test_bodies_of_a_urdf_without_mass_are_told(tmp_path):
    """A frame needs none: the body that carries it has one."""
    path = tmp_path / "robot.urdf"
    text = looped.two_parents()
    path.write_text(text.replace(looped.link("pin"), looped.link("pin", "")))
    assert not any("no mass" in note for note in read_looped_urdf(path).notes)
    path.write_text(text.replace(looped.link("rocker"), looped.link("rocker", "")))
    assert read_looped_urdf(path).notes[-1] == "no mass is given for 'rocker': it is 0 in `model`"


def test_mujocos_rotors_are_read(tmp_path):
    rotor = '<default><joint armature="0.2"/></default>'
    bodies = mjcf_models.body("a", '<joint name="i"/>') + mjcf_models.body(
        "b", '<joint name="j" armature="0"/>'
    )
    (tmp_path / "robot.xml").write_text(mjcf_models.mjcf(bodies, before=rotor))
    assert dict(read_mjcf(tmp_path / "robot.xml").armature) == {"i": 0.2}


def urdf_with_rotor(element, name="theta1", before="", after=""):
    """The lecture's four-bar with something in one of its joints, or beside them."""
    text = looped.with_drake(before)
    end = text.index("</joint>", text.index(f'<joint name="{name}"'))
    return text[:end] + element + text[end:].replace("</robot>", f"{after}</robot>")


TRANSMISSION = (
    '<transmission name="t"><type>transmission_interface/SimpleTransmission</type>'
    '<joint name="{}"/><actuator name="motor">{}</actuator></transmission>'
)
DRAKES = '<drake:rotor_inertia value="1e-3"/><drake:gear_ratio value="10"/>'


@pytest.mark.parametrize(
    ("inside", "after", "armature"),
    [
        ('<dynamics armature="0.1"/>', "", {"theta1": 0.1}),
        ('<dynamics armature="0"/>', "", {}),
        ('<drake:rotor_inertia value="1e-3"/>', "", {"theta1": 1e-3}),
        (DRAKES, "", {"theta1": 0.1}),
        ("", TRANSMISSION.format("theta1", DRAKES), {"theta1": 0.1}),
        ("", TRANSMISSION.format("phi1", DRAKES), {"phi1": 0.1}),
        (DRAKES, TRANSMISSION.format("theta1", DRAKES), {"theta1": 0.2}),
        ("", TRANSMISSION.format("nobody", ""), {}),
    ],
)
def test_rotors_of_a_urdf_are_read(tmp_path, inside, after, armature):
    """Drake's are in the actuator of a transmission, and count by the square of their gear."""
    path = tmp_path / "robot.urdf"
    path.write_text(urdf_with_rotor(inside, after=after))
    assert read_looped_urdf(path).armature == pytest.approx(armature)


@pytest.mark.parametrize(
    ("inside", "after", "said"),
    [
        (
            '<dynamics armature="-1"/>',
            "",
            "<dynamics>: `armature` is -1; it must not be negative",
        ),
        ('<dynamics armature="x"/>', "", "`armature` is 'x', not a finite number"),
        (
            '<drake:gear_ratio value="x"/>' + DRAKES[: DRAKES.index("/>") + 2],
            "",
            "gear_ratio>: `va",
        ),
        (DRAKES + DRAKES, "", "2 <.*rotor_inertia>; give one"),
        (
            "",
            TRANSMISSION.format("thta1", DRAKES),
            "'thta1' does not exist; did you mean 'theta1'",
        ),
        ("", TRANSMISSION.format('a"/><joint name="b', DRAKES), "'t' has rotors and 2 joints"),
    ],
)
def test_rotors_that_cannot_be(tmp_path, inside, after, said):
    path = tmp_path / "robot.urdf"
    path.write_text(urdf_with_rotor(inside, after=after))
    with pytest.raises(pj.ModelFileError, match=said):
        read_looped_urdf(path)


def test_a_rotor_that_is_cut_with_its_joint_is_said(tmp_path):
    path = tmp_path / "robot.urdf"
    text = looped.two_parents()
    at = text.index("</joint>", text.index('<joint name="hinge"'))
    path.write_text(f'{text[:at]}<dynamics armature="0.1"/>{text[at:]}')
    cut = read_looped_urdf(path)
    assert not cut.armature
    assert any("joint 'hinge' is cut: its armature is lost" in note for note in cut.notes)
    kept = read_looped_urdf(path, ["hinge"])
    assert kept.armature == {"hinge": 0.1}
    assert not any("armature" in note for note in kept.notes)


def sdf_with_rotor(name, inside="", kind="revolute"):
    """A four-bar whose last joint closes it, and a motor in one of its joints."""
    rotor = f"<drake:rotor_inertia>1e-3</drake:rotor_inertia>{inside}"
    text = sdf(RHOMBUS + sdf_joint("c", "coupler", "rocker", kind=kind))
    end = text.index("</joint>", text.index(f'<joint name="{name}"'))
    return text[:end] + rotor + text[end:]


@pytest.mark.parametrize("kind", ["revolute", "screw"])
def test_rotors_of_sdformat_are_read(tmp_path, kind):
    """A screw that is cut stays in the tree before its hub, and so does its rotor."""
    path, gear = tmp_path / "robot.sdf", "<drake:gear_ratio>10</drake:gear_ratio>"
    path.write_text(sdf_with_rotor("a"))
    assert read_sdf(path).armature == {"a": 1e-3}
    path.write_text(sdf_with_rotor("a", gear))
    assert read_sdf(path).armature == pytest.approx({"a": 0.1})
    pitch = "<screw_thread_pitch>0.1</screw_thread_pitch>" if kind == "screw" else ""
    path.write_text(sdf_with_rotor("c", gear + pitch, kind=kind))
    cut, lost = read_sdf(path), "joint 'c' is cut: its armature is lost"
    assert any(lost in note for note in cut.notes) == (kind == "revolute")
    assert cut.armature == pytest.approx({"c": 0.1} if kind == "screw" else {})
    assert read_sdf(path, ["c"]).armature == pytest.approx({"c": 0.1})


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (sdf_with_rotor("a").replace("1e-3", "-1"), "<drake:rotor_inertia> is below 0: -1"),
        (sdf_with_rotor("a").replace("1e-3", "x"), "<drake:rotor_inertia> is 'x'"),
        (sdf_with_rotor("c", kind="ball"), "which is not read of a ball joint"),
    ],
)
def test_rotors_of_sdformat_that_cannot_be(tmp_path, text, said):
    path = tmp_path / "robot.sdf"
    path.write_text(text)
    with pytest.raises(pj.ModelFileError, match=said):
        read_sdf(path)


def test_rotors_are_in_the_mass_matrix(tmp_path):
    """Of MuJoCo's own, of a model file, and of what `convert` writes."""
    inertial = '<inertial pos="0.3 0 0" mass="2" diaginertia="0.1 0.2 0.3"/>'
    tip = mjcf_models.body("b", f'{inertial}<joint name="j" axis="0 0 1"/>')
    text = mjcf_models.mjcf(
        mjcf_models.body("a", f'{inertial}<joint name="i" axis="0 1 0" armature="0.5"/>{tip}')
    )
    path = tmp_path / "arm.xml"
    path.write_text(text)
    mechanism = pj.load(path, actuated=["i", "j"], tool="b")
    theirs = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(theirs)
    mujoco.mj_forward(theirs, data)
    wanted = np.eye(2)
    for column in wanted:
        mujoco.mj_mulM(theirs, data, result := np.zeros(2), column.copy())
        column[:] = result
    np.testing.assert_allclose(mechanism.home.dynamics().mass_matrix, wanted, atol=1e-12)
    pj.convert(path, tmp_path / "arm.toml", actuated=["i", "j"], tool="b")
    again = pj.load(tmp_path / "arm.toml")
    assert again.spec.armature == {"i": 0.5}
    np.testing.assert_allclose(again.home.dynamics().mass_matrix, wanted, atol=1e-9)
    text = (tmp_path / "arm.toml").read_text()
    (tmp_path / "arm.toml").write_text(text.replace("0.5", "0.7"))
    more = pj.load(tmp_path / "arm.toml").home.dynamics().mass_matrix
    assert more[0, 0] - wanted[0, 0] == pytest.approx(0.2)
    assert pj.load(tmp_path / "arm.toml", locked=["j"], actuated=["i"]).model.armature == 0.7
    for wrong, said in (("i = -1", "below 0"), ("k = 1", "unknown joint 'k'")):
        (tmp_path / "arm.toml").write_text(text.replace("i = 0.5", wrong))
        with pytest.raises(pj.PmjacError, match=said):
            pj.load(tmp_path / "arm.toml")


def test_a_moment_that_is_not_given_is_said(tmp_path):
    """SDFormat would take 1 kg m² where one letter is wrong."""
    inertia = "<inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.1</izz></inertia>"
    path = tmp_path / "robot.sdf"
    for wrong, told in ((inertia, ()), (inertia.replace("ixx", "ixz"), ("<ixx>",))):
        link = f'<link name="a"><inertial><mass>1</mass>{wrong}</inertial></link>'
        path.write_text(f'<sdf version="1.9"><model name="m">{link}</model></sdf>')
        default = "SDFormat's default, 1, is taken"
        expected = tuple(f"no {tag} is given for 'a': {default}" for tag in told)
        notes = read_sdf(path).notes
        assert tuple(note for note in notes if default in note) == expected
