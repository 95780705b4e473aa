"""Grids walked from neighbour to neighbour: each pose is what `close` says from there."""

from __future__ import annotations

import numpy as np
import pytest
from mechanisms import loaded

import pmjac_pin as pj


def check(mechanism, found, guess):
    """Every cell that is closed is where the single call leads from its source."""
    shape = found.status.shape
    for cell in np.ndindex(shape):
        if found.status[cell] != pj.Status.CLOSED:
            continue
        source, start = found.source[cell], guess
        if source >= 0:
            place = np.unravel_index(source, shape)
            assert found.status[place] == pj.Status.CLOSED
            assert np.abs(np.subtract(place, cell)).sum() == 1
            start = mechanism.configuration(found.q[place])
        expected = mechanism.close(found.actuated[cell], start)
        np.testing.assert_allclose(found.q[cell], expected.q, atol=1e-8)


@pytest.mark.parametrize(
    ("name", "over"),
    [
        ("five_bar", {"theta1": np.linspace(0.3, 2.6, 6), "theta2": np.linspace(0.5, 2.9, 5)}),
        (
            "three_rps",
            {"l3": np.linspace(0.8, 1.2, 4), "l1": [1.0], "l2": np.linspace(0.9, 1.1, 3)},
        ),
        ("four_bar", {"theta1": np.linspace(-3.0, 3.0, 40)}),
    ],
)
def test_each_cell_is_closed_from_the_one_beside_it(name, over):
    mechanism = loaded(name)
    found = pj.batch(mechanism).grid(over)
    assert found.status.shape == tuple(len(axis) for axis in over.values())
    for axis, (motor, values) in enumerate(over.items()):
        column = mechanism.actuated.index(motor)
        moved = np.moveaxis(found.actuated[..., column], axis, -1)
        np.testing.assert_array_equal(moved, np.broadcast_to(values, moved.shape))
    assert (found.status == pj.Status.CLOSED).sum() > found.status.size / 2
    assert (found.source == -1).sum() >= 1
    check(mechanism, found, mechanism.home)


def test_a_fold_between_cells_stops_it_and_is_walked_around():
    """A five-bar whose arms stretch: no cell beyond is reached but by poses that are closed."""
    mechanism = loaded("five_bar")
    axis = np.linspace(-3.0, 3.0, 21)
    found = pj.batch(mechanism).grid({"theta1": axis, "theta2": axis}, enforce_limits=False)
    closed = found.status == pj.Status.CLOSED
    assert 0.1 < closed.mean() < 0.95
    # Cells that the straight path does not reach, and a way around does.
    straight = (
        pj.batch(mechanism)
        .close(found.actuated.reshape(-1, 2), enforce_limits=False)
        .status.reshape(closed.shape)
    )
    assert not (closed < (straight == pj.Status.CLOSED)).any()
    assert (closed > (straight == pj.Status.CLOSED)).any()
    # All closed neighbours are one family: between them nothing folds.
    values = {cell: found.q[cell] for cell in zip(*np.nonzero(closed), strict=True)}
    for cell, q in list(values.items())[::7]:
        beside = (cell[0] + 1, cell[1])
        if beside in values:
            try:
                there = mechanism.close(found.actuated[beside], mechanism.configuration(q))
            except pj.ClosureError:
                continue
            np.testing.assert_allclose(there.q, values[beside], atol=1e-7)


def test_limits_are_not_walked_through():
    mechanism = loaded("three_rps")
    lower, _ = mechanism.coordinates.limits("l1")
    axis = np.linspace(lower - 0.2, lower + 0.3, 6)
    found = pj.batch(mechanism).grid({"l1": axis})
    np.testing.assert_array_equal(found.status == pj.Status.LIMITS, axis < lower)


def test_where_no_cell_is_reached():
    mechanism = loaded("three_rps")
    found = pj.batch(mechanism).grid({"l1": np.linspace(5.0, 9.0, 70)}, enforce_limits=False)
    assert (found.status == pj.Status.STOPPED).all()
    assert (found.source == -1).all()
    assert (found.share < 1.0).all()


@pytest.mark.parametrize(
    ("over", "guess", "message"),
    [
        ({}, "home", "`over` is a mapping of names to values"),
        ([1.0], "home", "`over` is a mapping of names to values"),
        ({"l9": [1.0]}, "home", "unknown motor 'l9'"),
        ({"l1": 1.0}, "home", "a list of values for 'l1' expected"),
        ({"l1": []}, "home", "a list of values for 'l1' expected"),
        ({"l1": ["a"]}, "home", "the values of 'l1' must be real numbers"),
        ({"l1": [1.0]}, "nowhere", "unknown pose 'nowhere'"),
        ({"l1": [1.0]}, 3, "`guess` is a pose's name or a Configuration"),
    ],
)
def test_what_is_refused(over, guess, message):
    with pytest.raises(pj.PmjacError, match=message):
        pj.batch(loaded("three_rps")).grid(over, guess)


def test_progress_tells_of_all_cells_in_the_end():
    many, told = pj.batch(loaded("five_bar")), []
    axis = np.linspace(-3.0, 3.0, 15)
    found = many.grid({"theta1": axis, "theta2": axis}, progress=lambda *given: told.append(given))
    done = [cells for cells, _ in told]
    assert done == sorted(done)
    assert told[-1] == (225, 225)
    assert 0 < done[0] < 225
    reached = found.status == pj.Status.CLOSED
    np.testing.assert_array_equal(many.grid({"theta1": axis, "theta2": axis}).status, found.status)
    assert 0 < reached.sum() < 225
    with pytest.raises(pj.ArgumentError, match="progress is something to be called"):
        many.grid({"theta1": axis}, progress=1)


def test_an_interrupt_by_progress_keeps_what_is_known():
    many = pj.batch(loaded("five_bar"))

    def stop(done, count):
        raise KeyboardInterrupt

    axis = np.linspace(-3.0, 3.0, 15)
    with pytest.raises(pj.Interrupted, match="of 225 cells") as raised:
        many.grid({"theta1": axis, "theta2": axis}, progress=stop)
    assert (raised.value.done.status == pj.Status.NOT_DONE).any()
