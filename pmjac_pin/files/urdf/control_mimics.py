"""Joints within <ros2_control> that follow others: by its params mimic, multiplier and offset.

Params are told from each other by their names, and a hardware may have any of its own.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from xml.etree.ElementTree import Element

from pmjac_pin.errors import ModelFileError, quoted
from pmjac_pin.files.vocabulary import spelt_like
from pmjac_pin.files.xml_text import label

#: Where such joints are in a <robot>.
CONTROL_JOINTS = "ros2_control/joint"
_LEADER = "mimic"
_PARAMS = frozenset({_LEADER, "multiplier", "offset"})
_MIMIC_TRUTHS = {"": None, "true": True, "false": False}


def called_joint(joint: Element) -> str:
    """Return how messages call a joint within <ros2_control>."""
    return f"{label(joint)} of <ros2_control>"


def is_mimic(joint: Element) -> bool | None:
    """Whether a joint is said to follow another by ``mimic="true"``; None where nothing is said.

    Raises
    ------
    ModelFileError
        It is neither true nor false.
    """
    given = joint.get(_LEADER, "")
    if given.lower() not in _MIMIC_TRUTHS:
        raise ModelFileError(
            f"{called_joint(joint)}: `mimic` is {quoted(given)}; it is true or false"
        )
    return _MIMIC_TRUTHS[given.lower()]


def mimic_params(joint: Element) -> Mapping[str, Element]:
    """Return the params by which a joint follows another, by name; none without a leader.

    Raises
    ------
    ModelFileError
        A name that looks like a misspelt one, or that is given twice.

    Examples
    --------
    >>> from xml.etree.ElementTree import fromstring
    >>> params = '<param name="mimic">a</param><param name="id">7</param>'
    >>> list(mimic_params(fromstring(f'<joint name="b">{params}</joint>')))
    ['mimic']
    """
    names = [param.get("name", "") for param in joint.findall("param")]
    follows = _LEADER in names or is_mimic(joint)
    read = _PARAMS if follows else frozenset({_LEADER})
    for name in names:
        if name not in read and (meant := spelt_like(name, read)) is not None:
            what = f"{called_joint(joint)} has the unknown param {quoted(name)}"
            raise ModelFileError(f"{what}; did you mean {meant!r}?")
        if name in read and names.count(name) > 1:
            raise ModelFileError(f"{called_joint(joint)} has {names.count(name)} params {name!r}")
    if _LEADER not in names:
        return {}
    params = zip(names, joint.findall("param"), strict=True)
    return {name: param for name, param in params if name in _PARAMS}


def doubtful(robot: Element, followers: Collection[str]) -> Iterator[str]:
    """Yield a sentence on each joint within <ros2_control> that might follow another, or not.

    Parameters
    ----------
    robot : Element
    followers : collection of str
        The joints that follow others, by all that is read.
    """
    for joint in robot.iterfind(CONTROL_JOINTS):
        said, follows = is_mimic(joint), joint.get("name") in followers
        if said is True and not follows:
            yield f'{called_joint(joint)} has mimic="true", and nothing says which joint it follows'
        if said is False and follows:
            yield f'{called_joint(joint)} has mimic="false", and follows another all the same'
        for param in joint.findall("param"):
            name = param.get("name", "")
            if _LEADER in name.lower() and name != _LEADER:
                yield f"not read: <param> {quoted(name)} in {called_joint(joint)}"
