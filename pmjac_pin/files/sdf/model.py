"""SdfModel: the links, joints and frames of an SDFormat file, placed in the model's frame."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element

import pinocchio as pin

from pmjac_pin.errors import ModelFileError, quoted
from pmjac_pin.files.gazebo_plugins import misread_mimics, unread_harmless
from pmjac_pin.files.sdf.frames import MODEL, WORLD, Frames, SdfFrame, pose
from pmjac_pin.files.sdf.inertials import read_inertias
from pmjac_pin.files.sdf.joints import SdfJoint, end_of, read_joint
from pmjac_pin.files.sdf.plugins import PointTie, detachable_joints, point_ties, read_plugins
from pmjac_pin.files.sdf.visuals import SdfVisual, read_sdf_visuals
from pmjac_pin.files.sdf.vocabulary import SDF_WORDS
from pmjac_pin.files.sdf.world import the_model
from pmjac_pin.files.urdf.checks import MAXIMAL_LINKS, checked_names
from pmjac_pin.files.xml_text import check_name, label

_OLDEST, _NEWEST = (1, 4), (1, 12)


@dataclass(frozen=True, eq=False)
class SdfModel:
    """What is read of a model; all placements are in its frame, with all joints at zero.

    Attributes
    ----------
    name : str
    links : mapping of str to pin.SE3
        In file order, and "world" at the end.
    joints : tuple of SdfJoint
        In file order.
    ties : tuple of PointTie
    visuals : tuple of SdfVisual
    inertias : mapping of str to pin.Inertia
        Of links, in the link's frame.
    frames : mapping of str to (str, pin.SE3)
        Each <frame>: the link that carries it, and its placement.
    root : str or None
        "world" if a joint holds a link to it, else the link that the file calls canonical.
    element : Element
        The <model>.
    notes : tuple of str
        What was left out.
    unread : tuple of str
        One sentence for each kind of thing in the file that nobody reads.
    """

    name: str
    links: Mapping[str, pin.SE3]
    joints: tuple[SdfJoint, ...]
    ties: tuple[PointTie, ...]
    visuals: tuple[SdfVisual, ...]
    inertias: Mapping[str, pin.Inertia]
    frames: Mapping[str, tuple[str, pin.SE3]]
    root: str | None
    element: Element
    notes: tuple[str, ...]
    unread: tuple[str, ...]


def read_model(sdf: Element) -> SdfModel:
    """Read the one model of a file.

    Raises
    ------
    ModelFileError
        The message names the element at fault.
    """
    version = _sdf_version(sdf)
    model, notes, elsewhere = the_model(sdf)
    unread = SDF_WORDS.unread(sdf, *unread_harmless(sdf), *read_plugins(model))
    links, joints, extra = (model.findall(tag) for tag in ("link", "joint", "frame"))
    names = _names(links, joints, extra)
    canonical = model.get("canonical_link")
    if canonical is not None:
        check_name("the canonical link", canonical, names)
    frames = Frames(dict(_given(links, joints, extra)), names, canonical or names[0])
    named = {element.get("name", "") for element in (*links, *joints, *extra)}
    read = (
        *(read_joint(joint, frames, version) for joint in joints),
        *detachable_joints(model, "plugin", frames, named),
    )
    inertias, mass_notes = read_inertias(links, frames)
    held = any(joint.parent == WORLD for joint in read)
    return SdfModel(
        name=model.get("name", ""),
        links={name: frames.placement(name, MODEL) for name in names}
        | {WORLD: _world(model, frames)},
        joints=read,
        ties=point_ties(model, names),
        visuals=tuple(read_sdf_visuals(links, frames)),
        inertias=inertias,
        frames={
            name: (frames.link(name, MODEL), frames.placement(name, MODEL))
            for name in (frame.get("name", "") for frame in extra)
        },
        root=WORLD if held else canonical,
        element=model,
        notes=(*notes, *mass_notes),
        unread=(*unread, *misread_mimics(model), *elsewhere),
    )


def _sdf_version(sdf: Element) -> tuple[int, int]:
    if sdf.tag != "sdf":
        raise ModelFileError(f"the root element is <{quoted(sdf.tag)[1:-1]}>; an SDF's is <sdf>")
    given = sdf.get("version")
    for minor in range(_OLDEST[1], _NEWEST[1] + 1):
        if given == f"1.{minor}":
            return (1, minor)
    got = "no version" if given is None else f"the version {quoted(given)}"
    raise ModelFileError(f"<sdf> has {got}; 1.{_OLDEST[1]} to 1.{_NEWEST[1]} are read")


def _names(links: Sequence[Element], *others: Sequence[Element]) -> list[str]:
    """Return the links' names, once all names are certain to be there and to differ."""
    if not links:
        raise ModelFileError("the model has no <link>")
    for elements in (links, *others):
        if len(elements) > MAXIMAL_LINKS:
            got = f"{len(elements)} elements <{elements[0].tag}>"
            raise ModelFileError(f"{got} are too many; at most {MAXIMAL_LINKS} are read")
        names = checked_names(elements)
        for taken in (WORLD, MODEL):
            if taken in names:
                raise ModelFileError(f"the name {taken!r} is SDFormat's own; choose another")
    return list(checked_names(links))


def _given(
    links: Sequence[Element], joints: Sequence[Element], extra: Sequence[Element]
) -> Iterator[tuple[str, SdfFrame]]:
    """Yield all frames; before SDFormat 1.7 names may be shared, and a link's is meant then."""
    for joint in joints:
        child = end_of(joint, "child")
        yield (
            joint.get("name", ""),
            SdfFrame(label(joint), child, *pose(label(joint), joint, child)),
        )
    for frame in extra:
        carrier = frame.get("attached_to") or MODEL
        where = label(frame)
        yield frame.get("name", ""), SdfFrame(where, carrier, *pose(where, frame, carrier))
    for link in links:
        name = link.get("name", "")
        yield name, SdfFrame(label(link), name, *pose(label(link), link, MODEL))


def _world(model: Element, frames: Frames) -> pin.SE3:
    """Return the world's placement in the model's frame."""
    where = label(model)
    relative_to, placement = pose(where, model, WORLD)
    if relative_to != WORLD:
        got = f"{where}, <pose>: it is relative to {quoted(relative_to)}"
        raise ModelFileError(f"{got}; a model is placed in the world")
    placed: pin.SE3 = frames.placement(model.get("placement_frame") or MODEL, where)
    return placed * placement.inverse()
