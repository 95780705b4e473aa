"""The two names that span a slice: motors, or coordinates of the tool's place."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from pmjac_pin.errors import ArgumentError, enumerated, quoted, unknown_name
from pmjac_pin.mechanism import Mechanism

TOOL_AXES = ("x", "y", "z")
_WANTED = "a plane is of two motors, or of two of the tool's x, y and z"


def plane_names(plane: Sequence[str], mechanism: Mechanism) -> tuple[str, str]:
    """Return the two names of a plane, both of motors or both of the tool.

    Raises
    ------
    ArgumentError, UnknownNameError
        Not two, none that there are, a passive joint, one of each sort; a mechanism of mobility 1.
    """
    if mechanism.mobility in (0, 1):
        moves = f"{mechanism.name} has mobility {mechanism.mobility}, and moves over no plane"
        raise ArgumentError(f"{moves}: `follow` tells its singular poses along its motors")
    if isinstance(plane, str) or not isinstance(plane, Iterable):
        raise ArgumentError(f"{_WANTED}, in a list; got {quoted(plane)}")
    given, motors = tuple(plane), mechanism.actuated
    for name in given:
        if name in mechanism.passive:
            raise ArgumentError(f"{_WANTED}; got {quoted(name)}, which is passive")
        if name not in motors and name not in TOOL_AXES:
            raise unknown_name("motor or coordinate", name, (*motors, *TOOL_AXES))
    if len(given) != 2 or given[0] == given[1]:
        raise ArgumentError(f"{_WANTED}; got {enumerated([*map(quoted, given)]) or 'none'}")
    tools = [name for name in given if is_of_the_tool(name, mechanism)]
    if len(tools) == 1:
        raise ArgumentError(f"{_WANTED}; got one of each: {quoted(tools[0])} is the tool's")
    return given[0], given[1]


def is_of_the_tool(name: str, mechanism: Mechanism) -> bool:
    """Tell whether a name is a coordinate of the tool: a motor that is named so comes first."""
    return name in TOOL_AXES and name not in mechanism.actuated
