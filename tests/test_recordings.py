"""Programs of siblings, their constants bound anew, are what recording them afresh gives."""

from __future__ import annotations

from dataclasses import replace

import mechanisms
import numpy as np
import pytest

import pmjac_pin as pj
from pmjac_pin.algebra.programs import largest, root
from pmjac_pin.algebra.recordings import Recordings
from pmjac_pin.algebra.tape import Tape, _Writer
from pmjac_pin.algebra.tape_runner import run
from pmjac_pin.algebra.terms import Recording

QUICK = ("four_bar", "slider_crank")
WITH_PARAMETERS = [
    pytest.param(name, marks=() if name in QUICK else pytest.mark.slow)
    for name in mechanisms.CATALOGUE
    if pj.load(name).spec.parameters and name != "bennett"  # its lengths are tied
]


def tapes(recorded):
    jacobians = [recorded.jacobian(frame) for frame in ("LOCAL", "WORLD")]
    return [*recorded.walking, recorded.measures, *jacobians, recorded.rates.pose_tape()]


def assert_same_programs(mechanism, rng):
    alone = replace(mechanism, blueprint=None, _poses={})
    for one, fresh in zip(tapes(mechanism.recorded), tapes(alone.recorded), strict=True):
        assert not one.constants.flags.writeable
        inputs = rng.normal(size=(fresh.inputs, 5))
        with np.errstate(all="ignore"):
            np.testing.assert_array_equal(run(one, inputs), run(fresh, inputs))


@pytest.mark.parametrize("name", WITH_PARAMETERS)
def test_siblings(name, rng):
    """Those at the defaults, where many lengths are equal, among others."""
    mechanism = pj.load(name)
    parameters = mechanism.spec.parameters
    designs = [
        {key: one.default * (1.0 + 0.02 * rng.uniform(-1, 1)) for key, one in parameters.items()}
        for _ in range(3)
    ]
    for values in (*designs, {}, designs[0]):
        assert_same_programs(mechanism.with_parameters(values), rng)
    known = mechanism.blueprint.recordings._known
    assert all(known.values())


@pytest.mark.slow
def test_a_structure_that_changes(rng):
    """Platforms that are flat, and not."""
    mechanism = pj.load("stewart_gough")
    for height in (0.0, 0.01, 0.02, 0.0, 0.0, 0.03):
        assert_same_programs(mechanism.with_parameters(p4z=height, b5z=-height), rng)


def test_the_third_sibling_is_not_recorded(monkeypatch):
    mechanism = pj.load("slider_crank")

    def sibling(share):
        values = {key: share * value + 0.01 for key, value in mechanism.parameters.items()}
        return mechanism.with_parameters(values)

    first, second, third = map(sibling, (1.0, 1.01, 1.02))
    tapes(first.recorded)
    kept = tapes(second.recorded)
    monkeypatch.setattr(Recording, "term", None)
    for one, other in zip(tapes(third.recorded), kept, strict=True):
        assert one.code is other.code


@pytest.fixture
def planned(monkeypatch):
    """The programs that are planned from here on."""
    programs = []

    def plan(writer, write=_Writer.tape):
        programs.append(writer)
        return write(writer)

    monkeypatch.setattr(_Writer, "tape", plan)
    return programs


def scanned(mechanism, rng):
    """Ten designs."""
    for _ in range(10):
        shares = 1.0 + 0.05 * rng.uniform(-1, 1, len(mechanism.parameters))
        sizes = np.array([*mechanism.parameters.values()]) * shares
        yield mechanism.with_parameters(
            dict(zip(mechanism.parameters, sizes.tolist(), strict=True))
        )


@pytest.mark.parametrize("name", WITH_PARAMETERS)
def test_a_scan_plans_its_programs_once(name, rng, planned):
    """At first one that is forgotten, then one that is kept; but for two numbers that may meet."""
    programs = [tapes(design.recorded) for design in scanned(pj.load(name), rng)]
    assert len(planned) <= 2 * len(programs[0]) + 2


@pytest.mark.parametrize("name", ["four_bar", pytest.param("delta", marks=pytest.mark.slow)])
def test_batches_of_a_scan_plan_once(name, rng, planned):
    """Moves, arrivals, legs and measures."""
    for design in scanned(pj.load(name), rng):
        targets = design.home.actuated + rng.uniform(-0.05, 0.05, (20, design.mobility))
        many = pj.batch(design)
        many.measures(many.close(targets).q)
    assert len(planned) <= 2 * 4 + 2


def test_results_of_siblings(rng):
    """What a batch and what single calls say of a sibling does not depend on what came before."""
    mechanism = pj.load("three_rps")
    for share in (0.98, 1.01, 1.02):
        values = {key: share * value for key, value in mechanism.parameters.items()}
        one, other = mechanism.with_parameters(values), pj.load("three_rps", values)
        targets = one.home.actuated + rng.uniform(-0.1, 0.1, (20, 3))
        mine, theirs = (pj.batch(machine).close(targets) for machine in (one, other))
        np.testing.assert_array_equal(mine.q, theirs.q)
        np.testing.assert_array_equal(one.close(targets[0]).q, other.close(targets[0]).q)


# --- programs by hand --------------------------------------------------------------------------


def test_a_recording_is_free_at_once():
    """Its terms know it, and it knows them: the next one's memory would be taken beside theirs."""
    seen = []

    def make(inputs):
        term = inputs[0] * 2.0
        seen.append(term.recording)
        return [term]

    tape = Recordings().tape("it", 1, make)
    assert run(tape, np.array([[3.0]])).item() == 6.0
    assert not seen[0].terms


def check(*makes, inputs=2, bound=True):
    """Record these programs one after another, and compare each with what is recorded afresh."""
    recordings, rng = Recordings(), np.random.default_rng(0)
    codes = []
    for make in makes:
        tape, recording = recordings.tape("it", inputs, make), Recording(inputs)
        fresh = Tape.of(recording, make(recording.inputs))
        values = rng.normal(size=(inputs, 7))
        with np.errstate(all="ignore"):
            np.testing.assert_array_equal(run(tape, values), run(fresh, values))
        codes.append(tape.code)
    assert (codes[-1] is codes[1]) == bound


def line(a, b):
    return lambda x: [a * x[0] + b * x[1]]


def test_constants():
    check(line(2.0, 3.0), line(2.0, 3.0), line(4.0, 5.0), line(-4.0, 5.0), bound=False)
    check(line(2.0, 3.0), line(2.0, 3.0), line(4.0, 5.0), line(7.0, 0.5))


def test_constants_that_were_equal():
    check(line(2.0, 2.0), line(2.0, 2.0), line(4.0, 5.0), bound=False)


def test_constants_that_become_equal():
    check(line(2.0, 3.0), line(2.0, 3.0), line(4.0, 4.0))


@pytest.mark.parametrize("special", [0.0, 1.0, -1.0, -3.0])
def test_constants_that_are_no_operation(special):
    check(line(2.0, 3.0), line(2.0, 3.0), line(special, 3.0), bound=False)
    check(line(special, 3.0), line(special, 3.0), line(2.0, 3.0), bound=False)


def test_terms_that_were_one():
    def twice(a, b):
        return lambda x: [root(a * x[0]), root(b * x[0]) + x[1]]

    check(twice(2.0, 2.0), twice(2.0, 2.0), twice(2.0, 3.0), bound=False)
    check(twice(2.0, 2.0), twice(2.0, 2.0), twice(3.0, 3.0))


def test_a_difference_that_is_turned_round():
    """What is made of a term's operands is made of those of now."""

    def turned(a):
        return lambda x: [-(x[0] - a), (a - x[0]) * x[1]]

    check(turned(2.0), turned(2.0), turned(3.0), turned(4.0))


def test_outputs():
    def shown(a, b, *more):
        return lambda x: [a, x[0] * b, a, *more]

    check(shown(2.0, 3.0), shown(2.0, 3.0), shown(4.0, 5.0), shown(6.0, 6.0))
    check(shown(2.0, 3.0), shown(2.0, 3.0), shown(2.0, 3.0, 1.0), bound=False)
    check(lambda x: [x[0], 1.0], lambda x: [x[0], 1.0], lambda x: [x[1], 1.0], bound=False)
    check(lambda x: [x[0], 1.0], lambda x: [x[0], 1.0], lambda x: [x[0], x[1]], bound=False)
    check(lambda x: [x[0], x[1]], lambda x: [x[0], x[1]], lambda x: [x[0], 2.0], bound=False)


def test_what_takes_another_way():
    def larger(a, b):
        return lambda x: [largest(x[0], a) if a < b else x[1] * a, x[0] + b]

    check(larger(1.5, 2.5), larger(1.5, 2.5), larger(3.5, 2.5), bound=False)
    check(larger(1.5, 2.5), larger(1.5, 2.5), larger(1.25, 2.5))


def test_what_differs_within_an_array():
    """Where NumPy multiplies terms, nothing can be raised."""

    def product(*numbers):
        def make(x):
            terms = np.array(list(x), dtype=object)
            return [np.array(numbers, dtype=object).dot(terms), *(np.diag(numbers) @ terms)]

        return make

    check(product(2.0, 2.0), product(2.0, 2.0), product(3.0, 4.0), product(5.0, 6.0), bound=False)
    check(product(2.0, 3.0), product(2.0, 3.0), product(0.0, 4.0), product(5.0, 6.0), bound=False)


def test_more_inputs():
    recordings = Recordings()
    for inputs in (2, 2, 3):
        recordings.tape(f"of {inputs}", inputs, lambda x: [x[-1] * 2.0])
    assert recordings.tape("of 3", 3, lambda x: [x[-1] * 2.0]).inputs == 3
