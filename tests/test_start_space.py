"""Where random starts are drawn: all that limits, loops and gears let the passive joints be."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from math import pi

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
import transformed
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.model.frames import find_frame
from pmjac_pin.model.linkage import edges_of
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.modes.box_problem import box_problem, given_values
from pmjac_pin.studies.modes.closed_pose import open_by
from pmjac_pin.studies.modes.find import _without_open
from pmjac_pin.studies.modes.random_search import RandomSearch
from pmjac_pin.studies.modes.search_problem import search_problem
from pmjac_pin.studies.modes.slide_ranges import Polygons, slide_ranges
from pmjac_pin.studies.modes.starts import StartSpace

WIDE = np.full(1, 1e9)
SLIDING = (
    "planar_3rpr",
    "planar_3rrr",
    "slider_crank",
    "stewart_gough",
    "stewart_gough_dietmaier",
    "three_rps",
    "delta",
    "delta_rods",
)


def at(x=0.0, y=0.0):
    return pin.SE3(np.eye(3), np.array([x, y, 0.0]))


def machine(joints, frames, loops, actuated, tool, home, limits=WIDE):
    """Joints (name, model, parent, x, y) without frames of their own; frames (name, joint, x)."""
    model, ids = pin.Model(), {"world": 0}
    for name, kind, parent, x, y in joints:
        ids[name] = model.addJoint(ids[parent], kind, at(x, y), name, WIDE, WIDE, -limits, limits)
        model.addJointFrame(ids[name])
    for name, joint, x in frames:
        model.addFrame(pin.Frame(name, ids[joint], at(x), pin.FrameType.OP_FRAME), False)
    return pj.Mechanism.from_pinocchio(model, loops, actuated, tool, home=home)


def rack(theta):
    """A pinion turns a rack, x = 0.1 q, which a rod of length 1.5 joins to the motor's crank."""
    x = 0.5 * np.cos(theta) + np.sqrt(1.5**2 - (0.5 * np.sin(theta)) ** 2)
    return machine(
        [
            ("pinion", pin.JointModelRZ(), "world", 0, 0),
            ("rack", pin.JointModelPX(), "world", 1, 0),
            ("crank", pin.JointModelRZ(), "world", 0, 0),
        ],
        [("A", "crank", 0.5), ("B", "rack", 0)],
        [
            pj.DistanceLoop(frames=("A", "B"), length=1.5),
            pj.JointLoop(joints=("pinion", "rack"), ratio=0.1),
        ],
        ["crank"],
        "B",
        {"crank": theta, "rack": x - 1.0, "pinion": (x - 1.0) / 0.1},
    )


@pytest.mark.parametrize("theta", [1.2, 0.2])
def test_a_pinion_keeps_its_turns(theta):
    modes = pj.assembly_modes(rack(theta), [theta], rng=0)
    found = sorted(mode.tool_pose().translation[0] for mode in modes)
    root = np.sqrt(1.5**2 - (0.5 * np.sin(theta)) ** 2)
    np.testing.assert_allclose(found, 0.5 * np.cos(theta) + np.array([-root, root]), atol=1e-9)


def geared_cranks(ratio, turned=False, limits=WIDE):
    """The rocker of a four-bar drives a second shaft, `ratio` times as fast."""
    gear = pj.JointLoop(joints=("rocker", "shaft"), ratio=ratio, offset=0.3)
    if turned:
        gear = pj.JointLoop(joints=("shaft", "rocker"), ratio=1 / ratio, offset=-0.3 / ratio)
    return machine(
        [
            ("crank", pin.JointModelRZ(), "world", 0, 0),
            ("rocker", pin.JointModelRZ(), "world", 4, 0),
            ("shaft", pin.JointModelRZ(), "world", 4, 2),
        ],
        [("A", "crank", 1), ("B", "rocker", 3.5), ("end", "shaft", 1)],
        [pj.DistanceLoop(frames=("A", "B"), length=3.0), gear],
        ["crank"],
        "end",
        {"crank": 0.9, "rocker": 2.0, "shaft": 2.0 * ratio + 0.3},
        limits,
    )


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("ratio", [1.0, -2.0, 0.5, 1 / 3, -2 / 3])
def test_as_many_turns_as_make_a_difference(ratio, turned):
    """The shaft tells which of its turns the rocker is in: the ratio's denominator of them."""
    modes = pj.assembly_modes(geared_cranks(ratio, turned), [0.9], rng=0)
    assert len(modes) == 2 * Fraction(ratio).limit_denominator(9).denominator
    for mode in modes:
        error = mode.joint_values["shaft"] - ratio * mode.joint_values["rocker"] - 0.3
        assert abs(error) <= 1e-12


def test_limits_decide_which_turns_there_are():
    """Within ±2 turns, four of a third: two of the rocker's angles, each four times."""
    limited = geared_cranks(1 / 3, limits=np.full(1, 4 * pi))
    assert len(pj.assembly_modes(limited, [0.9], rng=0)) == 6
    narrow = geared_cranks(1 / 3, limits=np.full(1, pi))
    assert len(pj.assembly_modes(narrow, [0.9], rng=0)) == 2


def test_a_train_that_never_is_the_same_again_is_cut_off_and_says_so():
    modes = pj.assembly_modes(geared_cranks(np.sqrt(0.5)), [0.9], rng=0, most_starts=5000)
    assert len(modes) > 30
    bound = geared_cranks(np.sqrt(0.5))
    problem = search_problem(bound, bound.home.q)
    assert StartSpace.of(problem, True).cut_off.startswith("'rocker' between -60.")
    bounded = geared_cranks(np.sqrt(0.5), limits=np.full(1, 6.0))
    assert len(pj.assembly_modes(bounded, [0.9], rng=0)) == 4


def far_slide(kind=None):
    """A block on a rail, at the end of a rod that is far longer than its crank."""
    return machine(
        [
            ("crank", pin.JointModelRZ(), "world", 0, 0),
            ("rail", kind or pin.JointModelPX(), "world", 0, 0),
        ],
        [("A", "crank", 0.5), ("B", "rail", 0)],
        [pj.DistanceLoop(frames=("A", "B"), length=100.0)],
        ["crank"],
        "B",
        {"crank": 0.3, "rail": 100.0},
    )


@pytest.mark.parametrize("limits", [True, False])
def test_a_mode_far_along_a_slide_is_met(limits):
    mechanism = far_slide()
    modes = pj.assembly_modes(mechanism, [0.3], rng=0, limits=limits, proof=False)
    x = sorted(mode.joint_values["rail"] for mode in modes)
    root = np.sqrt(1e4 - (0.5 * np.sin(0.3)) ** 2)
    np.testing.assert_allclose(x, 0.5 * np.cos(0.3) + np.array([-root, root]), atol=1e-8)


@pytest.mark.parametrize("size", [0.01, 1.0, 100.0])
def test_parallel_slides_are_drawn_within_their_limits_where_there_are_some(size):
    """A geared pair, one on the other, goes far for little: both modes are within."""
    ratio, theta, shown = -1.0 / 0.98, 1.0, 0.02
    roots = 0.5 * np.cos(theta) + np.sqrt(2.25 - (0.5 * np.sin(theta)) ** 2) * np.array([-1, 1])
    b = size * roots / shown
    mechanism = machine(
        [
            ("crank", pin.JointModelRZ(), "world", 0, 0),
            ("a", pin.JointModelPX(), "world", 0, 0),
            ("b", pin.JointModelPX(), "a", 0, 0),
        ],
        [("A", "crank", 0.5 * size), ("B", "b", 0)],
        [
            pj.DistanceLoop(frames=("A", "B"), length=1.5 * size),
            pj.JointLoop(joints=("a", "b"), ratio=ratio),
        ],
        ["crank"],
        "B",
        {"crank": theta, "a": -0.98 * b[1], "b": b[1]},
        limits=np.full(1, 150.0 * size),
    )
    modes = pj.assembly_modes(mechanism, [theta], rng=0, proof=False)
    found = sorted(mode.joint_values["b"] for mode in modes)
    np.testing.assert_allclose(found, b, rtol=1e-6)
    assert "within" not in str(modes.evidence)


def test_two_slides_at_an_angle_are_a_place():
    """A gantry whose end is at the end of a rod."""
    mechanism = machine(
        [
            ("crank", pin.JointModelRZ(), "world", 0, 0),
            ("x", pin.JointModelPX(), "world", 3, 0),
            ("y", pin.JointModelPY(), "x", 0, 0),
        ],
        [("A", "crank", 1.0), ("B", "y", 0.0), ("C", "world", 0.5)],
        [
            pj.DistanceLoop(frames=("A", "B"), length=2.0),
            pj.DistanceLoop(frames=("C", "B"), length=2.5),
        ],
        ["crank"],
        "B",
        {"crank": 1.0, "x": -1.0, "y": 1.5},
    )
    problem = search_problem(mechanism, mechanism.home.q)
    for name, middle in (("x", 0.5 - 3.0), ("y", 0.0)):
        one = slide_ranges(problem, True)[name]
        assert one.cut_off is None
        assert middle - 2.5 - 1e-6 <= one.lower[0] <= one.upper[0] <= middle + 2.5 + 1e-6
    assert len(pj.assembly_modes(mechanism, [1.0], rng=0)) == 2


def test_parallel_slides_are_cut_off_and_say_so():
    mechanism = machine(
        [
            ("crank", pin.JointModelRZ(), "world", 0, 0),
            ("x", pin.JointModelPX(), "world", 3, 0),
            ("coupler", pin.JointModelRZ(), "x", 0, 0),
            ("y", pin.JointModelPX(), "coupler", 0, 0),
        ],
        [("A", "crank", 1.0), ("B", "y", 0.0), ("C", "y", 0.5), ("D", "crank", 0.5)],
        [pj.PointLoop(frames=("A", "B")), pj.DistanceLoop(frames=("D", "C"), length=0.7)],
        ["crank"],
        "B",
        {"crank": 1.0, "x": -1.0, "y": 1.5, "coupler": 2.8},
    )
    evidence = pj.assembly_modes(mechanism, [1.0], rng=0, proof=False, unseen=0.02).evidence
    assert "of the start space ('x' within" in str(evidence)
    assert "m of home, 'y' within" in str(evidence)


@pytest.mark.slow
@pytest.mark.parametrize("name", SLIDING)
def test_every_mode_is_in_the_start_space(name, rng):
    """Of the machine, and of the machine moved, which changes no range."""
    mechanism = loaded(name)
    legs = search_problem(mechanism, mechanism.home.q).legs
    for configuration in mechanisms.random_closed(mechanism, rng, 3):
        problem = search_problem(mechanism, configuration.q)
        ranges = slide_ranges(problem, False)
        row = problem.without_legs(configuration.q)
        assert legs or ranges.keys() == {
            edge.name for _, edge in problem.passive if edge.kind.along
        }
        for entries, edge in problem.passive:
            if edge.name in ranges:
                one = ranges[edge.name]
                values = row[entries][: one.lower.size]
                assert (one.lower - 1e-9 <= values).all()
                assert (values <= one.upper + 1e-9).all()
                assert one.cut_off is None


@pytest.mark.parametrize("name", SLIDING)
def test_ranges_are_those_of_the_machine_not_of_its_place(name):
    mechanism = loaded(name)
    problem = search_problem(mechanism, mechanism.home.q)
    away = pin.SE3(pin.rpy.rpyToMatrix(0.3, -0.8, 2.0), np.array([3e3, -2e3, 1e3]))
    moved = problem.model.copy()
    for joint in range(1, moved.njoints):
        if moved.parents[joint] == 0:
            moved.jointPlacements[joint] = away * moved.jointPlacements[joint]
    for index in range(1, moved.nframes):
        if moved.frames[index].parentJoint == 0:
            moved.frames[index].placement = away * moved.frames[index].placement
    edges = edges_of(moved)
    passive = tuple((entries, edges[edge.name]) for entries, edge in problem.passive)
    elsewhere = replace(problem, model=moved, passive=passive)
    one, other = slide_ranges(problem, False), slide_ranges(elsewhere, False)
    assert one.keys() == other.keys()
    for key, found in one.items():
        width = (found.upper - found.lower).max(initial=0.0)
        np.testing.assert_allclose(other[key].lower, found.lower, atol=1e-6 * width)
        np.testing.assert_allclose(other[key].upper, found.upper, atol=1e-6 * width)


def small_platform(ratio):
    """A Gough platform whose base and plate are so much smaller, its legs as long as before."""
    mechanism = loaded("stewart_gough")
    sizes = {name: one.default / ratio for name, one in mechanism.spec.parameters.items()}
    return pj.load("stewart_gough", sizes)


@pytest.mark.parametrize("ratio", [1, 100])
def test_no_mode_hides_where_legs_are_much_longer_than_what_they_carry(ratio):
    """Of a hundred starts some lead to each of four modes and their images below the base."""
    mechanism = small_platform(ratio)
    problem = search_problem(mechanism, mechanism.home.q)
    search = RandomSearch(problem, StartSpace.of(problem, limits=True), np.random.default_rng(0))
    search.run(512)
    shares = [share for _, share in search.modes()]
    assert len(shares) == 8
    assert min(shares) > 0.01


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [30, 100, 300, 1000])
def test_legs_driven_out_far_lead_to_eight_modes(ratio):
    """Tolerance and lengths are those of the machine at home; beyond, rounding decides."""
    mechanism = loaded("stewart_gough")
    values = ratio * mechanism.home.actuated
    modes = pj.assembly_modes(mechanism, values, rng=0, limits=False)
    assert len(modes) == 8
    assert (
        sorted(np.sign([mode.tool_pose().translation[2] for mode in modes])) == [-1] * 4 + [1] * 4
    )


def test_what_does_not_close_to_the_tolerance_is_told():
    """Two poses, one of them where no pose of the rocker reaches the coupler."""
    mechanism = mechanisms.rocker_rocker()
    motors = mechanism.problem.partition.actuated
    beyond = mechanism.coordinates.with_values(mechanism.home.q, motors, np.full(1, 3.0))
    assert open_by(mechanism, mechanism.home.q) == 0.0
    evidence = Evidence("statistics", "all", 0.001, 0.99)
    assert _without_open(mechanism, [mechanism.home.q], evidence) is evidence
    told = _without_open(mechanism, [mechanism.home.q, beyond], evidence).statement
    assert told.startswith("all; 1 more, open by ")
    assert told.endswith(f"misses the tolerance of {mechanism.tolerance:.2g} m and is left out")


def domain_of_slides(mechanism):
    """The boxes' ends of a proof, for what slides."""
    given = given_values(mechanism, mechanism.home.actuated)
    problem = box_problem(mechanism, given, limits=False)
    edges = edges_of(mechanism.kinematics.model)
    sliding = [edges[name].kind.name == "prismatic" for name in problem.names]
    assert any(sliding)
    return np.array([problem.domain.lower[sliding], problem.domain.upper[sliding]])


@pytest.mark.parametrize("machine", [far_slide(), loaded("slider_crank")], ids=["far", "crank"])
def test_a_proof_bounds_slides_as_a_search_does_wherever_the_machine_stands(machine):
    ends = domain_of_slides(machine)
    problem = search_problem(machine, machine.home.q)
    for lower, upper, found in zip(*ends, slide_ranges(problem, False).values(), strict=True):
        width = upper - lower
        assert lower <= found.lower[0] <= found.upper[0] <= upper
        assert width <= (1.0 + 1e-8) * (found.upper[0] - found.lower[0])
    away = pin.SE3(pin.rpy.rpyToMatrix(0.3, -0.8, 2.0), np.array([300.0, -200.0, 100.0]))
    moved = domain_of_slides(transformed.moved(machine, away))
    np.testing.assert_allclose(moved, ends, atol=1e-9 * np.ptp(ends))


def test_limits_out_of_reach_leave_no_box_inside_out():
    """No pose has the block between 200 and 201 m: what is left lies between them."""
    machine = far_slide()
    problem = search_problem(machine, machine.home.q)
    spans = [(find_frame(problem.model, "A"), find_frame(problem.model, "B"), 100.0)]
    edges = [edge for _, edge in problem.passive]
    polygons = Polygons(problem.model, problem.base, edges, spans)
    lower, upper = polygons.bounds({"rail": (np.full(1, 200.0), np.full(1, 201.0))})["rail"]
    assert 100.0 < lower <= upper <= 200.0
