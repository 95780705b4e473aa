"""Interrupting what computes many poses loses nothing that is done."""

from __future__ import annotations

import _thread
import pickle
import signal
import subprocess
import sys
import threading
import time
from dataclasses import fields

import numpy as np
import pytest

import pmjac_pin as pj
from pmjac_pin.batches import pieces
from pmjac_pin.batches.closing import Closing
from pmjac_pin.batches.gathering import gathered
from pmjac_pin.batches.pieces import PIECE, pieces_of
from pmjac_pin.batches.rest import Rest
from pmjac_pin.batches.result_shapes import shapes_of
from pmjac_pin.batches.turn import RefillTurn, Turns
from pmjac_pin.batches.wanted import Wanted

COUNT = 40_000
VALUES = np.array([2.187, 0.954]) + np.random.default_rng(0).uniform(-0.1, 0.1, (COUNT, 2))


def stop_at(most):
    """Return a progress that interrupts once as many are done: several may be told at a time."""

    def progress(done, count):
        if done >= most:
            raise KeyboardInterrupt

    return progress


def wanted(count):
    return Wanted(pj.ManyJacobians, shapes_of(pj.ManyJacobians, count, 1), {})


@pytest.fixture(scope="module")
def many():
    return pj.batch(pj.load("five_bar"))


@pytest.fixture(scope="module")
def poses(many):
    return many.close(VALUES, threads=1)


def parts_equal(done, whole):
    """Check that what is done is what would have been returned, and the rest says it is not."""
    known = done.status != pj.Status.NOT_DONE
    for name in (one.name for one in fields(whole)):
        array = getattr(whole, name)
        found = getattr(done, name)
        np.testing.assert_array_equal(found[known], array[known])
        assert not found.flags.writeable
        if name != "status":
            assert np.isnan(found[~known]).all()
    return known


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("asked", ["close", "jacobian", "ellipsoids", "measures"])
def test_what_is_done_is_kept(many, poses, asked, threads):
    """A KeyboardInterrupt comes anywhere; here, from where progress is told."""
    given = VALUES if asked == "close" else poses.q
    of = getattr(many, asked)
    whole = of(given, threads=threads)
    with pytest.raises(KeyboardInterrupt, match=f"of {COUNT} poses are done") as raised:
        of(given, threads=threads, progress=stop_at(2 * PIECE))
    assert isinstance(raised.value, pj.Interrupted)
    assert not isinstance(raised.value, pj.PmjacError)
    known = parts_equal(raised.value.done, whole)
    assert known.sum() >= 2 * PIECE  # those of which it was told; which ones threads decide
    if asked == "close" and threads == 1:  # elsewhere the others may be done at once
        assert not known.all()
    again = pickle.loads(pickle.dumps(raised.value))
    np.testing.assert_array_equal(again.done.status, raised.value.done.status)
    assert str(again) == str(raised.value)


def test_other_errors_are_raised_as_they_are(many, poses):
    def progress(done, count):
        raise ValueError("no")

    with pytest.raises(ValueError, match="no"):
        many.jacobian(poses.q, progress=progress)


def test_a_grid_keeps_its_cells(many, monkeypatch):
    axes = {"theta1": np.linspace(0.5, 2.5, 12), "theta2": np.linspace(0.5, 1.5, 12)}
    whole, close, calls = many.grid(axes), Closing.close, []

    def interrupted(*arguments, **options):
        calls.append(0)
        if len(calls) == 3:
            raise KeyboardInterrupt
        return close(*arguments, **options)

    monkeypatch.setattr(Closing, "close", interrupted)
    with pytest.raises(pj.Interrupted, match="of 144 cells are done") as raised:
        many.grid(axes)
    known = raised.value.done.status != pj.Status.NOT_DONE
    assert 0 < known.sum() < known.size
    np.testing.assert_array_equal(raised.value.done.q[known], whole.q[known])
    np.testing.assert_array_equal(raised.value.done.actuated, whole.actuated)


SCRIPT = """
import os, signal, sys, time
from _thread import _count as others_at_work
import numpy as np
import pmjac_pin as pj

many = pj.batch(pj.load("five_bar"))
values = many.mechanism.home.actuated + np.zeros((4_000_000, 1))
seen = []

def progress(done, count):
    if not seen:
        seen.append(time.monotonic())
        print("begun", flush=True)

try:
    many.close(values, threads=int(sys.argv[1]), progress=progress)
except KeyboardInterrupt as stopped:
    known = stopped.done.status != pj.Status.NOT_DONE
    print(int(known.sum()), bool(np.isfinite(stopped.done.q[known]).all()))
    until = time.monotonic() + 5.0  # a piece would take much longer
    while others_at_work() and time.monotonic() < until:
        time.sleep(0.01)
    print(others_at_work())
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT to a child")
@pytest.mark.parametrize("threads", [1, 2])
def test_a_signal(threads):
    command = [sys.executable, "-c", SCRIPT, str(threads)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout.readline() == "begun\n"
        child.send_signal(signal.SIGINT)
        told, _ = child.communicate(timeout=60)
    assert child.returncode == 0
    first, at_work = told.splitlines()
    done, finite = first.split()
    assert 2048 <= int(done) < 4_000_000
    assert finite == "True"
    assert at_work == "0"


@pytest.mark.parametrize("threads", [1, 2])
def test_nobody_waits_for_a_piece_that_takes_long(threads):
    begun, stop = threading.Event(), threading.Event()

    def work(piece, given, J_eq, status):
        begun.set()
        while not stop.wait(0.01):
            piece.go_on()
        J_eq[:] = status[:] = 0

    def interrupt():
        begun.wait()
        signal.raise_signal(signal.SIGINT)

    threading.Thread(target=interrupt).start()
    with pytest.raises(pj.Interrupted, match="0 of 5000 poses") as raised:
        gathered(wanted(5000), work, (threads, None))
    stop.set()
    assert (raised.value.done.status == pj.Status.NOT_DONE).all()


@pytest.mark.parametrize("later", [1, 2])
def test_what_is_raised_is_of_the_first_piece_that_fails(later):
    """Whichever thread comes to it, and however much sooner another piece fails."""
    failed, count = threading.Event(), 5 * PIECE
    fails = pieces_of(count)[later].start

    def work(piece, given, J_eq, status):
        J_eq[:], status[:] = piece.at.start, 0
        if piece.at.start == fails:
            failed.set()
            raise ValueError("later")
        if piece.at.start == 0:
            assert failed.wait(30.0)
            raise ValueError("first")

    with pytest.raises(ValueError, match="first"):
        gathered(wanted(count), work, (2, None))


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_progress_tells_of_all_in_the_end(threads):
    count, told = 3 * PIECE + 1, []

    def work(piece, given, J_eq, status):
        J_eq[:], status[:] = piece.at.start, 0

    found = gathered(wanted(count), work, (threads, lambda *given: told.append(given)))
    for piece in pieces_of(count):
        assert (found.J_eq[piece] == piece.start).all()
    assert told[-1] == (count, count)
    assert [done for done, _ in told] == sorted({done for done, _ in told})


@pytest.mark.parametrize("stored", [False, True])
def test_a_sweep_keeps_its_chunks(stored, tmp_path):
    pytest.importorskip("zarr")
    asked = {
        "over": {"theta1": np.linspace(2.0, 2.2, 4), "theta2": np.linspace(0.9, 1.0, 5)},
        "measures": ["J_eq", "q"],
        "chunk": 5,
        "workers": 1,
    }
    five_bar, out = pj.load("five_bar"), tmp_path / "out.zarr"
    whole = pj.sweep(five_bar, **asked)
    where = {"out": out} if stored else {}
    with pytest.raises(pj.Interrupted, match="10 of 20 poses are done") as raised:
        pj.sweep(five_bar, **asked, **where, progress=stop_at(2))
    done = raised.value.done
    assert (done.status[2:] == pj.Status.NOT_DONE).all()
    np.testing.assert_array_equal(done.J_eq[:2], whole.J_eq[:2])
    assert np.isnan(done.q[2:]).all()
    if stored:
        resumed = pj.sweep(five_bar, **asked, out=out, resume=True)
        np.testing.assert_array_equal(resumed.J_eq, whole.J_eq)
        np.testing.assert_array_equal(resumed.status, whole.status)


@pytest.mark.parametrize("count", [0, 1, PIECE, PIECE + 1, 10_000, 40_000, 99_999, 1_000_000])
def test_two_threads_that_are_as_fast_end_together(count):
    """But not each of their pieces: where one comes to Python's lock, the other computes."""
    pieces = pieces_of(count)
    covered = [index for piece in pieces for index in range(piece.start, piece.stop)]
    assert covered == list(range(count))
    assert all(0 < piece.stop - piece.start <= PIECE for piece in pieces)
    ends = [0, 0]  # poses that each of them has done
    for piece in pieces:
        ends.sort()
        assert ends[0] < ends[1] or max(ends) == 0
        ends[0] += piece.stop - piece.start
    assert count <= PIECE or max(ends) <= 0.51 * count


def test_a_second_interrupt_waits_for_what_is_still_written():
    """Else another call's numbers would be written over by this one's, later."""
    count, caller = 3 * PIECE, threading.get_ident()
    begun, end = threading.Event(), threading.Event()

    def work(piece, given, J_eq, status):
        if threading.get_ident() == caller:
            assert begun.wait(30.0)
            for after in (0.1, 0.4):
                threading.Timer(after, _thread.interrupt_main).start()
            threading.Timer(0.8, end.set).start()
            while True:
                piece.go_on()
                time.sleep(0.01)
        begun.set()
        assert end.wait(30.0)  # as one long path that is walked by a single call
        J_eq[:], status[:] = 1.0, 0

    with pytest.raises(pj.Interrupted) as raised:
        gathered(wanted(count), work, (2, None))
    assert end.is_set()
    known = raised.value.done.status == pj.Status.CLOSED
    assert (raised.value.done.J_eq[known] == 1.0).all()
    assert np.isnan(raised.value.done.J_eq[~known]).all()


def test_what_a_thread_still_writes_to_is_no_other_calls():
    last, rest = RefillTurn(), Rest()
    turns, of_another = Turns(last), Turns(last)  # two results of one call
    last.helpers, last.has_ended, rest.is_busy = [rest], True, True
    assert not turns.go_on_with(RefillTurn(), pj.ManyClosed)
    rest.reach()
    assert turns.go_on_with(RefillTurn(), pj.ManyClosed)
    assert not turns.go_on_with(RefillTurn(), pj.ManyClosed)
    assert of_another.go_on_with(RefillTurn(), pj.ManyEllipsoids)


def test_turns_that_are_past_are_forgotten(many):
    """Also where one result of a call is filled again and again, and the other never."""
    poses, found = many.ellipsoids_at(np.tile(many.mechanism.home.actuated, (5, 1)))
    for _ in range(20):
        many.ellipsoids(poses.q, out=found)
    assert len(reached_from(poses._shown._last)) == 1


def reached_from(turn):
    """It and all turns that it keeps."""
    found, left = set(), [turn]
    while left:
        one = left.pop()
        found.add(id(one))
        left += [other for other in one.followed.values() if other is not None]
    return found


def test_where_no_thread_can_begin_the_caller_does_all(monkeypatch):
    """Or as many as can."""
    count, begin = 5 * PIECE, pieces.start_new_thread
    for most in (0, 1):
        begun = []

        def some(*given, most=most, begun=begun):
            if len(begun) == most:
                raise RuntimeError("can't start new thread")
            begun.append(1)
            return begin(*given)

        monkeypatch.setattr(pieces, "start_new_thread", some)

        def work(piece, given, J_eq, status):
            J_eq[:], status[:] = 1.0, 0

        assert (gathered(wanted(count), work, (4, None)).J_eq == 1.0).all()
        assert len(begun) == most
