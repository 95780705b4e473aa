"""Other threads go on while a kernel computes many poses."""

from __future__ import annotations

import sys
import threading

import pytest

import pmjac_pin as pj
from pmjac_pin.batches.rates_in_lanes import rates_kernel
from pmjac_pin.closing.path_kernel import many_paths_kernel

CALLS = 400  # at most, of which other threads have to get in at one


@pytest.fixture
def no_switching():
    """Python takes its lock from nobody: who has it lets go of it, or keeps it."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e3)
    yield
    sys.setswitchinterval(before)


class Other:
    """A thread that makes a step each time that it is let go, as soon as it gets Python's lock."""

    def __init__(self):
        self.steps, self._go, self._ended = 0, threading.Semaphore(0), False
        self._thread = threading.Thread(target=self._run)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._ended = True
        self._go.release()
        self._thread.join()

    def let_go(self):
        self._go.release()

    def _run(self):
        while not self._ended:
            self._go.acquire()
            self.steps += 1


def watch(library, other, monkeypatch):
    """Let a kernel note at which of its calls the other thread makes a step."""
    within = []

    class Watched(library._FuncPtr):
        _flags_ = library._FuncPtr._flags_

        def __call__(self, *arguments):
            other.let_go()
            before = other.steps
            found = super().__call__(*arguments)
            within.append(other.steps > before)
            return found

    for name, function in list(vars(library).items()):
        if isinstance(function, library._FuncPtr):
            watched = Watched((name, library))
            watched.argtypes, watched.restype = function.argtypes, function.restype
            monkeypatch.setattr(library, name, watched)
    return within


@pytest.mark.skipif(many_paths_kernel() is None, reason="no kernel was built")
@pytest.mark.usefixtures("no_switching")
@pytest.mark.parametrize(
    ("kernel", "asked"), [(many_paths_kernel, "close"), (rates_kernel, "jacobian")]
)
def test_another_thread_goes_on_within_a_call(kernel, asked, rng, monkeypatch):
    mechanism = pj.load("delta")
    values = mechanism.home.actuated + rng.uniform(-0.03, 0.03, (4000, 3))
    given = values if asked == "close" else pj.batch(mechanism).close(values, threads=1).q
    with Other() as other:
        within = watch(kernel(), other, monkeypatch)
        of = getattr(pj.batch(mechanism), asked)
        while not any(within) and len(within) < CALLS:
            calls = len(within)
            of(given, threads=1)
            assert len(within) > calls
    assert any(within)
