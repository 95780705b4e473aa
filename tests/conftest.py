"""Fixtures shared by all tests."""

from __future__ import annotations

import importlib.util
import signal
from pathlib import Path

import numpy as np
import pytest

import pmjac_pin as pj
from pmjac_pin import mechanism_value
from pmjac_pin.closing import blueprint

# The peers' polynomials are written in SymPy, which comes with the extra `peers`.
collect_ignore = [] if importlib.util.find_spec("sympy") else ["polynomials_by_hand.py"]

# A shell that starts tests in the background has them ignore Ctrl-C, which some send.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture
def rng(request):
    """A generator seeded by the test's own name: the same numbers each time, not one for all."""
    return np.random.default_rng(list(request.node.name.encode()))


@pytest.fixture(autouse=True)
def nothing_unpickled_before():
    """What other tests have unpickled is no help."""
    mechanism_value._MECHANISMS.clear()
    blueprint._BLUEPRINTS.clear()


@pytest.fixture
def viewer(mechanism):
    """A viewer without a browser, at home, of the `mechanism` of the test's own module."""
    with pj.view(mechanism.home, open_browser=False, port=0) as viewer:
        yield viewer


@pytest.fixture(scope="session")
def hatch_build():
    """The script that builds the package, as a module."""
    pytest.importorskip("hatchling")
    place = Path(__file__).resolve().parent.parent / "hatch_build.py"
    spec = importlib.util.spec_from_file_location("hatch_build", place)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
