"""The characteristic length and the place of a machine; gears and screws named from either side."""

from __future__ import annotations

import math

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
import transformed
from random_machines import Tree, at

import pmjac_pin as pj

SPHERICAL = (0.5, 1.2, 0.9, 1.3)  # rad: crank, coupler, rocker and ground of a linkage that closes


def about_x(angle):
    return pin.SE3(pin.exp3(np.array([angle, 0.0, 0.0])), np.zeros(3))


def spherical_four_bar(offset, tool_at=0.0, **options):
    """All joint origins at its centre but for what an exporter rounds."""
    crank, coupler, rocker, ground = SPHERICAL
    model, step = pin.Model(), np.array([0.0, 0.0, offset])
    wide = np.full(1, 1e9)

    def hinge(parent, name, angle):
        place = pin.SE3(about_x(angle).rotation, step)
        return model.addJoint(parent, pin.JointModelRZ(), place, name, wide, wide, -wide, wide)

    a = hinge(0, "a", 0.0)
    b = hinge(a, "b", crank)
    d = hinge(0, "d", ground)
    for body, name, angle in ((b, "one", coupler), (d, "other", rocker)):
        place = pin.SE3(about_x(angle).rotation, step)
        model.addFrame(pin.Frame(name, body, place, pin.FrameType.OP_FRAME), False)
    tip = pin.SE3(np.eye(3), np.array([tool_at, 0.0, 0.0]))
    model.addFrame(pin.Frame("tool", b, tip, pin.FrameType.OP_FRAME), False)
    loops = [pj.RevoluteLoop(frames=("one", "other"))]
    return pj.Mechanism.from_pinocchio(model, loops, ["a"], "tool", **options)


def misfit_of_the_cut_hinge(configuration):
    """The angle in rad between the hinge's axis seen from both of its bodies, by hand."""
    q = configuration.joint_values
    crank, coupler, rocker, ground = SPHERICAL

    def turn(axis, angle):
        return pin.exp3(np.eye(3)[axis] * angle)

    one = turn(2, q["a"]) @ turn(0, crank) @ turn(2, q["b"]) @ turn(0, coupler)
    other = turn(0, ground) @ turn(2, q["d"]) @ turn(0, rocker)
    return math.atan2(np.linalg.norm(np.cross(one[:, 2], other[:, 2])), one[:, 2] @ other[:, 2])


@pytest.mark.parametrize("offset", [0.0, 1e-17, 1e-15, 1e-13])
@pytest.mark.parametrize("tool_at", [0.0, 0.3])
def test_a_spherical_linkage_has_no_length_of_its_own(offset, tool_at):
    mechanism = spherical_four_bar(offset, tool_at)
    assert mechanism.characteristic_length <= (tool_at or 1.0) * (1 + 1e-9)
    assert mechanism.characteristic_length >= 0.5 * (tool_at or 1.0)
    assert mechanism.mobility == 1
    for step in (0.3, 0.8, -0.5):
        pose = mechanism.close(mechanism.home.actuated + step)
        assert pose.singularity().kind == "regular"
        assert misfit_of_the_cut_hinge(pose) < 1e-11


@pytest.mark.parametrize("offset", [1e-10, 1e-9, 1e-7])
def test_offsets_beyond_the_tolerance_are_said_and_taken_with_one(offset):
    with pytest.raises(pj.ClosureError, match="or a `tolerance` of 1e-"):
        spherical_four_bar(offset, tool_at=0.3)
    mechanism = spherical_four_bar(offset, tool_at=0.3, tolerance=10.0 * offset)
    assert mechanism.mobility == 1
    pose = mechanism.close(mechanism.home.actuated + 0.8)
    assert misfit_of_the_cut_hinge(pose) < 20.0 * offset


def test_the_length_is_that_of_the_arms():
    """Four-bar, cut between coupler and rocker: arms of the two hinges' frames at home, by hand."""
    mechanism = pj.load("four_bar")
    angle = mechanism.home.joint_values["phi1"]
    l0, l2, l3 = (mechanism.parameters[name] for name in ("l0", "l2", "l3"))
    tip = np.array([l0 + l3 * math.cos(angle), l3 * math.sin(angle)])
    arms = np.array([np.linalg.norm(tip), l2, l3])
    assert mechanism.characteristic_length == pytest.approx(arms @ arms / arms.sum(), rel=1e-9)


@pytest.mark.parametrize("name", ["slider_crank", "three_rps", "bricard", "ankle"])
def test_far_from_the_origin_poses_and_models_stand_where_they_were_put(name):
    place = pin.SE3(pin.exp3(np.array([0.1, 0.2, -0.3])), np.array([5e5, 4.6e6, 100.0]))
    here = pj.load(name)
    there = transformed.moved(here, place)
    expected = place * here.home.tool_pose()
    np.testing.assert_allclose(there.home.tool_pose().homogeneous, expected.homogeneous, atol=2e-9)
    joint = int(np.flatnonzero(np.array(list(there.model.parents)) == 0)[1])
    assert there.model.jointPlacements[joint] == place * here.model.jointPlacements[joint]
    world, aligned = (there.home.jacobian(frame).J_eq for frame in ("WORLD", "LOCAL_WORLD_ALIGNED"))
    v = aligned[:3] + np.cross(expected.translation, aligned[3:].T).T
    np.testing.assert_allclose(world[:3], v, atol=1e-8 * (1.0 + np.abs(v).max()))
    assert there.tolerance == pytest.approx(16 * 2.0**-52 * 4.6e6, rel=0.1)
    import pickle

    again = pickle.loads(pickle.dumps(there))
    assert again == there
    np.testing.assert_array_equal(again.home.q, there.home.q)


def test_a_mechanism_makes_one_scratch_data(monkeypatch):
    """Of a large model it takes longer than all else; standing elsewhere, it needs no second."""
    place = pin.SE3(np.eye(3), np.array([5e5, 0.0, 0.0]))
    far = transformed.moved(pj.load("three_rps"), place)
    made, create = [], pin.Model.createData

    def counted(model):
        made.append(model.nv)
        return create(model)

    monkeypatch.setattr(pin.Model, "createData", counted)
    for there in (place.inverse(), pin.SE3.Identity()):
        transformed.moved(far, there)
    assert made == [far.nv, far.nv]


def geared_four_bar(ratio, forward, passive_motor=False):
    """A four-bar whose crank a motor turns through a reduction, named from either joint."""
    tree, (l0, l1, l2, l3), theta = Tree(), (4.0, 1.0, 3.0, 2.5), 0.9
    corner = np.array([l1 * math.cos(theta), l1 * math.sin(theta), 0.0])
    x, y = l0 - corner[0], -corner[1]
    reach = math.hypot(x, y)
    elbow = math.acos((l2**2 + reach**2 - l3**2) / (2 * l2 * reach))
    angle = math.atan2(y, x) + elbow
    tip = corner + l2 * np.array([math.cos(angle), math.sin(angle), 0.0])
    tree.joint(0, "motor", at([0, 0, 0]))
    crank = tree.joint(0, "crank", at([0, 0, 0]))
    coupler = tree.joint(crank, "coupler", at(corner))
    rocker = tree.joint(0, "rocker", at([l0, 0, 0]))
    tree.frame(coupler, "one", at(tip))
    tree.frame(rocker, "other", at(tip))
    gear = (
        pj.JointLoop(joints=("motor", "crank"), ratio=1 / ratio)
        if forward
        else pj.JointLoop(joints=("crank", "motor"), ratio=ratio)
    )
    loops = [pj.PointLoop(frames=("one", "other")), gear]
    motor = "crank" if passive_motor else "motor"
    return pj.Mechanism.from_pinocchio(tree.model, loops, [motor], "one")


@pytest.mark.parametrize("ratio", [1e-3, 100.0, 6283.0, 628319.0, 2e6, 1e9])
@pytest.mark.parametrize("passive_motor", [False, True])
def test_a_gear_is_the_same_from_either_side(ratio, passive_motor):
    first, second = (geared_four_bar(ratio, side, passive_motor) for side in (True, False))
    expected = np.array([-0.32845212, -0.11496099])  # d tip / d crank, by the closed formula
    for mechanism in (first, second):
        assert mechanism.mobility == 1
        found = mechanism.home.singularity()
        assert (found.kind, found.idle) == ("regular", 0)
        per_crank = 1.0 if passive_motor else ratio
        J_eq = mechanism.home.jacobian().Jv_eq[:2, 0] * per_crank
        np.testing.assert_allclose(J_eq, expected, atol=1e-7)
    smallest = [mechanism.home.singularity().smallest for mechanism in (first, second)]
    assert smallest[0] == pytest.approx(smallest[1], rel=1e-6)
    assert smallest[0] > 0.1


@pytest.mark.parametrize("size", [1.0, 3.0])
@pytest.mark.parametrize("forward", [True, False])
def test_a_fine_screw_closes_from_either_side(size, forward):
    """A screw of 1 mm pitch lifts a slide on which a rod hangs a crank: 40 regular targets."""
    tree, turns = Tree(), 2 * math.pi / 0.001
    upright = pin.SE3(pin.exp3(np.array([-math.pi / 2, 0, 0])), np.zeros(3))
    tree.joint(0, "motor", at([0, 0, 0]))
    slide = tree.joint(0, "slide", upright, "prismatic")
    crank = tree.joint(0, "crank", at([3 * size, 0, 0]))
    tree.frame(slide, "one", at([0, 0, 0]))
    tree.frame(crank, "other", at([2 * size, 0, 0]))
    screw = (
        pj.JointLoop(joints=("motor", "slide"), ratio=1 / turns)
        if forward
        else pj.JointLoop(joints=("slide", "motor"), ratio=turns)
    )
    loops = [pj.DistanceLoop(frames=("one", "other"), length=2.1 * size), screw]
    home = {"motor": turns * 0.3 * size, "slide": 0.3 * size, "crank": 0.2}
    mechanism = pj.Mechanism.from_pinocchio(tree.model, loops, ["motor"], "other", home=home)
    rng = np.random.default_rng(0)
    for _ in range(40):
        share = rng.uniform(0.3, 0.5)
        pose = mechanism.close([turns * size * share])
        assert pose.joint_values["slide"] == pytest.approx(size * share, abs=1e-9)


@pytest.mark.parametrize("far", [0.3, 1e6])
def test_of_an_open_chain_no_loop_is_said_to_close(far):
    """A short lever beside the origin, or a machine on a map: nothing rests on a gap."""
    joints = [
        ("a", "revolute", "ground", "arm", (far, 0, 0), (0, 0, 1)),
        ("f", "fixed", "arm", "hand", (1e-4 if far < 1.0 else 0.5, 0, 0)),
    ]
    chain = mechanisms.build(joints, [], ["a"], "hand", {})
    assert chain.place.any()
    assert not any(finding.code == "far-from-origin" for finding in pj.check(chain).findings)


def test_check_and_pictures_of_a_machine_far_away():
    import transformed

    from pmjac_pin.viewer.scene import SceneMaker

    here = pj.load("three_rps")
    there = transformed.moved(here, pin.SE3(np.eye(3), np.array([0.0, 5e6, 0.0])))
    (note,) = [finding for finding in pj.check(there).findings if finding.code == "far-from-origin"]
    assert "closed up to 1.78e-08 m" in note.message
    assert not any(finding.code == "far-from-origin" for finding in pj.check(here).findings)
    np.testing.assert_allclose(there.place, [0.0, 5e6, 0.0], atol=3.0)
    drawn = SceneMaker(there).scene(there.home).items
    assert max(np.abs(item.transform[:3, 3]).max() for item in drawn) < 10.0


def test_a_tolerance_as_large_as_the_machine_is_refused():
    with pytest.raises(pj.PmjacError, match=r"a tolerance of 0\.01 m leaves nothing of a machine"):
        pj.load("ankle", tolerance=1e-2)


@pytest.mark.parametrize("carrier_first", [True, False])
def test_a_gear_train_in_no_loop_is_measured_by_what_moves_the_tool(carrier_first):
    """A slow carrier and a planet on it, driven a thousand times faster and slower."""
    tree = Tree()

    def carrier():
        body = tree.joint(0, "carrier", at([0, 0, 0]))
        return tree.joint(body, "planet", at([1, 0, 0]))

    planet = carrier() if carrier_first else 0
    tree.joint(0, "motor", at([0, 0, 1]))
    tree.joint(0, "sun", at([0, 0, 1]))
    planet = planet or carrier()
    tree.frame(planet, "tool", at([1.3, 0.2, 0]))
    loops = [
        pj.JointLoop(joints=("motor", "carrier"), ratio=1e-3),
        pj.JointLoop(joints=("sun", "planet"), ratio=-1e3),
    ]
    mechanism = pj.Mechanism.from_pinocchio(tree.model, loops, ["motor", "sun"], "tool")
    found = mechanism.home.singularity()
    assert (found.tool_rank, found.linear_rank, found.angular_rank) == (2, 2, 1)
    assert mechanism.home.jacobian().tool_ranks == (2, 2, 1)
