"""Paths that end early: what the program of many of them says is what `close` says, and why."""

from __future__ import annotations

import numpy as np
import pytest
from mechanisms import loaded
from test_batch import single, targets

import pmjac_pin as pj

FOLDING = ("five_bar", "bricard", "planar_3rpr", "planar_3rrr", "three_rps", "three_rps_ss")
SAME = 1e-8  # of the way: steps on both sides become shorter than can be resolved


@pytest.mark.parametrize(
    ("name", "count"),
    [
        ("five_bar", 50),
        *(pytest.param(name, 300, marks=pytest.mark.slow) for name in FOLDING),
        *(
            pytest.param(name, 60, marks=pytest.mark.slow)
            for name in ("stewart_gough", "stewart_gough_dietmaier")
        ),
    ],
)
def test_where_paths_end(name, count, rng):
    """Nothing that the program settles is walked again, so all of it must be right."""
    mechanism = loaded(name)
    assert mechanism.problem.partition.full
    values = targets(mechanism, count, 0.6, rng)
    start = np.tile(mechanism.home.q, (count, 1))
    q, share, settled = pj.batch(mechanism)._closing.together(start, values)
    assert settled.mean() > 0.95
    assert (share[settled] < 1.0).sum() > 1
    for k in np.flatnonzero(settled).tolist():
        end, expected = single(mechanism, values[k])
        assert (share[k] == 1.0) == (end == 1.0)
        assert share[k] == pytest.approx(end, abs=SAME)
        if end == 1.0:
            size = max(1.0, mechanism.characteristic_length)
            np.testing.assert_allclose(q[k], expected, atol=1e-10 * size)


def test_what_is_not_settled_in_few_steps_is_said_to_be_so(rng):
    mechanism = loaded("five_bar")
    many, values = pj.batch(mechanism), targets(mechanism, 200, 0.6, rng)
    start = np.tile(mechanism.home.q, (200, 1))
    q, share, settled = many._closing.together(start, values)
    early, share_early, settled_early = many._closing.together(start, values, most_steps=5)
    assert 0.05 < settled_early.mean() < 0.95
    np.testing.assert_array_equal(early[settled_early], q[settled_early])
    assert (share_early[~settled_early] <= share[~settled_early] + 1e-12).all()
    assert settled.all()
