"""Names of an MJCF model, and of what has none there."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any
from xml.etree.ElementTree import Element

from pmjac_pin.errors import quoted
from pmjac_pin.files.unused_name import unused_name

WORLD_BODY = "world"
JOINT_TYPES = ("free", "ball", "slide", "hinge")  # in the order of mujoco.mjtJoint

_EQUALITY_ENDS = [
    f"{kind}{number}" for kind in ("body", "site", "joint", "tendon") for number in (1, 2)
]


class Names:
    """The names of links and joints: the file's own, and new ones that are like no other.

    MJCF's bodies and sites may share names, which become links: then the site's name gets
    "_site" at its end. What has no name is called after the nearest body that has one.

    Parameters
    ----------
    model : mujoco.MjModel

    Attributes
    ----------
    bodies, joints, sites : tuple of str
        By MuJoCo's numbers.
    taken : set of str
        All names.
    """

    def __init__(self, model: Any) -> None:
        given = [model.body(number).name for number in range(model.nbody)]
        joints = [model.joint(number).name for number in range(model.njnt)]
        sites = [model.site(number).name for number in range(model.nsite)]
        self.taken = {*given, *joints, *sites} - {""}
        self.bodies = tuple(self._of_bodies(given, model.body_parentid.tolist()))
        on = [self.bodies[body] for body in model.jnt_bodyid]
        wishes = [
            f"{body}_{JOINT_TYPES[kind]}" for body, kind in zip(on, model.jnt_type, strict=True)
        ]
        self.joints = tuple(
            name or unused_name(wish, self.taken) for name, wish in zip(joints, wishes, strict=True)
        )
        self.sites = tuple(
            self._of_sites(sites, [self.bodies[k] for k in model.site_bodyid], given)
        )

    def _of_bodies(self, given: Sequence[str], parents: Sequence[int]) -> Iterable[str]:
        stems: list[str] = []
        for name, parent in zip(given, parents, strict=True):
            stems.append(name or stems[parent])
            yield name or unused_name(f"{stems[parent]}_body", self.taken)

    def _of_sites(
        self, sites: Sequence[str], on: Sequence[str], bodies: Sequence[str]
    ) -> Iterable[str]:
        for name, body in zip(sites, on, strict=True):
            if name and name not in bodies:
                yield name
            else:
                yield unused_name(f"{name or body}_site", self.taken)


class Places:
    """How messages call the elements of a model: by their names, or the body that they are on."""

    def __init__(self, root: Element) -> None:
        self._above = {child: parent for parent in root.iter() for child in parent}

    def of(self, element: Element) -> str:
        """Return how messages call an element."""
        above = self._above.get(element)
        while above is not None and not element.get("name"):
            if above.tag == "body" and (name := above.get("name")):
                return f"<{element.tag}> on body {quoted(name)}"
            above = self._above.get(above)
        return called(element)


def called(element: Element) -> str:
    """Return how messages call an element: by its name, or by what it joins."""
    if name := element.get("name"):
        return f"{element.tag} {quoted(name)}"
    ends = [f"{key}={quoted(element.get(key, ''))}" for key in _EQUALITY_ENDS if element.get(key)]
    return f"<{' '.join([element.tag, *ends])}>"
