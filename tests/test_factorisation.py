"""The factorisation: pseudoinverses of a given rank."""

from __future__ import annotations

import numpy as np
import pytest

from pmjac_pin.rates.factorisation import factorise


@pytest.mark.parametrize(
    "shape", [(3, 3, 3), (5, 3, 3), (3, 5, 3), (6, 6, 4), (9, 4, 2), (1, 1, 1)]
)
def test_the_inverse_by_the_generic_rank_is_the_pseudoinverse(shape, rng):
    rows, columns, rank = shape
    matrix = rng.normal(size=(rows, rank)) @ rng.normal(size=(rank, columns))
    inverse = factorise(matrix, 1.0).inverse(rank)
    np.testing.assert_allclose(inverse, np.linalg.pinv(matrix, rcond=1e-10), atol=1e-10)
