"""Default classes of MJCF: the attributes that an element has without giving them."""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree.ElementTree import Element

from pmjac_pin.errors import ModelFileError, did_you_mean
from pmjac_pin.formats.mjcf_frames import ORIENTATIONS
from pmjac_pin.urdf_xml import shown

_MAIN = "main"
_READ = ("equality", "geom", "joint", "site")

Attributes = dict[str, str]


class Defaults:
    """The default classes of a model, each with what it inherits.

    Parameters
    ----------
    root : Element
        <mujoco>.

    Raises
    ------
    ModelFileError
        A class without a name, or two of the same.

    Examples
    --------
    >>> from xml.etree.ElementTree import fromstring
    >>> text = '<default><joint type="slide"/><default class="x"><joint axis="1 0 0"/></default>'
    >>> defaults = Defaults(fromstring(f"<mujoco>{text}</default></mujoco>"))
    >>> defaults.complete(fromstring('<joint class="x" ref="2"/>')).attrib
    {'type': 'slide', 'axis': '1 0 0', 'class': 'x', 'ref': '2'}
    """

    def __init__(self, root: Element) -> None:
        self._classes: dict[str, dict[str, Attributes]] = {_MAIN: {}}
        for section in root.iterfind("default"):
            if (name := section.get("class", _MAIN)) != _MAIN:
                raise ModelFileError(f"the outermost <default> is called 'main', not {shown(name)}")
            self._read(section, _MAIN)

    def complete(self, element: Element, childclass: str = "", tag: str = "") -> Element:
        """Return a copy of an element with the attributes that its class gives it.

        Parameters
        ----------
        element : Element
        childclass : str
            The class of the bodies around it, which counts where the element names none.
        tag : str
            What the defaults call the element, where that is another name.
        """
        name = element.get("class") or childclass or _MAIN
        self.check(f"<{element.tag}>", name)
        inherited = self._classes[name].get(tag or element.tag, {})
        return Element(element.tag, _overlaid(inherited, element.attrib))

    def check(self, where: str, name: str) -> None:
        """Refuse the name of a class that does not exist."""
        if name not in self._classes:
            known = did_you_mean(name, self._classes)
            raise ModelFileError(f"{where}: the default class {shown(name)} does not exist{known}")

    def _read(self, section: Element, name: str) -> None:
        own = self._classes[name]
        nested = [child for child in section if child.tag == "default"]
        for child in section:
            if child.tag in _READ:
                own[child.tag] = _overlaid(own.get(child.tag, {}), child.attrib)
        for child in nested:
            if not (inner := child.get("class", "")):
                raise ModelFileError("a nested <default> has no `class`; give it a name")
            if inner in self._classes:
                raise ModelFileError(f"two default classes are named {shown(inner)}")
            self._classes[inner] = dict(own)
            self._read(child, inner)


def _overlaid(below: Mapping[str, str], above: Mapping[str, str]) -> Attributes:
    """Return both; an orientation of any form takes the place of any other."""
    turned = any(key in above for key in ORIENTATIONS)
    kept = {key: value for key, value in below.items() if not (turned and key in ORIENTATIONS)}
    return {**kept, **above}
