"""Checking the numbers and names that a caller gives."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeGuard

import numpy as np
from numpy.typing import ArrayLike

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.named_values import named_values

#: m, rad, kg, kg m²; squared twice it is still far from overflowing.
LARGEST = 1e9

#: m, of what must not be zero: its square must not vanish beside rounding.
SMALLEST = 1e-9

_DOUBLE = np.dtype(np.float64)  # NumPy asks a type for its own, each time
_WITHOUT_NAMES = (np.ndarray, float, int, list, tuple)


def as_numbers(given: object, what: str, largest: float = LARGEST) -> Array:
    """Return a float array of what the caller gave, or say what is wrong with it.

    Raises
    ------
    ArgumentError
        As `real_numbers`; NaN, infinities and numbers beyond `largest`.
    """
    array = real_numbers(given, what)
    _check_size(array, given, what, largest)
    return array


def real_numbers(given: object, what: str) -> Array:
    """Return a float array of what the caller gave, NaN and infinities among it.

    Raises
    ------
    ArgumentError
        Strings, complex numbers, ragged lists, masked entries; values with names, which must not
        be taken by their order.
    """
    if type(given) not in _WITHOUT_NAMES and named_values(given, what) is not None:
        message = f"{what} must be plain numbers in their order, got names, too"
        raise ArgumentError(f"{message}: {quoted(given)}")
    try:
        raw = np.asarray(given)
        if raw.dtype.kind not in "iuf":
            raise TypeError
    except (TypeError, ValueError):
        raise ArgumentError(f"{what} must be real numbers, got {quoted(given)}") from None
    # Only what has a mask is looked at: what knows masks takes long to import.
    if hasattr(given, "mask") and np.ma.is_masked(given):
        raise ArgumentError(f"{what} must have no masked entries, got {quoted(given)}")
    return raw.astype(np.float64)


def are_doubles(given: object) -> TypeGuard[Array]:
    """Tell whether this is an array of doubles already, where C can read them: it needs no copy."""
    return type(given) is np.ndarray and given.dtype == _DOUBLE and given.flags.aligned


def within(array: Array, ends: tuple[float, float]) -> bool:
    """Tell whether all numbers are in an interval; of NaN, False. No array is made for it."""
    lower, upper = ends
    return not array.size or (
        array.item(array.argmax()) <= upper and array.item(array.argmin()) >= lower
    )


def _check_size(array: Array, given: object, what: str, largest: float) -> None:
    if within(array, (-largest, largest)):
        return
    if not np.isfinite(array).all():
        raise ArgumentError(f"{what} must be finite, got {quoted(given)}")
    got = f"{array.flat[np.abs(array).argmax()]:g}"
    raise ArgumentError(f"{what} must be of magnitude {largest:g} or less, got {got}")


def as_number(given: object, what: str, largest: float = LARGEST) -> float:
    """Return one number that the caller gave, or say what is wrong with it.

    Raises
    ------
    ArgumentError
    """
    try:
        array = as_numbers(given, what, largest)
    except ArgumentError:
        if isinstance(given, int | float):
            raise
        raise ArgumentError(f"{what} must be a number, got {quoted(given)}") from None
    if array.ndim:
        raise ArgumentError(f"{what} must be one number, got {quoted(given)}")
    return float(array)


def as_flag(given: object, what: str) -> bool:
    """Return True or False as the caller gave it, or say that it is neither.

    Anything else that Python takes for true, as "no" or [False], is no answer to a question.

    Raises
    ------
    ArgumentError

    Examples
    --------
    >>> as_flag("no", "limits")
    Traceback (most recent call last):
        ...
    pmjac_pin.errors.ArgumentError: limits is True or False, got 'no'
    """
    if not isinstance(given, bool | np.bool_):
        raise ArgumentError(f"{what} is True or False, got {quoted(given)}")
    return bool(given)


def check_callable(given: object, what: str) -> None:
    """Raise ArgumentError where what the caller gave can not be called, and is not None."""
    if given is not None and not callable(given):
        raise ArgumentError(f"{what} is something to be called, or None, got {quoted(given)}")


def as_count(given: object, what: str, least: int = 1) -> int:
    """Return a whole number that the caller gave, `least` or more, or say what is wrong with it.

    Raises
    ------
    ArgumentError
    """
    if isinstance(given, bool) or not isinstance(given, int) or given < least:
        raise ArgumentError(f"{what} is a whole number ≥ {least}, got {quoted(given)}")
    return given


def check_one_of(given: object, what: str, known: Iterable[object]) -> None:
    """Raise ArgumentError where what the caller gave is none of these.

    Examples
    --------
    >>> check_one_of("both", "kind", ("gain", "loss"))
    Traceback (most recent call last):
        ...
    pmjac_pin.errors.ArgumentError: kind is gain or loss, got 'both'
    """
    known = tuple(known)
    if given not in known:
        raise ArgumentError(f"{what} is {' or '.join(map(str, known))}, got {quoted(given)}")


def as_names(given: object, wanted: str) -> tuple[str, ...]:
    """Return the names that the caller gave, or say what was wanted.

    Raises
    ------
    ArgumentError
        A single string, or a list that holds anything but strings.
    """
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise ArgumentError(f"{wanted}, got {quoted(given)}")
    try:
        names = tuple(given)
    except TypeError:  # NumPy's arrays without axes call themselves iterable
        raise ArgumentError(f"{wanted}, got {quoted(given)}") from None
    for name in names:
        if not isinstance(name, str):
            raise ArgumentError(f"{wanted}, it holds {quoted(name)}")
    return names


def check_kind(given: object, kind: type) -> None:
    """Raise ArgumentError where what the caller gave is not of this kind.

    Examples
    --------
    >>> check_kind(3, str)
    Traceback (most recent call last):
        ...
    pmjac_pin.errors.ArgumentError: a str is wanted, got int
    """
    if not isinstance(given, kind):
        raise ArgumentError(f"a {kind.__name__} is wanted, got {type(given).__name__}")


def as_vector(given: ArrayLike, size: int, what: str) -> Array:
    """Return finite numbers (size,), or say what was expected."""
    values = np.atleast_1d(as_numbers(given, what))
    if values.shape != (size,):
        raise ArgumentError(f"{what}: {size} numbers expected, got shape {values.shape}")
    return values


def as_limits(given: ArrayLike, size: int) -> Array:
    """Return limits of motors, numbers (size,) above 0, or say what was expected."""
    limits = as_vector(given, size, "motor limits")
    if not (limits > 0.0).all():
        raise ArgumentError("motor limits are numbers above 0")
    return limits
