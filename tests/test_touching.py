"""Boxes on a circle: what touches across the full turn's cut is one."""

from __future__ import annotations

import numpy as np
import pytest

from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.studies.modes.touching import moved_near, together

ANGLE_AND_SLIDE = np.array([True, False])


def boxes(*middles, half=1e-3):
    middle = np.array(middles, dtype=float)
    return Intervals(middle - half, middle + half)


@pytest.mark.parametrize(
    ("second", "count"),
    [
        ((-3.0, 0.1), 1),
        ((-3.0 + 2 * np.pi, 0.1), 1),
        ((-3.0 - 4 * np.pi + 1.9e-3, 0.1), 1),
        ((-3.0 + 2 * np.pi, 0.1 + 2 * np.pi), 2),
        ((-3.0 + 2.1e-3, 0.1), 2),
        ((0.14, 0.1), 2),
    ],
)
def test_angles_touch_modulo_a_turn_and_slides_do_not(second, count):
    both = boxes((-3.0, 0.1), second)
    hulls = together(both, ANGLE_AND_SLIDE, np.ones(2))
    assert len(hulls.lower) == count
    for index in (0, 1):
        inside = [
            moved_near(both[index], hull, ANGLE_AND_SLIDE).inside(hull.widened(1e-12)).all()
            for hull in (hulls[k] for k in range(count))
        ]
        assert sum(inside) == 1


def test_chains_of_boxes_are_one():
    chain = boxes(*[(0.0019 * k, 0.0) for k in range(20)])
    assert len(together(chain, ANGLE_AND_SLIDE, np.ones(2)).lower) == 1


def test_nothing_touches_nothing():
    assert together(boxes((0.0, 0.0))[:0], ANGLE_AND_SLIDE, np.ones(2)).shape == (0, 2)


def test_moving_is_rounded_outwards_and_leaves_alone_what_is_there():
    box, other = boxes((1.0, 2.0), half=0.0)[0], boxes((1.0 + 20 * np.pi, 0.0), half=0.0)[0]
    moved = moved_near(box, other, ANGLE_AND_SLIDE)
    assert moved.lower[0] < 1.0 + 20 * np.pi < moved.upper[0]
    assert moved.width[0] < 1e-12
    assert (moved.lower[1], moved.upper[1]) == (2.0, 2.0)
