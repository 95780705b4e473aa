"""What of an MJCF model MuJoCo gets to see: the words that we know, and nothing that is not read.

So it neither opens a file nor refuses a model for what has no bearing on it: a sensor, or bodies
that move without mass.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from xml.etree.ElementTree import Element, SubElement

from pmjac_pin.errors import ModelFileError, did_you_mean, quoted
from pmjac_pin.files.mjcf.file import MjcfFile
from pmjac_pin.files.mjcf.names import called
from pmjac_pin.files.mjcf.vocabulary import MJCF_WORDS
from pmjac_pin.files.text_file import at_file
from pmjac_pin.files.xml_text import numbers, written

KEYFRAME = "home"
NO_MASS = 1e-14  # kg and kg m², for bodies without: MuJoCo wants more than 1e-15

_READ = ("connect", "weld", "joint", "tendon")
_EQUALITIES_NOT_READ = ("distance", "flex", "flexstrain", "flexvert")
_BRAKES = ("adhesion", "damper")


@dataclass(frozen=True)
class Kept:
    """What is left of a model.

    Attributes
    ----------
    file : MjcfFile
        No body of it has less mass than `NO_MASS`.
    total_mass : float or None
        What all bodies together are to have, kg; taken out of the file.
    notes : tuple of str
        What was left out of it.
    unread : tuple of str
        What in it nobody knows.
    """

    file: MjcfFile
    total_mass: float | None
    notes: tuple[str, ...]
    unread: tuple[str, ...]


def kept(file: MjcfFile) -> Kept:
    """Return what is read of a model and of those that it attaches.

    Raises
    ------
    ModelFileError
        A word that looks misspelt, or a constraint that holds and is not read.
    """
    others = {name: kept(attached) for name, attached in file.attached.items()}
    with at_file(str(file.path)):
        equalities = list(_equalities(file.root))
        unread = (*MJCF_WORDS.unread(file.root), *_limited_tendons(file.root))
        root = MJCF_WORDS.known(file.root)
        notes, total = (*equalities, *_motors(root)), _bounded_masses(root)
        _keep_keyframe(root)
    return Kept(
        MjcfFile(file.path, root, {name: other.file for name, other in others.items()}),
        total if total > 0.0 else None,
        sum((other.notes for other in others.values()), notes),
        sum((other.unread for other in others.values()), unread),
    )


def _equalities(root: Element) -> Iterator[str]:
    """Yield what is to be said of the constraints that are not read."""
    for flag in root.iterfind("option/flag"):
        if "disable" in (flag.get("equality"), flag.get("constraint")):
            yield "<flag> disables the constraints; they are read all the same"
    for element in root.iterfind("equality/*"):
        where = called(element)
        if element.tag not in (*_READ, *_EQUALITIES_NOT_READ):
            known = did_you_mean(element.tag, _READ)
            what = f"<equality> holds an unknown <{quoted(element.tag)[1:-1]}>"
            raise ModelFileError(f"{what}{known}")
        if element.tag in _EQUALITIES_NOT_READ:
            if element.get("active") != "false":
                todo = 'set active="false" to leave it out'
                raise ModelFileError(f"{where} is not read, only {', '.join(_READ)} are; {todo}")
            yield f"{where} is not active, and left out"


def _limited_tendons(root: Element) -> Iterator[str]:
    """Yield what is to be said of tendons whose limits hold joints together.

    A range may be that of a class, so a limited tendon is told of wherever it has it from.
    """
    by_class = any(element.get("range") for element in root.iterfind("default//tendon"))
    for element in root.iterfind("tendon/*"):
        given = element.get("range") or element.get("limited") == "true" or by_class
        if given and element.get("limited") != "false":
            yield f"not read: the range of {called(element)}, which may hold joints together"


def _bounded_masses(root: Element) -> float:
    """Give every body the least mass; return and take out `settotalmass`, -1 where there is none.

    It would be shared by bodies that have none.
    """
    given = Element("compiler")
    for element in root.iterfind("compiler"):
        given.attrib.update(element.attrib)
        element.attrib.pop("settotalmass", None)
    least = {
        key: max(numbers("<compiler>", given, key, default="0")[0], NO_MASS)
        for key in ("boundmass", "boundinertia")
    }
    SubElement(root, "compiler", {key: written([value]) for key, value in least.items()})
    return numbers("<compiler>", given, "settotalmass", default="-1")[0]


def _keep_keyframe(root: Element) -> None:
    """Take out all keyframes but the one that is read."""
    for section in root.iterfind("keyframe"):
        for key in section.findall("key"):
            if key.get("name") != KEYFRAME:
                section.remove(key)


def _motors(root: Element) -> Iterator[str]:
    """Make motors of the actuators that move joints, and take out the others, of which is told."""
    for section in root.iterfind("actuator"):
        for element in list(section):
            brake = element.tag in _BRAKES
            if brake or not {"joint", "jointinparent"} & set(element.attrib):
                what = "is a brake" if brake else "moves no joint by itself"
                yield f"actuator {quoted(element.get('name', element.tag))} {what}, and is left out"
                section.remove(element)
            element.tag = "motor"
