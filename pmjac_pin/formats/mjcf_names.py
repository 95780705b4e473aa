"""Names of an MJCF model, and of what has none there."""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree.ElementTree import Element

from pmjac_pin.errors import ModelFileError, did_you_mean
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

    Raises
    ------
    ModelFileError
        Two bodies, sites or joints of the same name.
    """

    def __init__(self, root: Element) -> None:
        bodies, sites, joints = (_given(root, tags) for tags in (["body"], ["site"], _JOINTS))
        if WORLD in bodies:
            raise ModelFileError("a body is named 'world'; that name is the ground's")
        self._links = {WORLD, *bodies, *(sites - bodies)}
        self._joints = set(joints)
        self._bodies = bodies

    def link(self, wish: str) -> str:
        """Return a new name for a link."""
        return _taken(wish, self._links)

    def joint(self, wish: str) -> str:
        """Return a new name for a joint."""
        return _taken(wish, self._joints)

    def site(self, name: str) -> str:
        """Return the link that a named site becomes."""
        return self.link(f"{name}_site") if name in self._bodies | {WORLD} else name


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


def _taken(wish: str, names: set[str]) -> str:
    """Return this name, with a number at its end if it is taken; it is taken from now on."""
    number, name = 2, wish
    while name in names:
        name, number = f"{wish}_{number}", number + 1
    names.add(name)
    return name
