"""Starts that do not end, and proven poses that do not close: neither is told as nothing met."""

from __future__ import annotations

from types import SimpleNamespace

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded
from random_machines import Tree, at

import pmjac_pin as pj
from pmjac_pin.studies.modes.search import ManyClosures
from pmjac_pin.studies.modes.search_problem import search_problem
from pmjac_pin.studies.modes.settling import HomotopyCensus
from pmjac_pin.studies.modes.starts import StartSpace


def slides(angle):
    """A crank of 1 m, its tip held by two slides on each other, at a small angle.

    The second one has sin θ / sin(angle) to go: one mode, and linear equations.
    """
    tree, forward = Tree(), pin.rpy.rpyToMatrix(0.0, np.pi / 2, 0.0)
    turned = pin.rpy.rpyToMatrix(0.0, 0.0, angle) @ forward
    crank = tree.joint(0, "crank", at([0, 0, 0]))
    one = tree.joint(0, "one", pin.SE3(forward, np.zeros(3)), "prismatic")
    two = tree.joint(one, "two", pin.SE3(turned, np.zeros(3)), "prismatic")
    tree.frame(crank, "tip", at([1, 0, 0]))
    tree.frame(two, "end", at([0, 0, 0]))
    loops, home = [pj.PointLoop(frames=("tip", "end"))], slid(1e-3, angle)
    return pj.Mechanism.from_pinocchio(tree.model, loops, ["crank"], "end", home=home)


def slid(theta, angle):
    far = np.sin(theta) / np.sin(angle)
    return {"crank": theta, "one": np.cos(theta) - far * np.cos(angle), "two": far}


def ends(mechanism, count):
    base = mechanism.home.q
    problem = search_problem(mechanism, base)
    space = StartSpace.of(problem, limits=True)
    closures = ManyClosures(problem, space.strides(problem))
    first = closures.ends(space.draw(np.random.default_rng(0), count))
    return first, closures.finished(first)


@pytest.mark.parametrize(("angle", "theta"), [(1e-2, 0.5), (1e-2, 1.5), (0.1, 1.5)])
def test_slides_that_have_far_to_go_get_there(angle, theta):
    modes = pj.assembly_modes(slides(angle), [theta], rng=0, proof=False)
    [mode] = modes
    assert dict(mode.joint_values) == pytest.approx(slid(theta, angle), abs=1e-8)
    assert modes.evidence.kind == "statistics"


@pytest.mark.parametrize(
    ("angle", "theta"),
    mechanisms.mostly_slow([(1e-3, 0.5), (1e-3, 1.5), (1e-5, 0.5)], [(1e-5, 0.5)]),
)
def test_starts_that_do_not_end_give_no_confidence(angle, theta):
    """What they lead to is not known: that nothing was met rests on nothing."""
    modes = pj.assembly_modes(slides(angle), [theta], rng=0, proof=False)
    assert len(modes) == 0
    evidence = modes.evidence
    assert (evidence.kind, evidence.confidence, evidence.unseen) == ("nothing", None, None)
    assert f"{modes.starts} of {modes.starts} random starts did not end" in evidence.statement


def test_a_proof_finds_what_starts_do_not_reach():
    modes = pj.assembly_modes(slides(1e-3), [1.5], rng=0)
    assert (len(modes), modes.evidence.kind) == (1, "proof")


def test_a_proven_pose_that_rounding_keeps_open_is_named():
    """Slides driven out 48 km are known to 7e-12 m: there is no Configuration, but a mode."""
    mechanism = slides(1e-5)
    assert len(pj.prove(mechanism, [0.5]).enclosures) == 1
    modes = pj.assembly_modes(mechanism, [0.5], rng=0)
    assert (len(modes), modes.evidence.kind) == (0, "nothing")
    assert modes.evidence.statement.startswith("exactly 1, by interval arithmetic")
    assert "; 1 of them, open by " in modes.evidence.statement
    assert modes.evidence.statement.endswith("misses the tolerance of 1e-12 m and is left out")


def test_a_solution_of_a_homotopy_that_rounding_keeps_open_is_a_row():
    mechanism = slides(1e-5)
    [q] = pj.prove(mechanism, [0.5]).q
    complete = pj.prove(mechanism, [0.5]).evidence
    census = HomotopyCensus(
        mechanism, SimpleNamespace(real=[SimpleNamespace(q=q)], evidence=complete), limits=True
    )
    assert len(census.rows()) == 1
    assert census.found_as([]) == [None]


@pytest.mark.parametrize("name", mechanisms.mostly_slow(mechanisms.CLOSED))
def test_hardly_a_start_stays_undecided(name):
    """Each start closes, or is where no step brings it nearer, or is counted."""
    first, second = ends(loaded(name), 200)
    assert len(first.closed) + len(first.open) + len(first.spent) == 200
    assert len(second.closed) + len(second.open) + len(second.spent) >= len(first.spent)
    assert len(second.spent) <= 0.15 * 200
