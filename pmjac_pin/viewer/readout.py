"""What the page shows beside the scene, as plain data: numbers, sections and warnings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, get_args

import msgspec
import numpy as np
import pinocchio as pin

from pmjac_pin.configuration import Configuration
from pmjac_pin.model.tool_rows import ToolRows
from pmjac_pin.model.twist_frame import FrameName, change_frame
from pmjac_pin.pictures.ellipsoid_panels import PLANES
from pmjac_pin.rates.ellipsoid import Ellipsoid
from pmjac_pin.rates.jacobian import EquivalentJacobian
from pmjac_pin.rates.singularity import Singularity
from pmjac_pin.values.arrays import Array, norm
from pmjac_pin.viewer.equivalent import equivalent
from pmjac_pin.viewer.free_motion import ALMOST_SINGULAR, easiest_motions
from pmjac_pin.viewer.tool_ranks import ToolRanks
from pmjac_pin.words.numbers import SHOWN_AS_ZERO

Values = tuple[float, ...]


_SINGULARITIES = {
    "gain": "a gain (parallel) singularity",
    "loss": "a loss (serial) singularity",
    "gain and loss": "a gain and loss singularity",
    "configuration space": "a configuration-space singularity",
    "isolated": "a structure or a singular home: no pose near it closes",
}
_NAMES_SHOWN = 4
_NEEDS_J_EQ = ("Jv_singular_values", "Jw_singular_values", "J_eq", "sections")


class Section(msgspec.Struct, frozen=True):
    """The section of the linear velocity ellipsoid with one plane, in m/s.

    Attributes
    ----------
    plane : str
        Such as "zy": z to the right, y upwards.
    radii : tuple of float
        Two, descending.
    axes : tuple of tuple of float
        The direction of each radius, in the plane's coordinates.
    """

    plane: str
    radii: Values
    axes: tuple[Values, ...]


class Nearness(msgspec.Struct, frozen=True):
    """How near the pose is to a singularity.

    Attributes
    ----------
    level : str
        "regular", "loss" (of rank of [J_v]eq or [J_ω]eq alone), "near" or "singular".
    text : str
        One sentence without changing numbers, so that a screen reader says it once.
    """

    level: str
    text: str


class Readout(msgspec.Struct, frozen=True, kw_only=True):
    """The numbers at one pose; None where J_eq or what it rests on does not exist.

    Attributes
    ----------
    Jv_singular_values, Jw_singular_values : tuple of float or None
        Of [J_v]eq in m/s and of [J_ω]eq in rad/s, for unit motor rates.
    smallest, condition : float or None
        Of K*: the relative singular value that decides, and the condition; None without loops.
        JSON writes an infinite condition as null.
    loops : bool
        Whether there are any loops.
    tool_rank, generic_tool_rank : int
        How many independent velocities the loops allow the tool here and in general, on the rows
        of its twist that are judged.
    judged : tuple of str
        These rows, briefly and in full.
    residual : float
        Euclidean norm of the gaps of all loops, m.
    J_eq : mapping of str to (tuple of tuple of float), or None
        By its frame: six rows, linear ones first; what is only rounding is 0.
    tool_position, tool_turn : tuple of float
        Where the tool is, m, and its turn from the world's axes: angle times axis, rad.
    passive : tuple of float
        The values of the passive joints, m or rad.
    sections : tuple of Section or None
    warning : Nearness
    beyond : str
        Which joints are outside their limits; empty for none.
    refusal : str or None
        Why J_eq does not exist here.
    """

    Jv_singular_values: Values | None
    Jw_singular_values: Values | None
    smallest: float | None
    condition: float | None
    loops: bool
    tool_rank: int
    generic_tool_rank: int
    judged: tuple[str, str]
    residual: float
    J_eq: dict[FrameName, tuple[Values, ...]] | None
    tool_position: Values
    tool_turn: Values
    passive: Values
    sections: tuple[Section, ...] | None
    warning: Nearness
    beyond: str
    refusal: str | None


def make_readout(configuration: Configuration, ranks: ToolRanks | None = None) -> Readout:
    """Collect what the page shows at a configuration, singular or not.

    Parameters
    ----------
    configuration : Configuration
    ranks : ToolRanks, optional
        Of its mechanism; found at some other poses when None.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> readout = make_readout(pj.load("four_bar").home)
    >>> readout.warning.level, [section.plane for section in readout.sections]
    ('regular', ['zy', 'zx', 'xy'])
    """
    jacobian, refusal = equivalent(configuration)
    tool = configuration.tool_pose()
    singularity = configuration.singularity()
    loops = bool(singularity.generic_rank)
    known = dict.fromkeys(_NEEDS_J_EQ) if jacobian is None else _of_jacobian(jacobian, tool)
    return Readout(
        **known,
        smallest=singularity.smallest if loops else None,
        condition=singularity.condition if loops else None,
        loops=loops,
        tool_rank=singularity.tool_rank,
        generic_tool_rank=singularity.generic_tool_rank,
        judged=_rank_words(singularity.tool_rows),
        residual=configuration.residual_norm,
        tool_position=tuple(tool.translation.tolist()),
        tool_turn=tuple(pin.log3(tool.rotation).tolist()),
        passive=tuple(configuration.passive.tolist()),
        warning=_warning(configuration, singularity, jacobian, ranks),
        beyond=_beyond(configuration),
        refusal=refusal,
    )


def _beyond(configuration: Configuration) -> str:
    found = tuple(configuration.limits_violated)
    if not found:
        return ""
    their = "its limits" if len(found) == 1 else "their limits"
    return (
        f"Beyond {their}: {_first_names(found)}. The loops close, but the machine cannot be here."
    )


def _rank_words(rows: ToolRows) -> tuple[str, str]:
    brief = "all rows" if rows.is_whole else ", ".join(rows.names)
    return brief, f"judged on {rows}"


def _of_jacobian(jacobian: EquivalentJacobian, tool: pin.SE3) -> dict[str, Any]:
    motors, linear = jacobian.partition.actuated.size, jacobian.velocity_ellipsoid()
    J_eq, own_sizes = {}, jacobian.sizes
    for frame in get_args(FrameName):
        entries = change_frame(jacobian.J_eq, frame, tool.rotation, tool.translation)
        sizes = own_sizes.copy()
        sizes[0] += norm(tool.translation) * sizes[1] * (frame == "WORLD")
        rounding = SHOWN_AS_ZERO * sizes.repeat(3)[:, None]
        J_eq[frame] = tuple(map(tuple, np.where(np.abs(entries) > rounding, entries, 0.0).tolist()))
    return {
        "Jv_singular_values": tuple(linear.radii[:motors].tolist()),
        "Jw_singular_values": tuple(jacobian.angular_ellipsoid().radii[:motors].tolist()),
        "J_eq": J_eq,
        "sections": _sections(linear),
    }


def _sections(ellipsoid: Ellipsoid) -> tuple[Section, ...]:
    ellipses = ((plane, ellipsoid.section(plane)) for plane in PLANES)
    return tuple(
        Section(plane, tuple(ellipse.radii.tolist()), tuple(map(tuple, ellipse.axes.T.tolist())))
        for plane, ellipse in ellipses
    )


def _warning(
    configuration: Configuration,
    singularity: Singularity,
    jacobian: EquivalentJacobian | None,
    ranks: ToolRanks | None,
) -> Nearness:
    if singularity.kind != "regular":
        kind = f"{_SINGULARITIES[singularity.kind]}{_types(singularity)}"
        return Nearness("singular", f"At {kind}{_consequence(singularity)}.")
    if singularity.smallest < ALMOST_SINGULAR:
        names = _moving_names(singularity.passive_names, easiest_motions(configuration)[:, 0])
        text = f"Near a gain singularity: with all motors locked, {names} almost come free."
        return Nearness("near", text)
    if jacobian is None:
        return Nearness("regular", "")
    if _tool_share(configuration, jacobian) < ALMOST_SINGULAR:
        text = f"the tool almost loses a motion, judged on {singularity.tool_rows}"
        return Nearness("near", f"Near a loss singularity: {text}.")
    loss = (ranks or ToolRanks.of(configuration.mechanism)).loss(jacobian)
    return Nearness("loss" if loss else "regular", loss)


def _types(singularity: Singularity) -> str:
    """Return the field's names of it, in brackets."""
    types = singularity.types
    kind = types.gosselin_angeles
    names = [*([] if kind is None else [f"type {kind}"]), *types.present]
    return f" ({', '.join(names)})" if names and not singularity.isolated else ""


def _consequence(singularity: Singularity) -> str:
    if singularity.gained > 0:
        names = _moving_names(singularity.passive_names, singularity.free_motions[:, 0])
        return f": with all motors locked, {names} come free"
    if singularity.lost > 0:
        return f": the tool has lost a motion, judged on {singularity.tool_rows}"
    return ": branches of motion meet here"


def _moving_names(names: tuple[str, ...], rates: Array) -> str:
    """Name the joints that take part in a motion: those above 5 % of the largest rate."""
    largest = np.abs(rates).max()
    moving = [n for n, r in zip(names, rates, strict=True) if abs(r) > 0.05 * largest]
    return _first_names(moving)


def _first_names(names: Sequence[str]) -> str:
    return ", ".join(names[:_NAMES_SHOWN]) + " and others" * (len(names) > _NAMES_SHOWN)


def _tool_share(configuration: Configuration, jacobian: EquivalentJacobian) -> float:
    """Return the smallest over the largest generic singular value of the scaled tool motion."""
    partition, pose = jacobian.partition, configuration.tool_pose()
    rank, rows = partition.tool_rank, partition.tool_rows
    J_eq = change_frame(jacobian.J_eq, rows.axes, pose.rotation, pose.translation)
    scaled = J_eq * partition.motor_scale
    scaled[3:] *= partition.length
    scaled = scaled[rows.linear + rows.angular]
    if not rank or not norm(scaled):
        return 1.0
    values = partition.factorise(scaled, norm(scaled)).singular_values
    return float(values[rank - 1] / values[0]) if rank <= values.size else 1.0
