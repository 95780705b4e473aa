"""The one model of an SDFormat file, which may stand in a world beside others that stand still."""

from __future__ import annotations

from xml.etree.ElementTree import Element

from pmjac_pin.errors import ModelFileError, quoted
from pmjac_pin.files.sdf.frames import truth
from pmjac_pin.files.sdf.joints import text_of
from pmjac_pin.files.xml_text import label

_SCENERY = ("ground_plane", "sun")  # what every world includes


def the_model(sdf: Element) -> tuple[Element, list[str], list[str]]:
    """Return the model that moves, notes on those that were left out, and what was not read.

    Raises
    ------
    ModelFileError
        Not one model, or one that is written elsewhere.
    """
    models = [*sdf.findall("model"), *sdf.findall("world/model")]
    static = [model for model in models if is_static(model)]
    moving = [model for model in models if model not in static]
    elsewhere = _included(sdf)
    if elsewhere and not moving:
        todo = "write it into the file itself"
        raise ModelFileError(f"<include> of {quoted(elsewhere[0])} is not read; {todo}")
    unread = [f"not read: <include> of {quoted(place)}" for place in elsewhere]
    if len(models) > 1 and len(moving) == 1:
        notes = [f"{label(model)} is static, and left out" for model in static]
        return _flat(moving[0]), notes, unread
    if len(models) != 1:
        got = f"there are {len(models)} models" + (f", {len(static)} of them static" * bool(static))
        raise ModelFileError(f"{got}; a file with one <model> is read")
    notes = [f"{label(models[0])} is static; it is read as if it were not"] if static else []
    return _flat(models[0]), notes, unread


def is_static(model: Element) -> bool:
    """Whether a model says that it stands still."""
    where = label(model)
    return truth(f"{where}, <static>", text_of(where, model, "static") or "false")


def _included(sdf: Element) -> list[str]:
    """Return what a world includes, but for the ground and the sun."""
    places = [
        text_of("<include>", include, "uri") or "" for include in sdf.iterfind("world/include")
    ]
    return [place for place in places if place.rstrip("/").rpartition("/")[2] not in _SCENERY]


def _flat(model: Element) -> Element:
    for tag in ("model", "include"):
        if model.find(tag) is not None:
            todo = "write its links and joints into the model itself"
            raise ModelFileError(f"a <{tag}> within a <model> is not read; {todo}")
    return model
