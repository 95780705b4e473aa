"""Screws: one machine from Pinocchio, from a URDF and from SDF, and all that is asked of it."""

from __future__ import annotations

import math

import matplotlib
import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from differences import difference_quotient

import pmjac_pin as pj
from pmjac_pin.files.urdf.locking import lock_joints
from pmjac_pin.files.urdf.robot import parse_urdf
from pmjac_pin.model.linkage import edges_of, turned_to
from pmjac_pin.viewer.motors import motors_of

# A loop of seven joints with axes anywhere: one degree of freedom.
NUMBERS = np.random.default_rng(7)
POINTS = NUMBERS.uniform(-1.0, 1.0, (7, 3)).round(3)
AXES = NUMBERS.normal(size=(7, 3)).round(3)
AXES /= np.linalg.norm(AXES, axis=1, keepdims=True)
PITCHES = {"j2": 0.12, "j4": -0.3, "j5": 0.05}
NAMES = [f"j{k}" for k in range(1, 7)]
TOOL = np.array([0.2, -0.5, 0.4])
UNALIGNED = {"X": pin.JointModelHX, "Y": pin.JointModelHY, "Z": pin.JointModelHZ}
TURNING = {"X": pin.JointModelRX, "Y": pin.JointModelRY, "Z": pin.JointModelRZ}


def turn_of(letter, axis):
    """A rotation that takes one of the axes to a unit vector."""
    to_z = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}[letter]
    return turned_to(axis) * turned_to(to_z).inverse()


def from_pinocchio(letter):
    """With HX, HY or HZ, or with the axes as they are."""
    model, parent, frame = pin.Model(), 0, pin.SE3.Identity()
    for name, point, axis in zip(NAMES, POINTS, AXES, strict=False):
        pitch, turn = PITCHES.get(name), pin.SE3.Identity()
        if letter is None:
            joint = pin.JointModelRevoluteUnaligned(axis)
            if pitch:
                joint = pin.JointModelHelicalUnaligned(axis, pitch)
        else:
            turn = turn_of(letter, axis)
            joint = UNALIGNED[letter](pitch) if pitch else TURNING[letter]()
        there = pin.SE3(np.eye(3), point) * turn
        parent, frame = model.addJoint(parent, joint, frame.actInv(there), name), there
        if name == "j3":
            at = there.actInv(pin.SE3(np.eye(3), TOOL))
            model.addFrame(pin.Frame("tool", parent, at, pin.FrameType.OP_FRAME))
    end = pin.SE3(np.eye(3), POINTS[6])
    for name, joint, at in (("fixed", 0, end), ("moved", parent, frame.actInv(end))):
        model.addFrame(pin.Frame(name, joint, at, pin.FrameType.OP_FRAME))
    loops = [pj.RevoluteLoop(frames=("fixed", "moved"), axis=tuple(AXES[6]))]
    return pj.Mechanism.from_pinocchio(model, loops, ["j1"], "tool", home=np.zeros(6))


def from_urdf(folder):
    """With the pitches beside a URDF, which has no screws."""
    links = ["ground", *(f"l{k}" for k in range(1, 7))]
    before = [np.zeros(3), *POINTS[:5]]
    kinds = ["continuous" if name == "j4" else "revolute" for name in NAMES]
    steps = [tuple((point - base).tolist()) for point, base in zip(POINTS, before, strict=False)]
    axes = map(tuple, AXES.tolist())
    joints = list(zip(NAMES, kinds, links, links[1:], steps, axes, strict=False))
    ends = [("fixed", "ground", POINTS[6]), ("moved", "l6", POINTS[6] - POINTS[5])]
    ends.append(("tool", "l3", TOOL - POINTS[2]))
    joints += [(f"{name}_at", "fixed", on, name, tuple(place.tolist())) for name, on, place in ends]
    (folder / "screws.urdf").write_text(mechanisms.tree(*joints))
    pitches = ", ".join(f"{name} = {pitch}" for name, pitch in PITCHES.items())
    (folder / "screws.toml").write_text(
        f'urdf = "screws.urdf"\nactuated = ["j1"]\nhelical = {{ {pitches} }}\n'
        f'tool.frame = "tool"\n[[loop]]\nkind = "revolute"\nframes = ["fixed", "moved"]\n'
        f"axis = {AXES[6].tolist()}\n[poses.home]\nj1 = 0.0\n"
    )
    return pj.load(folder / "screws.toml")


def from_sdf(folder, cut="j7", inverse=False):
    """With the pitches in m per turn, or as the inverse in rad/m; the last joint is cut."""
    names = [name for name in (*NAMES, "j7") if name != cut] + [cut]
    order = [int(name[1:]) - 1 for name in names]
    links = ["world", *(f"l{k}" for k in range(1, 7)), "world"]
    text = "".join(f'<link name="{name}"/>' for name in links[1:-1])
    for k in order:
        name, ends = f"j{k + 1}", (links[k], links[k + 1])
        ends = ("world", "l6") if name == "j7" else ends
        pitch, thread = PITCHES.get(name), ""
        if pitch and inverse:
            thread = f"<thread_pitch>{-1 / pitch!r}</thread_pitch>"
        elif pitch:
            thread = f"<screw_thread_pitch>{pitch * math.tau!r}</screw_thread_pitch>"
        numbers = (" ".join(map(repr, array[k].tolist())) for array in (POINTS, AXES))
        point, axis = numbers
        text += (
            f'<joint name="{name}" type="{"screw" if pitch else "revolute"}">'
            f"<parent>{ends[0]}</parent><child>{ends[1]}</child>{thread}"
            f'<pose relative_to="__model__">{point} 0 0 0</pose>'
            f"<axis><xyz>{axis}</xyz></axis></joint>"
        )
    tool = " ".join(map(repr, TOOL.tolist()))
    text += (
        f'<frame name="tool" attached_to="l3"><pose relative_to="l3">{tool} 0 0 0</pose></frame>'
    )
    path = folder / "screws.sdf"
    path.write_text(f'<sdf version="1.10"><model name="screws">{text}</model></sdf>')
    return pj.load(path, actuated=["j1"], tool="tool")


WAYS = {
    "unaligned": lambda folder: from_pinocchio(None),
    **{letter: lambda folder, letter=letter: from_pinocchio(letter) for letter in "XYZ"},
    "URDF": from_urdf,
    "SDF": from_sdf,
    "SDF, inverse": lambda folder: from_sdf(folder, inverse=True),
    "SDF, cut at a screw": lambda folder: from_sdf(folder, cut="j5"),
}


@pytest.mark.parametrize("way", WAYS)
def test_the_same_machine_comes_in_by_all_ways(way, tmp_path):
    """J_eq is that of differences through the closure, and the same whatever it was read from."""
    mechanism, oracle = WAYS[way](tmp_path), from_pinocchio(None)
    assert mechanism.mobility == 1
    for theta in (0.0, 0.25):
        expected, found = (one.close([theta]) for one in (oracle, mechanism))
        J_eq = found.jacobian().J_eq
        np.testing.assert_allclose(J_eq, difference_quotient(expected, 1e-3), atol=1e-8)
        np.testing.assert_allclose(J_eq, expected.jacobian().J_eq, atol=1e-9)
        for name in NAMES if way != "SDF, cut at a screw" else ("j1", "j5"):
            assert found.joint_values[name] == pytest.approx(expected.joint_values[name], abs=1e-9)


@pytest.mark.parametrize("joint", NAMES)
def test_the_cut_does_not_matter(joint):
    mechanism = from_pinocchio("X")
    cut = pj.recut(mechanism, joint)
    for theta in (0.1, -0.2):
        expected, found = (one.close([theta]) for one in (mechanism, cut))
        np.testing.assert_allclose(found.jacobian().J_eq, expected.jacobian().J_eq, atol=1e-9)


def test_certificate_and_findings():
    mechanism = from_pinocchio("Y")
    assert pj.certify(mechanism.close([0.2]))
    kinds = {one.name: one.kind for one in pj.check(mechanism).freedoms}
    assert kinds == {name: "helical" if name in PITCHES else "revolute" for name in NAMES}
    with pytest.raises(pj.ArgumentError, match="the screw 'j2' is no polynomial"):
        pj.parameter_homotopy(mechanism, rng=0)


REACH, ROD, PITCH = 0.4, 1.0, 0.02  # m, m, m/rad


def press(driven="crank"):
    """A crank pushes a slide by a rod, and the slide a fast screw that turns as it gives way."""
    model = pin.Model()

    def add(joint, name, x=0.0, limit=np.inf):
        wide = np.full(1, 1e9)
        place, most = pin.SE3(np.eye(3), np.array([x, 0.0, 0.0])), np.full(1, limit)
        return model.addJoint(0, joint, place, name, wide, wide, -most, most)

    crank, slide = add(pin.JointModelRZ(), "crank"), add(pin.JointModelPX(), "slide")
    screw = add(pin.JointModelHX(PITCH), "screw", 0.3)
    for name, joint, place in (
        ("pin", crank, (REACH, 0.0, 0.0)),
        ("on slide", slide, (0.0, 0.0, 0.0)),
        ("head", screw, (-0.1, 0.0, 0.0)),
        ("tool", screw, (0.0, 0.1, 0.0)),
    ):
        at = pin.SE3(np.eye(3), np.array(place))
        model.addFrame(pin.Frame(name, joint, at, pin.FrameType.OP_FRAME))
    loops = [
        pj.DistanceLoop(frames=("pin", "on slide"), length=ROD),
        pj.PointLoop(frames=("on slide", "head")),
    ]
    x = slid(0.7, 1)
    home = {"crank": 0.7, "slide": x, "screw": (x - 0.2) / PITCH}
    return pj.Mechanism.from_pinocchio(model, loops, [driven], "tool", home=home, name="press")


def slid(crank, side):
    """Where the slide is by hand."""
    return REACH * math.cos(crank) + side * math.sqrt(ROD**2 - (REACH * math.sin(crank)) ** 2)


def rate(crank, side):
    """And its rate per rate of the crank."""
    root = side * math.sqrt(ROD**2 - (REACH * math.sin(crank)) ** 2)
    return -REACH * math.sin(crank) - REACH**2 * math.sin(crank) * math.cos(crank) / root


def test_close_and_jacobian_by_hand():
    for crank in (0.7, 1.5, -2.0):
        configuration = press().close([crank])
        x, dx = slid(crank, 1), rate(crank, 1)
        turn = (x - 0.2) / PITCH
        assert configuration.joint_values["screw"] == pytest.approx(turn, abs=1e-9)
        J_eq = configuration.jacobian().J_eq[:, 0]
        spin = dx / PITCH
        aside = 0.1 * np.array([-math.sin(turn), math.cos(turn)])
        np.testing.assert_allclose(J_eq, [dx, *(aside * spin), spin, 0, 0], atol=1e-9)


def test_a_screw_that_drives():
    mechanism = press("screw")
    turn = (slid(0.9, 1) - 0.2) / PITCH
    configuration = mechanism.close([turn])
    assert configuration.joint_values["crank"] == pytest.approx(0.9)
    np.testing.assert_allclose(
        configuration.jacobian().J_eq, difference_quotient(configuration, 1e-2), atol=1e-8
    )
    assert pj.certify(configuration)


def test_its_turns_count_in_the_modes():
    """Both of the rod's modes, and the screw as many turns apart as the slide is pitches apart."""
    modes = pj.assembly_modes(press(), [0.7], rng=0)
    assert (len(modes), modes.evidence.kind) == (2, "proof")
    found = sorted(mode.joint_values["screw"] for mode in modes)
    assert found == pytest.approx([(slid(0.7, side) - 0.2) / PITCH for side in (-1, 1)])
    by_search = pj.assembly_modes(press(), [0.7], rng=0, proof=False)
    assert len(by_search) == 2
    assert len(pj.assembly_modes(press("screw"), [50.0], rng=0)) == 2


def test_a_joint_geared_to_a_screw_has_no_period():
    """One that followed an angle would be the same after a full turn; a screw is not."""
    model = press().model.copy()
    wheel = model.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), "wheel")
    model.addFrame(pin.Frame("rim", wheel, pin.SE3.Identity(), pin.FrameType.OP_FRAME))
    loops = [*press().spec.loops, pj.JointLoop(joints=("screw", "wheel"), ratio=0.5)]
    home = {**press().home.joint_values, "wheel": 0.5 * press().home.joint_values["screw"]}
    mechanism = pj.Mechanism.from_pinocchio(model, loops, ["crank"], "rim", home=home)
    found = [mode.joint_values["screw"] for mode in pj.assembly_modes(mechanism, [0.7], rng=0)]
    assert sorted(found) == pytest.approx([(slid(0.7, side) - 0.2) / PITCH for side in (-1, 1)])


def test_the_length_of_a_machine_is_not_its_pitch():
    lengths = []
    for pitch in (0.001, 0.02, 5.0):
        model = pin.Model()
        screw = model.addJoint(0, pin.JointModelHZ(pitch), pin.SE3.Identity(), "screw")
        slide = model.addJoint(0, pin.JointModelPZ(), pin.SE3.Identity(), "slide")
        for name, joint in (("one", screw), ("other", slide)):
            model.addFrame(pin.Frame(name, joint, pin.SE3.Identity(), pin.FrameType.OP_FRAME))
        loops = [pj.PointLoop(frames=("one", "other"))]
        jack = pj.Mechanism.from_pinocchio(model, loops, ["screw"], "other", home=np.zeros(2))
        lengths.append(jack.problem.partition.length)
        assert jack.close([3.0]).passive == pytest.approx([3.0 * pitch])
    assert lengths == [lengths[0]] * 3


def test_a_screw_without_limits_has_a_slider_about_home():
    (motor,) = motors_of(press("screw"))
    turn, far = (slid(0.7, 1) - 0.2) / PITCH, 2.0 * press().characteristic_length / PITCH
    assert (motor.lower, motor.upper) == pytest.approx((turn - far, turn + far))


def test_drawing_and_page(tmp_path):
    matplotlib.use("Agg")
    from pmjac_pin.pictures.mode_sheet import plot_modes

    assert plot_modes(pj.assembly_modes(press(), [0.7], rng=0))[0].axes
    with pj.view(press().home, open_browser=False, port=0) as viewer:
        viewer.save_html(tmp_path / "page.html")
    assert (tmp_path / "page.html").stat().st_size > 0


def test_a_locked_screw_is_where_its_turn_slid_it(tmp_path):
    from_urdf(tmp_path)
    mechanism, value = pj.load(tmp_path / "screws.toml"), 0.35
    urdf = parse_urdf((tmp_path / "screws.urdf").read_text(), "screws.urdf")
    model = pin.buildModelFromXML(lock_joints(urdf, {"j2": value}, PITCHES).kinematic_xml())
    places = []
    for one, turned in ((model, {}), (mechanism.model, {"j2": value})):
        q, data = pin.neutral(one), one.createData()
        for name, angle in turned.items():
            q[one.joints[one.getJointId(name)].idx_q] = angle
        pin.framesForwardKinematics(one, data, q)
        places.append(data.oMf[one.getFrameId("l2")].homogeneous)
    np.testing.assert_allclose(*places, atol=1e-12)


def test_it_is_converted(tmp_path):
    from_sdf(tmp_path)
    model_file, _ = pj.convert(
        tmp_path / "screws.sdf", tmp_path / "own.toml", actuated=["j1"], tool="tool"
    )
    written = pj.load(model_file)
    expected = from_pinocchio(None).close([0.2]).jacobian().J_eq
    np.testing.assert_allclose(written.close([0.2]).jacobian().J_eq, expected, atol=1e-9)
    assert {name: edge.pitch for name, edge in edges_of(written.model).items() if edge.pitch} == (
        pytest.approx(PITCHES)
    )


@pytest.mark.parametrize(
    ("helical", "message"),
    [
        ("{ j7 = 0.1 }", "`helical` names joints that the URDF writes as revolute or continuous"),
        ("{ j1 = 0.0 }", "the pitch of joint 'j1' is of magnitude 1e-09 to 1e+09 m/rad, got 0"),
        ("{ j1 = inf }", "`helical` holds inf; a finite number is wanted"),
        ('{ j1 = "1" }', "Expected `float`, got `str` - at `helical"),
    ],
)
def test_pitches_that_are_none(helical, message, tmp_path):
    from_urdf(tmp_path)
    path = tmp_path / "screws.toml"
    lines = path.read_text().splitlines()
    lines[2] = f"helical = {helical}"
    path.write_text("\n".join(lines))
    with pytest.raises(pj.ModelFileError) as caught:
        pj.load(path)
    assert message in str(caught.value)


def test_pinocchios_pitches_are_checked():
    model = press().model.copy()
    model.addJoint(0, pin.JointModelHX(math.nan), pin.SE3.Identity(), "odd")
    with pytest.raises(pj.ArgumentError, match="the pitch of joint 'odd'"):
        pj.Mechanism.from_pinocchio(model, press().spec.loops, ["crank"], "tool")
