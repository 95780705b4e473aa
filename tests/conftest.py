"""Fixtures shared by all tests."""

from __future__ import annotations

import numpy as np
import pytest


@pytest.fixture
def rng(request):
    """A generator seeded by the test's own name: the same numbers each time, not one for all."""
    return np.random.default_rng(list(request.node.name.encode()))
