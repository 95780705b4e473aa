"""Adapters: closed machines for other people's libraries, each an extra of its library's name.

A module imports its library, and is imported only when it is asked for:
``from pmjac_pin.adapters import pink``, or ``pmjac_pin.adapters.pink``.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import lazy_loader  # type: ignore[import-untyped]

from pmjac_pin.errors import MissingDependencyError

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__, submodules=["casadi", "crocoddyl", "jax", "mink", "pink", "ros2_control", "tsid"]
)


@contextmanager
def importing(library: str) -> Iterator[None]:
    """Say which extra to install where a library is missing.

    Raises
    ------
    MissingDependencyError
    """
    try:
        yield
    except ImportError as error:
        needed = f"pmjac_pin.adapters.{library} needs {library}"
        raise MissingDependencyError(
            f"{needed}: pip install 'pmjac_pin[{library}]' ({error})"
        ) from error
