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
    notes : tuple of str
        One sentence for each thing that the format says otherwise than the mechanism, or not.
    evidence : Evidence
        What "the same machine" rests on: the file was read again before it was put in its place.
    """

    paths: tuple[Path, ...]
    notes: tuple[str, ...]
    evidence: Evidence
