"""Loops much smaller than the machine that they are in: all is as if they were as large."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin
import pytest
from random_machines import Tree, at

import pmjac_pin as pj

LINKS = (4.0, 1.0, 3.0, 2.5)
ANGLE = 0.9
SIZES = [1e-3, 3e-6]


def corner_and_tip():
    l0, l1, l2, l3 = LINKS
    corner = l1 * np.array([math.cos(ANGLE), math.sin(ANGLE), 0.0])
    x, y = l0 - corner[0], -corner[1]
    reach = math.hypot(x, y)
    turn = math.atan2(y, x) + math.acos((l2**2 + reach**2 - l3**2) / (2 * l2 * reach))
    return corner, corner + l2 * np.array([math.cos(turn), math.sin(turn), 0.0])


def add_four_bar(tree, prefix, place, size, crank=None):
    """Add a four-bar of this size; return the bodies of its crank, coupler and rocker."""
    corner, tip = corner_and_tip()
    a = crank or tree.joint(0, f"{prefix}a", at(place))
    b = tree.joint(a, f"{prefix}b", at(place + size * corner))
    d = tree.joint(0, f"{prefix}d", at(place + size * np.array([LINKS[0], 0.0, 0.0])))
    for end, body in ((0, b), (1, d)):
        tree.frame(body, f"{prefix}{end}", at(place + size * tip))
    return a, b, d


def mechanism(tree, actuated):
    loops = [pj.PointLoop(frames=(f"{prefix}0", f"{prefix}1")) for prefix in ("large", "small")]
    return pj.Mechanism.from_pinocchio(tree.model, loops, actuated, "tool")


def side_by_side(size, motor="a"):
    """Two four-bars that have nothing to do with each other; the tool is on the small one."""
    tree, place = Tree(), np.array([1.0, 0.4, 0.0])
    add_four_bar(tree, "large", np.zeros(3), 1.0)
    _, coupler, _ = add_four_bar(tree, "small", place, size)
    tree.frame(coupler, "tool", at(place + size * corner_and_tip()[1]))
    return mechanism(tree, [f"large{motor}", f"small{motor}"])


def one_drives_the_other(size):
    """The small one's rocker is the crank of the large one, whose coupler carries the tool."""
    tree, place = Tree(), np.array([1.0, 0.4, 0.0])
    *_, rocker = add_four_bar(tree, "small", place, size)
    pivot = place + size * np.array([LINKS[0], 0.0, 0.0])
    _, coupler, _ = add_four_bar(tree, "large", pivot, 1.0, crank=rocker)
    tree.frame(coupler, "tool", at(pivot + corner_and_tip()[1]))
    return mechanism(tree, ["smalla"])


@pytest.mark.slow
@pytest.mark.parametrize("size", SIZES)
def test_a_small_loop_beside_a_large_one(size):
    alike, small = side_by_side(1.0), side_by_side(size)
    assert small.mobility == alike.mobility == 2
    target = alike.home.actuated + np.array([0.2, -0.3])
    expected, found = (m.close(target) for m in (alike, small))
    assert found.singularity().kind == "regular"
    np.testing.assert_allclose(found.q, expected.q, atol=1e-9)
    unit = np.repeat([[size], [1.0]], 3, axis=0)
    np.testing.assert_allclose(
        found.jacobian().J_eq / unit, expected.jacobian().J_eq, atol=1e-8, rtol=0
    )
    assert len(pj.assembly_modes(small, target, rng=0)) == 4


@pytest.mark.parametrize("size", SIZES)
def test_a_small_loop_that_drives_a_large_one(size):
    alike, small = one_drives_the_other(1.0), one_drives_the_other(size)
    assert small.mobility == alike.mobility == 1
    target = alike.home.actuated + 0.2
    expected, found = (m.close(target) for m in (alike, small))
    assert found.singularity().kind == "regular"
    np.testing.assert_allclose(found.q, expected.q, atol=1e-9)
    np.testing.assert_allclose(found.jacobian().J_eq, expected.jacobian().J_eq, atol=1e-8, rtol=0)


@pytest.mark.parametrize("size", SIZES)
def test_a_small_loop_stops_where_a_large_one_does(size):
    """The rocker as motor, until crank and coupler are in line."""
    stops = []
    for machine in (side_by_side(1.0, "d"), side_by_side(size, "d")):
        with pytest.raises(pj.ClosureError) as caught:
            machine.close(machine.home.actuated + np.array([0.0, 2.0]))
        stops.append(caught.value.reached.actuated)
    np.testing.assert_allclose(*stops, atol=1e-4)


@pytest.mark.parametrize(
    ("size", "code"), [(1e-4, "small-loop"), (1e-8, "loop-without-size"), (1.0, None)]
)
def test_check_says_by_what_a_loop_is_measured(size, code):
    findings = pj.check(one_drives_the_other(size)).findings
    codes = {finding.code for finding in findings} & {"small-loop", "loop-without-size"}
    assert codes == ({code} if code else set())


# --- slides that a small loop shares with a large one --------------------------------------------

ANY = np.full(1, 1e9)


def planar(joints):
    """A model of named joints on the ground, turning about z or sliding along x."""
    model = pin.Model()
    for name, kind, x, y in joints:
        place = pin.SE3(np.eye(3), np.array([x, y, 0.0]))
        model.addJointFrame(model.addJoint(0, kind(), place, name, ANY, ANY, -ANY, ANY))
    return model


def eccentric(radius, motor):
    """A crank of this radius with a rod of thrice moves a slide; that turns a lever of 1 m."""
    model = planar(
        [
            ("crank", pin.JointModelRZ, 0.0, 0.0),
            ("slide", pin.JointModelPX, 0.0, 0.0),
            ("lever", pin.JointModelRZ, 0.3, -0.8),
        ]
    )
    for name, joint, arm in (("pin", 1, radius), ("end", 3, 1.0)):
        place = pin.SE3(np.eye(3), np.array([arm, 0.0, 0.0]))
        model.addFrame(pin.Frame(name, joint, place, pin.FrameType.OP_FRAME), False)
    turn = 0.7
    x = radius * (math.cos(turn) + math.sqrt(9.0 - math.sin(turn) ** 2))
    reach = math.hypot(x - 0.3, 0.8)
    lever = math.atan2(0.8, x - 0.3) + math.acos(reach / 2.0)
    loops = [
        pj.DistanceLoop(frames=("pin", "slide"), length=3.0 * radius),
        pj.DistanceLoop(frames=("end", "slide"), length=1.0),
    ]
    home = {"crank": turn, "slide": x, "lever": lever}
    rate = -radius * math.sin(turn) * (1.0 + math.cos(turn) / math.sqrt(9.0 - math.sin(turn) ** 2))
    machine = pj.Mechanism.from_pinocchio(model, loops, [motor], "end", home=home)
    return machine, rate, x, lever


@pytest.mark.parametrize("motor", ["crank", "lever"])
@pytest.mark.parametrize("radius", [0.3, 0.02, 3e-3, 3e-4, 2e-5])
def test_an_eccentric_of_any_size_moves_a_slide(radius, motor):
    machine, rate, x, lever = eccentric(radius, motor)
    home = machine.home
    assert (machine.mobility, home.singularity().kind) == (1, "regular")
    # By hand: the slide by the crank, and the lever's end (u, v) at 1 m from the slide.
    u, v = 0.3 + math.cos(lever) - x, -0.8 + math.sin(lever)
    turned = rate * u / (v * math.cos(lever) - u * math.sin(lever))
    expected = np.array([1.0, rate, turned]) / (1.0 if motor == "crank" else turned)
    np.testing.assert_allclose(home.jacobian().motion_map[:, 0], expected, rtol=1e-6)
    modes = pj.assembly_modes(machine, home.actuated, rng=0)
    assert len(modes) == (2 if motor == "lever" and radius < 0.3 else 4)
    assert any(np.allclose(mode.q, home.q, atol=1e-6) for mode in modes)
    assert machine.close(home.actuated + 1e-2 * radius).residual_norm <= machine.tolerance


@pytest.mark.parametrize("rod", [0.3, 0.03, 0.009, 1e-3, 1e-4])
def test_a_rod_between_two_slides_may_have_any_length(rod):
    """How it is inclined is all that matters: no singular value depends on its length."""
    model = planar(
        [
            ("crank", pin.JointModelRZ, 0.0, 0.0),
            ("near", pin.JointModelPX, 0.0, 0.0),
            ("far", pin.JointModelPX, 0.0, rod / 2.0),
        ]
    )
    place = pin.SE3(np.eye(3), np.array([0.3, 0.0, 0.0]))
    model.addFrame(pin.Frame("pin", 1, place, pin.FrameType.OP_FRAME), False)
    x = 0.3 * math.cos(0.7) + math.sqrt(1.0 - (0.3 * math.sin(0.7)) ** 2)
    loops = [
        pj.DistanceLoop(frames=("pin", "near"), length=1.0),
        pj.DistanceLoop(frames=("near", "far"), length=rod),
    ]
    home = {"crank": 0.7, "near": x, "far": x + rod * math.sqrt(0.75)}
    machine = pj.Mechanism.from_pinocchio(model, loops, ["crank"], "far", home=home)
    singularity = machine.home.singularity()
    assert (machine.mobility, singularity.kind) == (1, "regular")
    assert singularity.smallest == pytest.approx(0.368, abs=0.01)
    rate = -0.3 * math.sin(0.7) * (1.0 + 0.3 * math.cos(0.7) / (x - 0.3 * math.cos(0.7)))
    jacobian = machine.home.jacobian()
    assert jacobian.J_eq[0, 0] == pytest.approx(rate, rel=1e-9)
    assert jacobian.error_estimate.max() < 1e-9
    assert len(pj.assembly_modes(machine, [0.7], rng=0)) == 4


@pytest.mark.parametrize("rod", [1e-4, 0.1, 1e2, 1e5])
def test_two_slides_and_a_rod_in_any_unit_of_length(rod):
    model = planar([("x", pin.JointModelPX, 0.0, 0.0), ("y", pin.JointModelPY, 0.0, 0.0)])
    loops = [pj.DistanceLoop(frames=("x", "y"), length=rod)]
    home = {"x": 0.6 * rod, "y": 0.8 * rod}
    machine = pj.Mechanism.from_pinocchio(model, loops, ["x"], "y", home=home)
    assert (machine.mobility, machine.home.singularity().kind) == (1, "regular")
    assert machine.home.jacobian().J_eq[1, 0] == pytest.approx(-0.75, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_a_mode_is_told_once_however_a_small_loop_widens_the_tolerance(seed):
    """A crank of 3 µm and one of 0.5 m pull one slide; the large one is the motor."""
    small = 1e-5
    model = pin.Model()
    ground = [
        ("turn", 0, pin.JointModelRZ(), (0.0, 0.0)),
        ("slide", 0, pin.JointModelPX(), (0.0, 0.0)),
        ("crank", 0, pin.JointModelRZ(), (-1.2, 0.2)),
    ]
    for name, parent, kind, (x, y) in ground:
        place = pin.SE3(np.eye(3), np.array([x, y, 0.0]))
        model.addJointFrame(model.addJoint(parent, kind, place, name, ANY, ANY, -ANY, ANY))
    frames = (("pin", 1, 0.3 * small, 0.0), ("end", 3, 0.5, 0.0), ("eye", 2, 0.0, 0.1))
    for name, joint, x, y in frames:
        place = pin.SE3(np.eye(3), np.array([x, y, 0.0]))
        model.addFrame(pin.Frame(name, joint, place, pin.FrameType.OP_FRAME), False)
    s = small * (0.3 * math.cos(0.7) + math.sqrt(1.0 - (0.3 * math.sin(0.7)) ** 2))
    reach = math.hypot(s + 1.2, -0.1)
    crank = math.atan2(-0.1, s + 1.2) + math.acos((0.25 + reach**2 - 1.0) / reach)
    loops = [
        pj.DistanceLoop(frames=("pin", "slide"), length=small),
        pj.DistanceLoop(frames=("end", "eye"), length=1.0),
    ]
    home = {"turn": 0.7, "slide": s, "crank": crank}
    machine = pj.Mechanism.from_pinocchio(model, loops, ["crank"], "end", home=home)
    modes = pj.assembly_modes(machine, machine.home.actuated, rng=seed, proof=False)
    assert sorted(round(mode.joint_values["turn"], 4) for mode in modes) == [-0.7, 0.7]
    assert modes.evidence.kind == "statistics"  # what does not end is not open by rounding


@pytest.mark.parametrize("radius", [0.3, 3e-2, 3e-3, 3e-4, 3e-5, 3e-6])
def test_the_tool_rests_at_the_dead_centre_and_nowhere_else(radius):
    """However small the crank is beside the lever that carries the tool."""
    machine = eccentric(radius, "crank")[0]
    kinds = []
    for away in (1.0, 0.1, 1e-2, 1e-3, 1e-4, 1e-8):
        found = machine.close([math.pi - away]).singularity()
        kinds.append((found.kind, found.tool_rank, found.generic_tool_rank))
    assert kinds == [("regular", 1, 1)] * 5 + [("loss", 0, 1)]


@pytest.mark.parametrize("ratio", [1.0, 1e-3, 1e-5])
def test_a_motor_that_moves_the_tool_little_is_lost_where_it_moves_it_not(ratio):
    """Two motors: the large arm and, by a crank of this size, a slide on it carry the tool."""
    model = planar([("arm", pin.JointModelRZ, 0.0, 0.0)])
    for parent, name, kind in ((1, "crank", pin.JointModelRZ()), (1, "slide", pin.JointModelPX())):
        model.addJointFrame(model.addJoint(parent, kind, pin.SE3.Identity(), name))
    place = pin.SE3(np.eye(3), np.array([0.3 * ratio, 0.0, 0.0]))
    model.addFrame(pin.Frame("pin", 2, place, pin.FrameType.OP_FRAME), False)
    place = pin.SE3(np.eye(3), np.array([1.0, 0.0, 0.0]))
    model.addFrame(pin.Frame("tip", 3, place, pin.FrameType.OP_FRAME), False)
    loops = [pj.DistanceLoop(frames=("pin", "slide"), length=ratio)]
    slide = ratio * (0.3 * math.cos(0.7) + math.sqrt(1.0 - (0.3 * math.sin(0.7)) ** 2))
    home = {"crank": 0.7, "slide": slide}
    machine = pj.Mechanism.from_pinocchio(model, loops, ["arm", "crank"], "tip", home=home)
    for away, kind, rank in ((1.0, "regular", 2), (1e-3, "regular", 2), (1e-8, "loss", 1)):
        found = machine.close([0.4, math.pi - away]).singularity()
        assert (found.kind, found.tool_rank, found.generic_tool_rank) == (kind, rank, 2)


@pytest.mark.parametrize("rod", [0.1, 1e-3, 1e-4, 1e-5])
def test_slides_alone_whose_rods_differ_in_length(rod):
    """x and y on a short rod, y and z on one of 1 m."""
    model = planar([("x", pin.JointModelPX, 0.0, 0.0), ("y", pin.JointModelPY, 0.0, 0.0)])
    model.addJointFrame(model.addJoint(0, pin.JointModelPZ(), pin.SE3.Identity(), "z"))
    loops = [
        pj.DistanceLoop(frames=("x", "y"), length=rod),
        pj.DistanceLoop(frames=("y", "z"), length=1.0),
    ]
    home = {"x": 0.6 * rod, "y": 0.8 * rod, "z": math.sqrt(1.0 - 0.64 * rod**2)}
    machine = pj.Mechanism.from_pinocchio(model, loops, ["x"], "z", home=home)
    found = machine.home.singularity()
    assert (machine.mobility, found.kind, found.tool_rank) == (1, "regular", 1)
    for share in (0.6, 0.9, 0.999):
        pose = machine.close([share * rod])
        rate = share * rod / math.sqrt(1.0 - (1.0 - share**2) * rod**2)
        assert pose.jacobian().J_eq[2, 0] == pytest.approx(rate, rel=1e-9)
    assert len(pj.assembly_modes(machine, machine.home.actuated, rng=0)) == 4


@pytest.mark.parametrize("radius", [0.3, 3e-3, 3e-5])
def test_an_error_beside_a_small_loop_is_what_its_own_rounding_does(radius):
    """Relative to J_eq, some 1e-15 over the loop's size, with a factor of at most a thousand."""
    machine, rate, x, lever = eccentric(radius, "crank")
    u, v = 0.3 + math.cos(lever) - x, -0.8 + math.sin(lever)
    expected = rate * u / (v * math.cos(lever) - u * math.sin(lever))
    jacobian = machine.home.jacobian()
    estimate = jacobian.error_estimate[5, 0]
    assert abs(jacobian.J_eq[5, 0] - expected) <= estimate + 1e-15 * abs(expected)
    assert estimate < 1e-12 / radius * abs(expected)


def lever_at(radius, turn):
    """Return the lever's angle of an eccentric, on the side that `eccentric` takes."""
    x = radius * (math.cos(turn) + math.sqrt(9.0 - math.sin(turn) ** 2))
    return math.atan2(0.8, x - 0.3) + math.acos(math.hypot(x - 0.3, 0.8) / 2.0)


@pytest.mark.parametrize("radius", [0.3, 0.1, 3e-3])
def test_a_target_just_before_a_fold_is_on_this_mode_or_not_told(radius):
    """Driven by its lever, the crank folds at 0: no pose before it is on another mode."""
    machine, refused = eccentric(radius, "lever")[0], 0
    for turn in (1e-2, 1e-3, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6):
        try:
            pose = machine.close([lever_at(radius, turn)])
        except pj.ClosureError as error:
            assert "not told apart" in str(error)
            refused += 1
        else:
            # A turn of the crank opens the loop by radius (1 − cos turn): the gap allows so much.
            crank, gap = pose.joint_values["crank"], pose.residual_norm + 1e-15
            assert crank > 0.0
            assert abs(crank**2 - turn**2) <= 2.0 * gap / radius
    assert refused < 7


def test_a_tool_that_counts_as_at_rest_is_told():
    tree = Tree()
    add_four_bar(tree, "large", np.zeros(3), 1.0)
    tree.frame(0, "tool", at([0.1, 0.2, 0.0]))
    loops = [pj.PointLoop(frames=("large0", "large1"))]
    machine = pj.Mechanism.from_pinocchio(tree.model, loops, ["largea"], "tool")
    [finding] = [one for one in pj.check(machine).findings if one.code == "tool-rests"]
    assert finding.severity == "warning"
    assert "counts as at rest" in finding.message


@pytest.mark.parametrize("rod", [0.3, 1e-2, 1e-3, 1e-4])
def test_a_structure_beside_slides_on_a_short_rod_is_one(rod):
    """A four-bar stretched taut, l0 = l1 + l2 + l3, whatever else is in the model."""
    model = pin.Model()
    for name, parent, kind, x in (
        ("x", 0, pin.JointModelPX(), 0.0),
        ("y", 0, pin.JointModelPY(), 0.0),
        ("crank", 0, pin.JointModelRZ(), 0.0),
        ("coupler", 3, pin.JointModelRZ(), 1.0),
        ("rocker", 0, pin.JointModelRZ(), 2.2),
    ):
        place = pin.SE3(np.eye(3), np.array([x, 0.0, 0.0]))
        model.addJointFrame(model.addJoint(parent, kind, place, name))
    for name, joint, x in (("tip", 4, 0.7), ("end", 5, -0.5)):
        place = pin.SE3(np.eye(3), np.array([x, 0.0, 0.0]))
        model.addFrame(pin.Frame(name, joint, place, pin.FrameType.OP_FRAME), False)
    loops = [
        pj.DistanceLoop(frames=("x", "y"), length=rod),
        pj.PointLoop(frames=("tip", "end")),
    ]
    home = {"x": 0.6 * rod, "y": 0.8 * rod}
    machine = pj.Mechanism.from_pinocchio(model, loops, ["x", "crank"], "tip", home=home)
    assert machine.mobility is None
    assert machine.home.singularity().kind == "isolated"
    with pytest.raises(pj.SingularError):
        machine.home.jacobian()
