"""Ties of an SDFormat model that are no joints: Gazebo's detachable joints, Drake's constraints."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.errors import ModelFileError
from pmjac_pin.files.gazebo_plugins import is_mimic_plugin
from pmjac_pin.files.sdf.frames import MODEL, Frames
from pmjac_pin.files.sdf.joints import SdfJoint, text_of
from pmjac_pin.files.unused_name import unused_name
from pmjac_pin.files.vocabulary import spelt
from pmjac_pin.files.xml_text import check_name, label, numbers_in

BALL = "drake:ball_constraint"
NOT_READ = {
    "drake:coupler_constraint": "gear the joints by <mimic> in an <axis>",
    "drake:weld_constraint": 'write it as a <joint type="fixed">',
}


def is_detachable(plugin: Element, model: Element) -> bool:
    """Whether a plugin holds two links of this model, or robot, to each other."""
    child = text_of("<plugin>", plugin, "child_model")
    own = child in (MODEL, model.get("name"))
    return own and all(plugin.find(tag) is not None for tag in ("parent_link", "child_link"))


def read_plugins(model: Element) -> list[Element]:
    """Return the plugins of a model that are read."""
    plugins = model.findall("plugin")
    return [plugin for plugin in plugins if is_mimic_plugin(plugin) or is_detachable(plugin, model)]


@dataclass(frozen=True, eq=False)
class PointTie:
    """A constraint that holds a point of one link at a point of another.

    Attributes
    ----------
    links : tuple of str
    points : tuple of ndarray, shapes (3,)
        Each in its link's frame, m.
    """

    links: tuple[str, str]
    points: tuple[NDArray[np.float64], NDArray[np.float64]]


def detachable_joints(
    model: Element, within: str, frames: Frames, taken: Collection[str]
) -> Iterator[SdfJoint]:
    """Yield a fixed joint for each plugin that holds two links of a model to each other.

    Parameters
    ----------
    model : Element
        Or a URDF's <robot>.
    within : str
        Where the plugins are in it, as a path.
    frames : Frames
    taken : collection of str
        The names of other things.

    Raises
    ------
    ModelFileError
        A link that does not exist, or that is joined to itself.
    """
    names = set(taken)
    for plugin in model.iterfind(within):
        if not is_detachable(plugin, model):
            continue
        where = label(plugin)
        ends = [
            frames.link(text_of(where, plugin, tag) or "", f"{where}, <{tag}>")
            for tag in ("parent_link", "child_link")
        ]
        if ends[0] == ends[1]:
            raise ModelFileError(f"{where} joins link {ends[0]!r} to itself")
        name = unused_name(plugin.get("name") or "detachable_joint", names)
        placement = frames.placement(ends[1], where)
        yield SdfJoint(name, "fixed", ends[0], ends[1], placement, (), plugin)


def point_ties(model: Element, links: Collection[str]) -> tuple[PointTie, ...]:
    """Return Drake's ball constraints.

    Raises
    ------
    ModelFileError
        A link that does not exist, or a part that is missing.
    """
    ties = []
    for element in model:
        if (todo := NOT_READ.get(tag := spelt(element.tag))) is not None:
            raise ModelFileError(f"<{tag}> is not read; {todo}")
        if tag == BALL:
            ties.append(_point_tie(element, links))
    return tuple(ties)


def ball_parts(element: Element) -> dict[str, Element]:
    """Return the four parts of a ball constraint of Drake's, by their names in short.

    Raises
    ------
    ModelFileError
        One of them is missing.
    """
    given = {spelt(child.tag).removeprefix(f"{BALL}_"): child for child in element}
    for part in ("body_A", "p_AP", "body_B", "p_BQ"):
        if part not in given:
            raise ModelFileError(f"<{BALL}> has no <{BALL}_{part}>")
    return given


def _point_tie(element: Element, links: Collection[str]) -> PointTie:
    given = ball_parts(element)
    first, second = ((given[part].text or "").strip() for part in ("body_A", "body_B"))
    for name in (first, second):
        check_name(f"<{BALL}>: the link", name, links)
    if first == second:
        raise ModelFileError(f"<{BALL}> joins link {first!r} to itself")
    here, there = (
        np.array(numbers_in(f"<{BALL}_{part}>", given[part].text or "", count=3))
        for part in ("p_AP", "p_BQ")
    )
    return PointTie((first, second), (here, there))
