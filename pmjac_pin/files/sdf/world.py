"""The one model of an SDFormat file, which may stand in a world beside others that stand still."""

from __future__ import annotations

import re
from xml.etree.ElementTree import Element

from pmjac_pin.errors import ModelFileError, quoted
from pmjac_pin.files.sdf.frames import MODEL, WORLD, truth
from pmjac_pin.files.sdf.joints import ENDS, text_of
from pmjac_pin.files.sdf.plugins import NOT_READ
from pmjac_pin.files.vocabulary import spelt
from pmjac_pin.files.xml_text import label

_FUEL = r"https://fuel\.(?:gazebosim|ignitionrobotics)\.org/1\.0/openrobotics/models/"
_SCENERY = re.compile(  # what every world includes
    rf"model://(?:ground_plane|sun)|(?i:{_FUEL}(?:ground( |%20)plane|sun)(/\d+)?)"
)
_NAMED = ("link", "frame", "joint", "model")
_JOINT_ENDS = (
    *ENDS,
    *(f"drake:{kind}_constraint_body_{end}" for kind in ("ball", "weld") for end in "AB"),
)


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
        tied = [note for model in static for note in _ties_to_others(model)]
        return _flat_model(moving[0]), notes, [*unread, *tied]
    if len(models) != 1:
        got = f"there are {len(models)} models" + (f", {len(static)} of them static" * bool(static))
        raise ModelFileError(f"{got}; a file with one <model> is read")
    notes = [f"{label(models[0])} is static; it is read as if it were not"] if static else []
    return _flat_model(models[0]), notes, unread


def is_static(model: Element) -> bool:
    """Whether a model says that it stands still."""
    where = label(model)
    return truth(f"{where}, <static>", text_of(where, model, "static") or "false")


def _included(sdf: Element) -> list[str]:
    """Return what worlds and their models include, but for the ground and the sun."""
    places = [text_of("<include>", include, "uri") or "" for include in sdf.iter("include")]
    return [place for place in places if not _SCENERY.fullmatch(place)]


def _ties_to_others(model: Element) -> list[str]:
    """Return what joins a model to links that are not its own."""
    own = {WORLD, MODEL}
    for tag in _NAMED:
        scope = "::" * (tag == "model")
        own |= {inside.get("name", "") + scope for inside in model.iterfind(f".//{tag}")}
    found = []
    for element in model.iter():
        ends = [inside for inside in element if spelt(inside.tag) in _JOINT_ENDS]
        named = [(end.text or "").strip() or end.get("name", "") for end in ends]
        others = [name for name in named if "".join(name.partition("::")[:2]) not in own]
        if others:
            what = f"{label(element)} in {label(model)}"
            found.append(f"not read: {what}, which joins {', '.join(map(quoted, others))}")
        elif not ends and spelt(element.tag) in NOT_READ:
            found.append(f"not read: <{spelt(element.tag)}> in {label(model)}")
    return found


def _flat_model(model: Element) -> Element:
    for tag in ("model", "include"):
        if model.find(tag) is not None:
            todo = "write its links and joints into the model itself"
            raise ModelFileError(f"a <{tag}> within a <model> is not read; {todo}")
    return model
