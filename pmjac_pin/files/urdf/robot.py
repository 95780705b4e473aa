"""Urdf: a URDF that was read and checked, and that parameters may move.

It knows nothing of Pinocchio, and is a value: it can be shared, compared and pickled. A file is
parsed and checked once; what moves or locks joints copies the elements and checks those that it
changed. What Pinocchio gets is `Urdf.kinematic_xml`, never the file itself.
"""

from __future__ import annotations

import copy
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple, Self
from xml.etree.ElementTree import Element, SubElement, tostring

from pmjac_pin.errors import ModelFileError, unknown_name
from pmjac_pin.files.text_file import at_file
from pmjac_pin.files.urdf.checks import checked_joint, checked_robot
from pmjac_pin.files.urdf.joint_tree import UrdfJoint, joints_of
from pmjac_pin.files.urdf.vocabulary import URDF_WORDS
from pmjac_pin.files.xml_text import label, numbers, only, parse_xml, written
from pmjac_pin.model.parameter import Move
from pmjac_pin.values.sealed_pickle import sealed_pickle, unsealed

__all__ = ["Urdf", "UrdfJoint", "parse_urdf"]

MAXIMAL_URDF = 20_000_000  # bytes

SIZE_ATTRIBUTES: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "box": ("size",),
        "cylinder": ("radius", "length"),
        "capsule": ("radius", "length"),
        "sphere": ("radius",),
    }
)


@dataclass(frozen=True, eq=False)
class Urdf:
    """A URDF whose links and joints form one tree that Pinocchio can build.

    Two are equal where path, text and `unread` are.

    Attributes
    ----------
    path : str
        Where it came from; only for messages.
    joints : tuple of UrdfJoint
        In file order.
    links : tuple of str
        In file order.
    visuals : tuple of str
        The names of the <visual> elements that have one, in file order.
    unread : tuple of str
        One sentence for each kind of thing in it that nobody reads.
    """

    path: str
    joints: tuple[UrdfJoint, ...]
    links: tuple[str, ...]
    visuals: tuple[str, ...]
    unread: tuple[str, ...]
    # Never changed, since copies of this value share them.
    _robot: Element = field(repr=False)
    _kinematic: Element = field(repr=False)

    @classmethod
    def of(cls, robot: Element, path: str, unread: tuple[str, ...] = ()) -> Self:
        """Check a <robot>, which nobody may change any more.

        Raises
        ------
        ModelFileError
            Not a URDF, not one tree, or something that Pinocchio would crash on, misread or
            ignore in silence.
        """
        with at_file(path):
            kinematic = checked_robot(robot)
        names = (visual.get("name") for visual in robot.iterfind("link/visual"))
        return cls(
            path=path,
            joints=joints_of(kinematic),
            links=tuple(link.get("name", "") for link in kinematic.iterfind("link")),
            visuals=tuple(name for name in names if name),
            unread=unread,
            _robot=robot,
            _kinematic=kinematic,
        )

    @cached_property
    def text(self) -> str:
        """The whole XML, visuals included, without comments."""
        return tostring(self._robot, encoding="unicode")

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Urdf):
            return NotImplemented
        mine, theirs = ((urdf.path, urdf.unread, urdf.text) for urdf in (self, other))
        return mine == theirs

    def __hash__(self) -> int:
        return hash((self.path, self.text))

    def __reduce__(self) -> tuple[Any, ...]:
        sealed = self.__dict__.get("_sealed") or sealed_pickle(
            {field.name: getattr(self, field.name) for field in fields(self)}
        )
        return _unpickled_urdf, (type(self), sealed)

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """Open one that was unpickled, when it is first looked at: most never are."""
            if "_sealed" not in self.__dict__ or name not in self.__dataclass_fields__:
                raise AttributeError(name, name=name, obj=self)
            self.__dict__.update(unsealed(self.__dict__["_sealed"], "a URDF"))
            return self.__dict__[name]

    def robot(self) -> Element:
        """Return the whole XML as elements: a copy, to change as you like."""
        return copy.deepcopy(self._robot)

    def kinematic_xml(self) -> str:
        """Return the least URDF that gives Pinocchio the same model.

        Its links have inertials and nothing else; its joints have their origin, axis, limit
        and dynamics. Every number was read and written anew.

        Examples
        --------
        >>> urdf = parse_urdf('<robot name="r"><link name="a"><visual/></link></robot>', "r.urdf")
        >>> urdf.kinematic_xml()
        '<robot name="r"><link name="a" /></robot>'
        """
        return tostring(self._kinematic, encoding="unicode")

    def heavy(self) -> set[str]:
        """Return the links that have a mass."""
        return {
            link.get("name", "")
            for link in self._kinematic.iterfind("link")
            if (mass := link.find("inertial/mass")) is not None and float(mass.get("value", "")) > 0
        }

    def changed(self, robot: Element, joints: Collection[str]) -> Self:
        """Return the URDF with a changed copy of its <robot>.

        Parameters
        ----------
        robot : Element
            Nobody may change it any more.
        joints : collection of str
            The joints that were changed, which still join the same links; only they are checked.

        Raises
        ------
        ModelFileError
            As `Urdf.of`.
        """
        with at_file(self.path):
            checked = {
                joint.get("name", ""): checked_joint(joint, self.links)
                for joint in robot.iterfind("joint")
                if joint.get("name") in joints
            }
        kinematic = Element(self._kinematic.tag, self._kinematic.attrib)
        for element in self._kinematic:
            new = checked.get(element.get("name", "")) if element.tag == "joint" else None
            kinematic.append(element if new is None else new)
        return replace(self, joints=joints_of(kinematic), _robot=robot, _kinematic=kinematic)

    def moved(self, moves: Iterable[tuple[Move, float]]) -> Urdf:
        """Return the URDF with ``coefficient * delta`` added to the numbers that each move names.

        Parameters
        ----------
        moves : iterable of (Move, float)
            Each with its parameter's distance from the default, in m or rad. Moves of the same
            number add up.

        Raises
        ------
        UnknownNameError
            A joint or a visual that does not exist.
        ModelFileError
            A visual name that is not unique, a shape without the attribute, or a size that
            would not be positive.
        """
        with at_file(self.path):
            asked = list(moves)
            self._targets(self._robot, asked)
            steps = [(move, delta) for move, delta in asked if delta != 0.0]
            if not steps:
                return self
            robot = self.robot()
            places = [
                (place, delta)
                for (move, delta), element in zip(steps, self._targets(robot, steps), strict=True)
                for place in _moved_numbers(element, move)
            ]
            for place, delta in places:
                place.add(delta)
            for place, _ in places:  # one may shrink a shape and another make up for it
                place.check()
        joints = {move.joint for move, _ in steps if move.joint is not None}
        return self.changed(robot, joints)

    def _targets(self, robot: Element, moves: Iterable[tuple[Move, float]]) -> list[Element]:
        named = _what_moves_name(robot)
        return [self._target(named, move) for move, _ in moves]

    def _target(self, named: Mapping[tuple[str, str], list[Element]], move: Move) -> Element:
        """Return the element that a move names, once it is certain that it can be moved so."""
        kind, name = ("visual", move.visual or "") if move.joint is None else ("joint", move.joint)
        found = named.get((kind, name), [])
        if not found:
            joints = tuple(joint.name for joint in self.joints)
            raise unknown_name(kind, name, joints if kind == "joint" else self.visuals)
        if len(found) > 1:
            many = f"{len(found)} visuals are named {name!r}"
            raise ModelFileError(f"{many}; one that a parameter moves needs its own name")
        _resized_shape(found[0], move)
        return found[0]


def parse_urdf(text: str, path: str) -> Urdf:
    """Check a URDF.

    Parameters
    ----------
    text : str
        The XML. Meshes that it names are not opened.
    path : str
        Where it came from; messages start with it.

    Raises
    ------
    ModelFileError
        Not XML, not a URDF, not one tree, or something that Pinocchio would crash on, misread
        or ignore in silence.

    Examples
    --------
    >>> urdf = parse_urdf('<robot name="r"><link name="base"/></robot>', "r.urdf")
    >>> urdf.links
    ('base',)
    """
    with at_file(path):
        robot = parse_xml(text)
        unread = URDF_WORDS.unread(robot)
    return Urdf.of(robot, path, unread)


def _unpickled_urdf(kind: type[Urdf], sealed: bytes) -> Urdf:
    urdf = object.__new__(kind)
    urdf.__dict__["_sealed"] = sealed
    return urdf


def _what_moves_name(robot: Element) -> dict[tuple[str, str], list[Element]]:
    """Return what a move may name, joints and visuals, by kind and name."""
    named: dict[tuple[str, str], list[Element]] = {}
    for path in ("joint", "link/visual"):
        for element in robot.iterfind(path):
            named.setdefault((element.tag, element.get("name", "")), []).append(element)
    return named


class _MovedNumbers(NamedTuple):
    """Numbers that a move adds to."""

    where: str
    element: Element
    attribute: str
    coefficients: tuple[float, ...]

    def _numbers(self) -> list[float]:
        default = "0 0 0" if self.element.tag == "origin" else None
        count = len(self.coefficients)
        return numbers(self.where, self.element, self.attribute, default=default, count=count)

    def add(self, delta: float) -> None:
        pairs = zip(self._numbers(), self.coefficients, strict=True)
        self.element.set(self.attribute, written(old + one * delta for old, one in pairs))

    def check(self) -> None:
        """Refuse numbers that are too large, and sizes that are none."""
        values = self._numbers()
        if self.element.tag != "origin" and min(values) <= 0.0:
            got = f"`{self.attribute}` would become {written(values)}"
            raise ModelFileError(f"{self.where}: {got}; it must be positive")


def _moved_numbers(element: Element, move: Move) -> Iterator[_MovedNumbers]:
    """Yield the numbers of an element that a move adds to."""
    where = label(element)
    for attribute, coefficients in (("xyz", move.xyz), ("rpy", move.rpy)):
        if any(coefficients):
            origin = only(where, element, "origin")
            if origin is None:
                origin = SubElement(element, "origin")
            yield _MovedNumbers(f"{where}, <origin>", origin, attribute, coefficients)
    if (shape := _resized_shape(element, move)) is not None:
        for attribute, sizes in size_coefficients(move).items():
            yield _MovedNumbers(f"{where}, <{shape.tag}>", shape, attribute, sizes)


def size_coefficients(move: Move) -> dict[str, tuple[float, ...]]:
    given = {"size": move.size, "length": (move.length,), "radius": (move.radius,)}
    return {attribute: numbers for attribute, numbers in given.items() if any(numbers)}


def _resized_shape(element: Element, move: Move) -> Element | None:
    """Return the shape whose size the move changes; nothing if it changes none."""
    if not (wanted := size_coefficients(move)):
        return None
    where = label(element)
    geometry = only(where, element, "geometry")
    if geometry is None or len(geometry) != 1:
        raise ModelFileError(f"{where} needs a <geometry> with one shape")
    sizes = SIZE_ATTRIBUTES.get(geometry[0].tag, ())
    for attribute in wanted:
        if attribute not in sizes:
            got = f"{where} is a <{geometry[0].tag}> and has no `{attribute}` to move"
            known = f"; it has: {', '.join(sizes)}" if sizes else ""
            raise ModelFileError(f"{got}{known}")
    return geometry[0]
