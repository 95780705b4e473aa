"""One bad pose among many costs none of the others: what is wrong with it is its status."""

from __future__ import annotations

import numpy as np
import pytest
from mechanisms import loaded, mostly_slow
from test_batch import LONGER, NAMES, machine, targets, turning

import pmjac_pin as pj
from pmjac_pin.batches.few_poses import FewPoses
from pmjac_pin.batches.pieces import PIECE
from pmjac_pin.values.checks import are_doubles

CALLS = ("jacobian", "ellipsoids", "measures")
BAD = (np.nan, np.inf, -np.inf, 1e10)
SOME = list(mostly_slow(NAMES, ("four_bar", "three_rps", "delta")))


def fields_at(found, which):
    return {
        name: array[which] for name, array in vars(found).items() if isinstance(array, np.ndarray)
    }


def equal_at(found, expected, which):
    """To rounding: singular values that are found side by side are refined together."""
    for name, array in fields_at(found, which).items():
        other = fields_at(expected, which)[name]
        size = np.abs(other[np.isfinite(other)]).max(initial=1.0)
        np.testing.assert_allclose(array, other, rtol=1e-13, atol=1e-13 * size)


def nothing_at(found, which, status):
    for name, array in fields_at(found, which).items():
        assert (array == status).all() if name == "status" else np.isnan(array).all()


@pytest.mark.parametrize("name", SOME)
def test_values_that_are_no_numbers(name, rng):
    """As `close`, which raises ArgumentError."""
    mechanism = machine(name)
    many, values = pj.batch(mechanism), targets(mechanism, 12, 0.1, rng)
    expected = many.close(values)
    bad = np.arange(12) % 3 == 1
    spoilt = values.copy()
    spoilt[bad, -1] = BAD
    for given in (spoilt, spoilt.tolist(), dict(zip(mechanism.actuated, spoilt.T, strict=False))):
        if isinstance(given, dict) and len(given) < values.shape[1]:
            continue  # a motor of several degrees of freedom has a column for each
        found = many.close(given)
        equal_at(found, expected, ~bad)
        nothing_at(found, bad, pj.Status.INVALID)
    for value in spoilt[bad]:
        with pytest.raises(pj.ArgumentError):
            mechanism.close(value)
    both = many.measures_at(spoilt)
    equal_at(both[0], expected, ~bad)
    equal_at(both[1], many.measures(expected.q), ~bad)
    nothing_at(both[1], bad, pj.Status.INVALID)


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("name", SOME)
def test_poses_that_are_no_numbers(name, call, rng):
    """Such as cells of a grid that are not reached, and what an interrupt has left."""
    mechanism = machine(name)
    many = pj.batch(mechanism)
    q = many.close(targets(mechanism, 12, 0.1, rng)).q
    expected = getattr(many, call)(q)
    bad = np.arange(12) % 3 == 1
    spoilt = q.copy()
    spoilt[bad, 0] = BAD
    found = getattr(many, call)(spoilt)
    equal_at(found, expected, ~bad)
    nothing_at(found, bad, pj.Status.INVALID)
    for row in spoilt[bad]:
        with pytest.raises(pj.ArgumentError):
            mechanism.configuration(row)


@pytest.mark.parametrize("make", [pj.batch, FewPoses])
def test_guesses_that_are_open_or_none(make, rng):
    mechanism = loaded("five_bar")
    many, values = make(mechanism), targets(mechanism, 9, 0.1, rng)
    guess = np.tile(mechanism.home.q, (9, 1))
    expected = many.close(values, guess=guess)
    guess[2] += 0.1
    guess[5, 1], values[7, 0] = np.nan, np.nan
    found = many.close(values, guess=guess)
    good = ~np.isin(np.arange(9), [2, 5, 7])
    equal_at(found, expected, good)
    nothing_at(found, [2], pj.Status.OPEN)
    nothing_at(found, [5, 7], pj.Status.INVALID)
    with pytest.raises(pj.ClosureError):
        mechanism.close(values[2], guess=mechanism.configuration(guess[2]))


@pytest.mark.parametrize("call", CALLS)
def test_turns_that_are_none(call):
    mechanism = turning()
    many, q = pj.batch(mechanism), np.array([mechanism.close([0.3, 0.4]).q] * 3)
    q[1] *= LONGER
    found = getattr(many, call)(q)
    nothing_at(found, [1], pj.Status.INVALID)
    assert found.status[[0, 2]].tolist() == [0, 0]
    closed = many.close([[0.3, 0.4]] * 3, guess=q)
    nothing_at(closed, [1], pj.Status.INVALID)
    with pytest.raises(pj.ArgumentError, match="not of unit length"):
        mechanism.configuration(q[1])


def test_a_grid_is_measured_where_it_is_reached():
    many = pj.batch(loaded("five_bar"))
    grid = many.grid({"theta1": np.linspace(-3, 3, 9), "theta2": np.linspace(-3, 3, 9)})
    q, reached = grid.q.reshape(-1, 4), grid.status.ravel() == pj.Status.CLOSED
    assert 0 < reached.sum() < reached.size
    found = many.measures(q)
    none = np.isnan(q).any(axis=1)
    nothing_at(found, none, pj.Status.INVALID)
    equal_at(found, many.measures(np.where(none[:, None], many.mechanism.home.q, q)), ~none)


def test_in_pieces_the_start_of_all_stays_the_start_of_all(rng):
    many = pj.batch(loaded("three_rps"))
    values = targets(many.mechanism, PIECE + 500, 0.1, rng)
    expected = many.close(values)
    bad = rng.uniform(size=len(values)) < 0.01
    values[bad] = np.nan
    found = many.close(values, threads=2)
    equal_at(found, expected, ~bad)
    nothing_at(found, bad, pj.Status.INVALID)
    nothing_at(many.close(np.full((5, 3), np.nan)), np.arange(5), pj.Status.INVALID)


def test_rows_with_names_are_not_taken_by_their_order():
    import pandas as pd

    many = pj.batch(loaded("three_rps"))
    table = pd.DataFrame({"l3": [1.05], "l1": [0.95], "l2": [1.0]})
    expected = many.close(table)
    np.testing.assert_allclose(expected.joint("l1"), 0.95)
    for rows in ([row for _, row in table.iterrows()], list(table.itertuples(index=False))):
        with pytest.raises(pj.ArgumentError, match="rows with names"):
            many.close(rows)


def test_numbers_at_odd_addresses_are_copied(rng):
    """C reads doubles where doubles may lie."""
    many = pj.batch(machine("five_bar"))
    values = targets(many.mechanism, 70, 0.1, rng)
    odd = np.ndarray(values.shape, float, b"x" + values.tobytes(), 1)
    assert not odd.flags.aligned
    assert not are_doubles(odd)
    assert many.mechanism.motors.table(odd).flags.aligned
    assert many.mechanism.motors.table(values) is values
    np.testing.assert_array_equal(many.close(odd).q, many.close(values).q)
