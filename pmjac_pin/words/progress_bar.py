"""A bar on stderr for what takes long."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable, Iterator

from rich.console import Console
from rich.progress import Progress


@contextlib.contextmanager
def progress_bar(name: str) -> Iterator[Callable[[float, float], None]]:
    """Show a bar where somebody watches, in a terminal or a notebook.

    Parameters
    ----------
    name : str
        Of what is counted.

    Yields
    ------
    callable
        (how much is done, of how much) ↦ nothing: what `progress` takes of `Batch`, `sweep`,
        `follow`.

    Examples
    --------
    >>> import numpy as np, pmjac_pin as pj
    >>> many = pj.batch(pj.load("five_bar"))
    >>> with pj.progress_bar("poses") as progress:
    ...     poses = many.close(np.zeros((5, 2)) + [2.1, 0.9], progress=progress)
    """
    console = Console(stderr=True)
    watched = sys.stderr.isatty() or console.is_jupyter
    with Progress(console=console, disable=not watched) as bar:
        task = bar.add_task(name, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)
