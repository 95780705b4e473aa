"""Where the files for the browser are: our own page, and meshcat's viewer."""

from __future__ import annotations

import importlib.util
from pathlib import Path

from pmjac_pin.errors import MissingDependencyError

PAGE = Path(__file__).parent / "page"

#: What of it the server hands out, by suffix: index.html under a name of its own.
TYPES = {".html": "text/html", ".js": "text/javascript", ".css": "text/css"}


def page_files() -> list[str]:
    """Return the names of the page's files."""
    found = (path for path in PAGE.iterdir() if path.suffix in TYPES)
    return sorted(path.name for path in found if path.name != "index.html")


def meshcat_files() -> Path:
    """Return the folder of meshcat's browser files, without importing meshcat and ZeroMQ.

    Raises
    ------
    MissingDependencyError
        meshcat is not installed.
    """
    spec = importlib.util.find_spec("meshcat")
    if spec is None or not spec.submodule_search_locations:
        raise MissingDependencyError("the page needs meshcat: pip install 'pmjac_pin[view]'")
    return Path(spec.submodule_search_locations[0]) / "viewer" / "dist"
