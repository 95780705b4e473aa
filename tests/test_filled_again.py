"""Results that are filled again: the same numbers in the same memory, or refused with a reason."""

from __future__ import annotations

import copy
import pickle
from dataclasses import fields

import numpy as np
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.batches.pieces import PIECE, pieces_of

CALLS = ("jacobian", "ellipsoids", "measures")


def targets(mechanism, count, rng):
    return mechanism.home.actuated + rng.uniform(-0.1, 0.1, (count, len(mechanism.actuated)))


def equal(found, expected):
    for one in fields(expected):
        array = getattr(found, one.name)
        np.testing.assert_array_equal(array, getattr(expected, one.name))
        assert not array.flags.writeable


@pytest.mark.parametrize("count", [0, 1, 100, PIECE + 100])
@pytest.mark.parametrize("name", ["five_bar", "three_rps"])
def test_the_same_in_the_same_memory(name, count, rng):
    many = pj.batch(loaded(name))
    first, then = (targets(many.mechanism, count, rng) for _ in range(2))
    poses, expected = many.close(first), many.close(then)
    q = poses.q
    assert many.close(then, out=poses) is poses
    equal(poses, expected)
    np.testing.assert_array_equal(q, expected.q)
    np.testing.assert_array_equal(poses.beyond_limits, expected.beyond_limits)
    for call in CALLS:
        of = getattr(many, call)
        found, expected = of(many.close(first).q), of(poses.q)
        memory = found.J_eq
        assert of(poses.q, out=found) is found
        equal(found, expected)
        assert not count or np.shares_memory(found.J_eq, memory)


def test_limits_and_joints_are_those_of_the_machine_that_fills(rng):
    """Poses of one machine, filled by another with as many entries of q."""
    one, other = pj.batch(loaded("four_bar")), pj.batch(loaded("slider_crank"))
    poses = one.close(targets(one.mechanism, 20, rng))
    assert not poses.beyond_limits.all()
    expected = other.close(targets(other.mechanism, 20, rng))
    found = other.close(expected.joint(other.mechanism.actuated[0])[:, None], out=poses)
    for name in other.mechanism.passive:
        np.testing.assert_allclose(found.joint(name), expected.joint(name), atol=1e-12)
    with pytest.raises(pj.UnknownNameError):
        found.joint("phi1")


WRONG = {
    "another count": lambda many, poses: many.close(np.zeros((7, 2)) + poses.q[0, 0]),
    "another kind": lambda many, poses: many.jacobian(poses.q),
    "no result": lambda many, poses: poses.q,
    "by hand": lambda many, poses: pj.ManyClosed(poses.q, poses.share, poses.status),
    "copied": lambda many, poses: copy.deepcopy(poses),
    "unpickled": lambda many, poses: pickle.loads(pickle.dumps(poses)),
}


@pytest.mark.parametrize("how", WRONG)
def test_what_cannot_be_filled_is_refused(how, rng):
    many = pj.batch(loaded("five_bar"))
    values = targets(many.mechanism, 20, rng)
    out = WRONG[how](many, many.close(values))
    with pytest.raises(pj.ArgumentError, match="`out`"):
        many.close(values, out=out)


def test_what_is_read_is_not_written_over(rng):
    many = pj.batch(loaded("five_bar"))
    values = targets(many.mechanism, 20, rng)
    poses = many.close(values)
    with pytest.raises(pj.ArgumentError, match="written over while it is read"):
        many.close(values + 0.01, guess=poses.q, out=poses)
    with pytest.raises(pj.ArgumentError, match="written over while it is read"):
        many.close(poses.q[:, :2], out=poses)  # a view
    expected = many.close(values + 0.01, guess=poses.q)
    equal(many.close(values + 0.01, guess=poses.q.copy(), out=poses), expected)


def test_where_something_is_raised_what_is_not_done_says_so(rng):
    many = pj.batch(loaded("five_bar"))
    poses = many.close(targets(many.mechanism, 3 * PIECE, rng))
    found, done = many.ellipsoids(poses.q), pieces_of(len(poses.q))[0].stop

    def fail(done, count):
        raise RuntimeError("no more")

    with pytest.raises(RuntimeError, match="no more"):
        many.ellipsoids(poses.q, threads=1, progress=fail, out=found)
    assert (found.status[done:] == pj.Status.NOT_DONE).all()
    assert np.isnan(found.J_eq[done:]).all()
    assert (found.status[:done] == pj.Status.CLOSED).all()


def test_what_is_being_filled_is_no_other_calls(rng):
    """Two calls at once would leave poses of both, all of them CLOSED."""
    many = pj.batch(loaded("five_bar"))
    first, then = (targets(many.mechanism, 2 * PIECE, rng) for _ in range(2))
    poses, expected = many.close(then), many.close(first)
    refused = []

    def meanwhile(done, count):
        with pytest.raises(pj.ArgumentError, match="is being filled by another call"):
            many.close(then, out=poses)
        refused.append(done)

    equal(many.close(first, out=poses, threads=1, progress=meanwhile), expected)
    assert refused
    equal(many.close(then, out=poses), many.close(then))
