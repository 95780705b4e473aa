"""New names for links and joints that a file of another format leaves without one."""

from __future__ import annotations


def unused_name(name: str, taken: set[str]) -> str:
    """Return this name, with a number at its end if it is taken; from now on it is.

    Examples
    --------
    >>> unused_name("rod", {"rod", "rod_2"})
    'rod_3'
    """
    number, unused = 2, name
    while unused in taken:
        unused, number = f"{name}_{number}", number + 1
    taken.add(unused)
    return unused
