"""Names of an MJCF model, and of what has none there."""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree.ElementTree import Element

from pmjac_pin.errors import ModelFileError, did_you_mean
from pmjac_pin.formats.unused_name import unused_name
from pmjac_pin.urdf_xml import shown

WORLD = "world"
_JOINTS = ["joint", "freejoint"]


class Names:
    """The names of links and joints: the file's own, and new ones that are like no other.

    MJCF's bodies and sites may share names, which become links: then the site's name gets
    "_site" at its end.

    Parameters
    ----------
    root : Element
        <mujoco>.

    Attributes
    ----------
    taken : set of str
        All names so far.

    Raises
    ------
    ModelFileError
        Two bodies, sites or joints of the same name.
    """

    def __init__(self, root: Element) -> None:
        bodies, sites, joints = (_given(root, tags) for tags in (["body"], ["site"], _JOINTS))
        if WORLD in bodies:
            raise ModelFileError("a body is named 'world'; that name is the ground's")
        self.taken = {WORLD, *bodies, *sites, *joints}
        self._bodies = {WORLD, *bodies}

    def new(self, wish: str) -> str:
        """Return a new name for a link or a joint."""
        return unused_name(wish, self.taken)

    def site(self, name: str) -> str:
        """Return the link that a named site becomes."""
        return self.new(f"{name}_site") if name in self._bodies else name


def find_name(what: str, name: str, known: Mapping[str, str]) -> str:
    """Return what a name stands for.

    Raises
    ------
    ModelFileError
        The name does not exist; `what` says who gives it.
    """
    if name not in known:
        raise ModelFileError(f"{what} {shown(name)} does not exist{did_you_mean(name, known)}")
    return known[name]


def _given(root: Element, tags: list[str]) -> set[str]:
    seen: set[str] = set()
    for section in root.iterfind("worldbody"):
        for element in section.iter():
            name = element.get("name", "")
            if element.tag not in tags or not name:
                continue
            if name in seen:
                raise ModelFileError(f"two of <{tags[0]}> are named {shown(name)}")
            seen.add(name)
    return seen
