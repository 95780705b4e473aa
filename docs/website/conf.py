"""Sphinx's settings. `make docs` builds the site, from what `stage.py` has put together."""

from __future__ import annotations

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
sys.path.insert(0, str(HERE))  # references.py

project = "pmjac_pin"
author = "The pmjac_pin developers"
project_copyright = "the pmjac_pin developers, BSD-2-Clause"

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.mathjax",
    "sphinx-mathjax-offline",
    "sphinx_gallery.gen_gallery",
    "references",
]
exclude_patterns = ["examples/*.ipynb", "examples/*.py", "**/*.zip", "**/*.json", "**/*.md5"]

html_theme = "furo"
html_title = "pmjac_pin"
html_static_path = [str(HERE / "static")]
html_extra_path = [str(ROOT / "build" / "gallery" / "files")]
html_css_files = ["site.css"]
html_show_sphinx = False
html_copy_source = False
html_show_sourcelink = False
highlight_language = "none"

myst_enable_extensions = ["dollarmath", "amsmath"]
myst_heading_anchors = 4

# Each notebook is run whenever the site is built: what stands below a cell is what it gives today.
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 120
nb_merge_streams = True

# A name in single backticks leads to its page, where it has one (references.py).
nitpicky = True
default_role = "py:obj"
autodoc_typehints = "signature"
autodoc_member_order = "bysource"
autodoc_class_signature = "mixed"
add_module_names = False
python_maximum_signature_line_length = 80
napoleon_google_docstring = False
napoleon_use_rtype = False

sphinx_gallery_conf = {
    "examples_dirs": [str(ROOT / "examples")],
    "gallery_dirs": ["examples"],
    "filename_pattern": r"\.py$",
    "download_all_examples": False,
    "show_memory": False,
    "abort_on_example_error": True,
    "remove_config_comments": True,
}
