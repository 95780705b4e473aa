"""The same sweep by processes of one's own, by Dask and by Ray."""

from __future__ import annotations

import os
import threading
import time
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
import xarray
from mechanisms import loaded
from swept_for_kill import reach

import pmjac_pin as pj
from pmjac_pin.studies.sweep.clients import Client

LENGTHS = np.linspace(0.85, 1.2, 6)


def swept(reach=reach, **given):
    over = {"l1": LENGTHS, "l2": LENGTHS}
    measures = ("J_eq", "q", ("reach", reach))
    return pj.sweep(loaded("three_rps"), over, measures=measures, chunk=4, **given).load()


@pytest.fixture(scope="module")
def expected():
    return swept(workers=1)


def made_here():
    """A function that no other process can import: `reach`, of what is at hand here."""
    norm, stack = np.linalg.norm, np.column_stack
    return lambda poses, found: stack([norm(found.position, axis=1), poses.joint("theta1")])


def assert_said(client):
    """What a function raises there is said here; what cannot be sent, before any work."""
    lock = threading.Lock()

    def far_only(poses, found):
        if len(poses.q) == 2:  # the chunk, not the pose at which functions are tried
            raise ZeroDivisionError("none is far")
        return poses.share

    for function, said in (
        (far_only, "measure 'far': its function raised ZeroDivisionError: none is far"),
        (lambda poses, found: lock and poses.share, "measure 'far': its function cannot be sent"),
    ):
        with pytest.raises(pj.ArgumentError, match=said):
            pj.sweep("four_bar", {"theta1": [0.9, 1.0]}, measures={"far": function}, client=client)


class Outstanding:
    """Computes what is asked for, and notes how much was handed out at a time."""

    def __init__(self):
        self.now = self.most = 0

    def submit(self, function, *arguments, pure=None):
        self.now += 1
        self.most = max(self.most, self.now)
        return partial(self._result, function, *arguments)

    def _result(self, function, *arguments):
        self.now -= 1
        return function(*arguments)


class OfDask(Outstanding):
    __module__ = "distributed.client"

    def __init__(self, threads=(4, 3)):
        super().__init__()
        self._threads = threads

    def nthreads(self):
        return dict(enumerate(self._threads))

    def submit(self, *job, pure):
        assert pure is False
        return SimpleNamespace(result=super().submit(*job))


class OfRay(Outstanding):
    __name__ = "ray"
    initialized = False

    def is_initialized(self):
        return self.initialized

    def init(self):
        self.initialized = True

    def cluster_resources(self):
        assert self.initialized
        return {"CPU": 5.0, "memory": 1e9}

    def remote(self, function):
        return SimpleNamespace(remote=partial(Outstanding.submit, self, function))

    def get(self, task):
        return task()

    submit = None


class OfExecutor(Outstanding):
    def __init__(self, **told):
        super().__init__()
        vars(self).update(told)

    def submit(self, *job):
        return SimpleNamespace(result=super().submit(*job))


ANGLES = {"theta1": np.linspace(0.8, 1.1, 40)}


@pytest.mark.parametrize(
    ("client", "workers"),
    [
        (OfDask, 7),
        (OfRay, 5),
        (partial(OfExecutor, num_workers=6), 6),
        (partial(OfExecutor, _max_workers=4), 4),
        (OfExecutor, 2),
        (partial(OfDask, ()), 2),  # a cluster that has none yet
    ],
)
def test_a_client_is_asked_how_many_it_is(client, workers, monkeypatch):
    """Three chunks are handed out for each; for as many as there are cores if it does not say."""
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {3, 5}, raising=False)
    expected = pj.sweep("four_bar", ANGLES, workers=1)
    for given, count in ((None, workers), (3, 3), (1000, 40)):
        made = client()
        found = pj.sweep("four_bar", ANGLES, chunk=1, client=made, workers=given)
        xarray.testing.assert_allclose(found, expected, atol=1e-12)
        assert (made.now, made.most) == (0, min(3 * count, 40))


def test_as_many_processes_as_cores_that_this_one_may_use(monkeypatch):
    """On one of them all is done here: what cannot be sent is not."""
    lock = threading.Lock()
    measures = {"far": lambda poses, found: lock and poses.share}
    monkeypatch.setattr(os, "cpu_count", lambda: 64)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {7}, raising=False)
    assert pj.sweep("four_bar", ANGLES, measures=measures, chunk=10).far.shape == (40,)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {7, 9})
    with pytest.raises(pj.ArgumentError, match="cannot be sent"):
        pj.sweep("four_bar", ANGLES, measures=measures, chunk=10)
    monkeypatch.delattr(os, "sched_getaffinity")  # as not on Linux
    with pytest.raises(pj.ArgumentError, match="cannot be sent"):
        pj.sweep("four_bar", ANGLES, measures=measures, chunk=10)
    monkeypatch.setattr(os, "cpu_count", lambda: None)  # where nobody knows
    assert pj.sweep("four_bar", ANGLES, measures=measures, chunk=10).far.shape == (40,)


@pytest.mark.parametrize("given", ["dask", "ray", 3])
def test_what_is_no_client_is_told_what_to_install(given, tmp_path):
    with pytest.raises(pj.ArgumentError, match=r"'pmjac_pin\[dask\]' or 'pmjac_pin\[ray\]'"):
        pj.sweep("four_bar", ANGLES, client=given, workers=2, out=tmp_path / "store.zarr")
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_processes(expected, tmp_path):
    found = swept(workers=2, out=tmp_path / "store.zarr")
    xarray.testing.assert_equal(found, expected)


def dies(poses, found):
    """Where it was tried all is well."""
    if len(poses.q) == 2 and poses.joint("theta1")[0] > 0.83:
        os._exit(1)
    return poses.share


@pytest.mark.slow
@pytest.mark.parametrize("seconds", [0.0, 1.0])
def test_a_process_that_dies(seconds, tmp_path):
    """Also where others are to be handed chunks that hears of it, having been busy."""
    with pytest.raises(pj.WorkerError, match="has ended before it has answered"):
        pj.sweep(
            "four_bar",
            {"theta1": np.linspace(0.8, 1.1, 41)},
            measures={"mine": dies},
            out=tmp_path / "store.zarr",
            chunk=2,
            workers=2,
            progress=lambda *done: time.sleep(seconds),
        )


@pytest.mark.slow
def test_dask(expected, tmp_path):
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(n_workers=3, threads_per_worker=1, dashboard_address=None) as here,
        distributed.Client(here) as client,
    ):
        assert Client.of(client).workers == 3
        xarray.testing.assert_equal(swept(made_here(), client=client.get_executor()), expected)
        xarray.testing.assert_equal(swept(made_here(), client=client), expected)
        for name in ("one.zarr", "one.zarr"):
            found = swept(made_here(), client=client, out=tmp_path / name, resume=True)
            xarray.testing.assert_equal(found, expected)
        found = swept(made_here(), client=client, out=tmp_path / "two.zarr")
        xarray.testing.assert_equal(found, expected)
        assert_said(client)


# Ray forks, and then runs another program; JAX, where a test before has imported it, warns of that.
@pytest.mark.filterwarnings(r"ignore:os\.fork\(\) was called:RuntimeWarning")
@pytest.mark.slow
def test_ray(expected, tmp_path):
    ray = pytest.importorskip("ray")
    ray.init(num_cpus=3, include_dashboard=False, log_to_driver=False)
    try:
        assert Client.of(ray).workers == 3
        xarray.testing.assert_equal(
            swept(made_here(), client=ray, out=tmp_path / "store.zarr"), expected
        )
        assert_said(ray)
    finally:
        ray.shutdown()
