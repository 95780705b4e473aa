"""Sweep files: what `pmjac sweep` is asked for, in TOML."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, Literal

import msgspec
import numpy as np

from pmjac_pin.errors import ArgumentError, ModelFileError, did_you_mean
from pmjac_pin.files.bounded_toml import bounded_table, in_words_of_toml
from pmjac_pin.files.catalog import list_mechanisms
from pmjac_pin.files.text_file import at_file, read_text
from pmjac_pin.files.user_path import user_path
from pmjac_pin.model.table import TomlTable
from pmjac_pin.values.arrays import Array

MAXIMAL_SWEEP_FILE = 1 << 24  # bytes; lists of samples may be long

_MOST_VALUES = 10**8  # of an axis: they are kept


class EvenlySpaced(TomlTable, frozen=True, kw_only=True):
    """Evenly spaced values."""

    start: float = msgspec.field(name="from")
    to: float
    count: int

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.count < 1:
            raise ArgumentError(f"`count` is 1 or more, got {self.count}")
        if self.count > _MOST_VALUES:
            raise ArgumentError(f"`count` is {_MOST_VALUES:.0e} or less, got {self.count}")


class SweepFile(TomlTable, frozen=True, kw_only=True):
    """What a sweep file says; its keys are the arguments of `sweep`."""

    mechanism: str
    out: str
    over: dict[str, tuple[float, ...] | EvenlySpaced] | None = None
    samples: dict[str, tuple[float, ...]] | None = None
    measures: tuple[str, ...] = ("J_eq",)
    guess: str = "home"
    enforce_limits: bool | Literal["all"] = True
    chunk: int = 10_000

    def arguments(self, folder: Path) -> dict[str, Any]:
        """Return what `sweep` takes; paths are seen from the file's folder."""
        over, samples = self.over, self.samples
        in_catalogue = self.mechanism in list_mechanisms()
        return {
            "mechanism": self.mechanism if in_catalogue else folder / user_path(self.mechanism),
            "out": folder / user_path(self.out),
            "over": over and {name: _axis_values(axis) for name, axis in over.items()},
            "samples": samples and {name: list(values) for name, values in samples.items()},
            "measures": self.measures,
            "guess": self.guess,
            "enforce_limits": self.enforce_limits,
            "chunk": self.chunk,
        }


def _axis_values(axis: tuple[float, ...] | EvenlySpaced) -> Array:
    if isinstance(axis, EvenlySpaced):
        return np.linspace(axis.start, axis.to, axis.count)
    return np.array(axis, dtype=float)


def read_sweep_file(path: Path) -> SweepFile:
    """Read and check a sweep file.

    Raises
    ------
    ModelFileError
        The message starts with the file's path and names the key at fault.
    """
    text = read_text(path, MAXIMAL_SWEEP_FILE)
    with at_file(str(path)):
        try:
            return msgspec.convert(bounded_table(text), SweepFile)
        except msgspec.ValidationError as error:
            raise ModelFileError(_sweep_fault(error)) from None


def _sweep_fault(error: msgspec.ValidationError) -> str:
    message = in_words_of_toml(str(error))
    if unknown := re.search(r"unknown key `([^`]*)`", message):
        table = EvenlySpaced if "at `over" in message else SweepFile
        keys = [one.encode_name for one in msgspec.structs.fields(table)]
        message += did_you_mean(unknown[1], keys)
    return message
