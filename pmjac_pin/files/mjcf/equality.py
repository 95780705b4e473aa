"""The loop closures of MJCF: <connect> and <weld> of <equality>, and <tendon> that are rods.

MuJoCo holds two bodies as they are to each other at qpos0: the file gives a point of one of them,
and the other's is where that is then (MuJoCo, XML reference, equality/connect and /weld). A
tendon from one site straight to another is held at its length at qpos0 plus the first coefficient
(equality/tendon).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from pmjac_pin.errors import ArgumentError, ModelFileError, quoted
from pmjac_pin.files.mjcf.bodies import place
from pmjac_pin.files.mjcf.mujoco import Compiled
from pmjac_pin.files.mjcf.names import Names
from pmjac_pin.files.mjcf.tree import MjcfTree
from pmjac_pin.files.urdf.checks import MAXIMAL_LINKS
from pmjac_pin.model.loop_spec import DistanceLoop, FrameLoop, Loop, PointLoop

_EQUALITIES = ("connect", "weld", "joint", "tendon")  # in the order of mujoco.mjtEq
_SITE = 6  # of mujoco.mjtObj
_WRAPPED_SITE = 3  # of mujoco.mjtWrap
_TERMS = 5


def active_equalities(compiled: Compiled) -> tuple[dict[str, list[int]], list[str]]:
    """Return the constraints that hold by their kind, and a note for each other one.

    Raises
    ------
    ModelFileError
        Very many.
    """
    model = compiled.model
    active: dict[str, list[int]] = {kind: [] for kind in _EQUALITIES}
    notes = []
    for number, label in enumerate(compiled.equalities):
        if model.eq_active0[number]:
            active[_EQUALITIES[model.eq_type[number]]].append(number)
        else:
            notes.append(f"{label} is not active, and left out")
    if model.neq > MAXIMAL_LINKS:
        what = f"{model.neq} equality constraints are too many"
        raise ModelFileError(f"{what}; at most {MAXIMAL_LINKS} are read")
    return active, notes


def straight_tendons(compiled: Compiled, numbers: Sequence[int]) -> list[int]:
    """Return which of these <tendon> constraints hold one tendon from a site to another."""
    model = compiled.model
    return [
        number
        for number in numbers
        if not (model.eq_obj2id[number] >= 0 and model.eq_data[number, 1:_TERMS].any())
        and len(_sites(compiled, int(model.eq_obj1id[number]))) == 2
    ]


def read_closures(
    compiled: Compiled, numbers: Sequence[int], names: Names, tree: MjcfTree
) -> list[Loop]:
    """Return the loops of <connect>, <weld> and straight tendons; frames are added to the tree.

    Raises
    ------
    ModelFileError
        A body or site joined to itself.
    """
    return [
        _rod(compiled, number, names)
        if _EQUALITIES[compiled.model.eq_type[number]] == "tendon"
        else _loop_of_equality(compiled, number, names, tree)
        for number in numbers
    ]


def _sites(compiled: Compiled, tendon: int) -> list[int]:
    """Return the sites that a tendon joins; none of one that goes over anything else."""
    model = compiled.model
    own = slice(
        int(model.tendon_adr[tendon]), int(model.tendon_adr[tendon] + model.tendon_num[tendon])
    )
    straight = bool((model.wrap_type[own] == _WRAPPED_SITE).all())
    return model.wrap_objid[own].tolist() if straight else []


def _rod(compiled: Compiled, number: int, names: Names) -> DistanceLoop:
    model, where = compiled.model, compiled.equalities[number]
    tendon = int(model.eq_obj1id[number])
    first, second = (names.sites[site] for site in _sites(compiled, tendon))
    if first == second:
        raise ModelFileError(f"{where} joins site {quoted(first)} to itself")
    length = float(model.tendon_length0[tendon] + model.eq_data[number, 0])
    try:
        loop = DistanceLoop(frames=(first, second), length=length)
        loop.resolved({})
    except ArgumentError as error:
        raise ModelFileError(f"{where}: {error}") from None
    return loop


def _loop_of_equality(compiled: Compiled, number: int, names: Names, tree: MjcfTree) -> Loop:
    model, where = compiled.model, compiled.equalities[number]
    data, welded = model.eq_data[number], _EQUALITIES[model.eq_type[number]] == "weld"
    by_site = model.eq_objtype[number] == _SITE
    known = names.sites if by_site else names.bodies
    first, second = known[model.eq_obj1id[number]], known[model.eq_obj2id[number]]
    if first == second:
        kind = "site" if by_site else "body"
        raise ModelFileError(f"{where} joins {kind} {quoted(first)} to itself")
    if not by_site:
        places = _welded(data) if welded else _connected(data)
        wishes = (f"{first}_at_{second}", f"{second}_at_{first}")
        first, second = (
            tree.anchor(body, wish, placement)
            for body, wish, placement in zip((first, second), wishes, places, strict=True)
        )
    turns = welded and data[10] != 0.0  # torquescale
    return (FrameLoop if turns else PointLoop)(frames=(first, second))


def _connected(data: np.ndarray) -> tuple[pin.SE3, pin.SE3]:
    return pin.SE3(np.eye(3), data[:3].copy()), pin.SE3(np.eye(3), data[3:6].copy())


def _welded(data: np.ndarray) -> tuple[pin.SE3, pin.SE3]:
    """Return the second body's pose on the first, and the anchor on the second.

    MuJoCo takes relpose's translation for the anchor on the first body as it is, even where the
    second body's anchor is not at its origin.
    """
    return place(data[3:6], data[6:10]), pin.SE3(np.eye(3), data[:3].copy())
