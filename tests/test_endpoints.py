"""Proofs of complex solutions: of those that are there, and of no others."""

from __future__ import annotations

import numpy as np
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.studies.homotopy.endpoints import proven
from pmjac_pin.studies.homotopy.machines import Machines


def four_bar(theta):
    """The equations, the motor's numbers, and both solutions."""
    machines = Machines(loaded("four_bar"))
    _, form = machines.at([theta])
    modes = pj.assembly_modes(machines.mechanism, [theta], rng=0)
    x = machines.loops.unknowns(np.array([mode.q for mode in modes]))
    return machines.loops, form.driven, x


@pytest.mark.parametrize("theta", [0.9, -2.0])
def test_real_solutions_are_proven(theta):
    loops, driven, x = four_bar(theta)
    np.testing.assert_array_equal(proven(loops, driven, x), [True, True])


def test_what_is_no_solution_is_not_proven():
    """A box about a point further away than the box is wide holds no solution."""
    loops, driven, x = four_bar(0.9)
    assert not proven(loops, driven, x + 0.05).any()


def test_one_solution_does_not_count_twice():
    loops, driven, x = four_bar(0.9)
    np.testing.assert_array_equal(proven(loops, driven, np.vstack([x, x[:1]])), [True, True, False])


def test_what_is_not_proven_spoils_no_other():
    loops, driven, x = four_bar(0.9)
    beside = np.vstack([x[:1] + 0.05, x])
    np.testing.assert_array_equal(proven(loops, driven, beside), [False, True, True])
    np.testing.assert_array_equal(proven(loops, driven, beside[::-1]), [True, True, False])


def test_a_real_solution_is_not_proven_complex():
    """With an imaginary part of rounding it is neither proven real nor proven not to be."""
    loops, driven, x = four_bar(0.9)
    assert not proven(loops, driven, x + 1e-13j).any()


def test_a_double_solution_is_not_proven():
    """Coupler and rocker in line: the two modes meet there, and K* is singular."""
    machines = Machines(pj.load("four_bar", {"l0": 4.0, "l1": 1.0, "l2": 2.0, "l3": 3.0}))
    machine, form = machines.at([np.pi])
    model, q = machines.mechanism.model, form.problem.whole.copy()
    for name, angle in {"phi1": np.pi, "phi2": -np.pi}.items():
        q[model.joints[model.getJointId(name)].idx_q] = angle
    x = machines.loops.unknowns(q[None])
    assert machines.loops.unmet(x, machine.p)[0] <= 1e-14
    assert not proven(machines.loops, form.driven, x).any()
