"""Generic ranks are those of the branch that a pose lies on, whichever branch home is on."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from random_machines import Tree, at
from recording import recorded

import pmjac_pin as pj


def rhombus(home, motors):
    """Two arms of two equal bars on one pivot, their tips joined; angles of each elbow relative."""
    tree = Tree()
    for arm in "12":
        shoulder = tree.joint(0, f"shoulder{arm}", at([0, 0, 0]))
        elbow = tree.joint(shoulder, f"elbow{arm}", at([1, 0, 0]))
        tree.frame(elbow, f"tip{arm}", at([2, 0, 0]))
        tree.frame(shoulder, f"knee{arm}", at([1, 0, 0]))
    loops = [pj.PointLoop(frames=("tip1", "tip2"))]
    return pj.Mechanism.from_pinocchio(tree.model, loops, motors, "tip1", home=home)


def kites(home, motors, bars=(0.8,), tool="tip0"):
    """Kites between a crank and the ground, both of 1 m: folded together at 0, rockers turn freely.

    One for each length of coupler and rocker, all on the same crank.
    """
    tree, loops = Tree(), []
    crank = tree.joint(0, "crank", at([0, 0, 0]))
    for k, bar in enumerate(bars):
        coupler = tree.joint(crank, f"coupler{k}", at([1, 0, 0]))
        rocker = tree.joint(0, f"rocker{k}", at([1, 0, 0]))
        tree.frame(coupler, f"tip{k}", at([1 + bar, 0, 0]))
        tree.frame(rocker, f"end{k}", at([1 + bar, 0, 0]))
        loops.append(pj.PointLoop(frames=(f"tip{k}", f"end{k}")))
    tree.frame(crank, "middle", at([0.5, 0, 0]))
    return pj.Mechanism.from_pinocchio(tree.model, loops, motors, tool, home=home)


def folded(crank=0.0, angles=(0.9,)):
    """Return joint values with all kites folded."""
    pose = {"crank": crank}
    for k, angle in enumerate(angles):
        pose |= {f"coupler{k}": angle - crank, f"rocker{k}": angle}
    return pose


def opened(crank, bars=(0.8,), ways=(1,)):
    """Return joint values of open kites: coupler and rocker lean alike to the line of symmetry."""
    half, pose = 2.0 * np.sin(crank / 2.0) / 2.0, {"crank": crank}
    across = crank / 2.0 - np.pi / 2.0  # from the crank's end to the ground's
    for k, (bar, way) in enumerate(zip(bars, ways, strict=True)):
        lean = way * np.arccos(np.clip(half / bar, -1.0, 1.0))
        pose |= {f"coupler{k}": across + lean - crank, f"rocker{k}": across + np.pi - lean}
    return pose


TOGETHER = {"shoulder1": 0.3, "elbow1": 0.9, "shoulder2": 0.3, "elbow2": 0.9}


def open_rhombus(one, other):
    between = other - one
    return {"shoulder1": one, "elbow1": between, "shoulder2": other, "elbow2": -between}


TWO = (0.8, 1.3)
STRETCHED = 2.0 * np.arcsin(0.8)  # where coupler and rocker of the first kite are in line
CASES = {
    "rhombus": (
        lambda home: rhombus(home, ["shoulder1", "shoulder2"]),
        TOGETHER,
        [open_rhombus(0.3, 1.2), open_rhombus(-1.0, 1.5), open_rhombus(2.0, 0.7)],
    ),
    "rhombus, tips at the pivot": (
        lambda home: rhombus(home, ["shoulder1", "shoulder2"]),
        TOGETHER,
        [{"shoulder1": 0.3, "elbow1": np.pi, "shoulder2": 1.3, "elbow2": np.pi}],
    ),
    "kite": (
        lambda home: kites(home, ["crank"]),
        folded(),
        [opened(0.5), opened(1.2, ways=(-1,)), opened(-1.0), opened(1.7)],
    ),
    "kite with a ground of equal bars": (
        lambda home: kites(home, ["crank"], (1.0,)),
        folded(),
        [opened(0.5, (1.0,)), opened(-1.2, (1.0,), (-1,)), opened(2.5, (1.0,))],
    ),
    "two kites, both folded": (
        lambda home: kites(home, ["crank"], TWO),
        folded(angles=(0.9, -0.4)),
        [opened(0.5, TWO, (1, 1)), opened(1.2, TWO, (-1, 1)), opened(-1.0, TWO, (1, -1))],
    ),
    "two kites, one folded": (
        lambda home: kites(home, ["rocker1"], TWO),
        folded(angles=(0.9, -0.4)),
        [opened(0.5, TWO, (1, 1)), opened(1.2, TWO, (-1, 1)), opened(-1.0, TWO, (1, -1))],
    ),
}


def said(question):
    """Return an answer, or the error's words."""
    try:
        return question()
    except pj.PmjacError as error:
        return f"{type(error).__name__}: {error}"


@pytest.mark.parametrize("name", CASES)
def test_a_pose_has_the_ranks_of_its_own_branch(name, rng):
    """Whatever is asked there, the machine answers as if its home were there."""
    build, low, poses = CASES[name]
    mechanism = build(low)
    for pose in poses:
        other = build(pose)
        assert other.problem.partition.passive_rank > mechanism.problem.partition.passive_rank
        theirs = other.home
        ours = mechanism.configuration(theirs.q)
        for one in (ours, pickle.loads(pickle.dumps(ours))):
            assert repr(one.singularity()) == repr(theirs.singularity())
            assert one.singularity().idle == 0
            J_eq = one.jacobian().J_eq
            np.testing.assert_allclose(J_eq, theirs.jacobian().J_eq, atol=1e-12)
        for _ in range(2):
            values = ours.actuated + 0.05 * rng.normal(size=ours.actuated.size)
            closed = mechanism.close(values, guess=ours)
            expected = other.close(values, guess=theirs)
            np.testing.assert_allclose(closed.q, expected.q, atol=1e-9)
            assert closed.singularity().generic_rank == theirs.singularity().generic_rank
            batch = pj.batch(mechanism).close([values], guess=ours)
            np.testing.assert_allclose(batch.q[0], expected.q, atol=1e-9)


@pytest.mark.parametrize("way", [1, -1])
def test_a_singular_pose_of_another_branch_is_singular(way):
    """With coupler and rocker in line K* has the rank of the folded home, but less than beside."""
    mechanism = kites(folded(), ["crank"])
    stretched = mechanism.configuration(
        mechanism.coordinates.q(opened(way * STRETCHED), mechanism.home.q)
    )
    found = stretched.singularity()
    assert (found.kind, found.rank, found.generic_rank, found.idle) == ("gain", 1, 2, 0)
    with pytest.raises(pj.SingularError):
        stretched.jacobian()


@pytest.mark.parametrize("motor", ["coupler0", "rocker0"])
@pytest.mark.parametrize("home", [folded(), opened(1.1)])
@pytest.mark.parametrize("use", [lambda mechanism: mechanism, recorded])
def test_what_a_tool_loses_is_what_it_has_on_its_branch(motor, home, use):
    """Folded, the crank rests; opened, it does only where coupler and rocker are in line."""
    mechanism = use(kites(home, [motor], tool="middle"))
    kinds = []
    for pose in (opened(1.1), opened(0.5), opened(STRETCHED), opened(STRETCHED - 1e-3)):
        there = mechanism.configuration(mechanism.coordinates.q(pose, mechanism.home.q))
        found = there.singularity()
        kinds.append((found.kind, found.tool_rank, found.generic_tool_rank))
    regular = ("regular", 1, 1)
    assert kinds == [regular, regular, ("loss", 0, 1), regular]


def test_a_path_that_ends_on_another_branch_says_so_by_its_ranks():
    mechanism = kites(folded(), ["crank"])
    start = mechanism.configuration(mechanism.coordinates.q(opened(1.2), mechanism.home.q))
    with pytest.raises(pj.ClosureError, match="meets a singularity") as caught:
        mechanism.close([STRETCHED + 0.1], guess=start)
    assert not caught.value.ties
    assert caught.value.reached.actuated[0] == pytest.approx(STRETCHED, abs=1e-4)


@pytest.mark.parametrize("crank", [0.7, 1.3])
def test_folded_poses_are_singular_beside_a_home_that_is_open(crank):
    """The other way round: what is free there is free, and no J_eq is given."""
    mechanism = kites(opened(crank), ["crank"])
    there = mechanism.configuration(mechanism.coordinates.q(folded(), mechanism.home.q))
    found = there.singularity()
    assert (found.rank, found.generic_rank, found.gained, found.idle) == (1, 2, 1, 0)
    assert found.free_motion() == pytest.approx({"coupler0": 1.0, "rocker0": 1.0})
    with pytest.raises(pj.SingularError):
        there.jacobian()


def test_home_keeps_its_own_ranks_where_it_is_folded():
    for mechanism in (kites(folded(), ["crank"]), kites(folded(), ["crank"], (1.0,))):
        found = mechanism.home.singularity()
        assert (found.kind, found.rank, found.generic_rank, found.idle) == ("regular", 1, 1, 1)
        with pytest.raises(pj.ForbiddenRatesError, match="crank"):
            mechanism.home.jacobian()


@pytest.mark.parametrize("name", ["rhombus", "kite", "two kites, both folded"])
def test_modes_are_those_that_a_home_on_their_branch_finds(name):
    """What moves freely at home does not at these motor values, and says nothing of them."""
    build, low, poses = CASES[name]
    ours, theirs = build(low), build(poses[0])
    values = theirs.home.actuated
    found = pj.assembly_modes(ours, values, rng=0, limits=False)
    expected = pj.assembly_modes(theirs, values, rng=0, limits=False)
    assert len(found) == len(expected) > 1
    for one, other in zip(found, expected, strict=True):
        assert one.tool_pose().isApprox(other.tool_pose(), 1e-7)
    with pytest.raises(pj.IdleMotionError):
        pj.assembly_modes(ours, ours.home.actuated, rng=0, limits=False)
