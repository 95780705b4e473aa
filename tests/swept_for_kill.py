"""A sweep in a process of its own, to be killed: `multiprocessing` imports this by its name."""

from __future__ import annotations

import os

import numpy as np
from mechanisms import loaded

import pmjac_pin as pj

# What a server of forks imports once, before the first of them; Dask is what xarray asks for.
PRELOADED = ["pmjac_pin.studies.sweep.sweep", "xarray", "zarr", "dask.array"]


def reach(poses, found):
    """A measure of one's own: how far the tool is from the origin, and a joint's value."""
    return np.column_stack([np.linalg.norm(found.position, axis=1), poses.joint("theta1")])


def go_on(out, count, workers=1, progress=None):
    """Sweep `count` times `count` poses into `out`, each a chunk, going on there."""
    lengths = np.linspace(0.85, 1.2, count)
    pj.sweep(
        loaded("three_rps"),
        {"l1": lengths, "l2": lengths},
        measures=("J_eq", "q", "share", ("reach", reach)),
        out=out,
        chunk=1,
        workers=workers,
        resume=True,
        progress=progress,
    )


def swept_for_kill(out, count, workers, said):
    """Sweep, with a byte for each chunk, until one kills the group of this process."""
    os.setsid()
    go_on(out, count, workers, lambda *_: said.send_bytes(b"."))
