"""Shown: values that show themselves as a page, where they are printed and in notebooks."""

from __future__ import annotations

from importlib import import_module
from typing import Any

#: What makes pages. It is named, not imported: values know that there are words, not which, and
#: these are loaded at the moment when something is shown.
_PAGES = "pmjac_pin.words.pages"


class Shown:
    """A value with a page of its own."""

    __slots__ = ()

    def _repr_html_(self) -> str:
        """Return the page for a notebook."""
        return str(_pages().html_page(self))


class Printed(Shown):
    """A value that is its page wherever it is printed."""

    __slots__ = ()

    def __repr__(self) -> str:
        return str(_pages().text_page(self))

    __str__ = __repr__


def _pages() -> Any:
    return import_module(_PAGES)
