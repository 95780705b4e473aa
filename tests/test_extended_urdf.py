"""URDF with a YAML file beside it: the four-bar again, and what each key does."""

from __future__ import annotations

import looped
import numpy as np
import pinocchio as pin
import pytest
from looped import TOOL, joint, link

import pmjac_pin as pj
from pmjac_pin.files.urdf.extended_urdf import closure_yaml_beside, read_extended_urdf

YAML = "closed_loop: [[tip_a, tip_b]]\ntype: ['3d']\nname_mot: [theta]\n"


def urdf():
    """The cut four-bar; `tip_a` and `end_b` are links at C, `tip_b` is a hinge there."""
    p = looped.points()
    links, joints = looped.chain()
    weld = joint("weld", "fixed", "coupler", "tip_a", p["C"] - p["B"])
    hinge = joint("tip_b", "revolute", "rocker", "end_b", p["C"] - p["D"])
    return looped.robot(*links, link("tip_a"), link("end_b"), *joints.values(), weld, hinge)


@pytest.fixture
def write(tmp_path):
    def write(yaml=YAML, text=None, name="robot.yaml", stem="robot"):
        folder = tmp_path / "four_bar_like"
        folder.mkdir(exist_ok=True)
        (folder / name).write_text(yaml)
        path = folder / f"{stem}.urdf"
        path.write_text(urdf() if text is None else text)
        return path

    return write


@pytest.fixture
def read(write):
    return lambda *arguments, **keywords: read_extended_urdf(write(*arguments, **keywords))


@pytest.mark.parametrize(("kind", "loop"), [("3d", pj.PointLoop), ("6D", pj.FrameLoop)])
def test_the_four_bar(write, kind, loop):
    mechanism = pj.load(write(YAML.replace("3d", kind)), tool=TOOL)
    assert mechanism.actuated == ("theta1",)
    assert mechanism.spec.loops == (loop(frames=("tip_a", "end_b")),)
    expected = looped.home().jacobian().J_eq
    np.testing.assert_allclose(mechanism.home.jacobian().J_eq, expected, atol=1e-9)


def test_names(read):
    assert read().name == "four_bar_like"
    assert read(stem="machine").name == "machine"


def test_the_yaml_of_the_same_name_comes_first(write):
    path = write(stem="machine", name="machine.yaml")
    other = path.with_name("robot.yaml")
    other.write_text("nothing: here")
    assert closure_yaml_beside(path).name == "machine.yaml"
    assert pj.load(path, tool=TOOL).mobility == 2
    path.with_name("machine.yaml").unlink()
    assert closure_yaml_beside(path) == other
    other.unlink()
    assert closure_yaml_beside(path) is None
    with pytest.raises(pj.ModelFileError, match=r"there is no robot\.yaml beside it"):
        read_extended_urdf(path)


def test_loops_are_frames_without_a_type(read):
    (loop,) = read("closed_loop: [[tip_a, tip_b]]\nname_mot: [theta1]").loops
    assert isinstance(loop, pj.FrameLoop)


@pytest.mark.parametrize(
    ("names", "motors"),
    [
        ("[theta1]", ("theta1",)),
        ("[phi]", ("phi2", "phi1")),  # every joint that contains it
        ("[phi1, theta]", ("phi1", "theta1")),
        ("[phi1, phi]", ("phi1", "phi2")),
        ("[h, phi1]", ("theta1", "phi2", "phi1")),
        ("[]", ()),
    ],
)
def test_motors_contain_a_part_of_their_name(read, names, motors):
    assert read(YAML.replace("[theta]", names)).actuated == motors


def test_joints_that_are_something_else(read):
    kinds = "joint_name: [phi1, phi2, tip_b]\njoint_type: [SPHERICAL, UJOINT_ZX, FIXED]\n"
    model = read(YAML + kinds)
    joints = {joint.name: joint for joint in model.urdf.joints}
    assert model.spherical == ("phi1",)
    assert joints["tip_b"].type == "fixed"
    first, second = joints["phi2_Z"], joints["phi2_X"]
    assert (first.parent, first.child) == ("crank", "phi2_cross")
    assert (second.parent, second.child) == ("phi2_cross", "coupler")
    assert model.loops == (pj.PointLoop(frames=("tip_a", "end_b")),)
    assert model.notes == (
        "SPHERICAL instead of the URDF's joint: 'phi1'",
        "UJOINT_ZX instead of the URDF's joint: 'phi2'",
        "FIXED instead of the URDF's joint: 'tip_b'",
    )


@pytest.mark.parametrize("kind", ["XY", "YZ", "ZX", "ZY", "XZ", "YX"])
def test_a_universal_joint_turns_about_axes_of_its_own_frame(read, kind):
    model = read(f"{YAML}joint_name: [phi2]\njoint_type: [UJOINT_{kind}]\n")
    pinocchio = pin.buildModelFromXML(model.urdf.kinematic_xml())
    data, q = pinocchio.createData(), pin.neutral(pinocchio)
    angles = {f"phi2_{kind[0]}": 0.4, f"phi2_{kind[1]}": -0.7}
    for name, angle in angles.items():
        q[pinocchio.joints[pinocchio.getJointId(name)].idx_q] = angle
    pin.framesForwardKinematics(pinocchio, data, q)
    turns = {
        letter: pin.AngleAxis(angle, np.eye(3)["XYZ".index(letter)]).matrix()
        for letter, angle in zip(kind, angles.values(), strict=True)
    }
    pose = data.oMf[pinocchio.getFrameId("coupler")]
    np.testing.assert_allclose(pose.rotation, turns[kind[0]] @ turns[kind[1]], atol=1e-15)
    np.testing.assert_allclose(pose.translation, looped.points()["B"], atol=1e-15)


def test_a_spherical_joint_frees_a_spin_that_the_tool_does_not_feel(write):
    """Coupler hung on balls at both ends: it spins about BC, and J_eq of B does not change."""
    yaml = f"{YAML}joint_name: [phi2]\njoint_type: [SPHERICAL]\n"
    mechanism = pj.load(write(yaml), tool="coupler")
    plain = pj.load(write(YAML), tool="coupler")
    assert mechanism.nv == plain.nv + 2
    linear = mechanism.home.split_jacobian().Jv
    np.testing.assert_allclose(linear, plain.home.jacobian().Jv_eq, atol=1e-12)


def test_a_floating_base(write):
    mechanism = pj.load(write(f"{YAML}free_flyer: true\n"), tool=TOOL)
    assert (mechanism.nq, mechanism.nv) == (4 + 7, 4 + 6)
    assert mechanism.mobility == 1 + 1 + 6  # the crank, the hinge behind tip_b, the base
    assert "free_flyer.x" in mechanism.passive


def test_unused_keys_are_said(read):
    assert "robot.yaml: 'rotor_inertia' is not used" in read(f"{YAML}rotor_inertia: [1]\n").notes


BAD = {
    "frame": (
        YAML.replace("tip_b", "tip_c"),
        "`closed_loop`: unknown frame 'tip_c'; did you mean 'tip_b' or 'tip_a'?",
    ),
    "one frame": (
        YAML.replace("tip_a", "end_b"),
        "`closed_loop`: the frames 'end_b' and 'tip_b' are one, of link 'end_b'",
    ),
    "motor": (
        YAML.replace("theta", "tetha"),
        "`name_mot`: no joint that moves is named 'tetha'; there are: theta1, phi2, phi1, tip_b",
    ),
    "joint": (
        f"{YAML}joint_name: [phi3]\njoint_type: [FIXED]",
        "`joint_name`: unknown joint 'phi3'; did you mean 'phi2' or 'phi1'?",
    ),
    "joint type": (
        f"{YAML}joint_name: [phi1]\njoint_type: [BALL]",
        "`joint_type`: unknown 'BALL'; SPHERICAL, FIXED and UJOINT_XY, ... are read",
    ),
    "universal about one axis": (
        f"{YAML}joint_name: [phi1]\njoint_type: [UJOINT_XX]",
        "`joint_type`: UJOINT_XX has twice the same axis",
    ),
}


@pytest.mark.parametrize(("yaml", "message"), BAD.values(), ids=BAD)
def test_what_is_refused(write, yaml, message):
    path = write(yaml)
    with pytest.raises(pj.ModelFileError) as caught:
        read_extended_urdf(path)
    assert str(caught.value) == f"{path.with_name('robot.yaml')}: {message}"


def test_a_urdf_that_is_wrong_is_named(write):
    path = write(text=urdf().replace('link="rocker"', 'link="roker"', 1))
    with pytest.raises(pj.ModelFileError, match="the child link 'roker' does not exist") as caught:
        read_extended_urdf(path)
    assert str(caught.value).startswith(f"{path}: ")
