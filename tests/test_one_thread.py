"""Studies leave BLAS one thread while they work, and give the others back."""

import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import numpy as np
import pytest
import threadpoolctl
from interrupter import Interrupter
from ladder import ladder
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.algebra import one_thread
from pmjac_pin.algebra.one_thread import on_one_thread
from pmjac_pin.values.lapack import lapack


def threads():
    return {one["num_threads"] for one in threadpoolctl.threadpool_info() if "blas" in one.values()}


@pytest.fixture
def two_threads():
    lapack()
    with threadpoolctl.threadpool_limits(limits=2, user_api="blas"):
        if threads() != {2}:
            pytest.skip("a BLAS of one thread, or none that tells")
        yield


@pytest.fixture
def told(monkeypatch):
    """What is asked of BLAS of 7 threads, one after the other: 1, and all of them again."""
    asked = []

    class Library:
        user_api, num_threads = "blas", 7

        def set_num_threads(self, number):
            asked.append(number)

    class Libraries:
        lib_controllers = (Library(),)

    monkeypatch.setattr(threadpoolctl, "ThreadpoolController", Libraries)
    one_thread._libraries.cache_clear()
    yield asked
    one_thread._libraries.cache_clear()


@pytest.mark.usefixtures("two_threads")
def test_within_there_is_one_and_after_it_as_many_as_before():
    assert on_one_thread(threads)() == {1}
    assert threads() == {2}


@pytest.mark.usefixtures("two_threads")
def test_an_error_gives_them_back():
    with pytest.raises(ZeroDivisionError):
        on_one_thread(lambda: 1 / 0)()
    assert threads() == {2}


def test_what_would_be_imported_within_has_one_as_well():
    """NumPy's BLAS and SciPy's, each of which has threads of its own."""
    code = """
import threadpoolctl
from pmjac_pin.algebra.one_thread import on_one_thread
from pmjac_pin.values.lapack import lapack
@on_one_thread
def within():
    lapack()
    return [one["num_threads"] for one in threadpoolctl.threadpool_info() if "blas" in one.values()]
assert set(within()) == {1}, within()
"""
    two = {**os.environ, "OPENBLAS_NUM_THREADS": "2"}
    subprocess.run([sys.executable, "-c", code], env=two, check=True)


def test_the_last_of_several_that_overlap_gives_them_back(told):
    """What the second found is not what there was before, and the first one out must not."""
    begun, ended = Barrier(2), Barrier(2)

    @on_one_thread
    def first():
        begun.wait()

    @on_one_thread
    def second():
        begun.wait()
        ended.wait()
        return list(told)

    with ThreadPoolExecutor(2) as pool:
        last = pool.submit(second)
        pool.submit(first).result()
        ended.wait()
        assert last.result() == [1]
    assert told == [1, 7]


@pytest.mark.parametrize(
    "study",
    [
        lambda bar: pj.workspace(bar, ("x", "y"), cells=5, trace=False),
        lambda bar: pj.singularity_locus(bar, bar.actuated, kinds=["gain"], cells=9),
        lambda bar: pj.nearest_singularity(bar.home, kind="gain", starts=0),
    ],
)
def test_studies_of_many_small_matrices_have_one(study, told):
    study(loaded("five_bar"))
    assert told == [1, 7]


def test_a_large_machine_has_one_for_its_load_its_first_pose_and_each_path(told):
    machines, asked = [], [0]
    for step in (
        lambda: machines.append(ladder(24)),
        lambda: machines[0].home,
        lambda: machines[0].close([1.21]),
        lambda: machines[0].close([1.22]),
    ):
        step()
        asked.append(len(told))
    assert np.diff(asked).all()
    assert told == [1, 7] * (len(told) // 2)


@pytest.mark.usefixtures("two_threads")
def test_interrupted_at_any_step_there_are_as_many_as_before():
    points, left_by_interrupts, mechanism = 0, 0, ladder(24)
    target = mechanism.home.actuated + 0.01
    mechanism.close(target)
    while True:
        points += 1
        interrupter, before = Interrupter(points, "one_thread.py"), sys.gettrace()
        sys.settrace(interrupter)
        try:
            mechanism.close(target)
        except KeyboardInterrupt:
            pass
        finally:
            sys.settrace(before)
        left_by_interrupts += threads() != {2}
        on_one_thread(lambda: None)()
        assert threads() == {2}
        if interrupter.left > 0:
            break
    # Where the interrupt comes before the first step of leaving, the next one who leaves does it.
    assert left_by_interrupts <= 0.1 * points
    assert points > 10


@pytest.mark.usefixtures("two_threads")
def test_a_process_that_is_forked_within_has_them_back():
    read, write = os.pipe()
    with one_thread.one_thread_from(100):
        child = os.fork()
        if not child:
            os.write(write, bytes(threads()))
            os._exit(0)
        assert threads() == {1}
    os.waitpid(child, 0)
    assert set(os.read(read, 9)) == {2}


def test_of_a_small_one_nothing_is_asked(told):
    mechanism = pj.load("four_bar")
    mechanism.close(mechanism.home.actuated + 0.01)
    assert told == []
