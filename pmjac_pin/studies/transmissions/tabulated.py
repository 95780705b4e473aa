"""Tabulated: exact values at the points of a table, as files."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass

import numpy as np

from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.values.arrays import Array, Index

TABLE_SUFFIXES = (".h", ".npz", ".csv")


@dataclass(frozen=True, eq=False)
class Tabulated:
    """A transmission at the points of a grid.

    Attributes
    ----------
    joints, motors : tuple of str
    axes : tuple of ndarray
        Joint values, m or rad.
    motor_values : ndarray, shape (*grid, n)
        θ, m or rad.
    ratio : ndarray, shape (*grid, n, n)
        ∂θ/∂x.
    twist : ndarray, shape (*grid, n), or None
        ∂²θ/∂x₁∂x₂, of two joints.
    error, lower, upper : ndarray
        As of `TransmissionTable`.
    evidence : str
    """

    joints: tuple[str, ...]
    motors: tuple[str, ...]
    axes: tuple[Array, ...]
    motor_values: Array
    ratio: Array
    twist: Array | None
    error: Array
    lower: Array
    upper: Array
    evidence: str

    def encoded(self, suffix: str) -> bytes:
        """Return the contents of a file, .npz or .csv."""
        return {".npz": self._npz, ".csv": self._csv}[suffix]()

    def _npz(self) -> bytes:
        contents = io.BytesIO()
        arrays = {
            "joints": np.array(self.joints),
            "motors": np.array(self.motors),
            **{f"axis{k}": axis for k, axis in enumerate(self.axes)},
            "motor_values": self.motor_values,
            "ratio": self.ratio,
            **({} if self.twist is None else {"twist": self.twist}),
            "error": self.error,
            "lower": self.lower,
            "upper": self.upper,
            "evidence": np.array(self.evidence),
        }
        np.savez(contents, **arrays)  # type: ignore[arg-type]
        return contents.getvalue()

    def _csv(self) -> bytes:
        contents = io.StringIO()
        writer = csv.writer(contents, lineterminator="\n")
        rates = [f"d{motor}/d{joint}" for motor in self.motors for joint in self.joints]
        writer.writerow([*self.joints, *self.motors, *rates])
        joints = np.stack(np.meshgrid(*self.axes, indexing="ij"), axis=-1)
        columns = [joints, self.motor_values, self.ratio]
        rows = np.hstack([column.reshape(joints[..., 0].size, -1) for column in columns])
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
