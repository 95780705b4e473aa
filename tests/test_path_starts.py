"""Where paths of many poses begin: at the pose that is asked for, whoever else asks."""

from __future__ import annotations

import pickle
import sys

import numpy as np
import pytest
from mechanisms import loaded
from test_batch import targets

import pmjac_pin as pj
from pmjac_pin.batches.few_poses import FewPoses
from pmjac_pin.batches.paths_request import PathsRequests

KINDS = [pj.batch, FewPoses]
LAST = 24  # of the steps between which another thread asks


def beyond_limits(many, rng):
    """Targets of which one is beyond the motors' limits, and one is no number."""
    values = targets(many.mechanism, 5, 0.02, rng)
    values[1], values[3] = 5.0, np.nan
    return values


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("call", ["close", "ellipsoids_at"])
def test_what_another_thread_asks_between_two_steps_changes_nothing(kind, call, rng):
    """Of another start, as many poses or not, within limits or not: what was asked is kept."""
    many = kind(loaded("three_rps"))
    values, of = beyond_limits(many, rng), getattr(many, call)
    other, asked = many.mechanism.pose("lecture_b"), 0
    others = [(values, other, True), (values[:3], "home", True), (values, "home", False)]

    def ask(frame, event, argument):
        nonlocal asked
        if frame.f_code is not PathsRequests.of.__code__ or asked > LAST:
            return None
        sys.settrace(None)
        given, guess, limits = others[asked % len(others)]
        of(given, guess, enforce_limits=limits)
        asked += 1
        sys.settrace(ask)
        return ask

    expected, before = arrays(of(values)), sys.gettrace()
    for _ in range(2):
        sys.settrace(ask)
        try:
            found = of(values)
        finally:
            sys.settrace(before)
        compare(arrays(found), expected)
    assert asked > 10


def compare(found, expected):
    """To rounding: single calls are made by programs where there have been some."""
    for one, same in zip(found, expected, strict=True):
        np.testing.assert_allclose(one, same, rtol=1e-9, atol=1e-12)


def arrays(found):
    """Those of one result, or of both."""
    results = found if isinstance(found, tuple) else (found,)
    return [array for one in results for array in vars(one).values() if hasattr(array, "shape")]


ASKED = (
    ("home", True, 5), ("home", True, 5), ("lecture_b", True, 5), ("home", True, 5),
    ("home", False, 5), ("home", True, 5), ("home", "all", 5), ("home", False, 5),
    ("home", True, 3), ("home", True, 5), ("each", True, 5), ("lecture_b", True, 5),
    ("lecture_b", False, 5),
)  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("by_name", [True, False])
@pytest.mark.parametrize("call", ["close", "ellipsoids_at", "measures_at"])
def test_what_was_asked_before_changes_nothing(kind, by_name, call, rng):
    """One of start, limits and count is another one than before, or none."""
    mechanism = loaded("three_rps")
    many, alone = kind(mechanism), {}
    values = beyond_limits(many, rng)
    for guess, limits, count in ASKED:
        start = guess if by_name else mechanism.pose("home" if guess == "each" else guess)
        if guess == "each":
            start = np.tile(mechanism.home.q, (count, 1))
        given, how = (values[:count], start), {"enforce_limits": limits}
        if (guess, limits, count) not in alone:
            expected = arrays(getattr(kind(mechanism), call)(*given, **how))
            alone[guess, limits, count] = expected
        compare(arrays(getattr(many, call)(*given, **how)), alone[guess, limits, count])
    statuses = [told[2].tolist() for told in (alone["home", True, 5], alone["home", False, 5])]
    assert statuses[0] != statuses[1]


@pytest.mark.parametrize("kind", KINDS)
def test_a_guess_that_has_been_written_to_is_another_one(kind, rng):
    mechanism = loaded("four_bar")
    many, values = kind(mechanism), targets(mechanism, 4, 0.1, rng)
    guess = np.tile(mechanism.home.q, (4, 1))
    first = many.ellipsoids_at(values, guess)[0]
    guess[2, 0] += 0.5  # open
    assert (first.status == pj.Status.CLOSED).all()
    again = many.ellipsoids_at(values, guess)[0]
    np.testing.assert_array_equal(again.status == pj.Status.OPEN, np.arange(4) == 2)


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_no_guess_is_refused_of_no_targets_too(kind):
    many = kind(loaded("four_bar"))
    with pytest.raises(pj.ArgumentError, match="q must be"):
        many.close(np.empty((0, 1)), guess=None)


def test_few_poses_survive_pickling_whatever_was_asked_of_them(rng):
    few = FewPoses(loaded("four_bar"))
    values = targets(few.mechanism, 3, 0.1, rng)
    expected, measures = few.measures_at(values)
    few.close(values)
    few.ellipsoids_at(values)
    again = pickle.loads(pickle.dumps(few))
    poses, found = again.measures_at(values)
    np.testing.assert_array_equal(poses.q, expected.q)
    np.testing.assert_array_equal(found.smallest, measures.smallest)
