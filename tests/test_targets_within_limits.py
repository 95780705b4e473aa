"""Targets are looked at before anything is walked: by the kernel, or where it cannot by NumPy."""

from __future__ import annotations

import warnings

import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded
from test_batch import in_a_row, targets, turning

import pmjac_pin as pj
from pmjac_pin.batches.few_poses import FewPoses
from pmjac_pin.batches.pieces import PIECE
from pmjac_pin.closing import paths_in_lanes
from pmjac_pin.model.coordinates import LIMIT_SLACK

NARROW, WIDE = 0.5, 1.5  # rad


def without_kernel(mechanism):
    many = pj.batch(mechanism)
    object.__setattr__(many._closing, "lanes", None)
    return many


@pytest.mark.parametrize("kind", [pj.batch, without_kernel, FewPoses])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_each_motor_has_limits_of_its_own(kind, sign):
    """Whichever row is beyond, at a limit or one of rounding beyond what is taken for it."""
    many = kind(in_a_row(pin.JointModelRZ(), np.array([NARROW, WIDE])))
    between = 0.5 * (NARROW + WIDE)
    for row, (values, status) in enumerate(
        [
            ((NARROW, WIDE), pj.Status.CLOSED),
            ((0.0, between), pj.Status.CLOSED),
            ((between, 0.0), pj.Status.LIMITS),
            ((NARROW + 2 * LIMIT_SLACK, 0.0), pj.Status.LIMITS),
            ((0.0, WIDE + 2 * LIMIT_SLACK), pj.Status.LIMITS),
            ((NARROW + 0.5 * LIMIT_SLACK, 0.0), pj.Status.CLOSED),
            ((0.0, np.nan), pj.Status.INVALID),
            ((-np.inf, 0.0), pj.Status.INVALID),
        ]
    ):
        given, expected = np.zeros((9, 2)), np.full(9, pj.Status.CLOSED)
        given[row], expected[row] = sign * np.array(values), status
        poses = many.close(given)
        np.testing.assert_array_equal(poses.status, expected)
        together, found = many.ellipsoids_at(given)
        np.testing.assert_array_equal(together.status, expected)
        np.testing.assert_array_equal(together.q, poses.q)
        has_pose = ~np.isnan(poses.q).any(axis=1)
        np.testing.assert_array_equal(np.isfinite(found.J_eq).all(axis=(1, 2)), has_pose)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e10])
def test_ways_are_not_made_of_what_is_no_number(bad):
    """Of a motor whose values are no entries of q; and without a warning."""
    many = pj.batch(turning())
    given = np.full((5, 2), 0.1)
    given[2, 0] = bad
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        poses, found = many.ellipsoids_at(given)
        alone = many.close(given)
    np.testing.assert_array_equal(poses.status == pj.Status.INVALID, np.arange(5) == 2)
    np.testing.assert_array_equal(poses.q, alone.q)
    np.testing.assert_array_equal(found.status, poses.status)


@pytest.mark.parametrize("count", [12, PIECE + 100])
def test_what_is_refused_leaves_no_trace(count, rng):
    """In the pieces beside it, in calls behind it, and in results that are filled again."""
    many = pj.batch(loaded("five_bar"))
    values = targets(many.mechanism, count, 0.1, rng)
    expected, of_them = many.ellipsoids_at(values)
    spoilt = values.copy()
    spoilt[-1, 0] = 100.0
    out = many.ellipsoids_at(spoilt)
    for one, right in zip(out, (expected, of_them), strict=True):
        for name, array in vars(right).items():
            if isinstance(array, np.ndarray):
                np.testing.assert_allclose(getattr(one, name)[:-1], array[:-1], atol=1e-13)
    assert out[0].status[-1] != pj.Status.CLOSED
    many.ellipsoids_at(values, out=out)
    np.testing.assert_array_equal(out[0].q, expected.q)
    np.testing.assert_array_equal(out[1].J_eq, of_them.J_eq)


@pytest.mark.parametrize("bad", [0.0, 100.0, np.nan])
def test_each_call_leaves_its_memory_to_others(bad, monkeypatch, rng):
    """Where all arrive, where some do not, and where none sets out."""
    many = pj.batch(loaded("five_bar"))
    if many._closing.lanes is None:
        pytest.skip("no kernel was built")
    made = []

    class Counted(paths_in_lanes.KernelWalk):
        def __init__(self, *given, **options):
            made.append(self)
            super().__init__(*given, **options)

    monkeypatch.setattr(paths_in_lanes, "KernelWalk", Counted)
    values = targets(many.mechanism, 5, 0.1, rng)
    values[1] += bad
    for _ in range(5):
        many.close(values, threads=1)
        many.ellipsoids_at(values, threads=1)
        many.close(values, np.tile(many.mechanism.home.q, (5, 1)), threads=1)
    assert len(made) == 1
