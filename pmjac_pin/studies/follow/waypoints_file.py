"""Waypoints files: motor values along a path, in CSV or TOML."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from pathlib import Path

import msgspec

from pmjac_pin.errors import ModelFileError, quoted
from pmjac_pin.files.bounded_toml import bounded_table, in_words_of_toml
from pmjac_pin.files.text_file import at_file, read_text
from pmjac_pin.files.user_path import shown_path
from pmjac_pin.model.table import TomlTable
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import as_numbers

MAXIMAL_WAYPOINTS_FILE = 1 << 24  # bytes
TIME = "t"  #: the name of the column of times


class _WaypointsTable(TomlTable, frozen=True, kw_only=True):
    """What a TOML file of waypoints says."""

    waypoints: dict[str, tuple[float, ...]]


@dataclass(frozen=True, slots=True)
class Waypoints:
    """Motor values by the motors' names, and their times where the file has a column of them."""

    columns: dict[str, Array]
    times: Array | None


def read_waypoints(path: Path) -> Waypoints:
    """Read a file of waypoints: a column a motor, by its name, and `t` for times.

    Parameters
    ----------
    path : Path
        CSV with a header, or TOML with a table `waypoints` of lists.

    Raises
    ------
    ModelFileError
        The message starts with the file's path.
    """
    if path.suffix.lower() not in (".csv", ".toml"):
        raise ModelFileError(f"{shown_path(path)}: waypoints are read from .csv or .toml")
    text = read_text(path, MAXIMAL_WAYPOINTS_FILE)
    with at_file(str(path)):
        given = _of_toml(text) if path.suffix.lower() == ".toml" else _of_csv(text)
        columns = {name: as_numbers(values, f"column {name!r}") for name, values in given.items()}
    times = columns.pop(TIME, None)
    return Waypoints(columns, times)


def _of_toml(text: str) -> dict[str, tuple[float, ...]]:
    try:
        return msgspec.convert(bounded_table(text), _WaypointsTable).waypoints
    except msgspec.ValidationError as error:
        raise ModelFileError(in_words_of_toml(str(error))) from None


def _of_csv(text: str) -> dict[str, list[float]]:
    try:
        rows = [row for row in csv.reader(io.StringIO(text), strict=True) if row]
    except csv.Error as error:
        raise ModelFileError(f"not valid CSV: {error}") from None
    names = [name.strip() for name in rows[0]]
    if len(set(names)) < len(names) or not all(names):
        raise ModelFileError(f"a header names each column once, got {quoted(rows[0])}")
    columns: dict[str, list[float]] = {name: [] for name in names}
    for number, row in enumerate(rows[1:], 2):
        if len(row) != len(names):
            raise ModelFileError(f"row {number} has {len(row)} values for {len(names)} columns")
        for name, item in zip(names, row, strict=True):
            try:
                columns[name].append(float(item))
            except ValueError:
                message = f"row {number}, column {name!r}: a number is wanted, got {quoted(item)}"
                raise ModelFileError(message) from None
    return columns
