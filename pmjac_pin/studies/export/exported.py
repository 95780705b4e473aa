"""Exported: what became of a mechanism that was written for other programs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from pmjac_pin.studies.evidence import Evidence


@dataclass(frozen=True)
class Exported:
    """The files that were written, and what is to be said of them.

    Attributes
    ----------
    paths : tuple of Path
        The file, and those beside it that belong to it.
    actuated, tool : tuple of str
        The motors and the tool's frame, or the three that span it, by their names in the file:
        for formats that do not say which they are.
    notes : tuple of str
        One sentence for each thing that the format says otherwise than the mechanism, or not.
    evidence : Evidence
        What "the same machine" rests on: the file was read again before it was put in its place.
    """

    paths: tuple[Path, ...]
    actuated: tuple[str, ...]
    tool: tuple[str, ...]
    notes: tuple[str, ...]
    evidence: Evidence
