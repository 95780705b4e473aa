"""Datasets of xarray, an extra that is imported when the first one is made."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from pmjac_pin.errors import MissingDependencyError

if TYPE_CHECKING:
    from xarray import Dataset as Dataset  # noqa: PLC0414 - for others
else:
    Dataset = Any


def dataset(
    variables: Mapping[str, Any], coordinates: Mapping[str, Any], attributes: Mapping[str, Any]
) -> Dataset:
    """Return arrays with names.

    Raises
    ------
    MissingDependencyError
        xarray is not installed.
    """
    try:
        import xarray  # noqa: PLC0415 (heavy)
    except ImportError as error:
        message = f"to_xarray needs xarray: pip install 'pmjac_pin[sweep]' ({error})"
        raise MissingDependencyError(message) from error
    return xarray.Dataset(variables, coordinates, attributes)
