"""Figures without pyplot: no global state, no display, and any thread may draw; and their files.

Matplotlib is imported only when something is drawn.
"""

from __future__ import annotations

import io
import os
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from pmjac_pin.errors import ArgumentError, MissingDependencyError, quoted
from pmjac_pin.files.output_file import check_place, write_files
from pmjac_pin.files.user_path import output_path
from pmjac_pin.values.checks import as_number

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_FEWEST_DOTS, _MOST_DOTS = 1, 2400  # per inch: of more, the picture would not fit in memory


def matplotlib_package() -> ModuleType:
    """Return matplotlib, with what figures need of it imported.

    Raises
    ------
    MissingDependencyError
    """
    try:
        # The plain form also looks up the package itself, not only its cached submodules.
        import matplotlib.backends.backend_agg  # noqa: PLC0415
        import matplotlib.figure  # noqa: PLC0415
        import matplotlib.patheffects  # noqa: PLC0415
    except ImportError as error:
        raise MissingDependencyError(
            f"plotting needs matplotlib: pip install 'pmjac_pin[plot]' ({error})"
        ) from error
    return matplotlib


def new_figure(title: str, size: tuple[float, float], fontsize: float) -> Any:
    """Return an empty figure of this size in inches, without pyplot; "" for no title."""
    mpl = matplotlib_package()
    from pmjac_pin.pictures.shown_figure import ShownFigure  # noqa: PLC0415

    figure = ShownFigure(figsize=size, layout="constrained")
    mpl.backends.backend_agg.FigureCanvasAgg(figure)
    if title:
        figure.suptitle(as_it_is(title), fontsize=fontsize, fontweight="bold")
    return figure


def as_it_is(text: str) -> str:
    """Escape the dollar signs, between which matplotlib would look for a formula."""
    return text.replace("$", r"\$")


def save_figure(figure: Figure, path: str | os.PathLike[str], dpi: float = 150) -> None:
    """Write a figure to a file; a failure leaves a file that is already there untouched.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
    path : str or path-like
        The suffix tells the format: .png, .pdf, .svg and what else matplotlib can write.
    dpi : float
        Dots per inch, for formats made of dots.

    Raises
    ------
    ArgumentError
        If the suffix is unknown, or `dpi` is not positive.
    OutputError
        If the file cannot be written: no such folder, no right to, no space, or no file there
        but a folder, a device or a pipe.
    """
    save_pages([figure], path, dpi)


def save_pages(
    figures: Sequence[Figure], path: str | os.PathLike[str], dpi: float = 150
) -> list[Path]:
    """Write figures as the pages of one .pdf, or into a file each: x.png, x-2.png, x-3.png.

    Parameters
    ----------
    figures : sequence of matplotlib.figure.Figure
    path : str or path-like
        Of the first page, or of all; see `save_figure`.
    dpi : float

    Returns
    -------
    list of Path
        The files written: all of them, or none.

    Raises
    ------
    ArgumentError, OutputError
        As `save_figure`.
    """
    suffix = check_figure_file(path)
    if not _FEWEST_DOTS <= as_number(dpi, "dpi") <= _MOST_DOTS:
        raise ArgumentError(f"dpi must be {_FEWEST_DOTS} to {_MOST_DOTS}; got {quoted(dpi)}")
    first = output_path(path)
    paths = [first]
    if suffix == "pdf":
        contents = [_pdf(figures, dpi)]
    else:
        others = (f"{first.stem}-{page}{first.suffix}" for page in range(2, len(figures) + 1))
        paths += [first.with_name(name) for name in others]
        contents = [_encoded(figure, dpi, suffix) for figure in figures]
    write_files(dict[str | os.PathLike[str], bytes](zip(paths, contents, strict=True)))
    return paths


def _pdf(figures: Sequence[Figure], dpi: float) -> bytes:
    from matplotlib.backends.backend_pdf import PdfPages  # noqa: PLC0415

    drawn = io.BytesIO()
    with PdfPages(drawn) as pages:
        for figure in figures:
            pages.savefig(figure, dpi=dpi)
    return drawn.getvalue()


def _encoded(figure: Figure, dpi: float, suffix: str) -> bytes:
    drawn = io.BytesIO()
    figure.savefig(drawn, dpi=dpi, format=suffix)
    return drawn.getvalue()


def check_figure_file(path: str | os.PathLike[str]) -> str:
    """Return the suffix of a figure's file; refuse, before anything is drawn, what cannot be one.

    Raises
    ------
    ArgumentError, OutputError, MissingDependencyError
        As `save_figure`.
    """
    check_place(path)
    suffix = output_path(path).suffix.lower().removeprefix(".")
    canvas = matplotlib_package().backends.backend_agg.FigureCanvasAgg
    formats = sorted(canvas.get_supported_filetypes())
    if suffix not in formats:
        known = f"its suffix must be one of .{', .'.join(formats)}"
        raise ArgumentError(f"cannot save {quoted(os.fspath(path))}: {known}")
    return suffix
