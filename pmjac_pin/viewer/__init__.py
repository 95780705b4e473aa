"""The viewer: a mechanism and its ellipsoids, in meshcat."""

from __future__ import annotations

from importlib.util import find_spec

from pmjac_pin.errors import MissingDependencyError

# meshcat's files are taken from where it is installed: it is not imported itself.
if missing := [name for name in ("meshcat", "tornado") if find_spec(name) is None]:
    raise MissingDependencyError(
        f"the page needs {' and '.join(missing)}: pip install 'pmjac_pin[view]'"
    )
