"""Recorded loop equations over boxes: nothing true is outside, and no solution is dropped."""

from __future__ import annotations

import numpy as np
import pytest
from mechanisms import CLOSED, loaded
from test_interval_loops import LOOPS, interval_loops, model

import pmjac_pin as pj
from pmjac_pin.algebra.balls import Balls, exactly, precise
from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.algebra.jets import Jet
from pmjac_pin.studies.modes import box_problem as problems
from pmjac_pin.studies.modes import recorded_loops
from pmjac_pin.studies.modes.box_domain import NoBoxesError
from pmjac_pin.studies.modes.box_equations import DROPPED
from pmjac_pin.studies.modes.interval_loops import IntervalLoops
from pmjac_pin.studies.modes.pruning_kernel import pruning_kernel
from pmjac_pin.studies.modes.recorded_loops import RecordedLoops, recorded

pytestmark = pytest.mark.skipif(pruning_kernel() is None, reason="no kernel was built")

__all__ = ["model"]  # a fixture

SERVED = {
    "agile_eye": [0.1, -0.2, 0.3],
    "ankle": [0.1, -0.2],
    "bennett": [1.0],
    "bricard": [0.3],
    "five_bar": [2.1874829, 0.95410976],
    "four_bar": [0.9],
    "humanoid_ankle": [0.1, 0.2],
    "planar_3rpr": [0.34, 0.36, 0.35],
    "planar_3rrr": [1.0, 0.9, 1.1],
    "sarrus": [0.5],
    "slider_crank": [0.9],
    "three_rps": [2 / 3, 3 / 5, 3 / 4],
    "three_rps_ss": [0.9, 1.0, 1.1],
    "watt_six_bar": [0.9],
}
SIZES = (0.0, 1e-9, 1e-4, 0.1, np.pi)


class Exact(Balls):
    """Arb's numbers at the model's own doubles: of an interval that is given, one end."""

    def measured(self, values):
        return self.constant(values)

    def directed(self, directions, x):
        return self.times(directions, x)

    def between(self, ends):
        return exactly(ends.upper)[..., None, None]


@pytest.fixture
def both(monkeypatch):
    """The equations of a mechanism, recorded and not, and all values of its unknowns."""
    monkeypatch.setattr(problems, "RecordedLoops", lambda program, loops: loops)

    def of(name, motors=None):
        mechanism = loaded(name)
        values = np.array(SERVED[name] if motors is None else motors)
        given = problems.given_values(mechanism, values)
        problem = problems.box_problem(mechanism, given, False)
        return RecordedLoops(recorded(problem.loops), problem.loops), problem

    return of


def random_boxes(rng, problem, count, size):
    share = rng.random((count, len(problem.names)))
    middle = problem.domain.lower + share * problem.domain.width
    half = size * rng.random(middle.shape) * problem.scale
    return Intervals(middle - half, middle + half)


def points_in(rng, boxes):
    inside = boxes.lower + rng.random(boxes.shape) * boxes.width
    return np.clip(inside, boxes.lower, boxes.upper)


def exact_rows(loops, points):
    """Return rows (p, b) and derivatives (p, k, b), balls of 106 bits."""
    balls = Exact()
    names, given = loops.tree.unknowns, loops.tree.given

    def value(name):
        if name in given:
            return exactly([[given[name]]])
        return exactly(points[None, :, names.index(name)])

    with precise():
        blocks, cosines = loops.at(loops.tree.at(balls, value, True))
    count, rows = len(points), len(loops.names)
    residual = np.concatenate(
        [np.broadcast_to(b.value[:, 0], (len(b.value), count)) for b in blocks]
    )
    jacobian = exactly(np.zeros((rows, len(names), count)))
    start = 0
    for block in blocks:
        where = slice(start, start + len(block.value))
        start = where.stop
        if block.columns:
            jacobian[where, [loops.places[column] for column in block.columns]] = block.rates
    return residual, jacobian, [np.broadcast_to(cosine[0], count) for cosine in cosines]


def holds_balls(intervals, balls):
    """Intervals (b, ...) hold balls (..., b)."""
    with precise():
        flat = zip(
            np.moveaxis(intervals.lower, 0, -1).ravel().tolist(),
            np.moveaxis(intervals.upper, 0, -1).ravel().tolist(),
            balls.ravel(),
            strict=True,
        )
        return all(bool(ball >= low) and bool(ball <= high) for low, high, ball in flat)


def test_all_that_proofs_serve_is_tried():
    for name in set(CLOSED) - set(SERVED):
        mechanism = loaded(name)
        given = problems.given_values(mechanism, mechanism.home.actuated)
        with pytest.raises(NoBoxesError):
            problems.box_problem(mechanism, given, False)


@pytest.mark.parametrize("name", SERVED)
def test_boxes_hold_the_exact_rows_and_derivatives(name, both, rng):
    loops, problem = both(name)
    for size in SIZES:
        boxes = random_boxes(rng, problem, 9, size)
        enclosed = loops.evaluate(boxes)
        residual, jacobian, cosines = exact_rows(problem.loops, points_in(rng, boxes))
        assert holds_balls(enclosed.residual, residual)
        assert holds_balls(enclosed.jacobian, jacobian)
        meant = [all(bool(one > 0) for one in of_point) for of_point in zip(*cosines, strict=True)]
        assert enclosed.possible[np.flatnonzero(meant)].all()


@pytest.mark.parametrize("name", SERVED)
def test_boxes_are_as_narrow_as_without_the_kernel(name, both, rng):
    loops, problem = both(name)
    for size in SIZES:
        boxes = random_boxes(rng, problem, 40, size)
        ours, theirs = loops.evaluate(boxes), problem.loops.evaluate(boxes)
        for one, other in ((ours.residual, theirs.residual), (ours.jacobian, theirs.jacobian)):
            assert (one.width <= other.width * (1.0 + 1e-9) + 1e-14 * problem.scale.max()).all()
            assert one.meets(other).all()


@pytest.mark.parametrize("size", [0.0, 1e-3, 0.3, 3.0])
@pytest.mark.parametrize("kind", LOOPS)
def test_every_kind_of_loop_and_of_joint(model, kind, size, rng):
    """Screws, slides and turns about slanted axes; the rows of each kind; half turns off."""
    known = interval_loops(model, LOOPS[kind])
    loops = RecordedLoops(recorded(known), known)
    middle = rng.uniform(-4, 4, (20, len(known.tree.unknowns)))
    half = size * rng.random(middle.shape)
    boxes = Intervals(middle - half, middle + half)
    enclosed, theirs = loops.evaluate(boxes), known.evaluate(boxes)
    residual, jacobian, _ = exact_rows(known, points_in(rng, boxes))
    assert holds_balls(enclosed.residual, residual)
    assert holds_balls(enclosed.jacobian, jacobian)
    np.testing.assert_array_equal(enclosed.possible, theirs.possible)


def test_rows_that_divide_by_doubles_are_not_recorded(model):
    """A kind from elsewhere may do so: 1 / 3 would be rounded before any interval is there."""

    class Third(IntervalLoops):
        def at(self, poses):
            (rows, *others), cosines = super().at(poses)
            third = Jet(rows.algebra, rows.value / 3.0, rows.rates, rows.columns)
            return [third, *others], cosines

    known = interval_loops(model, LOOPS["point"])
    assert recorded(known) is not None
    assert recorded(Third(known.tree, known._rows)) is None


@pytest.mark.parametrize(
    ("name", "by_kernel"),
    [(name, True) for name in SERVED] + [(name, False) for name in ("slider_crank", "three_rps")],
)
def test_no_point_is_dropped_whose_rows_are_within_tolerance(name, by_kernel, both, rng):
    """With tolerances so wide that points anywhere count as closed."""
    _, problem = both(name)
    for size in SIZES:
        boxes = random_boxes(rng, problem, 60, size)
        points = points_in(rng, boxes)
        rows = np.abs(problem.loops.residual(Intervals.exact(points)).middle)
        for share in (0.5, 0.9):
            tolerance = np.quantile(rows, share, axis=0) + 1e-12
            closed = (rows < 0.999 * tolerance).all(axis=1)
            closed &= problem.loops.evaluate(Intervals.exact(points)).possible
            problem.loops.tolerance = tolerance
            one = problem.loops
            if by_kernel:
                one = RecordedLoops(recorded(one), one)
            narrowed, cuts = one.narrowed(boxes, problem.scale, 0.6)
            assert (cuts[closed] != DROPPED).all()
            assert narrowed.holds(points)[closed].all()


@pytest.mark.parametrize("name", sorted(set(SERVED) - {"sarrus"}))  # whose modes are not apart
def test_boxes_about_a_mode_get_as_narrow_as_without_the_kernel(name, both, rng):
    """So that combined rows, which no proof depends on, are those that help."""
    loops, problem = both(name)
    proof = pj.prove(loaded(name), SERVED[name], limits=False)
    modes = np.array([one.mode.middle for one in proof.enclosures])
    for size in (1e-4, 1e-3, 1e-2):
        middle = np.repeat(modes, 5, axis=0)
        half = size * problem.scale * rng.uniform(0.5, 1.0, middle.shape)
        off = 0.5 * half * rng.uniform(-1.0, 1.0, middle.shape)
        boxes = Intervals(middle + off - half, middle + off + half)
        ours, cuts = loops.narrowed(boxes, problem.scale, 0.6)
        theirs, _ = problem.loops.narrowed(boxes, problem.scale, 0.6)
        assert (cuts != DROPPED).all()
        assert (ours.width <= 1.01 * theirs.width + 1e-9 * problem.scale).all()


@pytest.mark.parametrize("strange", [np.nan, np.inf])
@pytest.mark.parametrize("name", ["three_rps", "planar_3rpr", "slider_crank"])
def test_a_box_that_is_not_of_numbers_is_kept_and_spoils_no_other(name, strange, both, rng):
    loops, problem = both(name)
    boxes = random_boxes(rng, problem, 40, 0.3)
    some = rng.random(40) < 0.5
    wide = Intervals(boxes.lower.copy(), boxes.upper.copy())
    wide.lower[some] = np.nan if np.isnan(strange) else -strange
    wide.upper[some] = strange
    ours, cuts = loops.narrowed(wide, problem.scale, 0.6)
    assert (cuts[some] != DROPPED).all()
    np.testing.assert_array_equal(ours.lower[some], wide.lower[some])
    np.testing.assert_array_equal(ours.upper[some], wide.upper[some])
    assert loops.evaluate(wide).possible[some].all()
    alone, alone_cuts = loops.narrowed(boxes, problem.scale, 0.6)
    np.testing.assert_array_equal(cuts[~some], alone_cuts[~some])
    kept = ~some & (cuts != DROPPED)
    np.testing.assert_array_equal(ours.lower[kept], alone.lower[kept])


@pytest.mark.parametrize("count", [0, 1, 31, 32, 33, 65])
def test_a_box_is_narrowed_alike_however_many_there_are(count, both, rng):
    loops, problem = both("agile_eye")
    boxes = random_boxes(rng, problem, 65, 0.5)
    whole, cuts = loops.narrowed(boxes, problem.scale, 0.6)
    part, some = loops.narrowed(boxes[:count], problem.scale, 0.6)
    np.testing.assert_array_equal(some, cuts[:count])
    kept = some != DROPPED
    np.testing.assert_array_equal(part.lower[kept], whole.lower[:count][kept])
    np.testing.assert_array_equal(part.upper[kept], whole.upper[:count][kept])


@pytest.mark.parametrize(
    ("name", "motors"),
    [
        ("four_bar", [0.9]),
        ("watt_six_bar", [0.9]),
        ("planar_3rpr", [0.34, 0.34, 0.34]),
        ("three_rps", [3.0, 3.0, 3.0]),
        ("three_rps", [5.0, 1.0, 1.0]),
        ("ankle", [0.0, 0.0]),
        ("bricard", [0.0]),
        pytest.param("agile_eye", [0.0, 0.0, 0.0], marks=pytest.mark.slow),
    ],
)
def test_a_proof_is_the_same_without_the_kernel(name, motors, monkeypatch):
    ours = pj.prove(loaded(name), motors, limits=False)
    monkeypatch.setattr(recorded_loops, "pruning_kernel", lambda: None)
    theirs = pj.prove(pj.load(name), motors, limits=False)
    assert bool(ours) == bool(theirs)
    assert len(ours.enclosures) == len(theirs.enclosures)
    found = [ours.match(one.mode.middle)[0] for one in theirs.enclosures]
    assert sorted(found) == list(range(len(ours.enclosures)))
    assert abs(ours.boxes - theirs.boxes) <= 0.05 * theirs.boxes
