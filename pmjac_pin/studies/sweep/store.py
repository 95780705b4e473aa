"""Store: a sweep's results in a zarr folder, each chunk written by one process, whole or not."""

from __future__ import annotations

import json
import os
import secrets
import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.errors import ArgumentError, MissingDependencyError, OutputError
from pmjac_pin.files.user_path import output_path, shown_path
from pmjac_pin.studies.sweep.points import Region
from pmjac_pin.studies.sweep.work import SweepWork
from pmjac_pin.values.arrays import Index

_DONE = "done"  # of each chunk: 1 once all of it is there
MARK = "pmjac_pin_sweep"


@dataclass(frozen=True, slots=True)
class Store:
    """A folder that holds a sweep, or will.

    Attributes
    ----------
    path : Path
    """

    path: Path

    @classmethod
    def at(cls, path: str | os.PathLike[str]) -> Store:
        """Return the store at a path that somebody gave."""
        place = output_path(path).absolute()
        if not place.parent.is_dir():
            raise OutputError(f"{shown_path(place)}: there is no folder {shown_path(place.parent)}")
        return cls(place)

    def create(self, work: SweepWork, chunk: tuple[int, ...], identity: Mapping[str, Any]) -> None:
        """Make it at once, without values."""
        draft = self.path.with_name(f".{self.path.name}.{secrets.token_hex(4)}")
        if os.path.lexists(self.path):  # a link that leads nowhere, too
            raise OutputError(
                f"{shown_path(self.path)}: exists already; with `resume` a sweep goes on there"
            )
        try:
            self._write_draft(draft, work, chunk, identity)
            draft.rename(self.path)
        except BaseException as error:
            shutil.rmtree(draft, ignore_errors=True)
            if isinstance(error, OSError):
                why = error.strerror or "cannot be written"
                raise OutputError(f"{shown_path(self.path)}: {why}") from None
            raise

    def check(self, identity: Mapping[str, Any]) -> None:
        """Raise where the folder holds another sweep, or none."""
        found, given = self._identity(), json.loads(json.dumps(identity))
        if other := [key for key in given if found.get(key) != given[key]]:
            raise ArgumentError(
                f"{shown_path(self.path)} is the store of another sweep: it differs in its "
                f"{', '.join(other)}; give another `out`"
            )

    def left(self) -> Index:
        """Return the numbers of the chunks that are not done."""
        return np.flatnonzero(np.asarray(self._group()[_DONE][:]) == 0)

    def write(self, index: int, region: Region, found: Mapping[str, NDArray[Any]]) -> None:
        """Write a chunk, and only then that it is done."""
        group = self._group()
        for name, values in found.items():
            group[name][region] = values
        group[_DONE][index] = 1

    def open(self) -> Any:
        """Return its contents."""
        xarray, _ = packages()
        return xarray.open_zarr(self.path, consolidated=False, chunks=None, drop_variables=[_DONE])

    def _identity(self) -> dict[str, Any]:
        try:
            return dict(self._group().attrs[MARK])
        except (KeyError, OSError, ValueError):
            raise OutputError(f"{shown_path(self.path)}: is no store of a sweep") from None

    def _group(self) -> Any:
        return packages()[1].open_group(self.path, mode="r+")

    def _write_draft(
        self, draft: Path, work: SweepWork, chunk: tuple[int, ...], identity: Mapping[str, Any]
    ) -> None:
        points = work.points
        group = packages()[1].create_group(draft, attributes={MARK: dict(identity)})
        for name, column in points.values.items():
            dims = (name,) if points.is_grid else points.dims
            group.create_array(name, data=column, dimension_names=dims)
        for name, variable in work.variables.items():
            part = variable.empty(chunk, work.labels)
            group.create_array(
                name,
                shape=(*points.shape, *part.shape[len(chunk) :]),
                chunks=part.shape,
                dtype=part.dtype,
                fill_value=variable.not_done,
                dimension_names=(*points.dims, *variable.dims),
            )
        group.create_array(
            _DONE,
            shape=(len(points.regions(chunk)),),
            chunks=(1,),
            dtype="u1",
            fill_value=0,
            compressors=None,
            dimension_names=("chunk",),
        )


def packages() -> tuple[Any, Any]:
    """Return xarray and zarr."""
    try:
        import xarray  # noqa: PLC0415
        import zarr  # noqa: PLC0415
    except ImportError as error:
        raise MissingDependencyError(
            f"a sweep needs xarray and zarr: pip install 'pmjac_pin[sweep]' ({error})"
        ) from error
    return xarray, zarr
