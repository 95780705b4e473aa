"""What an MJCF model must be before MuJoCo may see it: finite numbers, and not too many.

MuJoCo multiplies out what a file asks for, names and all, and takes time that grows with the
square of it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from xml.etree.ElementTree import Element

from pmjac_pin.errors import ModelFileError
from pmjac_pin.files.mjcf.file import MjcfFile
from pmjac_pin.files.mjcf.names import Places, called
from pmjac_pin.files.text_file import at_file
from pmjac_pin.files.urdf.checks import MAXIMAL_LINKS, MAXIMAL_NAME
from pmjac_pin.files.xml_text import check_name, numbers, numbers_in

MAXIMAL_MJCF_ELEMENTS = 10_000  # that are read, with what <replicate> and <attach> make of them
MAXIMAL_CLASSES = 1000

_SOFT = ("composite", "flexcomp")
_LINKS = ("body", "site", "joint", "freejoint")
_CARRIERS = ("worldbody", "body", "frame", "replicate")
_WORDS = frozenset(
    {
        *("active", "align", "alignfree", "angle", "autolimits", "balanceinertia", "body", "body1"),
        *("body2", "childclass", "class", "constraint", "coordinate", "equality", "eulerseq"),
        *("file", "frame", "geom", "inertiafromgeom", "joint", "joint1", "joint2"),
        *("jointinparent", "limited", "mesh", "mocap", "model", "name", "prefix", "sep"),
        *("shellinertia", "sidesite", "site", "site1", "site2", "tendon1", "tendon2", "type"),
    }
)


@dataclass(frozen=True)
class _Count:
    links: int = 0
    elements: int = 0

    def __add__(self, other: _Count) -> _Count:
        return _Count(self.links + other.links, self.elements + other.elements)

    def times(self, factor: int) -> _Count:
        return _Count(factor * self.links, factor * self.elements)


def check_mjcf(file: MjcfFile) -> None:
    """Refuse a model with numbers or names that are none, or with too much in it.

    Raises
    ------
    ModelFileError
    """
    _check_words(file)
    count = _in_model(file)
    if count.links > MAXIMAL_LINKS:
        what = f"{count.links} bodies, sites and joints are too many"
        raise ModelFileError(f"{what}; at most {MAXIMAL_LINKS} links are read")
    if count.elements > MAXIMAL_MJCF_ELEMENTS:
        what = f"{count.elements} elements are too many"
        raise ModelFileError(f"{what}; at most {MAXIMAL_MJCF_ELEMENTS} are read")


def _check_words(file: MjcfFile) -> None:
    """Refuse numbers that are not finite or too large, long names, and classes that do not exist.

    How many numbers there must be MuJoCo knows, and which words mean something.
    """
    places = Places(file.root)
    given = [default.get("class", "") for default in file.root.iterfind(".//default")]
    classes = dict.fromkeys(["main", *given])
    with at_file(str(file.path)):
        if len(classes) > MAXIMAL_CLASSES:
            got = f"{len(classes)} default classes are too many"
            raise ModelFileError(f"{got}; at most {MAXIMAL_CLASSES} are read")
        for element in file.root.iter():
            for key, text in element.attrib.items():
                if key not in _WORDS:
                    numbers_in(f"{places.of(element)}: `{key}`", text, count=len(text.split()))
                elif len(text) > MAXIMAL_NAME:
                    got = f"`{key}` is a name of {len(text)} characters"
                    raise ModelFileError(f"<{element.tag}>: {got}; at most {MAXIMAL_NAME} are read")
                elif key in ("class", "childclass"):
                    check_name(f"{places.of(element)}: the default class", text, classes)
    for attached in file.attached.values():
        _check_words(attached)


def _in_model(file: MjcfFile) -> _Count:
    models: dict[str, _Count] = {}
    for element in file.root.iterfind("asset/model"):
        count = _in_model(file.attached[element.get("file", "")])
        models[element.get("name", "")] = count
    return _in_element(file.root, models)


def _in_element(element: Element, models: Mapping[str, _Count]) -> _Count:
    """Return how much there is in an element, but for itself."""
    total = _Count()
    for child in element:
        if child.tag in _SOFT:
            todo = "a soft body has no joints; remove it"
            raise ModelFileError(f"<{child.tag}> is not read: {todo}")
        if child.tag == "attach":
            # One that is not named is called after what is in it.
            known = models.get(child.get("model", ""))
            total += known or sum(models.values(), _Count())
            continue
        link = child.tag in _LINKS and element.tag in _CARRIERS
        count = _Count(int(link), 1) + _in_element(child, models)
        total += count.times(_copies(child) if child.tag == "replicate" else 1)
    return total


def _copies(replicate: Element) -> int:
    (count,) = numbers(called(replicate), replicate, "count")
    return max(math.ceil(count), 1)
