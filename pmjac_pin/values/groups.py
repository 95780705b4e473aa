"""Groups of things that have something in common."""

from __future__ import annotations

from collections.abc import Hashable, Sequence, Set
from typing import TypeVar

Member = TypeVar("Member", bound=Hashable)


def sharing_groups(members: Sequence[Set[Member]]) -> list[list[int]]:
    """Return the numbers of sets in groups that share members, themselves or by others.

    Examples
    --------
    >>> sharing_groups([{"a", "b"}, {"c"}, {"b", "d"}])
    [[1], [0, 2]]
    """
    groups: list[list[int]] = []
    for number, own in enumerate(members):
        mine, others = [number], []
        for group in groups:
            if any(own & members[k] for k in group):
                mine = [*group, *mine]
            else:
                others.append(group)
        groups = [*others, mine]
    return groups
