"""The same sweep by processes of one's own, by Dask and by Ray."""

from __future__ import annotations

import os
import threading
import time

import numpy as np
import pytest
import xarray
from mechanisms import loaded
from swept_for_kill import reach

import pmjac_pin as pj

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
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as here,
        distributed.Client(here) as client,
    ):
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
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    try:
        xarray.testing.assert_equal(
            swept(made_here(), client=ray, out=tmp_path / "store.zarr"), expected
        )
        assert_said(ray)
    finally:
        ray.shutdown()
