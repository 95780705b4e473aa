"""TransmissionTable: a transmission over a rectangle by interpolation, its error bounded."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pmjac_pin.errors import ArgumentError, OutputError
from pmjac_pin.files.output_file import check_new, write_files
from pmjac_pin.files.user_path import output_path, shown_path
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.transmissions.c_header import HeaderParts, c_header
from pmjac_pin.studies.transmissions.newton_program import NewtonProgram
from pmjac_pin.studies.transmissions.rectangle import Rectangle
from pmjac_pin.studies.transmissions.sheet import Sheet
from pmjac_pin.studies.transmissions.tabulated import TABLE_SUFFIXES, table_bytes, twist_of
from pmjac_pin.studies.transmissions.transmission import Transmission
from pmjac_pin.studies.transmissions.transmission_map import TransmissionMap
from pmjac_pin.values.arrays import Array, ReadOnlyArrays
from pmjac_pin.values.brief import at_most, with_names
from pmjac_pin.values.checks import as_flag, as_numbers


@dataclass(frozen=True, eq=False, repr=False)
class TransmissionTable(ReadOnlyArrays):
    """A transmission over a rectangle of joint values.

    Made by `pmjac_pin.transmission_table`. The closed pose is interpolated between the points of
    a grid by polynomials that are cubic in each joint, of exact values and derivatives there.

    Attributes
    ----------
    map : TransmissionMap
        The points.
    sheet : Sheet
        The polynomials, of the entries of q.
    program : NewtonProgram
        What leads from them to the exact pose.
    error : ndarray, shape (n,)
        How far each motor's interpolated value is from the exact one at most, m or rad; rounding,
        of some 1e-15, comes on top.
    alone : ndarray, shape (nq,)
        No other closed pose has each entry of q nearer to the interpolated one than this.
    lower, upper : ndarray, shape (n, n)
        Between which R is, all over the rectangle.
    evidence : Evidence
        Whether that is proven, or an estimate.
    """

    map: TransmissionMap
    sheet: Sheet
    program: NewtonProgram
    error: Array
    alone: Array
    lower: Array
    upper: Array
    evidence: Evidence

    @property
    def transmission(self) -> Transmission:
        """Motors and joints."""
        return self.map.transmission

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the n joints."""
        return self.transmission.joints

    @property
    def motors(self) -> tuple[str, ...]:
        """Names of the n motors."""
        return self.transmission.motors

    @property
    def rectangle(self) -> Rectangle:
        """The joint values that the table is for."""
        return self.map.rectangle

    def motor_values(self, joints: ArrayLike) -> Array:
        """Return θ by interpolation, shape (..., n), as near the exact values as `error` says.

        Parameters
        ----------
        joints : array_like, shape (..., n)
            x, m or rad.

        Raises
        ------
        ArgumentError
            Values outside the rectangle.
        """
        rows, shape = self._rows(joints)
        return self._motors(self.sheet.at(rows)).reshape(shape)

    def exact(self, joints: ArrayLike) -> tuple[Array, Array]:
        """Return θ (..., n) and R (..., n, n), by Newton's steps from the interpolated pose.

        Raises
        ------
        ArgumentError
            Values outside the rectangle.
        """
        rows, shape = self._rows(joints)
        q = self.program.polished(self.sheet.at(rows), rows)
        ratio = self.program.run({"ratio": self.program.step["ratio"]}, q)["ratio"]
        return self._motors(q).reshape(shape), ratio.reshape(*shape, shape[-1])

    def c(self, name: str | None = None) -> str:
        """Return a header in C99 without dependencies: position, velocity and effort, both ways.

        Each pose is the exact one: Newton's steps from the table, until they are rounding. What
        does not converge, is outside the rectangle, singular, or no pose of the table has a
        status of its own, and NaN for its numbers.

        Parameters
        ----------
        name : str, optional
            What its names begin with; by default the mechanism's.

        Raises
        ------
        ArgumentError
            A name that C does not allow.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> table = pj.transmission_table(pj.load("four_bar"), {"phi1": (2.2, 2.4)}, points=5)
        >>> text = table.c("rocker")
        >>> [line for line in text.splitlines() if "int rocker_at" in line]  # doctest: +ELLIPSIS
        ['static inline int rocker_at_joints(...', 'static inline int rocker_at_motors(...']
        """
        parts = HeaderParts(
            transmission=self.transmission,
            sheet=self.sheet,
            program=self.program,
            alone=self.alone,
            motors=self.map.motors,
        )
        return c_header(parts, name, self.said())

    def save(
        self, path: str | os.PathLike[str], *, name: str | None = None, force: bool = False
    ) -> None:
        """Write the table: as a C header (.h), for NumPy (.npz) or as text with commas (.csv).

        Of an .npz, `motor_values` (*grid, n), `ratio` (*grid, n, n) and, of two joints, `twist`
        (*grid, n), ∂²θ/∂x₁∂x₂, are at the points of `axis0` and `axis1`: cubic Hermite
        polynomials of them are the interpolation whose `error` (n,) is told, but for motors that
        turn without end, of which that is of their cosines and sines. `joints`, `motors`,
        `lower`, `upper` and `evidence` are as here. A .csv has one row a point: joints, motors,
        rates of motors by those of joints.

        Parameters
        ----------
        path : str or Path
            It ends in one of these.
        name : str, optional
            What the names of a header begin with, as of `c`.
        force : bool
            Replace a file that exists.

        Raises
        ------
        OutputError
            It ends otherwise, exists, or cannot be written; then nothing has changed.
        """
        force = as_flag(force, "force")
        suffix = output_path(path).suffix
        if suffix not in TABLE_SUFFIXES:
            ends = ", ".join(TABLE_SUFFIXES)
            raise OutputError(f"{shown_path(output_path(path))}: a table's file ends in {ends}")
        check_new(path, force)
        header = suffix == ".h"
        contents = self.c(name).encode() if header else table_bytes(self.tabulated(), suffix)
        write_files({path: contents}, replace=force)

    def tabulated(self) -> dict[str, NDArray[Any]]:
        """Return exact values at the points, and what the table says of itself: as in its .npz.

        Of two joints `twist`, shape (*grid, n), is ∂²θ/∂x₁∂x₂.
        """
        n, data = len(self.joints), self.sheet.data
        shape, flat = data.shape[:n], data.reshape(-1, *data.shape[n:])
        poses: Array = flat[:, 0] if n == 1 else flat[:, 0, 0]
        told = self.program.run({"ratio": self.program.step["ratio"]}, poses)
        found = {
            "joints": np.array(self.joints),
            "motors": np.array(self.motors),
            **{f"axis{k}": axis for k, axis in enumerate(self.sheet.axes)},
            "motor_values": self._motors(poses).reshape(*shape, n),
            "ratio": told["ratio"].reshape(*shape, n, n),
        }
        if n > 1:
            coordinates, columns = self.transmission.by_motors.coordinates, self.program.followers
            found["twist"] = twist_of(coordinates, columns, flat).reshape(*shape, n)
        bounds = {"error": self.error, "lower": self.lower, "upper": self.upper}
        return {**found, **bounds, "evidence": np.array(str(self.evidence))}

    def said(self) -> Iterator[str]:
        """Yield what the table is of and what it rests on, line by line."""
        units = self.transmission.by_motors.units
        motors, joints = (
            ", ".join(f"{name} [{units[name]}]" for name in names)
            for names in (self.motors, self.joints)
        )
        yield f"The transmission of {self.transmission.by_motors.name}"
        yield f"between joints {joints} and motors {motors},"
        yield f"for {self.rectangle}."
        errors = zip(self.motors, self.error.tolist(), strict=True)
        yield "Largest error of interpolation: " + ", ".join(
            f"{name} {at_most(error)} {units[name]}" for name, error in errors
        )
        yield str(self.evidence)

    def _motors(self, q: Array) -> Array:
        coordinates = self.transmission.by_motors.coordinates
        return coordinates.values_of(q, self.program.followers)

    def _rows(self, joints: ArrayLike) -> tuple[Array, tuple[int, ...]]:
        values, n = as_numbers(joints, "joint values"), len(self.joints)
        if not values.ndim or values.shape[-1] != n:
            raise ArgumentError(f"joint values of shape (..., {n}) expected, got {values.shape}")
        rows, (lower, upper) = values.reshape(-1, n), (self.rectangle.lower, self.rectangle.upper)
        outside = np.flatnonzero(((rows < lower) | (rows > upper)).any(axis=1))
        if outside.size:
            where = with_names(self.joints, rows[outside[0]])
            raise ArgumentError(f"{where} is outside the table, which is for {self.rectangle}")
        return rows, values.shape

    def __repr__(self) -> str:
        error = ", ".join(
            f"{name} {at_most(value)}"
            for name, value in zip(self.motors, self.error.tolist(), strict=True)
        )
        return f"TransmissionTable({self.rectangle}; error {error}: {self.evidence.kind})"
