"""The elimination itself, on matrices from elsewhere: no Pinocchio, no mechanism."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

import pmjac_pin as pj
from pmjac_pin.model.twist_frame import change_frame


def split_of(C, J, n):
    columns = list(range(C.shape[1]))
    partition = pj.Partition.from_matrices(C, J, columns[:n], columns[n:])
    return pj.SplitJacobian(C, J, "LOCAL_WORLD_ALIGNED", partition)


@pytest.mark.parametrize(("n", "m_p"), [(1, 1), (1, 2), (3, 3), (6, 12)])
def test_square_case_is_the_formula(n, m_p, rng):
    C, J = rng.normal(size=(m_p, n + m_p)), rng.normal(size=(6, n + m_p))
    jacobian = pj.equivalent_jacobian(split_of(C, J, n))
    K, K_star = C[:, :n], C[:, n:]
    np.testing.assert_allclose(jacobian.K, K)
    np.testing.assert_allclose(jacobian.K_star, K_star)
    expected = J[:, :n] - J[:, n:] @ np.linalg.inv(K_star) @ K
    np.testing.assert_allclose(jacobian.J_eq, expected, atol=1e-10 * np.abs(expected).max())
    assert jacobian.det_K_star == pytest.approx(np.linalg.det(K_star))


def test_redundant_rows_change_nothing(rng):
    C, J = rng.normal(size=(4, 6)), rng.normal(size=(6, 6))
    mixed = rng.normal(size=(9, 4)) @ C
    expected = pj.equivalent_jacobian(split_of(C, J, 2)).J_eq
    jacobian = pj.equivalent_jacobian(split_of(mixed, J, 2))
    np.testing.assert_allclose(jacobian.J_eq, expected, atol=1e-11)
    assert jacobian.K_star.shape == (4, 4)
    assert jacobian.det_K_star is not None


def test_no_loops_at_all(rng):
    J = rng.normal(size=(6, 3))
    jacobian = pj.equivalent_jacobian(split_of(np.zeros((0, 3)), J, 3))
    np.testing.assert_array_equal(jacobian.J_eq, J)
    np.testing.assert_array_equal(jacobian.motion_map, np.eye(3))
    assert jacobian.K.shape == (0, 3)


def test_given_arrays_are_left_alone(rng):
    C, J = rng.normal(size=(2, 3)), rng.normal(size=(6, 3))
    split = split_of(C, J, 1)
    C[:] = J[:] = 0.0
    assert C.flags.writeable
    assert np.abs(split.K_star).min() > 0


def test_lost_rank_is_refused(rng):
    C, J = rng.normal(size=(3, 4)), rng.normal(size=(6, 4))
    partition = split_of(C, J, 1).partition
    C[:, 3] = C[:, 2]
    split = pj.SplitJacobian(C, J, "LOCAL", partition)
    with pytest.raises(pj.SingularError, match=r"\(phi1 [+-]1, phi2 [+-]1\) is free"):
        pj.equivalent_jacobian(split)
    assert split.det_K_star == pytest.approx(0.0, abs=1e-15)


def test_one_vanishing_column_is_singular_too():
    """A 1 × 1 K* has always full rank beside itself: the size of [K K*] decides."""
    J = np.ones((6, 2))
    partition = split_of(np.array([[1.0, 0.5]]), J, 1).partition
    nearly = pj.SplitJacobian(np.array([[1.0, 1e-9]]), J, "LOCAL", partition)
    with pytest.raises(pj.SingularError):
        pj.equivalent_jacobian(nearly)


def test_unknown_frame():
    with pytest.raises(pj.ArgumentError, match="got 'TOOL'"):
        change_frame(np.eye(6), "TOOL", np.eye(3), np.zeros(3))


@pytest.mark.parametrize(
    "module",
    [
        *(f"rates.{name}" for name in ("jacobian", "singularity", "ellipsoid", "partition")),
        "rates.factorisation",
        "model.spec",
    ],
)
def test_linear_algebra_imports_no_pinocchio(module):
    code = (
        "import sys, types, pathlib, importlib; "
        "package = types.ModuleType('pmjac_pin'); "
        f"package.__path__ = [{str(next(iter(pj.__path__)))!r}]; "
        "sys.modules['pmjac_pin'] = package; "
        f"importlib.import_module('pmjac_pin.{module}'); "
        "sys.exit('pinocchio' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"actuated": [0, 0]}, "must name each of the columns 0 to 2 once, got [0, 0] and [1, 2]"),
        ({"passive": [1]}, "must name each of the columns 0 to 2 once"),
        ({"passive": [1, -1]}, "must name each of the columns 0 to 2 once"),
        ({"tool_jacobian": np.ones((3, 3))}, "got shapes (2, 3) and (3, 3)"),
        ({"constraint_jacobian": [[1.0, np.nan, 0.0]]}, "the constraint Jacobian must be finite"),
        ({"constraint_jacobian": None}, "the constraint Jacobian must be real numbers, got None"),
        ({"length": 0.0}, "length must be 1e-09 m or more, got 0.0"),
    ],
)
def test_matrices_that_do_not_fit(change, message):
    arguments = {
        "constraint_jacobian": np.ones((2, 3)),
        "tool_jacobian": np.ones((6, 3)),
        "actuated": [0],
        "passive": [1, 2],
    }
    with pytest.raises(pj.ArgumentError) as caught:
        pj.Partition.from_matrices(**{**arguments, **change})
    assert message in str(caught.value)
