"""The recorded kinematics of every mechanism is what Pinocchio computes."""

from __future__ import annotations

import numpy as np
import pytest

import pmjac_pin as pj
from pmjac_pin.algebra.programs import Term
from pmjac_pin.kinematics.loops import Loops
from pmjac_pin.kinematics.recorded import record
from pmjac_pin.kinematics.tree import Tree
from test_one_kinematics import run


def recorded(mechanism):
    model, spec = mechanism.model, mechanism.spec
    loops = Loops(model, Tree(model), spec.loops, mechanism.parameters)
    return record(model, loops, spec.tool)


def at(kinematics, q):
    values = run(kinematics.recording, q)

    def number(entries):
        known = [values[x.index] if isinstance(x, Term) else x for x in entries.ravel().tolist()]
        return np.array(known, dtype=float).reshape(entries.shape)

    return number


@pytest.mark.parametrize("name", pj.list_mechanisms())
def test_the_program_is_pinocchio(name, rng):
    mechanism = pj.load(name)
    kinematics = recorded(mechanism)
    import pinocchio as pin
    for size in (0.0, 0.05):
        q = pin.integrate(mechanism.model, mechanism.home.q, size * rng.normal(size=mechanism.model.nv))
        number = at(kinematics, q)
        residual, rates = mechanism.kinematics.closure(q)
        snapshot = mechanism.kinematics.snapshot(q)
        length = mechanism.characteristic_length
        np.testing.assert_allclose(number(kinematics.tool), snapshot.tool_jacobian, atol=1e-12 * length)
        np.testing.assert_allclose(number(kinematics.position), snapshot.position, atol=1e-12 * length)
        np.testing.assert_allclose(number(kinematics.rotation), snapshot.rotation, atol=1e-12)
        print(name, len(kinematics.recording.terms), np.abs(number(kinematics.residual)-residual).max(initial=0), np.abs(number(kinematics.rates)-rates).max(initial=0))
