"""The same sweep by processes of one's own, by Dask and by Ray."""

from __future__ import annotations

import numpy as np
import pytest
import xarray
from mechanisms import loaded

import pmjac_pin as pj

LENGTHS = np.linspace(0.85, 1.2, 6)


def swept(**given):
    over = {"l1": LENGTHS, "l2": LENGTHS}
    return pj.sweep(loaded("three_rps"), over, measures=("J_eq", "q"), chunk=4, **given).load()


@pytest.fixture(scope="module")
def expected():
    return swept(workers=1)


@pytest.mark.slow
def test_processes(expected, tmp_path):
    found = swept(workers=2, out=tmp_path / "store.zarr")
    xarray.testing.assert_equal(found, expected)


@pytest.mark.slow
def test_dask(expected, tmp_path):
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as here,
        distributed.Client(here) as client,
    ):
        xarray.testing.assert_equal(swept(client=client), expected)
        for name in ("one.zarr", "one.zarr"):
            found = swept(client=client, out=tmp_path / name, resume=True)
            xarray.testing.assert_equal(found, expected)
        found = swept(client=client, out=tmp_path / "two.zarr")
        xarray.testing.assert_equal(found, expected)


@pytest.mark.slow
def test_ray(expected, tmp_path):
    ray = pytest.importorskip("ray")
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    try:
        xarray.testing.assert_equal(swept(client=ray, out=tmp_path / "store.zarr"), expected)
    finally:
        ray.shutdown()
