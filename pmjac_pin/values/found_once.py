"""Attributes that are found when they are first asked for, and kept."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic, TypeVar, overload

Value = TypeVar("Value")


class found_once(Generic[Value]):  # noqa: N801 - as `functools.cached_property`
    """`functools.cached_property` without its lock, which costs more than what is found here.

    Two threads may find the same at the same time; both have what the first of them found.

    Examples
    --------
    >>> class Circle:
    ...     @found_once
    ...     def area(self):
    ...         return [3.0]
    >>> circle = Circle()
    >>> circle.area is circle.area
    True
    """

    def __init__(self, find: Callable[[Any], Value]) -> None:
        self._find, self._name, self.__doc__ = find, find.__name__, find.__doc__

    @overload
    def __get__(self, instance: None, owner: type) -> found_once[Value]: ...
    @overload
    def __get__(self, instance: object, owner: type) -> Value: ...
    def __get__(self, instance: object | None, owner: type) -> Value | found_once[Value]:
        """Return what an instance has, or find it."""
        if instance is None:
            return self
        found: Value = instance.__dict__.setdefault(self._name, self._find(instance))
        return found
