"""Where paths of many poses begin: at the pose that is asked for, whoever else asks."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.batches.few_poses import FewPoses
from pmjac_pin.batches.path_starts import PathStarts


@pytest.mark.parametrize("count", [0, 1, 5, 7])
def test_what_another_thread_asks_between_two_steps_changes_nothing(count):
    mechanism = loaded("three_rps")
    starts, other = PathStarts(mechanism), mechanism.pose("lecture_b")
    asked = 0

    def ask(frame, event, argument):
        nonlocal asked
        if frame.f_code is not PathStarts.of.__code__:
            return None
        sys.settrace(None)
        starts.of(other, count)
        asked += 1
        sys.settrace(ask)
        return ask

    before = sys.gettrace()
    for _ in range(3):
        sys.settrace(ask)
        try:
            rows, known = starts.of("home", 5)
        finally:
            sys.settrace(before)
        assert known
        np.testing.assert_array_equal(rows, np.tile(mechanism.home.q, (5, 1)))
    assert asked > 10


@pytest.mark.parametrize("kind", [pj.batch, FewPoses])
def test_what_is_no_guess_is_refused_of_no_targets_too(kind):
    many = kind(loaded("four_bar"))
    with pytest.raises(pj.ArgumentError, match="q must be"):
        many.close(np.empty((0, 1)), guess=None)
