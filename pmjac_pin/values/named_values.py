"""Values that carry names: taken by these, never by their order."""

from __future__ import annotations

import reprlib
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from pmjac_pin.errors import ArgumentError


def named_values(given: Any, what: str) -> dict[Any, Any] | None:
    """Return what a caller gave by its names, None for values that have only their order.

    Names have mappings, pandas' Series, xarray's arrays of one dimension, NumPy's records, named
    tuples and rows of a database. None of these packages is imported.

    Raises
    ------
    ArgumentError
        A name twice, or labels that are neither names nor 0, 1, 2, ... in this order; a table.

    Examples
    --------
    >>> named_values({"l2": 1.1, "l1": 1.0}, "motor values")
    {'l2': 1.1, 'l1': 1.0}
    >>> named_values([1.0, 1.1], "motor values")
    """
    if type(given) in (list, tuple, float, int) or _is_plain(given):
        return None
    if isinstance(given, Mapping):
        return dict(given)
    pairs = _labelled_pairs(given, what)
    if pairs is None:
        return None
    labels = [label for label, _ in pairs]
    if not any(isinstance(label, str) for label in labels) and labels == list(range(len(labels))):
        return None
    if not all(isinstance(label, str) for label in labels) or len(set(labels)) < len(labels):
        message = f"{what} are labelled {reprlib.repr(labels)}, by no names, or by one twice"
        raise ArgumentError(f"{message}; give names, or a plain list")
    return dict(pairs)


def _is_plain(given: Any) -> bool:
    """Whether this is an array of NumPy's own, without fields."""
    return type(given) is np.ndarray and given.dtype.names is None


def _labelled_pairs(given: Any, what: str) -> list[tuple[Any, Any]] | None:
    """Return labels and values, each by the way that its kind has for it."""
    if callable(getattr(given, "_asdict", None)):  # a named tuple
        return list(given._asdict().items())
    if names := getattr(getattr(given, "dtype", None), "names", None):
        return [(name, np.squeeze(given[name])) for name in names]
    if callable(getattr(given, "iterrows", None)):
        todo = "give one row of it, e.g. frame.iloc[0]"
        raise ArgumentError(f"{what} are given as a table; {todo}")
    if callable(getattr(given, "keys", None)):  # a Series, a row of a database
        return _zipped(given.keys(), given)
    dimensions: Any = getattr(given, "dims", ())
    coordinates: Any = getattr(given, "coords", {})
    if len(dimensions) == 1 and (labels := _labels(dimensions, coordinates)) is not None:
        return _zipped(labels, np.asarray(given))
    return None


def _labels(dimensions: Any, coordinates: Any) -> list[Any] | None:
    """Return what labels the one dimension of xarray's array, under its own name or another."""
    if dimensions[0] in coordinates:
        return list(np.asarray(coordinates[dimensions[0]]).tolist())
    along = [one for one in coordinates.values() if getattr(one, "dims", ()) == dimensions]
    named = [labels for one in along if _are_names(labels := np.asarray(one).tolist())]
    if len(named) > 1:
        raise ArgumentError(f"values are labelled in {len(named)} ways; give them by one name each")
    return named[0] if named else None


def _are_names(labels: list[Any]) -> bool:
    return all(isinstance(label, str) for label in labels)


def _zipped(labels: Iterable[Any], values: Iterable[Any]) -> list[tuple[Any, Any]]:
    labels, values = list(labels), list(values)
    # A table's keys are its columns; its shape is refused where its numbers are looked at.
    return list(zip(labels, values, strict=False)) if len(labels) == len(values) else []
