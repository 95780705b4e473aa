"""What a mechanism is made of, as a diagnosis lists it: bodies, freedoms, loops, mobility."""

from __future__ import annotations

import msgspec


class BodyEntry(msgspec.Struct, frozen=True):
    """A rigid body: links joined by fixed joints.

    Attributes
    ----------
    name : str
        Its first link.
    links : tuple of str
    joint : str or None
        The joint that carries it; None for the ground.
    loops : tuple of str
        The loops that end on it.
    tool : bool
    """

    name: str
    links: tuple[str, ...]
    joint: str | None
    loops: tuple[str, ...]
    tool: bool


class FreedomEntry(msgspec.Struct, frozen=True):
    """One degree of freedom of a joint, m or rad.

    Attributes
    ----------
    name, joint, kind : str
        A joint with several degrees of freedom has one entry for each.
    role : {"actuated", "passive", "unknown"}
        "unknown" where nobody says which joints are motors.
    unit : str
    lower, upper : float or None
        Limits; None for none.
    given, home, moved : float or None
        The file's value in the home pose, the value with the loops closed, and how far it had to
        move for that.
    loops : tuple of str
        The loops that its joint is part of.
    """

    name: str
    joint: str
    kind: str
    role: str
    unit: str
    lower: float | None
    upper: float | None
    given: float
    home: float | None
    moved: float | None
    loops: tuple[str, ...]


class LoopEntry(msgspec.Struct, frozen=True):
    """One loop closure.

    Attributes
    ----------
    name, kind : str
    joints : tuple of str
        The joints along it.
    equations, units : tuple of str
        Its rows.
    group : str or None
        What its joints move in: "planar", "spherical", "spatial", ...
    group_rows : int
        Its independent rows for displacements in that group.
    rank, needed : int or None
        Of its rows alone; and how much the rank of all loops' rows drops without it.
    size : float
        The mean of its lever arms, m; 0 where they are rounding only, or it has none.
    gap_given : float
        How open it is in the file's home pose, m.
    gap_alone : float or None
        Where home does not assemble: how near it comes to closing with the other loops left open.
    """

    name: str
    kind: str
    joints: tuple[str, ...]
    equations: tuple[str, ...]
    units: tuple[str, ...]
    group: str | None
    group_rows: int
    rank: int | None
    needed: int | None
    size: float
    gap_given: float
    gap_alone: float | None


class Mobility(msgspec.Struct, frozen=True):
    """The mobility as it is, and as it is counted.

    Attributes
    ----------
    freedoms : int
        Σf, degrees of freedom of the tree's joints.
    rows : int
        Rows of all loops.
    gruebler : int
        Grübler-Kutzbach in space: Σf − rows, the same as 6 (bodies − 1 − joints) + Σf with each
        cut counted as a joint of the loop's kind.
    group_rows, gruebler_in_groups : int
        The rows that each loop has in its own group (2 for a planar loop cut at a point), and the
        count with these.
    rank, mobility : int or None
        Of [K K*], and Σf − rank: what is true.
    reach : float or None
        How far from home joints were seen to move, rad or a share of the characteristic length,
        where it is so little that loops may part beyond.
    """

    freedoms: int
    rows: int
    gruebler: int
    group_rows: int
    gruebler_in_groups: int
    rank: int | None
    mobility: int | None
    reach: float | None = None
