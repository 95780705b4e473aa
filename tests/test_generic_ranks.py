"""Generic ranks where home is no ordinary pose: a branch point, or no pose near it closes."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded
from random_machines import Tree, at, planar_four_bar

import pmjac_pin as pj
from pmjac_pin.closing.generic_ranks import ranked
from pmjac_pin.closing.nearby_poses import FARTHEST, nearby
from pmjac_pin.studies.modes.legs import find_legs


def taut_four_bar(motors, **options):
    """Ground as long as the three bars together: it is assembled and cannot move at all."""
    ends = (2.0, 0.0), (2.0, 0.0)
    return planar_four_bar((1.0, 0.0), (3.0, 0.0), ends, motors, name="taut", **options)


@pytest.mark.parametrize("motors", [["a"], ["a", "b"], ["c"]])
def test_a_taut_four_bar_is_a_structure_or_not_known(motors):
    mechanism = taut_four_bar(motors)
    assert mechanism.mobility is None
    assert "mobility not known" in repr(mechanism)
    found = mechanism.home.singularity()
    assert (found.kind, found.is_singular) == ("isolated", True)
    with pytest.raises(pj.SingularError, match="no pose near home closes: a structure, or a sing"):
        mechanism.home.jacobian()
    diagnosis = pj.check(mechanism)
    assert diagnosis.severity == "error"
    assert diagnosis.mobility.mobility is None
    assert any(finding.code == "isolated" for finding in diagnosis.findings)
    assert not any("command every motion" in finding.message for finding in diagnosis.findings)


@pytest.mark.parametrize("motor", ["a", "wheel", "crank"])
def test_what_moves_beside_a_structure_does_not_make_it_a_mechanism(motor):
    """A taut four-bar beside a free wheel and a four-bar that moves: 1 + 1, no motor moves `a`."""
    tree = Tree()
    a = tree.joint(0, "a", at([0, 0, 0]))
    b = tree.joint(a, "b", at([1, 0, 0]))
    tree.frame(b, "bt", at([2, 0, 0]))
    tree.frame(0, "ct", at([2, 0, 0]))
    tree.joint(0, "wheel", at([5, 0, 0]))
    crank = tree.joint(0, "crank", at([9, 0, 0]))
    coupler = tree.joint(crank, "coupler", at([9, 1, 0]))
    rocker = tree.joint(0, "rocker", at([12, 0, 0]))
    tree.frame(coupler, "one", at([11.5, 2, 0]))
    tree.frame(rocker, "other", at([11.5, 2, 0]))
    loops = [pj.PointLoop(frames=frames) for frames in (("bt", "ct"), ("one", "other"))]
    mechanism = pj.Mechanism.from_pinocchio(tree.model, loops, [motor], "bt")
    assert mechanism.mobility is None
    assert mechanism.home.singularity().kind == "isolated"
    with pytest.raises(pj.SingularError, match="no pose near home closes: a structure"):
        mechanism.home.jacobian()


@pytest.mark.parametrize("tolerance", [1e-8, 1e-6, 1e-5])
def test_a_tolerance_does_not_make_a_structure_move(tolerance):
    """The gap grows with the square of a displacement: near home it is below any tolerance."""
    mechanism = taut_four_bar(["a"], tolerance=tolerance)
    assert mechanism.mobility is None
    assert mechanism.home.singularity().kind == "isolated"


def taut_bars_on_a_crank(motors):
    """Between two points of a crank three bars in line, each free in the plane but for its ends."""
    tree = Tree()
    crank = tree.joint(0, "crank", at([0, 0, 0]))
    for name, x in (("a0", 1.0), ("d0", 4.0)):
        tree.frame(crank, name, at([x, 0, 0]))
    along_x, along_y = pin.exp3(np.array([0, np.pi / 2, 0])), pin.exp3(np.array([-np.pi / 2, 0, 0]))
    home = {"crank": 0.0}
    for k in range(3):
        x = tree.joint(0, f"x{k}", pin.SE3(along_x, np.zeros(3)), "prismatic")
        y = tree.joint(x, f"y{k}", pin.SE3(along_y, np.zeros(3)), "prismatic")
        body = tree.joint(y, f"r{k}", at([0, 0, 0]))
        tree.frame(body, f"one{k}", at([-0.5, 0, 0]))
        tree.frame(body, f"end{k}", at([0.5, 0, 0]))
        home |= {f"x{k}": 1.5 + k, f"y{k}": 0.0, f"r{k}": 0.0}
    pairs = [("a0", "one0"), ("end0", "one1"), ("end1", "one2"), ("end2", "d0")]
    loops = [pj.PointLoop(frames=pair) for pair in pairs]
    return pj.Mechanism.from_pinocchio(tree.model, loops, motors, "end1", home=home)


@pytest.mark.parametrize("motors", [["crank"], ["crank", "y0", "y1"]])
def test_a_structure_that_is_carried_along_is_told(motors):
    """The crank moves all coordinates, but no bar moves against another, though rates allow it."""
    mechanism = taut_bars_on_a_crank(motors)
    assert mechanism.mobility is None
    assert mechanism.home.singularity().kind == "isolated"
    with pytest.raises(pj.SingularError, match="a structure"):
        mechanism.home.jacobian()


@pytest.mark.parametrize("wheels", [2, 3, 4, 5])
@pytest.mark.parametrize("motor", ["first", "last", "all"])
def test_a_flat_coupling_rod_moves_and_its_home_is_a_branch_point(wheels, motor, rng):
    """Equal cranks, all joints at 0: cranks at v and the rod at -v close the loops at every v."""
    tree, arm = Tree(), rng.uniform(0.2, 1.0)
    places = [0.0, *np.cumsum(rng.uniform(0.5, 3.0, wheels - 1))]
    first = tree.joint(0, "c0", at([0, 0, 0]))
    rod = tree.joint(first, "rod", at([arm, 0, 0]))
    loops = []
    for k, place in enumerate(places[1:], start=1):
        crank = tree.joint(0, f"c{k}", at([place, 0, 0]))
        tree.frame(crank, f"pin{k}", at([place + arm, 0, 0]))
        tree.frame(rod, f"eye{k}", at([place + arm, 0, 0]))
        loops.append(pj.PointLoop(frames=(f"eye{k}", f"pin{k}")))
    tree.frame(rod, "tool", at([arm + 0.5, 0, 0]))
    cranks = [f"c{k}" for k in range(wheels)]
    motors = {"first": cranks[:1], "last": cranks[-1:], "all": cranks}[motor]
    mechanism = pj.Mechanism.from_pinocchio(tree.model, loops, motors, "tool")
    assert mechanism.mobility == 1
    assert mechanism.home.singularity().kind == "configuration space"
    q = np.full(wheels + 1, 0.3)
    q[mechanism.model.joints[mechanism.model.getJointId("rod")].idx_q] = -0.3
    assert mechanism.configuration(q).singularity().constraint_rank == wheels


@pytest.mark.parametrize("shorter", [1e-3, 1e-2, 0.3])
def test_a_four_bar_that_is_not_quite_taut_moves(shorter):
    """With a ground that is a little shorter, it is a mechanism of mobility 1."""
    tree = Tree()
    ground = 3.0 - shorter
    # Bars of 1 m: crank and rocker lean by the same angle, the coupler lies between them.
    lean = math.acos((ground - 1.0) / 2.0)
    corner = np.array([math.cos(lean), math.sin(lean), 0.0])
    a = tree.joint(0, "a", at([0, 0, 0]))
    b = tree.joint(a, "b", at(corner))
    c = tree.joint(0, "c", at([ground, 0, 0]))
    tree.frame(b, "bt", at(corner + np.array([1, 0, 0])))
    tree.frame(c, "ct", at(corner + np.array([1, 0, 0])))
    loops = [pj.PointLoop(frames=("bt", "ct"))]
    mechanism = pj.Mechanism.from_pinocchio(tree.model, loops, ["a"], "bt")
    assert mechanism.mobility == 1
    assert mechanism.home.singularity().kind == "regular"


def parallelogram(theta):
    tree = Tree()
    crank = tree.joint(0, "crank", at([0, 0, 0]))
    coupler = tree.joint(crank, "coupler", at([1, 0, 0]))
    rocker = tree.joint(0, "rocker", at([2, 0, 0]))
    tree.frame(coupler, "ct", at([3, 0, 0]))
    tree.frame(rocker, "rt", at([3, 0, 0]))
    tree.frame(coupler, "tool", at([1.6, 0, 0]))
    home = {"crank": theta, "coupler": -theta, "rocker": theta}
    loops = [pj.PointLoop(frames=("ct", "rt"))]
    return pj.Mechanism.from_pinocchio(tree.model, loops, ["crank"], "tool", home=home)


@pytest.mark.parametrize("home", [0.7, 0.0])
def test_from_a_branch_point_regular_poses_are_regular(home):
    mechanism = parallelogram(home)
    assert mechanism.mobility == 1
    assert mechanism.home.singularity().kind == (
        "configuration space" if home == 0.0 else "regular"
    )
    found = mechanism.configuration([1.1, -1.1, 1.1]).singularity()
    assert (found.kind, found.lost, found.tool_rank) == ("regular", 0, 1)


def three_upu(height):
    """Three legs U-P-U between equal triangles one above the other (the SNU machine at home).

    Outer hinges of each leg tangential, the inner ones perpendicular to the leg.
    """
    tree, loops = Tree(), []
    plate = tree.joint(0, "plate", at([0, 0, height]), "free")
    for k in range(3):
        angle = 2.0 * math.pi * k / 3.0
        out = np.array([math.cos(angle), math.sin(angle), 0.0])
        tangent = np.array([-math.sin(angle), math.cos(angle), 0.0])
        up = np.array([0.0, 0.0, 1.0])
        tangential = pin.SE3(np.column_stack([up, out, tangent]), out)
        radial = pin.SE3(np.column_stack([tangent, up, out]), out)
        body = tree.joint(0, f"u{k}", tangential)
        body = tree.joint(body, f"v{k}", radial)
        body = tree.joint(body, f"l{k}", pin.SE3(np.eye(3), out), "prismatic")
        raised = out + np.array([0, 0, height])
        tree.frame(body, f"top{k}", at(raised))
        tree.frame(plate, f"on{k}", at(raised))
        axes = tuple(out), tuple(tangent)
        loops.append(pj.UniversalLoop(frames=(f"top{k}", f"on{k}"), axes=axes))
    tree.frame(plate, "tool", at([0, 0, height]))
    motors = [f"l{k}" for k in range(3)]
    return pj.Mechanism.from_pinocchio(tree.model, loops, motors, "tool", name="three_upu")


def test_from_the_singular_home_of_a_3_upu():
    """All legs are parallel at home, and whenever the plate has not turned: then they are equally
    long, whatever the motors are asked for, and two motions come free. No tool motion is lost."""
    mechanism = three_upu(1.0)
    assert mechanism.home.singularity().kind == "configuration space"
    assert mechanism.mobility == 3
    for shift in ([0.3, 0.1, 0.2], [-0.2, 0.4, -0.1]):
        values = {"plate": [*shift, 0.0, 0.0, 0.0]}
        leg = np.array(shift) + np.array([0.0, 0.0, 1.0])
        for k in range(3):
            angle = 2.0 * math.pi * k / 3.0
            out = np.array([math.cos(angle), math.sin(angle), 0.0])
            aside = leg @ [-math.sin(angle), math.cos(angle), 0.0]
            values[f"l{k}"] = float(np.linalg.norm(leg)) - 1.0
            values[f"u{k}"] = math.atan2(leg @ out, leg[2])
            values[f"v{k}"] = -math.atan2(aside, math.hypot(leg @ out, leg[2]))
        pose = mechanism.close([values[name] for name in mechanism.actuated], guess=values)
        np.testing.assert_allclose(pose.tool_pose().translation, leg, atol=1e-9)
        found = pose.singularity()
        assert (found.gained, found.lost, found.tool_rank) == (2, 0, 3)


def test_regular_poses_of_a_3_upu_are_regular_though_home_is_not():
    mechanism = three_upu(1.0)
    for motors in ([0.05, 0.01, -0.04], [-0.03, 0.06, 0.02]):
        guess = {"plate": [0.0, 0.0, 0.0, motors[1], -motors[0], 0.0]}
        found = mechanism.close(motors, guess=guess).singularity()
        assert (found.kind, found.lost) == ("regular", 0)


def watt_on_a_rail():
    """Watt's four-bar, its cranks square to the coupler: the coupler's middle follows a rail.

    It leaves the straight line with the fifth power of the way, so that near home it stays within
    the tolerance. It is a structure.
    """
    tree, slide = Tree(), pin.SE3(pin.rpy.rpyToMatrix(-np.pi / 2, 0, 0), np.zeros(3))
    crank = tree.joint(0, "crank", at([-1, 0.5, 0]))
    coupler = tree.joint(crank, "coupler", at([0, 0.5, 0]))
    rocker = tree.joint(0, "rocker", at([1, -0.5, 0]))
    block = tree.joint(0, "block", slide, "prismatic")
    for body, name in ((coupler, "end"), (rocker, "tip")):
        tree.frame(body, name, at([0, -0.5, 0]))
    for body, name in ((coupler, "middle"), (block, "pin")):
        tree.frame(body, name, at([0, 0, 0]))
    loops = [pj.PointLoop(frames=frames) for frames in (("end", "tip"), ("middle", "pin"))]
    return pj.Mechanism.from_pinocchio(tree.model, loops, ["crank"], "pin", name="watt")


def test_ranks_that_rest_on_the_nearest_poses_alone_are_told():
    mechanism = watt_on_a_rail()
    assert mechanism.mobility == 1
    assert repr(mechanism).endswith("mobility 1, seen no further than 0.005 rad from home)")
    diagnosis = pj.check(mechanism)
    [told] = [found for found in diagnosis.findings if found.code == "near-home-only"]
    assert told.severity == "warning"
    assert "generic ranks rest on poses no further than 0.005 rad or " in told.message
    assert diagnosis.mobility.reach == 0.005


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_the_joints_of_the_catalogue_are_seen_to_move(name):
    mechanism = loaded(name)
    assert mechanism.problem.partition.reach >= FARTHEST
    assert "seen no further" not in repr(mechanism)


@pytest.mark.parametrize(
    "name", ["bennett", "bricard", "four_bar", "sarrus", "slider_crank", "watt_six_bar"]
)
def test_with_one_motor_poses_beside_home_are_on_both_its_sides_and_none_is_found_twice(name):
    mechanism = loaded(name)
    found = [mechanism.configuration(q) for q in nearby(mechanism.problem, mechanism.home.q)]
    ways = [float((pose.actuated - mechanism.home.actuated)[0]) for pose in found]
    assert min(ways) < 0.0 < max(ways)
    assert np.diff(sorted(ways)).min() > 1e-6


@pytest.mark.parametrize("seed", [None, 0, 1, 2])
@pytest.mark.parametrize(
    "loop",
    [
        pj.RevoluteLoop(frames=("frame", "hinge"), axis=(0, 0, 1)),
        pj.CylindricalLoop(frames=("frame", "hinge"), axis=(0, 0, 1)),
        pj.PointLoop(frames=("frame", "hinge")),
        pj.DistanceLoop(frames=("frame", "above"), length=0.5),
    ],
    ids=lambda loop: type(loop).__name__,
)
def test_loops_that_close_nothing(loop, seed):
    """A door on two hinges: all of [K K*] is rounding, or exactly zero where axes are aligned."""
    turn = np.eye(3) if seed is None else pin.exp3(np.random.default_rng(seed).normal(size=3))
    tree = Tree()
    door = tree.joint(0, "door", pin.SE3(turn, turn @ np.array([0.5, 0.2, 0.1])))
    places = {"frame": (0, 1.9), "hinge": (door, 1.9), "above": (door, 2.4)}
    for name, (body, height) in places.items():
        tree.frame(body, name, pin.SE3(turn, turn @ np.array([0.5, 0.2, height])))
    mechanism = pj.Mechanism.from_pinocchio(tree.model, [loop], ["door"], "above")
    found = mechanism.home.singularity()
    assert (mechanism.mobility, found.kind, found.rank) == (1, "regular", 0)
    np.testing.assert_allclose(mechanism.home.jacobian().Jw_eq[:, 0], turn[:, 2], atol=1e-12)


def test_nothing_idles_in_a_structure():
    """That its joints may move with the motor locked is to first order only."""
    mechanism = taut_four_bar(["a"])
    found = mechanism.home.singularity()
    assert (found.kind, found.idle, found.idle_motions.shape[1]) == ("isolated", 0, 0)
    assert "no pose near home closes" in str(pj.prove(mechanism, mechanism.home.actuated).evidence)
    pj.assembly_modes(mechanism, mechanism.home.actuated, rng=0)  # refuses nothing that idles


def test_ranks_are_found_when_they_are_asked_for_and_are_one_for_all_threads(monkeypatch):
    found = []

    def counted(*given):
        found.append(ranked(*given))
        return found[-1]

    monkeypatch.setattr("pmjac_pin.closing.parts.ranked", counted)
    mechanism = pj.load("four_bar")
    assert found == []
    with ThreadPoolExecutor(4) as pool:
        problems = list(pool.map(lambda _: mechanism.problem, range(8)))
    assert all(problem is problems[0] for problem in problems)
    count = len(found)
    assert any(problem is problems[0] for problem in found)
    mechanism.home.jacobian()
    assert mechanism.mobility == 1
    assert len(found) == count


def test_legs_are_the_same_where_ranks_are_not_known_yet(rng):
    """Ranks are found with the scratch data that legs are read off."""
    known = pj.load("stewart_gough")
    change = 0.2 * rng.normal(size=known.nv)
    q = pin.integrate(known.model, known.home.q, change)
    own, other = (
        [(leg.centre.tolist(), leg.length) for leg in find_legs(mechanism, q)]
        for mechanism in (known, pj.load("stewart_gough"))
    )
    assert len(own) == 6
    assert own == other
