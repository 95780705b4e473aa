"""Where the files for the browser are: our own page, and meshcat's viewer."""

from __future__ import annotations

import importlib.util
from pathlib import Path

from pmjac_pin.errors import MissingDependencyError

PAGE = Path(__file__).parent / "page"

#: What of it the server hands out.
PAGE_FILES = (
    "angles.js",
    "app.js",
    "connection.js",
    "elements.js",
    "fit.js",
    "labels.js",
    "legend.js",
    "load.css",
    "load.js",
    "modes.css",
    "modes.js",
    "numbers.js",
    "options.js",
    "picture.js",
    "play.js",
    "readout.js",
    "replay.css",
    "replay.js",
    "scene.html",
    "scene.js",
    "sections.js",
    "slice.css",
    "slice.js",
    "sliders.js",
    "snapshot.js",
    "stage.css",
    "stage.js",
    "status.js",
    "style.css",
    "tool.js",
)


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
