"""SliceMessage: what pages are told of the map beside the picture."""

from __future__ import annotations

from typing import Literal

import msgspec

from pmjac_pin.studies.singularities.singular_equations import Freed


class SliceCurve(msgspec.Struct, frozen=True):
    """A curve of singular poses, by the values of the two motors; complete as of `LocusCurve`."""

    kind: Freed
    complete: bool
    places: tuple[tuple[float, float], ...]


class SliceMessage(msgspec.Struct, frozen=True, kw_only=True, tag="slice", tag_field="type"):
    """A map of two motors' values, the others staying.

    Attributes
    ----------
    status : str
        "unknown", "drawing", "drawn", "stale" where the pose is not of the map any more, "failed".
    text : str
        What it shows and rests on; or why there is none, or why it is stale.
    plane : tuple of str
        The motors.
    lower, upper : tuple of float
        The window, m or rad.
    cells : tuple of str
        As of `SliceMap`: a string for each value of the first motor.
    curves : tuple of SliceCurve
    """

    status: Literal["unknown", "drawing", "drawn", "stale", "failed"]
    text: str
    plane: tuple[str, ...] = ()
    lower: tuple[float, ...] = ()
    upper: tuple[float, ...] = ()
    cells: tuple[str, ...] = ()
    curves: tuple[SliceCurve, ...] = ()
