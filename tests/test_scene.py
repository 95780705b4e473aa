"""The scene: what is to be seen of a configuration, without a browser."""

from __future__ import annotations

import itertools
import pickle
import re

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.files.catalog import find_model_file, find_urdf
from pmjac_pin.files.shapes import Box, Cone, Cylinder, Sphere, Text
from pmjac_pin.rates.ellipsoid import velocity_ellipsoid
from pmjac_pin.rates.motor_limits import stated_rate_limits
from pmjac_pin.viewer.ellipsoids import LIMIT, THINNEST, directions_after, radius_label
from pmjac_pin.viewer.free_motion import ALMOST_SINGULAR
from pmjac_pin.viewer.scene import SceneMaker
from pmjac_pin.viewer.scene_options import SceneOptions

EVERYTHING = SceneOptions(
    linear=True, angular=True, force=True, velocity_polytope=True, force_polytope=True
)
MESH = '<mesh filename="package://nowhere/missing.stl"/>'


def rewritten(name, folder, change):
    """The model file of the catalogue with another URDF, and without parameters."""
    model = find_model_file(name)
    text = model.read_text(encoding="utf-8")
    urdf = find_urdf(f"{name}.urdf", model).read_text(encoding="utf-8")
    text = text.split("[parameters")[0].replace("{ a = 1.7320508075688772 }", repr(0.75**0.5))
    (folder / f"{name}.toml").write_text(text, encoding="utf-8")
    (folder / f"{name}.urdf").write_text(change(urdf), encoding="utf-8")
    return pj.load(folder / f"{name}.toml")


def bare(name, folder):
    return rewritten(
        name, folder, lambda text: re.sub(r"<visual.*?</visual>", "", text, flags=re.S)
    )


def meshes(name, folder):
    pattern = r"<geometry>.*?</geometry>"
    return rewritten(
        name, folder, lambda text: re.sub(pattern, f"<geometry>{MESH}</geometry>", text)
    )


OTHERS = {
    "bare": lambda folder: bare("three_rps", folder),
    "bare_four_bar": lambda folder: bare("four_bar", folder),
    "meshes": lambda folder: meshes("three_rps_ss", folder),
    "idle_rod": lambda folder: mechanisms.rssr(),
    "distance": lambda folder: mechanisms.rssr(rod=False),
    "forbidden": lambda folder: mechanisms.over_actuated_four_bar(),
    "redundant": lambda folder: mechanisms.four_bar_cut_at("A", 0.9, (2.0236, 0.0075)),
    "yawing": lambda folder: mechanisms.yawing_four_bar(),
}


@pytest.fixture(params=[*mechanisms.CATALOGUE, *OTHERS])
def mechanism(request, tmp_path):
    make = OTHERS.get(request.param)
    return make(tmp_path) if make else pj.load(request.param)


@pytest.fixture(scope="module")
def three_rps():
    return loaded("three_rps")


@pytest.fixture(scope="module")
def limit():
    """A four-bar at the end of its motor's range, and the pose a little before it."""
    mechanism = mechanisms.rocker_rocker()
    with pytest.raises(pj.ClosureError) as caught:
        mechanism.close([3.0])
    reached = caught.value.reached
    return reached, mechanism.close(reached.actuated - 1e-4)


def scene(configuration, options=None):
    return SceneMaker(configuration.mechanism).scene(configuration, options)


def by_name(scene):
    return {item.name: item for item in scene.items}


def transforms(scene):
    return np.array([item.transform for item in scene.items])


def poses(mechanism, rng):
    """Home, the named poses and a random one."""
    named = [mechanism.pose(name) for name in mechanism.poses]
    if len(mechanism.actuated) > mechanism.mobility:
        return named
    return [*named, *mechanisms.random_closed(mechanism, rng, 1, spread=0.05)]


def ends(item):
    """Both ends of a cylinder or cone."""
    half = 0.5 * item.transform[:3, 2]
    return item.transform[:3, 3] - half, item.transform[:3, 3] + half


# Laws of every scene.


def test_names_are_the_same_at_all_poses_and_no_path_begins_another(mechanism, rng):
    maker = SceneMaker(mechanism)
    scenes = [maker.scene(pose, EVERYTHING) for pose in poses(mechanism, rng)]
    names = [item.name for item in scenes[0].items]
    assert len(set(names)) == len(names)
    paths = {tuple(name.split("/")) for name in names}
    assert not any(path[:depth] in paths for path in paths for depth in range(1, len(path)))
    assert all(part for path in paths for part in path)
    for other in scenes[1:]:
        assert [item.name for item in other.items] == names
        for one, two in zip(scenes[0].items, other.items, strict=True):
            assert one.colour == two.colour
            assert type(one.shape) is type(two.shape)


def test_transforms_are_finite_right_handed_read_only_and_without_shear(mechanism, rng):
    maker = SceneMaker(mechanism)
    for pose in poses(mechanism, rng):
        scene = maker.scene(pose, EVERYTHING)
        found = transforms(scene)
        assert np.isfinite(found).all()
        np.testing.assert_array_equal(found[:, 3], np.tile([0.0, 0, 0, 1], (len(found), 1)))
        scales = np.linalg.norm(found[:, :3, :3], axis=1)
        assert scales.min() > 0.0
        rotations = found[:, :3, :3] / scales[:, None, :]
        gram = rotations.transpose(0, 2, 1) @ rotations
        np.testing.assert_allclose(gram, np.broadcast_to(np.eye(3), gram.shape), atol=1e-9)
        assert (np.linalg.det(rotations) > 0.9).all()
        assert not any(item.transform.flags.writeable for item in scene.items)


def test_what_is_hidden_is_too_small_to_be_seen(mechanism):
    for item in scene(mechanism.home, EVERYTHING).items:
        widest = np.linalg.norm(item.transform[:3, :3], axis=0).max()
        assert (widest > 1e-3 * mechanism.characteristic_length) == item.visible, item.name


def test_a_scene_maker_gives_what_scene_gives_and_survives_other_poses(three_rps):
    maker = SceneMaker(three_rps)
    maker.scene(three_rps.pose("lecture_a"))
    again = maker.scene(three_rps.home)
    np.testing.assert_array_equal(transforms(again), transforms(scene(three_rps.home)))


def test_options_choose_what_there_is(three_rps):
    maker = SceneMaker(three_rps)
    plain = SceneOptions(linear=False, names=False)
    groups = {item.name.split("/")[0] for item in maker.scene(three_rps.home, plain).items}
    assert groups == {"links", "joints", "motors", "loops", "free", "tool", "load"}
    names = set(by_name(maker.scene(three_rps.home, EVERYTHING)))
    for kind in ("linear", "angular", "force"):
        assert f"ellipsoids/{kind}/surface" in names
    assert {"polytopes/velocity/faces", "polytopes/force/edges"} <= names


def test_wrong_arguments_are_refused(three_rps):
    for scale in (0.0, -1.0, np.inf, np.nan):
        with pytest.raises(pj.ArgumentError, match="scale must be a positive number"):
            SceneOptions(scale=scale)
    other = pj.load("three_rps", {"a": 0.6})
    with pytest.raises(pj.ArgumentError, match="'three_rps'"):
        SceneMaker(three_rps).scene(other.home)


# Links and joints.


def test_visuals_stand_where_pinocchio_has_their_links(three_rps, rng):
    model = three_rps.model
    data = model.createData()
    for pose in poses(three_rps, rng):
        pin.framesForwardKinematics(model, data, pose.q)
        items = by_name(scene(pose))
        tube = pin.SE3(pin.utils.rotate("y", np.pi / 2), np.array([-0.05, 0, 0]))
        for leg in (1, 2, 3):
            link = data.oMf[model.getFrameId(f"leg{leg}_cylinder")]
            expected = (link * tube).homogeneous @ np.diag([0.035, 0.035, 0.1, 1])
            found = items[f"links/leg{leg}_cylinder/leg{leg}_cylinder_tube"]
            assert isinstance(found.shape, Cylinder)
            np.testing.assert_allclose(found.transform, expected, atol=1e-12)
        plate = data.oMf[model.getFrameId("plate")].homogeneous @ np.diag([0.5, 0.5, 0.02, 1])
        found = items["links/plate/plate_disc"]
        np.testing.assert_allclose(found.transform, plate, atol=1e-12)
        assert found.colour == (0.0, 0.45, 0.70, 1.0)


def test_parameters_change_the_drawing():
    items = by_name(scene(pj.load("four_bar", {"l1": 1.3}).close([0.0])))
    crank = items["links/crank/crank_bar"].transform
    np.testing.assert_allclose(np.diag(crank), [1.3, 0.08, 0.08, 1])
    np.testing.assert_allclose(crank[:3, 3], [0.65, 0, 0], atol=1e-12)


def test_visuals_survive_pickling(three_rps):
    mechanism = pickle.loads(pickle.dumps(three_rps))
    expected = transforms(scene(three_rps.home))
    np.testing.assert_allclose(transforms(scene(mechanism.home)), expected, atol=1e-9)


def test_every_visual_that_can_be_drawn_is_and_a_broken_one_is_not(tmp_path, caplog):
    visuals = """<link name="ground">
      <visual><geometry><capsule radius="0.1" length="0.6"/></geometry>
        <material name="red"/></visual>
      <visual name="same"><geometry><box size="1 1 0"/></geometry></visual>
      <visual name="a/b"><geometry><sphere radius="0.5"/></geometry></visual>
      <visual name="a_b"><geometry><sphere radius="0.4"/></geometry>
        <material name="red"><color rgba="2 0.5 0 nonsense"/></material></visual>
      <visual name="empty"/>"""
    material = '<material name="red"><color rgba="1 0 0 0.5"/></material>'

    def change(text):
        text = re.sub(r"<visual.*?</visual>", "", text, flags=re.S)
        return text.replace('<link name="ground">', material + visuals)

    items = by_name(scene(rewritten("four_bar", tmp_path, change).home))
    names = [name for name in items if name.startswith("links/ground/")]
    capsule = [f"links/ground/visual1{end}" for end in ("", "~2", "~3")]
    balls = ["links/ground/a_b", "links/ground/a_b~2"]
    # A body with a visual that cannot be drawn has bars as well.
    assert names == [*capsule, *balls, "links/ground/bar1"]
    assert items[capsule[0]].colour == (1, 0, 0, 0.5)
    assert items[capsule[2]].transform[2, 3] == 0.3
    assert items[balls[1]].colour == items[capsule[0]].colour
    assert "box" in caplog.text
    assert "rgba" in caplog.text


@pytest.mark.parametrize(("make", "count"), [(bare, 4), (meshes, 4)])
def test_without_visuals_bars_join_the_joints(tmp_path, make, count):
    mechanism = make("four_bar", tmp_path)
    configuration = mechanism.close([1.2])
    items = by_name(scene(configuration))
    theta, phi = 1.2, configuration.passive[0]
    crank_tip = np.array([np.cos(theta), np.sin(theta), 0])
    pivot = np.array([4.0, 0, 0])
    tip = pivot + 3.5 * np.array([np.cos(phi), np.sin(phi), 0])
    bars = [name for name in items if name.startswith("links/") and "/bar" in name]
    assert len({name.split("/")[1] for name in bars}) == count
    np.testing.assert_allclose(ends(items["links/ground/bar1"]), [pivot, [0, 0, 0]], atol=1e-9)
    np.testing.assert_allclose(ends(items["links/crank/bar1"]), [[0, 0, 0], crank_tip], atol=1e-9)
    np.testing.assert_allclose(ends(items["links/rocker/bar1"]), [pivot, tip], atol=1e-9)
    # The tool is at the coupler's middle: one bar from there to either end.
    halves = np.array([ends(items[name])[1] for name in bars if "coupler" in name])
    np.testing.assert_allclose(halves, [crank_tip, tip], atol=1e-9)


def test_where_a_loops_end_is_far_from_a_links_visual_a_bar_goes_there(tmp_path):
    """The rocker is a small box about its joint; the visuals of the others span them."""
    box = '<visual><geometry><box size="0.3 0.3 0.3"/></geometry></visual>'
    rocker = re.compile(r'(<link name="rocker">.*?)<visual.*?</visual>', re.S)
    mechanism = rewritten("four_bar", tmp_path, lambda text: rocker.sub(rf"\1{box}", text))
    items = by_name(scene(mechanism.home))
    bars = [name for name in items if re.fullmatch(r"links/\w+/bar\d+", name)]
    assert bars == ["links/rocker/bar1"]
    bar = items["links/rocker/bar1"].transform
    ends = [bar[:3, 3] + way * bar[:3, 2] for way in (-0.5, 0.5)]
    anchor = items["loops/1/second"].transform[:3, 3]
    assert min(np.linalg.norm(end - anchor) for end in ends) < 1e-9


def test_a_slide_without_visuals_is_drawn_by_its_rail(tmp_path):
    mechanism = bare("three_rps", tmp_path)
    items = by_name(scene(mechanism.home))
    rail = ends(items["motors/l1/rail"])
    np.testing.assert_allclose(rail[0], [1, 0, 0], atol=1e-9)
    np.testing.assert_allclose(rail[1], items["loops/1/second"].transform[:3, 3], atol=1e-9)
    plate = [name for name in items if name.startswith("links/plate/bar")]
    assert len(plate) == 3


def test_meshes_of_an_arm_become_bars_from_joint_to_joint():
    mechanism = loaded("ur5")
    model, home = mechanism.model, mechanism.home
    data = model.createData()
    pin.forwardKinematics(model, data, home.q)
    items = by_name(scene(home))
    for joint, link in ((2, "upper_arm_link"), (3, "forearm_link")):
        expected = [data.oMi[joint].translation, data.oMi[joint + 1].translation]
        np.testing.assert_allclose(ends(items[f"links/{link}/bar1"]), expected, atol=1e-9)
    last = ends(items["links/wrist_3_link/bar1"])[1]
    np.testing.assert_allclose(last, home.tool_pose().translation, atol=1e-9)
    assert len([name for name in items if name.startswith("motors/")]) == 6


def test_pins_lie_along_their_axes_and_motors_have_their_own_colour(three_rps):
    model, home = three_rps.model, three_rps.home
    data = model.createData()
    pin.forwardKinematics(model, data, home.q)
    items = by_name(scene(home))
    placement = data.oMi[model.getJointId("theta2")]
    pin_ = items["joints/theta2/pin"]
    along = pin_.transform[:3, 2] / np.linalg.norm(pin_.transform[:3, 2])
    np.testing.assert_allclose(along, placement.rotation[:, 1], atol=1e-12)
    np.testing.assert_allclose(pin_.transform[:3, 3], placement.translation, atol=1e-12)
    assert isinstance(items["motors/l2/slider"].shape, Box)
    assert items["motors/l2/slider"].colour != pin_.colour
    assert items["names/l2"].shape == Text("l2")
    # The floating joint is where coordinates start, not a place: no glyph.
    assert not any("/platform/" in name for name in items)


# Loops.


def test_anchors_coincide_when_closed(mechanism, rng):
    maker = SceneMaker(mechanism)
    for pose in poses(mechanism, rng):
        items = by_name(maker.scene(pose))
        for number, loop in enumerate(mechanism.spec.loops, start=1):
            first = items[f"loops/{number}/first"].transform[:3, 3]
            second = items[f"loops/{number}/second"].transform[:3, 3]
            length = 0.0
            if isinstance(loop, pj.DistanceLoop):
                length = loop.resolved_length(mechanism.parameters)
                rod = ends(items[f"loops/{number}/rod"])
                np.testing.assert_allclose(rod, [first, second], atol=1e-9)
            assert abs(np.linalg.norm(second - first) - length) < 1e-9
            assert not items[f"loops/{number}/gap"].visible


def open_loop(loop, second):
    """A loop that leaves open what a rounded model may: millimetres."""
    model = pin.Model()
    joint = model.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), "motor")
    model.addFrame(pin.Frame("one", 0, pin.SE3.Identity(), pin.FrameType.OP_FRAME))
    model.addFrame(pin.Frame("two", joint, second, pin.FrameType.OP_FRAME))
    return pj.Mechanism.from_pinocchio(model, [loop], ["motor"], "two", tolerance=0.01)


AXIS = np.array([0.0, 0.6, 0.8])
AWAY = np.array([0.003, 0.005, -0.002])


@pytest.mark.parametrize(
    ("loop", "expected"),
    [
        (pj.PointLoop(frames=("one", "two")), AWAY),
        (pj.RevoluteLoop(frames=("one", "two"), axis=tuple(AXIS)), AWAY),
        (pj.PrismaticLoop(frames=("one", "two"), axis=tuple(AXIS)), AWAY - AWAY @ AXIS * AXIS),
        (pj.CylindricalLoop(frames=("one", "two"), axis=tuple(AXIS)), AWAY - AWAY @ AXIS * AXIS),
        (pj.PlanarLoop(frames=("one", "two"), axis=tuple(AXIS)), AWAY @ AXIS * AXIS),
        (
            pj.DistanceLoop(frames=("one", "two"), length=0.002),
            AWAY * (1 - 0.002 / np.linalg.norm(AWAY)),
        ),
    ],
    ids=lambda value: type(value).__name__,
)
def test_the_gap_is_what_the_loop_leaves_open(loop, expected):
    mechanism = open_loop(loop, pin.SE3(np.eye(3), AWAY))
    gap = by_name(scene(mechanism.home))["loops/1/gap"]
    assert gap.visible
    start, end = ends(gap)
    np.testing.assert_allclose(end - start, expected, atol=1e-12)


@pytest.mark.parametrize("joint", ["x", "beta"])
def test_anchors_show_the_axis_of_their_loop(joint):
    """The joint of the tree, and the loop that it becomes where it is cut."""
    mechanism = loaded("slider_crank")
    recut = pj.recut(mechanism, joint)
    for theta in (0.9, 2.0):
        data = mechanism.model.createData()
        pin.computeJointJacobians(mechanism.model, data, mechanism.close([theta]).q)
        column = data.J[:, mechanism.model.joints[mechanism.model.getJointId(joint)].idx_v]
        items = by_name(scene(recut.close([theta])))
        assert not items["loops/1/gap"].visible
        for name in ("first", "second"):
            along = items[f"loops/1/{name}_axis"].transform[:3, 2]
            expected = column[:3] if joint == "x" else column[3:]
            np.testing.assert_allclose(np.cross(along, expected), 0, atol=1e-9)
            middle = items[f"loops/1/{name}_axis"].transform[:3, 3]
            np.testing.assert_allclose(middle, items[f"loops/1/{name}"].transform[:3, 3])


@pytest.mark.parametrize("ratio", [-0.5, -3.0, 2.0])
def test_gears_are_wheels_as_large_as_their_ratio_says(ratio):
    model = loaded("serial_2r").model
    gear = pj.JointLoop(joints=("theta1", "theta2"), ratio=ratio)
    mechanism = pj.Mechanism.from_pinocchio(model, [gear], ["theta1"], "tip")
    home, moved = (by_name(scene(pose)) for pose in (mechanism.home, mechanism.close([0.4])))
    assert not any(name.startswith("loops/") for name in home)
    radii = [np.linalg.norm(home[f"gears/1/{end}"].transform[:3, 0]) for end in ("first", "second")]
    assert radii[0] / radii[1] == pytest.approx(abs(ratio))
    places = [home[f"gears/1/{end}"].transform[:3, 3] for end in ("first", "second")]
    if ratio < 0.0:  # they turn against each other, and touch
        assert sum(radii) == pytest.approx(np.linalg.norm(places[1] - places[0]))
    belt = home["gears/1/belt"].transform
    np.testing.assert_allclose(belt[:3, 3], np.mean(places, axis=0), atol=1e-12)
    spokes = [pose["gears/1/first_spoke"].transform[:3, 2] for pose in (home, moved)]
    turned = np.arccos(spokes[0] @ spokes[1] / np.linalg.norm(spokes[0]) ** 2)
    assert turned == pytest.approx(0.4)


def test_a_gear_on_a_slide_has_a_line_only():
    mechanism = pj.load("slider_crank")
    model, slide = mechanism.model, mechanism.actuated
    assert slide
    names = [name for name in model.names if name != "universe"]
    turning, sliding = (
        next(name for name in names if mechanism.units.get(name) == unit) for unit in ("rad", "m")
    )
    gear = pj.JointLoop(joints=(turning, sliding), ratio=0.1)
    geared = pj.Mechanism.from_pinocchio(model, [gear], [turning], mechanism.spec.tool.names[0])
    names = [name for name in by_name(scene(geared.home)) if name.startswith("gears/")]
    assert names == ["gears/1/first", "gears/1/first_spoke", "gears/1/belt"]


def test_a_motor_s_name_stands_midway_along_its_slide(three_rps):
    items = by_name(scene(three_rps.close([1.2, 1.0, 0.9])))
    for leg in (1, 2, 3):
        foot = items[f"joints/theta{leg}/pin"].transform[:3, 3]
        end = items[f"loops/{leg}/second"].transform[:3, 3]
        place = items[f"names/l{leg}"].transform[:3, 3]
        np.testing.assert_allclose(place, 0.5 * (foot + end), atol=1e-9)


# Ellipsoids.


@pytest.mark.parametrize("name", ["serial_2r", "four_bar", "three_rps"])
def test_arrows_do_not_jump_while_a_motor_turns(name):
    """The sign of the library's axes changes on the way, that of the arrows does not.

    At the home of the 3-RPS two radii are equal: there and beside it only the span of their arrows
    stays, not each.
    """
    mechanism = loaded(name)
    maker = SceneMaker(mechanism)
    values = mechanism.home.actuated
    directions, axes, arrows, apart = {}, [], [], []
    for step in np.linspace(0.0, 0.6 if name == "three_rps" else 3.4, 300):
        pose = mechanism.close(values + step * np.eye(values.size)[-1])
        before = directions.get("linear", np.eye(3))
        drawn = maker.scene(pose, directions=directions)
        directions = drawn.directions
        likeness = before.T @ directions["linear"]
        if arrows:
            assert likeness[np.abs(likeness).argmax(axis=0), range(3)].min() > 0.5
        ellipsoid = pose.jacobian().velocity_ellipsoid()
        head = by_name(drawn)["ellipsoids/linear/axis1/head"].transform[:3, 2]
        arrows.append(head / np.linalg.norm(head))
        axes.append(ellipsoid.axes[:, 0])
        apart.append(ellipsoid.radii[1] < 0.99 * ellipsoid.radii[0])
        np.testing.assert_allclose(abs(arrows[-1] @ axes[-1]), 1.0, atol=1e-9)
    both = np.array(apart[1:]) & apart[:-1]
    assert both.sum() > 280
    jumps = [np.sum(np.array(them[1:]) * them[:-1], axis=1)[both] for them in (axes, arrows)]
    assert jumps[1].min() > 0.9
    if name != "three_rps":
        assert jumps[0].min() < 0.0


def made(radii, axes):
    """The ellipsoid with these radii and axes, made as from a Jacobian."""
    return velocity_ellipsoid(axes * np.array(radii))


@pytest.mark.parametrize("radii", [(2, 1, 1), (2, 2, 1), (1, 1, 0), (1, 0, 0)])
def test_arrows_of_equal_radii_turn_as_little_as_it_takes(radii, rng):
    """Of all pairs of axes of the plane of equal radii, those that turned least."""
    two = slice(0, 2) if radii[0] == radii[1] else slice(1, 3)
    for _ in range(50):
        before = np.linalg.qr(rng.standard_normal((3, 3)))[0]
        axes = np.linalg.qr(rng.standard_normal((3, 3)))[0]
        after = directions_after({"linear": before}, {"linear": made(radii, axes)})["linear"]
        np.testing.assert_allclose(after.T @ after, np.eye(3), atol=1e-12)
        span = axes[:, two] @ axes[:, two].T
        np.testing.assert_allclose(span @ after[:, two], after[:, two], atol=1e-12)
        # The arrow that is nearest to the third axis becomes that; the others stay two and two.
        single = after[:, 2 if two.start == 0 else 0]
        others = np.delete(before, np.abs(before.T @ single).argmax(), axis=1)
        U, _, Vt = np.linalg.svd(span @ others)
        np.testing.assert_allclose(after[:, two], U[:, :2] @ Vt, atol=1e-12)
        again = directions_after({"linear": after}, {"linear": made(radii, axes)})["linear"]
        np.testing.assert_allclose(again, after, atol=1e-12)


def test_arrows_of_a_ball_stay(rng):
    before = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    ball = made((1, 1, 1), np.linalg.qr(rng.standard_normal((3, 3)))[0])
    np.testing.assert_array_equal(
        directions_after({"linear": before}, {"linear": ball})["linear"], before
    )


@pytest.mark.parametrize("name", ["three_rps", "agile_eye", "delta", "planar_3rrr"])
def test_arrows_at_a_symmetric_home_do_not_depend_on_rounding(name, rng):
    """Neither alone nor after another picture, though the Jacobian is a different one each time."""
    jacobian = loaded(name).home.jacobian()
    before = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    for block in (jacobian.Jv_eq, jacobian.Jw_eq):
        alone, following = [], []
        for _ in range(10):
            noise = 1e-14 * np.linalg.norm(block) * rng.standard_normal(block.shape)
            ellipsoid = velocity_ellipsoid(block + noise, rounding=1e-12)
            alone.append(ellipsoid.axes)
            after = directions_after({"linear": before}, {"linear": ellipsoid})
            following.append(after["linear"])
        for same in (alone, following):
            np.testing.assert_allclose(same, [same[0]] * 10, atol=1e-9)


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
@pytest.mark.parametrize("scale", [1.0, 0.3])
def test_the_ellipsoid_is_the_jacobians(name, scale, rng):
    mechanism = loaded(name)
    maker = SceneMaker(mechanism)
    options = SceneOptions(angular=True, scale=scale)
    home = mechanism.home.jacobian()
    for pose in mechanisms.random_closed(mechanism, rng, 2, spread=0.1):
        items, jacobian = by_name(maker.scene(pose, options)), pose.jacobian()
        for kind in ("linear", "angular"):
            get = pj.EquivalentJacobian.velocity_ellipsoid
            if kind == "angular":
                get = pj.EquivalentJacobian.angular_ellipsoid
            ellipsoid, unit_at_home = get(jacobian), get(home).radii[0] or 1.0
            surface = items[f"ellipsoids/{kind}/surface"].transform
            tool = pose.tool_pose().translation
            np.testing.assert_allclose(surface[:3, 3], tool, atol=1e-12)
            _, drawn, _ = np.linalg.svd(surface[:3, :3])
            size = items_size(mechanism)
            expected = 0.35 * size * scale * ellipsoid.radii / unit_at_home
            np.testing.assert_allclose(
                drawn, np.clip(expected, THINNEST * size, LIMIT * size), rtol=1e-9
            )
            for n in range(ellipsoid.rank):
                axis = f"ellipsoids/{kind}/axis{n + 1}"
                tip = ends(items[f"{axis}/head"])[1] - tool
                np.testing.assert_allclose(tip, ellipsoid.axes[:, n] * drawn[n], atol=1e-9)
                neck = ends(items[f"{axis}/head"])[0]
                np.testing.assert_allclose(ends(items[f"{axis}/shaft"])[1], neck, atol=1e-9)
                np.testing.assert_allclose(ends(items[f"{axis}/shaft"])[0], tool, atol=1e-9)
                text = items[f"{axis}/label"].shape.text
                value, unit = text.split()
                assert unit == ellipsoid.unit
                assert float(value) == pytest.approx(ellipsoid.radii[n], rel=5e-4)
            hidden = [items[f"ellipsoids/{kind}/axis{n + 1}/head"].visible for n in range(3)]
            assert sum(hidden) == ellipsoid.rank


def items_size(mechanism):
    """The mechanism's size by its glyphs: the tool's arrows are 0.15 of it long."""
    items = by_name(scene(mechanism.home))
    tip, start = ends(items["tool/z/head"])[1], ends(items["tool/z/shaft"])[0]
    return float(np.linalg.norm(tip - start)) / 0.15


def test_labels_keep_their_width():
    assert radius_label(2.34349, "m/s") == "2.343 m/s"
    assert radius_label(2.0, "m/s") == "2.000 m/s"
    assert radius_label(1000.0, "N") == "1000 N"
    assert radius_label(np.inf, "N") == "∞ N"


def test_an_unbounded_force_is_clipped_and_marked():
    mechanism = loaded("four_bar")
    size = items_size(mechanism)
    items = by_name(scene(mechanism.home, SceneOptions(force=True)))
    surface = items["ellipsoids/force/surface"].transform[:3, :3]
    np.testing.assert_allclose(
        np.linalg.svd(surface)[1], size * np.array([LIMIT, LIMIT, 0.35]), rtol=1e-9
    )
    texts = [items[f"ellipsoids/force/axis{n}/label"].shape.text for n in (1, 2, 3)]
    assert texts[:2] == ["∞ N, cut", "∞ N, cut"]
    along = items["ellipsoids/force/axis3/head"].transform[:3, 2]
    velocity = mechanism.home.jacobian().Jv_eq[:, 0]
    np.testing.assert_allclose(np.cross(along, velocity), 0, atol=1e-9)


def test_where_no_equivalent_jacobian_exists_there_is_no_ellipsoid(limit):
    singular, _ = limit
    forbidden = mechanisms.over_actuated_four_bar().home
    felt = mechanisms.rssr(tool="rod_side").home
    for configuration in (singular, forbidden, felt):
        for name, item in by_name(scene(configuration, EVERYTHING)).items():
            if name.startswith("ellipsoids/"):
                assert not item.visible
                assert item.shape in (Sphere(), Cylinder(), Cone(), Text(""))


# Singularities.


def coupler_turn(configuration):
    """The velocities of the coupler's middle and end with the crank locked: about its pin B."""
    theta = configuration.actuated[0]
    pin_b = 3.0 * np.array([np.cos(theta), np.sin(theta), 0])
    middle = configuration.tool_pose().translation
    across = np.cross([0, 0, 1], middle - pin_b)
    return middle, across / np.linalg.norm(across)


def test_free_motion_arrows_show_the_hand_computed_direction(limit):
    size = items_size(limit[0].mechanism)
    for configuration in limit:
        assert configuration.singularity().smallest < ALMOST_SINGULAR
        items = by_name(scene(configuration))
        middle, across = coupler_turn(configuration)
        first, last = ends(items["free/tool/forth"])[1], ends(items["free/tool/back"])[1]
        np.testing.assert_allclose(0.5 * (first + last), middle, atol=1e-9)
        direction = (first - last) / np.linalg.norm(first - last)
        np.testing.assert_allclose(np.abs(direction @ across), 1.0, atol=1e-6)
        # The coupler's end is twice as far from its pin: the fastest point there is.
        tip = ends(items["free/loops/1/first/forth"])[1]
        anchor = items["loops/1/first"].transform[:3, 3]
        assert np.linalg.norm(tip - anchor) == pytest.approx(0.3 * size)
        assert np.linalg.norm(first - middle) == pytest.approx(0.15 * size, rel=1e-6)
        # With the crank locked its pin stays.
        assert not items["free/joints/phi2/shaft"].visible


def test_at_regular_poses_nothing_comes_free(mechanism):
    assert mechanism.home.singularity().smallest > ALMOST_SINGULAR
    for item in scene(mechanism.home).items:
        assert not (item.name.startswith("free/") and item.visible)


def test_the_free_motion_satisfies_the_loops(limit):
    """The arrow at the cut, drawn with the coupler, is across the rocker too."""
    configuration = limit[0]
    items = by_name(scene(configuration))
    along = items["free/loops/1/first/forth"].transform[:3, 2]
    rocker = items["loops/1/first"].transform[:3, 3] - [4.0, 0, 0]
    assert abs(along @ rocker) < 1e-4 * np.linalg.norm(along) * 2.0


def test_an_idle_rod_hides_no_free_motion():
    """The rod's spin is free at every pose and moves no point; the crank comes free here."""
    rssr = mechanisms.rssr()
    mechanism = pj.Mechanism.from_pinocchio(
        rssr.model, rssr.spec.loops, ["psi"], "rocker_tip", home=rssr.home.q
    )
    with pytest.raises(pj.ClosureError) as caught:
        mechanism.close([3.0])
    configuration = caught.value.reached
    assert configuration.singularity().free_motions.shape == (4, 1)
    items = by_name(scene(configuration))
    visible = [name for name in items if name.startswith("free/") and items[name].visible]
    # The crank's tip is where all three turns of the rod meet: one arrow, not three.
    assert visible == [f"free/joints/rx/{end}" for end in ("shaft", "forth", "back")]
    theta = configuration.joint_values["theta"]
    along = items["free/joints/rx/forth"].transform[:3, 2]
    along = along / np.linalg.norm(along)
    np.testing.assert_allclose(abs(along @ [-np.sin(theta), np.cos(theta), 0]), 1.0, atol=1e-9)


def drawn_corners(item):
    """Return the corners of an item's triangles, in the world."""
    unit = np.frombuffer(item.shape.corners, "<f4").reshape(-1, 3).astype(float)
    return unit @ item.transform[:3, :3].T + item.transform[:3, 3]


@pytest.mark.parametrize("name", ["three_rps", "stewart_gough", "five_bar", "ur5", "sarrus"])
def test_polytopes_are_those_of_the_limits_about_the_tool(name):
    """By supports: along every direction as far as Σ |uᵀ Jᵢ| limitᵢ, times one scale."""
    mechanism = loaded(name)
    there = mechanism.close(mechanism.home.actuated + 0.03, enforce_limits=False)
    items, block = by_name(scene(there, EVERYTHING)), there.jacobian().Jv_eq
    tool, limits = there.tool_pose().translation, stated_rate_limits(mechanism.problem.partition)
    faces = items["polytopes/velocity/faces"]
    edges, label = items["polytopes/velocity/edges"], items["polytopes/velocity/label"]
    assert edges.visible
    assert faces.visible == (np.linalg.matrix_rank(block, tol=1e-9) > 1)
    ways = np.random.default_rng(3).normal(size=(30, 3))
    reach = np.abs(ways @ block) @ limits
    if faces.visible:
        scales = ((drawn_corners(faces) - tool) @ ways.T).max(axis=0) / reach
        np.testing.assert_allclose(scales, scales[0], rtol=1e-5)
    else:  # a segment along the one direction of motion
        arms = drawn_corners(edges) - tool
        arm = arms[np.linalg.norm(arms, axis=1).argmax()]
        along = np.abs(arm @ block).max() / np.linalg.norm(block, axis=0).max()
        assert along == pytest.approx(np.linalg.norm(arm), rel=1e-3)
    # The number at the farthest corner, by all combinations of motors at their limits.
    signs = np.array(list(itertools.product((-1.0, 1.0), repeat=limits.size)))
    farthest = np.linalg.norm(signs * limits @ block.T, axis=1).max()
    assert label.shape.text.split()[0] == f"{farthest:#.4g}".rstrip(".")


def test_faces_of_a_polytope_look_outwards():
    mechanism = loaded("three_rps")
    there = mechanism.close([1.1, 1.0, 0.9])
    for kind in ("velocity", "force"):
        shape = by_name(scene(there, EVERYTHING))[f"polytopes/{kind}/faces"].shape
        corners, normals = (
            np.frombuffer(each, "<f4").reshape(-1, 3, 3) for each in (shape.corners, shape.normals)
        )
        assert (np.einsum("tij,tij->ti", corners, normals) > 0.0).all()
        np.testing.assert_allclose(np.linalg.norm(normals, axis=2), 1.0, atol=1e-5)
        np.testing.assert_allclose(np.abs(corners).max(axis=(0, 1)), shape.half_extents, rtol=1e-6)


def test_the_load_is_an_arrow_at_the_tool_along_it():
    mechanism, maker = loaded("three_rps"), SceneMaker(loaded("three_rps"))
    force = np.array([3.0, -4.0, 12.0])
    items = by_name(maker.scene(mechanism.home, force=force))
    tool = mechanism.home.tool_pose().translation
    shaft, head = items["load/shaft"].transform, items["load/head"].transform
    np.testing.assert_allclose(
        shaft[:3, 2] / np.linalg.norm(shaft[:3, 2]), force / 13.0, atol=1e-12
    )
    np.testing.assert_allclose(shaft[:3, 3] - 0.5 * shaft[:3, 2], tool, atol=1e-12)
    np.testing.assert_allclose(
        head[:3, 3] - 0.5 * head[:3, 2], shaft[:3, 3] + 0.5 * shaft[:3, 2], atol=1e-12
    )
    assert items["load/label"].shape.text == "13.00 N"
    assert not by_name(maker.scene(mechanism.home))["load/shaft"].visible
