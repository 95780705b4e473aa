"""Exact values at the points of a table, as files."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.values.arrays import Array, Index

TABLE_SUFFIXES = (".h", ".npz", ".csv")


def table_bytes(arrays: Mapping[str, NDArray[Any]], suffix: str) -> bytes:
    """Return the contents of a file, .npz or .csv, of what `TransmissionTable.tabulated` tells."""
    return {".npz": _npz, ".csv": _csv}[suffix](arrays)


def _npz(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    contents = io.BytesIO()
    np.savez(contents, **arrays)  # type: ignore[arg-type]
    return contents.getvalue()


def _csv(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    contents = io.StringIO()
    writer = csv.writer(contents, lineterminator="\n")
    motors, joints = arrays["motors"].tolist(), arrays["joints"].tolist()
    rates = [f"d{motor}/d{joint}" for motor in motors for joint in joints]
    writer.writerow([*joints, *motors, *rates])
    axes = [arrays[f"axis{k}"] for k in range(len(joints))]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    columns = [points, arrays["motor_values"], arrays["ratio"]]
    rows = np.hstack([column.reshape(points[..., 0].size, -1) for column in columns])
    writer.writerows(rows.tolist())
    return contents.getvalue().encode()


def twist_of(coordinates: JointCoordinates, columns: Index, flat: Array) -> Array:
    """Return ∂²θ/∂x₁∂x₂ (N, k) of columns of v, of a sheet's data (N, 2, 2, nq).

    Where q holds cosine and sine of an angle, of that angle.
    """
    entries = np.array([coordinates.entry(column) for column in columns.tolist()])
    behind = np.minimum(entries + 1, flat.shape[-1] - 1)
    cosine, sine = flat[..., entries], flat[..., behind]
    of_angle = (
        cosine[:, 0, 0] * sine[:, 1, 1]
        - sine[:, 0, 0] * cosine[:, 1, 1]
        + cosine[:, 0, 1] * sine[:, 1, 0]
        - sine[:, 0, 1] * cosine[:, 1, 0]
    )
    return np.where(coordinates.wraps[columns], of_angle, cosine[:, 1, 1])
