"""The viewer: a mechanism and its ellipsoids, in meshcat."""

from __future__ import annotations

from pmjac_pin.errors import MissingDependencyError

try:
    import tornado as _server  # noqa: F401
except ImportError as error:
    raise MissingDependencyError(
        f"the page needs meshcat and tornado: pip install 'pmjac_pin[view]' ({error})"
    ) from error
