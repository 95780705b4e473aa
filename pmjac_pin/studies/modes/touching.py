"""Boxes of joint values where an angle and the same after a full turn are one."""

from __future__ import annotations

import numpy as np
from scipy.sparse.csgraph import connected_components

from pmjac_pin.algebra.intervals import Intervals, hull
from pmjac_pin.studies.modes.box_domain import FULL_TURN
from pmjac_pin.values.arrays import Array, Mask

_GAP = 1e-9  # scaled, between boxes that are taken together all the same


def together(boxes: Intervals, endless: Mask, scale: Array) -> Intervals:
    """Return the hulls of boxes that touch.

    Parameters
    ----------
    boxes : Intervals, shape (n, k)
    endless : ndarray of bool, shape (k,)
        Which values are the same after a full turn.
    scale : ndarray, shape (k,)
        What counts as 1, rad or m.
    """
    if not len(boxes.lower):
        return boxes
    middle, half = boxes.middle, 0.5 * boxes.width
    differences = middle[:, None] - middle[None]
    turns = np.round(differences / (2.0 * np.pi)) * endless
    apart = np.abs(differences - turns * 2.0 * np.pi)
    touch = (apart <= half[:, None] + half[None] + _GAP * scale).all(axis=2)
    count, label = connected_components(touch, directed=False)
    groups = [boxes[label == index] for index in range(count)]
    return Intervals.stack([hull(moved_near(group, group[0], endless)) for group in groups], 0)


def moved_near(boxes: Intervals, other: Intervals, endless: Mask) -> Intervals:
    """Return boxes (..., k) moved by full turns next to another, those that are there untouched."""
    turns = np.round((other.middle - boxes.middle) / (2.0 * np.pi)) * endless
    moved, there = boxes + Intervals.exact(turns) * FULL_TURN, turns == 0.0
    return Intervals(
        np.where(there, boxes.lower, moved.lower), np.where(there, boxes.upper, moved.upper)
    )
