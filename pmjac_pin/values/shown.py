"""Shown: values that show themselves as a page, where they are printed and in notebooks."""

from __future__ import annotations

from importlib import import_module
from typing import Any

#: What makes pages and tables. They are named, not imported: values know that there are words, not
#: which, and these are loaded at the moment when something is shown.
_PAGES = "pmjac_pin.words.pages"
_TABLES = "pmjac_pin.words.matrices"


class Shown:
    """A value with a page of its own."""

    __slots__ = ()

    def _repr_html_(self) -> str:
        """Return the page for a notebook."""
        return str(import_module(_PAGES).html_page(self))


class Printed(Shown):
    """A value that is its page wherever it is printed."""

    __slots__ = ()

    def __repr__(self) -> str:
        return str(import_module(_PAGES).text_page(self))

    __str__ = __repr__


class Tabled(Shown):
    """A value of matrices, each of which is a table with names and units, too."""

    def table(self, name: str) -> Any:
        """Return one matrix with names and units: as a data frame, LaTeX or Markdown, too.

        Parameters
        ----------
        name : str
            "J_eq", or the name of another attribute that is a matrix, such as "K_star" or "Jv_eq".

        Returns
        -------
        LabelledMatrix
            It prints, and in a notebook shows, as a table; `.dataframe()`, `.latex()` and
            `.markdown()` are for papers and data frames. m/s and rad/s, for J_eq per unit of a
            motor's rate.

        Raises
        ------
        UnknownNameError
            No such matrix.
        ArgumentError
            Matrices from elsewhere have no names and units.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> print(pj.load("four_bar").home.jacobian().table("Jw_eq"))
                       theta1
                      [rad/s]
        ─────────────────────
        ω_x [rad/s]    0.0000
        ω_y [rad/s]    0.0000
        ω_z [rad/s]   -0.3345
        """
        return import_module(_TABLES).table_of(self, name)
