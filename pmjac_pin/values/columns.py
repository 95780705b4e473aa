"""Values by names: the axes of a grid, or samples."""

from __future__ import annotations

from collections.abc import Mapping

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import as_numbers


def named_columns(given: object, what: str) -> dict[str, Array]:
    """Return lists of values by their names, or say what is wrong with them.

    Raises
    ------
    ArgumentError

    Examples
    --------
    >>> named_columns({"l1": [1.0, 1.1]}, "over")
    {'l1': array([1. , 1.1])}
    """
    if not isinstance(given, Mapping) or not given:
        raise ArgumentError(f"`{what}` is a mapping of names to values, got {quoted(given)}")
    columns = {}
    for name, values in given.items():
        # Plain lists, NumPy's arrays, and such with labels of their own, as xarray's.
        column = as_numbers(getattr(values, "values", values), f"`{what}`: the values of {name!r}")
        if not isinstance(name, str) or column.ndim != 1 or not column.size:
            wanted = f"`{what}`: a list of values for {quoted(name)} expected"
            raise ArgumentError(f"{wanted}, got shape {column.shape}")
        columns[name] = column
    return columns
