"""Axes of one column's width in a journal: symbols with units, no title, the legend below.

A column is 88.9 mm wide, and its letters 8 points: IEEE's and ASME's authors' guides.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pmjac_pin.pictures.figures import as_it_is, new_figure
from pmjac_pin.values.arrays import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLUMN = 3.5  # inches
PRINTED = 300.0  #: dots per inch
LETTERS, SMALL_LETTERS = 8.0, 7.0  # points
_FLATTEST, _HIGHEST = 0.5, 1.3  # height by width of the axes
_BESIDE, _COLOUR_BAR, _BELOW, _LINE = 0.6, 0.75, 0.4, 0.155  # inches: around the axes
_LEGEND_COLUMNS = 2
_GREEK = frozenset(
    (
        *("alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "iota", "kappa"),
        *("lambda", "mu", "nu", "xi", "pi", "rho", "sigma", "tau", "upsilon", "phi", "chi", "psi"),
        "omega",
    )
)
_SYMBOL = re.compile(rf"({'|'.join(sorted(_GREEK))}|[A-Za-z])_?(\d*)")
_ALL_ROUND = 2.0 * np.pi
_EDGE = 0.05  # of what is drawn


class DrawnPlane(NamedTuple):
    """What axes show.

    Attributes
    ----------
    names, units : two str
    lower, upper : ndarray, shape (2,)
    """

    names: tuple[str, str]
    units: tuple[str, str]
    lower: Array
    upper: Array

    @property
    def equal(self) -> bool:
        """Whether both axes have one scale."""
        return self.units[0] == self.units[1]

    @property
    def height(self) -> float:
        """Of the axes, by their width."""
        wide, high = self.upper - self.lower
        return float(np.clip(high / wide, _FLATTEST, _HIGHEST)) if self.equal else 0.8


def paper_axes(drawn: DrawnPlane, legend: int, *, colour_bar: bool) -> tuple[Figure, Any]:
    """Return an empty figure of one column, and its axes.

    Parameters
    ----------
    drawn : DrawnPlane
    legend : int
        How many entries it has.
    colour_bar : bool
        Whether there is to be one beside.
    """
    wide = COLUMN - _BESIDE - _COLOUR_BAR * colour_bar
    lines = 1 + -(-legend // _LEGEND_COLUMNS)  # under what is held
    size = (COLUMN, wide * drawn.height + _BELOW + _LINE * lines)
    figure: Figure = new_figure("", size, LETTERS)
    axes: Any = figure.subplots()
    ends = list(zip(drawn.lower.tolist(), drawn.upper.tolist(), strict=True))
    axes.set(xlim=ends[0], ylim=ends[1], xlabel=_label(drawn, 0), ylabel=_label(drawn, 1))
    axes.xaxis.label.set_size(LETTERS)
    axes.yaxis.label.set_size(LETTERS)
    axes.tick_params(labelsize=SMALL_LETTERS, direction="in", top=True, right=True, width=0.6)
    for spine in axes.spines.values():
        spine.set_linewidth(0.6)
    for axis, unit, (low, high) in zip((axes.xaxis, axes.yaxis), drawn.units, ends, strict=True):
        _place_ticks(axis, unit, high - low)
    if drawn.equal:
        axes.set_aspect("equal", adjustable="box")
    return figure, axes


def add_legend(figure: Any, axes: Any, title: str) -> None:
    """Put the legend below the axes, under what is held there."""
    handles, labels = axes.get_legend_handles_labels()
    if not handles and not title:
        return
    figure.legend(
        handles,
        labels,
        loc="outside lower center",
        ncols=_LEGEND_COLUMNS,
        fontsize=SMALL_LETTERS,
        title=title or None,
        title_fontsize=SMALL_LETTERS,
        frameon=False,
        handlelength=2.2,
        columnspacing=1.2,
        labelspacing=0.3,
        borderaxespad=0.1,
    )


def symbol(name: str) -> str:
    """Return the name of a coordinate as it is printed: θ₁ for theta1, in italics."""
    found = _SYMBOL.fullmatch(name)
    if found is None:
        return as_it_is(name)
    letter, number = found.groups()
    written = f"\\{letter}" if letter in _GREEK else letter
    return f"${written}_{{{number}}}$" if number else f"${written}$"


def around(places: Sequence[Array], lower: Array, upper: Array, units: Sequence[str]) -> Any:
    """Return ends (2,), (2,) of axes around what is drawn in a window, but of whole turns.

    Parameters
    ----------
    places : sequence of ndarray, shape (N, 2)
    lower, upper : ndarray, shape (2,)
        The window.
    units : two str
    """
    if not sum(map(len, places)):
        return lower, upper
    every = np.vstack(list(places))
    low, high = every.min(axis=0), every.max(axis=0)
    margin = _EDGE * float((high - low).max())
    low, high = np.maximum(low - margin, lower), np.minimum(high + margin, upper)
    whole = (np.abs(upper - lower - _ALL_ROUND) < 1e-9) & (np.array(units) == "rad")
    empty = ~(high > low)
    return np.where(whole | empty, lower, low), np.where(whole | empty, upper, high)


def _label(drawn: DrawnPlane, k: int) -> str:
    return f"{symbol(drawn.names[k])} ({drawn.units[k]})"


def _place_ticks(axis: Any, unit: str, extent: float) -> None:
    """Put ticks at round values, of angles over much of a turn at parts of π."""
    from matplotlib.ticker import FuncFormatter, MaxNLocator, MultipleLocator  # noqa: PLC0415

    if unit == "rad" and extent > 0.75 * _ALL_ROUND:
        axis.set_major_locator(MultipleLocator(np.pi / 2.0))
        axis.set_major_formatter(FuncFormatter(_of_pi))
    else:
        axis.set_major_locator(MaxNLocator(5, steps=[1, 2, 2.5, 5, 10]))


def _of_pi(value: float, _: object) -> str:
    halves = round(2.0 * value / np.pi)
    if halves == 0:
        return "0"
    sign, size = "−" * (halves < 0), abs(halves)
    top = "π" if size in {1, 2} else f"{size // 2 if size % 2 == 0 else size}π"
    return f"{sign}{top}" + "/2" * (size % 2)
