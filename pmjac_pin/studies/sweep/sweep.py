"""sweep: a map of a mechanism over its motors and parameters, resumable."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from pmjac_pin.batches.pieces import Progress, interrupted
from pmjac_pin.batches.results import Status
from pmjac_pin.errors import ArgumentError
from pmjac_pin.loading import load
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.datasets import Dataset, dataset
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.sweep.hands import Hands
from pmjac_pin.studies.sweep.own_measures import Measure
from pmjac_pin.studies.sweep.points import Region
from pmjac_pin.studies.sweep.question import identity, points_asked, question
from pmjac_pin.studies.sweep.store import MARK, Store, packages
from pmjac_pin.studies.sweep.work import SweepWork
from pmjac_pin.values.checks import as_count, as_flag

_MOST_IN_MEMORY = 10**7  # points: some hundred bytes each


def sweep(
    mechanism: Mechanism | str | Path,
    over: Mapping[Any, Any] | None = None,
    *,
    samples: Any = None,
    measures: Iterable[str | tuple[str, Measure]] | Mapping[str, Measure] = ("J_eq",),
    out: str | os.PathLike[str] | None = None,
    resume: bool = False,
    guess: str = "home",
    enforce_limits: bool | str = True,
    chunk: int = 10_000,
    workers: int | None = None,
    client: Any = None,
    progress: Progress | None = None,
) -> Dataset:
    """Close a mechanism at many values of motors and parameters, and measure each pose.

    Each pose is followed from the same named pose, so that a result depends neither on workers
    nor on what was interrupted, and on chunks by rounding alone.

    Parameters
    ----------
    mechanism : Mechanism, str or Path
        Or a name of the catalogue, or a path.
    over : mapping of str to array_like, shape (k,), or xarray.Dataset
        Values of motors (m or rad) and parameters: all combinations are computed. The other
        motors stay as at home, the other parameters as the mechanism has them. Of a dataset, its
        variables and coordinates, of one dimension each.
    samples : mapping of str to array_like, shape (k,), or table
        Instead: values that belong together, as drawn at random; also the columns of a pandas
        ``DataFrame``, of NumPy's records or of an xarray ``Dataset`` along one dimension.
    measures : iterable of str or (str, callable), or mapping of str to callable
        Variables of the result beside `status`: "share" and "q" as of `ManyClosed`, "J_eq",
        "Jv_eq", "Jw_eq", "velocity_radii", "velocity_rank", "velocity_volume", "angular_radii",
        "angular_rank", "angular_volume", "smallest", "condition", "position" and "rotation" as of
        `ManyMeasures`.
        And functions (`ManyClosed`, `ManyMeasures`) ↦ array_like, shape (N, ...), by a name: they
        are given N poses whose status is CLOSED, as `Batch.measures_at` returns them, and say of
        each what does not depend on the others; elsewhere is NaN.
    out : path, optional
        A zarr folder to be made. What is done stays there if the process ends early.
    resume : bool
        Go on with what is in `out` already; begin where there is nothing.
    guess : str
        The pose that all paths begin at.
    enforce_limits : bool or "all"
        As for `Mechanism.close`.
    chunk : int
        The largest number of poses that are computed at once, by one worker.
    workers : int, optional
        How many processes; by default as many as there are cores that this one may use. 1 for this
        one alone. A script that starts others has to ask for ``__name__ == "__main__"``.
        Of a client, how many chunks it computes at once, by default as many as it says: it is
        handed three times as many, and more as these are done.
    client : optional
        Dask's ``Client``, an executor of ``concurrent.futures``, or the module ``ray``, to hand
        the chunks to; all of its workers have to see `out`.
    progress : callable, optional
        (chunks done, chunks) ↦ anything.

    Returns
    -------
    xarray.Dataset
        Dimensions are the names of `over`, or "sample". Opened from `out` where that is given:
        its arrays are read when they are asked for. `status` is a `Status`.

    Raises
    ------
    ArgumentError, UnknownNameError
        No such motor, parameter, measure or pose; values out of range or in another unit; `out`
        holds another sweep; a function that fails, returns something else, or cannot be sent.
    OutputError
        `out` exists and is not to be resumed, or cannot be made.
    MissingDependencyError
        xarray or zarr is not installed.
    WorkerError
        A process that computes has ended before it has answered.
    Interrupted
        By Ctrl-C; its `done` is the dataset as far as it is known.

    Examples
    --------
    >>> import numpy as np, pmjac_pin as pj
    >>> lengths = np.linspace(0.9, 1.1, 5)
    >>> found = pj.sweep(pj.load("three_rps"), {"l1": lengths, "l2": lengths}, workers=1)
    >>> dict(found.J_eq.sizes)
    {'l1': 5, 'l2': 5, 'row': 6, 'motor': 3}
    >>> height = lambda poses, found: found.position[:, 2]
    >>> found = pj.sweep("three_rps", {"l1": lengths}, measures={"height": height}, workers=1)
    >>> found.height.dims
    ('l1',)
    """
    packages()
    resume = as_flag(resume, "resume")
    machine = mechanism if isinstance(mechanism, Mechanism) else load(mechanism)
    points = points_asked(machine, over, samples)
    work = question(machine, points, measures, guess, enforce_limits)
    shape = points.chunk(as_count(chunk, "`chunk`"))
    regions = points.regions(shape)
    hands = Hands.asked(client, workers, len(regions), progress)
    if hands.elsewhere:
        for one in work.own:
            one.contents  # noqa: B018 - says what cannot be sent, before any work
    what = identity(work, machine, shape)
    if out is None:
        return _in_memory(work, regions, hands, what)
    store = Store.at(out)
    if resume and os.path.exists(store.path):  # noqa: PTH110 - Path.exists raises for long names
        store.check(what)
    else:
        store.create(work, shape, what)
    return _in_store(store, work, regions, hands)


def _memory(work: SweepWork) -> dict[str, NDArray[Any]]:
    """Return arrays for all points; what is not done is said in them."""
    points = work.points
    if points.count > _MOST_IN_MEMORY:
        most = f"at most {_MOST_IN_MEMORY:.0e} are kept in memory"
        raise ArgumentError(f"{points.count:.3g} points without `out`: {most}; name a folder")
    return {
        name: variable.empty(points.shape, work.labels, not_done=True)
        for name, variable in work.variables.items()
    }


@contextlib.contextmanager
def _kept_on_interrupt(found: Callable[[], Dataset]) -> Iterator[Callable[[], Dataset]]:
    """Hand what is done to whoever interrupts."""
    try:
        yield found
    except KeyboardInterrupt:
        done = found()
        known = int((done.status != Status.NOT_DONE).sum())
        raise interrupted(f"{known} of {done.status.size} poses", done) from None


def _with_labels(work: SweepWork, found: Dataset) -> Dataset:
    """Say what the numbers of statuses and the places along the axes mean, and rest on."""
    statement = "statuses, poses and measures are those of single calls, to rounding"
    if own := ", ".join(one.name for one in work.own):
        statement += f"; functions that the caller gave say of them: {own}"
    found.attrs["evidence"] = str(Evidence("tolerance", statement))
    found.status.attrs["flag_values"] = [one.value for one in Status]
    found.status.attrs["flag_meanings"] = " ".join(one.name for one in Status)
    return found.assign_coords(
        {name: list(labels) for name, labels in work.labels.items() if name in found.dims}
    )


def _in_memory(
    work: SweepWork, regions: list[Region], hands: Hands, what: Mapping[str, Any]
) -> Dataset:
    """Compute all regions, and return them in arrays."""
    arrays, jobs = _memory(work), [(work, region) for region in regions]
    with _kept_on_interrupt(
        lambda: _with_labels(work, _dataset(work, arrays, {MARK: what}))
    ) as found:
        for region, values in zip(regions, hands.results(SweepWork.compute, jobs), strict=True):
            for name, part in values.items():
                arrays[name][region] = part
    return found()


def _in_store(store: Store, work: SweepWork, regions: list[Region], hands: Hands) -> Dataset:
    """Compute the regions that a folder has not yet, and return what it has then."""
    with _kept_on_interrupt(lambda: _with_labels(work, store.open())) as found:
        jobs = [(store, work, index, regions[index]) for index in store.left().tolist()]
        for _ in hands.results(_compute_and_write, jobs):
            pass
    return found()


def _compute_and_write(store: Store, work: SweepWork, index: int, region: Region) -> None:
    store.write(index, region, work.compute(region))


def _dataset(
    work: SweepWork, arrays: Mapping[str, NDArray[Any]], attributes: Mapping[str, Any]
) -> Dataset:
    points = work.points
    values = {
        name: ((name,) if points.is_grid else points.dims, column)
        for name, column in points.values.items()
    }
    asked = work.variables
    variables = {name: ((*points.dims, *asked[name].dims), array) for name, array in arrays.items()}
    return dataset({**variables, **values}, {}, attributes)
