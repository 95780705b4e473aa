"""``pmjac sweep``."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from cyclopts import Parameter

from pmjac_pin.batches.results import Status
from pmjac_pin.cli.output import Output
from pmjac_pin.files.user_path import user_path
from pmjac_pin.studies.sweep.sweep import sweep
from pmjac_pin.studies.sweep.sweep_file import read_sweep_file
from pmjac_pin.words.progress_bar import progress_bar
from pmjac_pin.words.terminal import one_line


def sweep_command(
    file: Annotated[str, Parameter(help="A TOML file: mechanism, out, over; see docs/sweeps.md.")],
    /,
    *,
    resume: Annotated[bool, Parameter(help="Go on with what is in its `out` already.")] = False,
    workers: Annotated[
        int | None, Parameter(help="How many processes; by default one a core.")
    ] = None,
) -> Output:
    """Close a mechanism at many values and keep what was measured in a zarr folder."""
    path = user_path(file)
    arguments = read_sweep_file(path).arguments(path.parent)
    with progress_bar("chunks") as progress:
        found = sweep(**arguments, resume=resume, workers=workers, progress=progress)
    counts = np.bincount(found.status.values.ravel(), minlength=len(Status))
    said = ", ".join(f"{counts[one]} {one.name}" for one in Status if counts[one])
    return f"{one_line(str(arguments['out']))}\n{said}\n"
