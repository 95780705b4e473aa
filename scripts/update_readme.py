"""Write the table of mechanisms into README.md, between its two markers, and beside the models."""

from __future__ import annotations

import re
from pathlib import Path

import pmjac_pin as pj
from pmjac_pin.files.catalogue_numbers import Catalogue, kept_text
from pmjac_pin.words.catalogue_table import catalogue_table, numbers_of
from pmjac_pin.words.markdown import markdown_table

README = Path(__file__).parent.parent / "README.md"
KEPT = README.parent / "models" / "catalogue.json"
BLOCK = re.compile(r"(<!-- mechanisms -->\n).*(<!-- end of mechanisms -->)", re.DOTALL)


def with_table(page: str, catalogue: Catalogue) -> str:
    """Return the page with the table of the catalogue as it is now."""
    table = markdown_table(catalogue_table(catalogue.values()))
    page, count = BLOCK.subn(lambda found: f"{found[1]}\n{table}\n\n{found[2]}", page)
    if count != 1:
        raise SystemExit("README.md needs the two markers of the table of mechanisms, once")
    return page


if __name__ == "__main__":
    mechanisms = {name: numbers_of(pj.load(name)) for name in pj.list_mechanisms()}
    KEPT.write_text(kept_text(mechanisms), encoding="utf-8")
    page = README.read_text(encoding="utf-8")
    README.write_text(with_table(page, mechanisms), encoding="utf-8")
