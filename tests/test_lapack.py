"""SciPy's LAPACK alone: the same numbers, and nothing is missing where all of SciPy comes later."""

import subprocess
import sys

import numpy as np
import pytest
import scipy.linalg.lapack as whole

from pmjac_pin.values import lapack

AFTERWARDS = """
import sys
import numpy as np, pmjac_pin as pj
mechanism = pj.load('four_bar')
mechanism.close(mechanism.home.actuated + 0.1).jacobian()
assert 'scipy.linalg' not in sys.modules
import scipy.linalg, scipy.linalg.lapack, scipy.optimize
assert scipy.linalg._flapack.dgesv and scipy.linalg.lapack.dgesv
A = np.array([[2.0, 1.0], [0.0, 4.0]])
assert np.allclose(A @ scipy.linalg.solve(A, A @ A), A @ A)
pj.load('delta').home.jacobian()
"""


OTHERWISE = """
import sys
from pmjac_pin.values import lapack
lapack._ROUTINES = ('called_otherwise',)
found = lapack.lapack()
assert found is sys.modules['scipy.linalg'].lapack
"""


def in_a_process(code):
    subprocess.run([sys.executable, "-W", "error", "-c", code], check=True)


def test_poses_and_paths_import_it_alone_and_the_rest_may_follow():
    in_a_process(AFTERWARDS)


def test_where_it_is_called_otherwise_the_whole_is_imported():
    in_a_process(OTHERWISE)


def test_one_that_is_nowhere_is_not_found():
    with pytest.raises(ImportError, match="elsewhere"):
        lapack._alone("elsewhere")


def test_both_give_the_same_bits(rng):
    alone = lapack._alone("_flapack")
    for _ in range(20):
        A, b = rng.normal(size=(7, 4)), rng.normal(size=7)
        for one, other in zip(alone.dgels(A, b), whole.dgels(A, b), strict=True):
            np.testing.assert_array_equal(one, other)
        for one, other in zip(alone.dgesv(A[:4], b[:4]), whole.dgesv(A[:4], b[:4]), strict=True):
            np.testing.assert_array_equal(one, other)
