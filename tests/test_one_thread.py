"""Studies leave BLAS one thread while they work, and give the others back."""

import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import numpy as np
import pytest
import threadpoolctl
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
    """What is asked of BLAS, one after the other: limits, and "back"."""
    asked = []

    class Libraries:
        def limit(self, limits, user_api):
            asked.append((limits, user_api))
            return self

        def restore_original_limits(self):
            asked.append("back")

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
        assert last.result() == [(1, "blas")]
    assert told == [(1, "blas"), "back"]


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
    assert told == [(1, "blas"), "back"]


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
    assert told == [(1, "blas"), "back"] * (len(told) // 2)


def test_of_a_small_one_nothing_is_asked(told):
    mechanism = pj.load("four_bar")
    mechanism.close(mechanism.home.actuated + 0.01)
    assert told == []
