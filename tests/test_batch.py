"""Many poses at once are what the single calls say: the same poses, J_eq, and where paths end."""

from __future__ import annotations

import numpy as np
import pytest
from random_machines import random_machine

import pmjac_pin as pj

NAMES = pj.list_mechanisms()
RANDOM = [
    pytest.param(f"random {seed}", marks=[pytest.mark.slow] if seed >= 5 else [])
    for seed in range(20)
]


def machine(name):
    return random_machine(int(name.split()[1])) if name.startswith("random ") else pj.load(name)


def targets(mechanism, count, share, rng):
    slides = np.array([mechanism.units[name] == "m" for name in mechanism.actuated])
    size = np.where(slides, mechanism.characteristic_length, 1.0)
    return mechanism.home.actuated + share * size * rng.uniform(-1, 1, (count, size.size))


def single(mechanism, values):
    try:
        pose = mechanism.close(values, enforce_limits=False)
    except pj.ClosureError as error:
        return error.share, error.reached.q
    return 1.0, pose.q


@pytest.mark.parametrize("share", [0.03, 0.6])
@pytest.mark.parametrize("name", [*NAMES, *RANDOM])
def test_the_same_as_one_by_one(name, share, rng):
    mechanism = machine(name)
    many = pj.batch(mechanism)
    values = targets(mechanism, 12, share, rng)
    poses = many.close(values, enforce_limits=False)
    jacobians = many.jacobian(poses.q)
    length = mechanism.characteristic_length
    for k, (end, q) in enumerate(single(mechanism, one) for one in values):
        assert poses.share[k] == pytest.approx(end, abs=1e-6)
        assert (poses.status[k] == pj.Status.CLOSED) == (end == 1.0)
        if end < 1.0:
            continue
        np.testing.assert_allclose(poses.q[k], q, atol=1e-10 * max(1.0, length))
        try:
            J_eq = mechanism.configuration(poses.q[k]).jacobian().J_eq
        except pj.SingularError:
            assert jacobians.status[k] == pj.Status.SINGULAR
            continue
        except pj.NoJacobianError:
            assert jacobians.status[k] == pj.Status.NO_JACOBIAN
            continue
        assert jacobians.status[k] == pj.Status.CLOSED
        condition = mechanism.configuration(poses.q[k]).singularity().condition
        np.testing.assert_allclose(
            jacobians.J_eq[k], J_eq, atol=1e-13 * condition * np.abs(J_eq).max()
        )
