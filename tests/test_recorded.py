"""What is recorded of every mechanism is what Pinocchio and LAPACK compute."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import pmjac_pin as pj
from pmjac_pin.algebra.floats import Floats
from pmjac_pin.algebra.numpy_tape import run
from pmjac_pin.algebra.programs import PROGRAMS, objects
from pmjac_pin.algebra.tape import Tape
from pmjac_pin.algebra.terms import Recording
from pmjac_pin.kinematics.joint_steps import arriving, between, entry_rates, moved_by
from pmjac_pin.kinematics.recorded import Recorder
from pmjac_pin.kinematics.tree import Tree
from pmjac_pin.model.joint_kinds import JOINT_KINDS
from pmjac_pin.rates.sparse_qr import Triangle, norm


def recorded(mechanism, q):
    """The recorded kinematics at one q, as floats."""
    model, spec = mechanism.model, mechanism.spec
    recording = Recording(model.nq)
    found = Recorder(model, spec, mechanism.parameters, np.zeros(3)).at(recording.inputs)

    def number(entries):
        tape = Tape.of(recording, entries.ravel().tolist())
        return run(tape, q[:, None])[:, 0].reshape(entries.shape)

    return found, number


@pytest.mark.parametrize("name", pj.list_mechanisms())
def test_the_tool_of_any_pose_and_the_loops_of_a_closed_one(name, rng):
    mechanism = pj.load(name)
    model, length = mechanism.model, mechanism.characteristic_length
    q = pin.integrate(model, mechanism.home.q, rng.normal(size=model.nv))
    snapshot = mechanism.kinematics.snapshot(q)
    found, number = recorded(mechanism, q)
    np.testing.assert_allclose(number(found.tool), snapshot.tool_jacobian, atol=1e-12 * length)
    np.testing.assert_allclose(number(found.position), snapshot.position, atol=1e-12 * length)
    np.testing.assert_allclose(number(found.rotation), snapshot.rotation, atol=1e-12)
    found, number = recorded(mechanism, mechanism.home.q)
    residual, rates = mechanism.kinematics.closure(mechanism.home.q)
    np.testing.assert_allclose(number(found.residual), residual, atol=1e-12 * length)
    # Rows of one loop may be seen in other axes.
    ours, theirs = number(found.rates), rates
    np.testing.assert_allclose(ours.T @ ours, theirs.T @ theirs, atol=1e-12 * length**2)
    rows, expected = mechanism.home.residual, mechanism.kinematics.snapshot(mechanism.home.q)
    ours, rates = (number(one) for one in found.in_world())
    np.testing.assert_allclose(ours, rows, atol=1e-12 * length)
    partition = mechanism.problem.partition
    order = [*partition.actuated, *partition.passive]
    np.testing.assert_allclose(
        rates[:, order], expected.constraint_jacobian[:, order], atol=1e-11 * length
    )
    np.testing.assert_allclose(number(found.cosines), 1.0, atol=1e-12)


@pytest.mark.parametrize(("rows", "columns"), [(1, 1), (4, 4), (7, 4), (3, 0)])
def test_least_squares_of_sparse_matrices(rows, columns, rng):
    """Recorded once for where entries are, and right at any entries."""
    pattern = rng.random((rows, columns + 2)) < 0.7
    pattern[:columns, :columns] |= np.eye(columns, dtype=bool)
    recording = Recording(int(pattern.sum()))
    matrix = np.full(pattern.shape, 0.0, dtype=object)
    matrix[pattern] = recording.inputs
    triangle = Triangle.of(matrix, columns)
    right = range(columns, columns + 2)
    left = triangle.matrix[np.ix_(triangle.left_over, right)]
    known = [triangle.inverse_norm(), norm(left), *triangle.solve(right).ravel()]
    tape = Tape.of(recording, known)
    for _ in range(5):
        entries = rng.normal(size=int(pattern.sum()))
        whole = np.zeros(pattern.shape)
        whole[pattern] = entries
        a, b = whole[:, :columns], whole[:, columns:]
        size, left_over, *solution = run(tape, entries[:, None])[:, 0]
        expected = np.linalg.lstsq(a, b, rcond=None)[0] if columns else np.zeros((0, 2))
        np.testing.assert_allclose(np.reshape(solution, (columns, 2)), expected, rtol=1e-9)
        assert left_over == pytest.approx(np.linalg.norm(b - a @ expected), abs=1e-12)
        if columns:
            assert size * np.linalg.svd(a)[1].min() >= 1.0 - 1e-9


def test_a_program_folds_what_is_known(rng):
    recording = Recording(3)
    x, y, z = recording.inputs
    assert x + y is y + x
    assert x - y is -(y - x)
    assert (-x) * y is -(x * y)
    assert x - (-y) is x + y
    assert x * 0.0 == 0.0
    assert x * 1.0 is x
    assert x - x == 0.0
    outputs = [x * y + z, x * y - z, z - x * y, 2.0 / x, abs(x), -x * 0.5, 3.0]
    u, v, w = values = rng.normal(size=(3, 5000))  # more than are computed at a time
    expected = [u * v + w, u * v - w, w - u * v, 2.0 / u, abs(u), -u * 0.5, 3.0 + 0.0 * u]
    np.testing.assert_allclose(run(Tape.of(recording, outputs), values), expected, rtol=1e-15)


BUILT = [name for name, kind in JOINT_KINDS.items() if kind.model is not None]


@pytest.mark.parametrize("size", [0.0, 1e-200, 1e-9, 1e-4, 0.7])
@pytest.mark.parametrize("name", BUILT)
def test_motions(name, size, rng):
    """`between` undoes `moved_by`, and `arriving` is its rate at the end; of turns of any size.

    As floats and as a program, and as Pinocchio integrates: slides first.
    """
    kind, model = JOINT_KINDS[name], pin.Model()
    model.addJoint(0, kind.built(0.3), pin.SE3.Random(), "joint")
    nq, nv, tree, floats = model.nq, model.nv, Tree(model), Floats()

    def motions(algebra, numbers):
        q, v, rates = np.split(numbers, [nq, nq + nv])
        end = moved_by(algebra, tree, q, v)
        on = between(algebra, tree, q, moved_by(algebra, tree, end, rates))
        back, along = between(algebra, tree, q, end), entry_rates(tree, q, rates)
        return [*end, *back, *on, *arriving(algebra, tree, v, rates), *along]

    sliding = np.arange(nv) < kind.slides
    recording = Recording(nq + 2 * nv)
    tape = Tape.of(recording, motions(PROGRAMS, objects(recording.inputs)))
    for _ in range(5):
        start = pin.integrate(model, pin.neutral(model), rng.normal(size=nv))
        step, onward = size * rng.normal(size=nv), rng.normal(size=nv)
        inputs = [np.concatenate([start, step, h * onward]) for h in (1e-6, -1e-6, 1.0)]
        found = [run(tape, numbers[:, None])[:, 0] for numbers in inputs]
        as_floats = np.array(motions(floats, np.transpose(inputs))).T
        np.testing.assert_allclose(as_floats, found, atol=1e-15, rtol=1e-14)
        (_, _, after, _, _), (_, _, before, _, _), (ours, back, _, rate, along) = (
            np.split(one, np.cumsum([nq, nv, nv, nv])) for one in found
        )
        slid = pin.integrate(model, start, np.where(sliding, step, 0.0))
        turned = pin.integrate(model, slid, np.where(sliding, 0.0, step))
        np.testing.assert_allclose(ours, turned, atol=1e-14)
        np.testing.assert_allclose(back, step, atol=1e-15)
        np.testing.assert_allclose(rate, (after - before) / 2e-6, atol=1e-9)
        ahead, behind = (pin.integrate(model, start, h * onward) for h in (1e-6, -1e-6))
        np.testing.assert_allclose(along, (ahead - behind) / 2e-6, atol=1e-9)
        assert pin.isNormalized(model, ours, 1e-15)
