"""Searches by the recorded program: steps and ends are those of NumPy, and each start's its own."""

from __future__ import annotations

import idling_machines
import numpy as np
import pytest
from mechanisms import CLOSED, loaded

import pmjac_pin as pj
from pmjac_pin.algebra import tape_runner
from pmjac_pin.closing.levenberg_marquardt import Linearised, Patience, damped_step, descend, norms
from pmjac_pin.rates.sparse_cholesky import Elimination
from pmjac_pin.studies.modes import descents_in_lanes, recorded_descent
from pmjac_pin.studies.modes.descents_in_lanes import DescentsInLanes, descent_kernel
from pmjac_pin.studies.modes.idling import Idling
from pmjac_pin.studies.modes.passive_joints import PassiveJoints
from pmjac_pin.studies.modes.search_problem import search_problem
from pmjac_pin.studies.modes.starts import StartSpace

needs_kernel = pytest.mark.skipif(descent_kernel() is None, reason="no kernel was built")
SOME = ("four_bar", "three_rps", "delta_rods", "agile_eye", "humanoid_ankle")


class Case:
    """A search of a catalogue mechanism, with motors beside those of home."""

    def __init__(self, name, rng):
        mechanism = loaded(name)
        self.problem = search_problem(mechanism, mechanism.home.q)
        space = StartSpace.of(self.problem, limits=False)
        self.strides = space.strides(self.problem)
        self.joints = PassiveJoints(self.problem, self.strides)
        self.draw = lambda count: space.draw(rng, count)

    @property
    def programs(self):
        return recorded_descent.recorded_descent(self.problem, self.strides)

    @property
    def in_lanes(self):
        return DescentsInLanes(descent_kernel(), self.programs, self.joints.stride)


@pytest.mark.parametrize("name", CLOSED)
@pytest.mark.parametrize("damping", [1e-3, 1.0, 1e4])
def test_a_step_is_numpys(name, damping, rng):
    case = Case(name, rng)
    q, programs = case.draw(40), case.programs
    before = rng.uniform(0.0, 2.0, (40, case.strides.size))
    error, rows = case.joints.evaluate(q)
    known = tape_runner.run(programs.pose, q.T)
    assert known[0] == pytest.approx(norms(error), rel=1e-12, abs=1e-14)

    inputs = np.vstack([q.T, known[1:], before.T, np.full((1, 40), damping)])
    led, sizes, length = np.split(
        tape_runner.run(programs.step, inputs), [programs.nq, programs.nq + programs.unknowns]
    )
    ease = case.joints.ease(q, error, rows, 1.0 / before)
    assert pytest.approx(1.0 / ease, rel=1e-9) == sizes.T
    step = damped_step(case.joints, Linearised(q, error, rows, ease), np.full(40, damping))
    assert pytest.approx(case.joints.moved(q, step), abs=1e-9) == led.T
    assert np.minimum(length[0], 1.0) == pytest.approx(norms(step / case.strides), abs=1e-9)


RULES = {
    "as ever": {},
    "few steps": {"steps": 3},
    "creeping": {"creeping": 0.5, "creeping_steps": 2},
    "soon enough": {"enough": 0.05},
    "within a tolerance": {"tolerance": 0.2, "falling": 0.5},
    "given up": {"most": 1e-1, "grows": 9.0},
    "one undamped": {"steps": 1, "damping": 0.0},
}


@needs_kernel
@pytest.mark.parametrize("name", SOME)
@pytest.mark.parametrize("rules", RULES)
def test_ends_are_numpys(name, rules, rng):
    """Few steps, and most starts: rounding may decide where two paths part."""
    case = Case(name, rng)
    told = {"steps": 6, "enough": 1e-9, "damping": 1e-2, "least": 1e-9, "most": 1e8}
    told |= {"shrinks": 5.0, "grows": 5.0, "grows_within": 5.0} | RULES[rules]
    starts = case.draw(150)
    ends = case.in_lanes.descend(starts, Patience(**told))
    others = descend(case.joints, starts, Patience(**told))
    same = np.isclose(ends.gap, others.gap, rtol=1e-6, atol=1e-9)
    same &= (abs(ends.q - others.q) < 1e-6 * (1.0 + abs(others.q))).all(axis=1)
    for which in ("closed", "spent", "iterations"):
        same &= getattr(ends, which) == getattr(others, which)
    assert np.count_nonzero(~same) <= 2


@needs_kernel
@pytest.mark.parametrize("name", SOME)
def test_an_end_is_that_of_its_own_start(name, rng):
    """To the last bit, whatever starts are taken up beside it and in which lane."""
    case = Case(name, rng)
    in_lanes, starts = case.in_lanes, case.draw(130)
    patience = Patience(steps=40, enough=1e-9, damping=1e-2, least=1e-9, most=1e8, shrinks=5.0,
                        grows=5.0)  # fmt: skip
    whole = in_lanes.descend(starts, patience)
    for few in (slice(0, 0), slice(7, 8), slice(20, 53), slice(66, 130)):
        part = in_lanes.descend(starts[few], patience)
        for one, other in zip(part, whole, strict=True):
            np.testing.assert_array_equal(one, other[few])


@pytest.mark.parametrize("name", CLOSED)
def test_of_no_starts_none_end(name, rng):
    """As where all that were drawn have closed, and nothing is left to be finished."""
    case = Case(name, rng)
    assert all(not len(each) for each in descend(case.joints, case.draw(0), Patience(3, 0.0)))


@pytest.mark.parametrize("name", SOME)
def test_modes_are_the_same_without_the_kernel(name, monkeypatch):
    mechanism = loaded(name)

    def modes():
        return pj.assembly_modes(mechanism, mechanism.home.actuated, rng=0, limits=False)

    found = modes()
    monkeypatch.setattr(descents_in_lanes, "descent_kernel", lambda: None)
    others = modes()
    assert len(found) == len(others)
    for one, other in zip(found, others, strict=True):
        assert one.tool_pose().homogeneous == pytest.approx(other.tool_pose().homogeneous, abs=1e-8)


def test_programs_that_would_be_too_long_are_not_written(monkeypatch, rng):
    """Then NumPy descends, with the same modes."""
    monkeypatch.setattr(recorded_descent, "_MOST_PRODUCTS", 3)
    assert Case("four_bar", rng).programs is None
    mechanism = loaded("four_bar")
    assert len(pj.assembly_modes(mechanism, mechanism.home.actuated, rng=0, limits=False)) == 2


def test_what_idles_is_seen_in_few_poses_and_nothing_is_recorded_for_these(monkeypatch):
    """Programs of joints that are all tied together take longer to write than to do."""
    mechanism = idling_machines.on_a_turntable(loaded("four_bar"), (0.0, 0.6, 0.8))
    problem = search_problem(mechanism, mechanism.home.q)

    def refused(*_):
        raise AssertionError("recorded")

    monkeypatch.setattr(recorded_descent, "recorded_descent", refused)
    assert Idling.of(problem, problem.base[None]).groups() == [[0], [1, 2, 3, 4]]


@pytest.mark.parametrize("count", [1, 2, 5, 12])
@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_an_elimination_solves(count, share, rng):
    matrix = np.where(rng.uniform(size=(count, count)) < share, rng.normal(size=(count, count)), 0)
    matrix = np.triu(matrix, 1) + np.triu(matrix, 1).T + 2.0 * count * np.eye(count)
    places = np.argwhere(np.triu(matrix)).tolist()
    upper = {(i, j): float(matrix[i, j]) for i, j in places}
    right = rng.normal(size=count).tolist()
    elimination = Elimination.of(upper)
    assert sorted(elimination.order) == list(range(count))
    assert elimination.solve(upper, right) == pytest.approx(np.linalg.solve(matrix, right))
