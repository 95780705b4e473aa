"""Values by names: the axes of a grid, or samples, from mappings, tables and datasets.

Neither pandas nor xarray is imported: what a caller gave is known by what it has.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import as_numbers

_SPELLINGS = {
    "m": ("m", "meter", "meters", "metre", "metres"),
    "rad": ("rad", "radian", "radians"),
}


def named_axes(given: object, what: str, units: Mapping[str, str]) -> dict[str, Array]:
    """Return the axes of a grid by their names, or say what is wrong with them.

    Parameters
    ----------
    given : mapping of str to array_like, shape (k,), or xarray.Dataset
        Of a dataset, variables and coordinates, along a dimension each. What labels a dimension
        along which something of `units` lies is no axis.
    what : str
        The argument's name.
    units : mapping of str to str
        "m" or "rad" of each name that there may be: a column that states another is refused.

    Raises
    ------
    ArgumentError

    Examples
    --------
    >>> named_axes({"l1": [1.0, 1.1]}, "over", {"l1": "m"})
    {'l1': array([1. , 1.1])}
    """
    if _is_dataset(given):
        columns = _dataset_variables(given, units)
        along: dict[Any, Any] = {}
        for name, column in columns.items():
            other = along.setdefault(column.dims, name)
            if column.dims and other != name:
                message = f"{other!r} and {name!r} lie along one dimension, {column.dims[0]!r}"
                right = "values that belong together are samples, axes have one each"
                raise ArgumentError(f"`{what}`: {message}; {right}")
    elif not isinstance(given, Mapping) and columns_of(given) is not None:
        right = "they are samples; axes are a mapping of names to values"
        raise ArgumentError(f"`{what}`: the values in a row of a table belong together: {right}")
    else:
        columns = _of_mapping(given, what)
    return _columns_of_numbers(columns, what, units)


def named_samples(given: object, what: str, units: Mapping[str, str]) -> dict[str, Array]:
    """Return columns whose values belong together by their names, or say what is wrong with them.

    Parameters
    ----------
    given : mapping of str to array_like, shape (k,), or a table
        A pandas ``DataFrame``, NumPy's records, an xarray ``Dataset`` along one dimension, or an
        array of xarray's that labels one of its two axes by the names. What numbers or labels the
        rows is a column where `units` has its name.
    what, units
        As for `named_axes`.

    Raises
    ------
    ArgumentError
    """
    if _is_dataset(given):
        columns = _dataset_variables(given, units)
        dimensions = {name: column.dims for name, column in columns.items() if column.ndim == 1}
        if len(set(dimensions.values())) > 1:
            got = ", ".join(f"{name!r} along {dims[0]!r}" for name, dims in dimensions.items())
            right = "samples lie along one dimension; axes of their own make a grid"
            raise ArgumentError(f"`{what}`: {right}: got {got}")
    elif (table := columns_of(given)) is not None:
        for name in table if hasattr(given, "dims") else ():  # an array that labels its columns
            check_stated_unit(given, f"`{what}`: {name!r}", units.get(name))
        columns = _row_labels(given, units) | table
    else:
        columns = _of_mapping(given, what)
    return _columns_of_numbers(columns, what, units)


def columns_of(given: Any) -> dict[Any, Any] | None:
    """Return columns by their names, None for what has none."""
    if type(given) is np.ndarray and given.dtype.names is None:
        return None
    if names := getattr(getattr(given, "dtype", None), "names", None):
        return {name: given[name] for name in names}
    if isinstance(given, Mapping) or callable(getattr(given, "keys", None)):
        return {name: given[name] for name in list(given.keys())}
    return _labelled_columns(given)


def without_labels(column: Any) -> Any:
    """Return the numbers of pandas' columns and xarray's variables without their own labels."""
    return getattr(column, "values", column)


def labels_of_rows(given: Any) -> list[Any] | None:
    """Return what labels the rows of pandas' tables and columns and xarray's arrays; None: nothing.

    Examples
    --------
    >>> labels_of_rows([1.0, 2.0]) is None
    True
    """
    index, dimensions = getattr(given, "index", None), getattr(given, "dims", ())
    if dimensions and dimensions[0] in given.coords:
        index = np.asarray(given.coords[dimensions[0]])
    tolist = getattr(index, "tolist", None)
    return None if tolist is None else list(tolist())


def _labelled_columns(given: Any) -> dict[Any, Any] | None:
    """Return the columns of an array of xarray's that labels one of its two axes by names."""
    dimensions, coordinates = getattr(given, "dims", ()), getattr(given, "coords", {})
    if len(dimensions) != 2:
        return None
    for axis, dimension in enumerate(dimensions):
        labels = np.asarray(coordinates[dimension]).tolist() if dimension in coordinates else []
        if labels and all(isinstance(label, str) for label in labels):
            if len(set(labels)) < len(labels):
                raise ArgumentError(f"motor values are labelled {quoted(labels)}, by one twice")
            table = np.moveaxis(np.asarray(given), axis, 1)
            return {label: table[:, k] for k, label in enumerate(labels)}
    return None


def _is_dataset(given: Any) -> bool:
    return hasattr(given, "data_vars") and hasattr(given, "coords")


def _dataset_variables(given: Any, known: Mapping[str, str]) -> dict[Any, Any]:
    """Return a dataset's variables and coordinates, but for those that label a known one's rows."""
    found = {name: given[name] for name in (*given.data_vars, *given.coords)}
    labelled = {dimension for name in found if name in known for dimension in found[name].dims}
    return {name: one for name, one in found.items() if name in known or name not in labelled}


def _row_labels(given: Any, known: Mapping[str, str]) -> dict[Any, Any]:
    """Return what is known of what labels the rows of a table of pandas'."""
    index = getattr(given, "index", None)
    names = [name for name in getattr(index, "names", ()) if name in known]
    return {name: index.get_level_values(name) for name in names}  # type: ignore[union-attr]


def _of_mapping(given: object, what: str) -> dict[Any, Any]:
    if not isinstance(given, Mapping) or not given:
        raise ArgumentError(f"`{what}` is a mapping of names to values, got {quoted(given)}")
    return dict(given)


def _columns_of_numbers(
    columns: Mapping[Any, Any], what: str, units: Mapping[str, str]
) -> dict[str, Array]:
    if not columns:
        raise ArgumentError(f"`{what}` is a mapping of names to values, and here are none")
    found = {}
    for name, given in columns.items():
        values = as_numbers(without_labels(given), f"`{what}`: the values of {name!r}")
        if not isinstance(name, str) or values.ndim != 1 or not values.size:
            wanted = f"`{what}`: a list of values for {quoted(name)} expected"
            raise ArgumentError(f"{wanted}, got shape {values.shape}")
        check_stated_unit(given, f"`{what}`: {name!r}", units.get(name))
        found[name] = values
    return found


def check_stated_unit(column: Any, what: str, wanted: str | None) -> None:
    """Raise ArgumentError where a column states another unit than ours, in its attributes.

    Examples
    --------
    >>> check_stated_unit([0.1, 0.2], "'theta1'", "rad")
    """
    attributes = getattr(column, "attrs", None)
    if wanted is None or not isinstance(attributes, Mapping):
        return
    for key, stated in attributes.items():
        if str(key).lower() not in ("units", "unit"):
            continue
        if stated is not None and str(stated).strip() not in ("", *_SPELLINGS[wanted]):
            right = f"values in {wanted} are wanted, and {key} {wanted!r} or none"
            raise ArgumentError(f"{what} has the {key} {quoted(stated)}: {right}")
