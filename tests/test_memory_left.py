"""Memory that large results have left goes to the next ones, and to nobody while it is seen."""

from __future__ import annotations

import sys
import threading
import time

import numpy as np
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.batches import memory_left, result_shapes
from pmjac_pin.batches.result_shapes import ResultShapes, empty_arrays

SHAPES = ResultShapes({"q": (5000, 7), "share": (5000,), "status": (5000,)})


@pytest.fixture(autouse=True)
def small_ones_are_large(monkeypatch):
    monkeypatch.setattr(result_shapes, "LARGE", 4096)


@pytest.fixture
def no_new_memory(monkeypatch):
    """Return what forbids new memory from now on."""

    def new(size):
        raise AssertionError(f"{size} bytes of new memory")

    return lambda: monkeypatch.setattr(memory_left, "_mapped", new)


linux = pytest.mark.skipif(sys.platform != "linux", reason="elsewhere nothing is kept")


@linux
def test_the_next_ones_lie_where_nobody_looks_any_longer(no_new_memory):
    arrays = empty_arrays(SHAPES)
    before = {array.ctypes.data for array in arrays.values()}
    no_new_memory()
    del arrays
    again = empty_arrays(SHAPES)
    assert {array.ctypes.data for array in again.values()} == before
    with pytest.raises(AssertionError, match="new memory"):
        empty_arrays(SHAPES)


@linux
def test_of_calls_whose_results_are_dropped_the_second_takes_no_memory(no_new_memory):
    many = pj.batch(loaded("five_bar"))
    values = many.mechanism.home.actuated + np.linspace(0.0, 0.1, 5000)[:, None]
    expected = many.measures(many.close(values).q).J_eq.copy()
    no_new_memory()
    np.testing.assert_array_equal(many.measures(many.close(values).q).J_eq, expected)


SEEN = {
    "itself": lambda array: array,
    "a view": lambda array: array[5:],
    "a view of a view": lambda array: array.T[::-1][3:],
    "other numbers": lambda array: array.view(np.int64),
    "flat": lambda array: array.reshape(-1),
    "read-only": lambda array: np.frombuffer(array.reshape(-1).data.toreadonly()),
    "a buffer": lambda array: np.asarray(memoryview(array)[7:]),
    "broadcast": lambda array: np.broadcast_to(array, (2, *array.shape)),
    "an iterator's": lambda array: np.nditer(array).itviews[0],
    "shared by DLPack": np.from_dlpack,
    "a class of its own": lambda array: array.view(np.recarray),
}


@pytest.mark.parametrize("how", SEEN)
def test_what_somebody_sees_stays(how):
    arrays = empty_arrays(SHAPES)
    arrays["q"][:] = 1.0
    seen = SEEN[how](arrays["q"])
    expected = seen.copy()
    del arrays
    others = [empty_arrays(SHAPES) for _ in range(3)]
    for other in others:
        other["q"][:] = 2.0
    np.testing.assert_array_equal(seen, expected)


@pytest.mark.parametrize("name", ["q", "share", "status"])
def test_a_result_stays_while_one_of_its_arrays_is_seen(name):
    many = pj.batch(loaded("five_bar"))
    values = many.mechanism.home.actuated + np.linspace(0.0, 0.1, 5000)[:, None]
    poses = many.close(values)
    seen = getattr(poses, name)[::-1]
    expected = seen.copy()
    del poses
    for turn in (1.0, 2.0):
        other = many.close(values + 0.01 * turn)
        assert not np.shares_memory(getattr(other, name), seen)
    np.testing.assert_array_equal(seen, expected)


def test_threads_get_memory_of_their_own():
    failed = []

    def work(number):
        for turn in range(100):
            array = empty_arrays(ResultShapes({"q": (1000 + number % 2,)}))["q"]
            array[:] = number + 100 * turn
            time.sleep(1e-4)
            if not (array == number + 100 * turn).all():
                failed.append((number, turn))

    threads = [threading.Thread(target=work, args=[number]) for number in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not failed


@linux
def test_what_is_kept_is_bounded():
    others = [empty_arrays(ResultShapes({"q": (1000 + k,)})) for k in range(60)]
    while others:
        others.pop(0)
    kept = memory_left._LEFT
    assert len(kept) == kept.maxlen < 60
    assert len(kept[-1]) == 8 * 1059  # the oldest go


@linux
def test_what_nobody_asks_for_any_longer_gives_way_to_the_latest(no_new_memory, monkeypatch):
    """As the results of another machine that were as large as all that is kept."""
    monkeypatch.setattr(memory_left, "_MOST", 8 * 3000)
    before = [empty_arrays(ResultShapes({"q": (1000 + k,)})) for k in range(3)]
    before.clear()
    now = [empty_arrays(ResultShapes({"q": (1400,)})) for _ in range(2)]
    now.clear()
    assert [len(memory) // 8 for memory in memory_left._LEFT] == [1400, 1400]
    no_new_memory()
    assert len([empty_arrays(ResultShapes({"q": (1400,)})) for _ in range(2)]) == 2


def test_more_than_there_is_is_an_error_as_ever():
    with pytest.raises(MemoryError):
        empty_arrays(ResultShapes({"q": (1 << 45, 8)}))
