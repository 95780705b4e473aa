"""Arms: the segments of a mechanism's loops, and which joints turn and slide each of them.

A loop's rows measure points p = Σₖ R₁⋯Rₖ dₖ that chains of joints carry, with Rᵢ the turn of the
i-th joint and dₖ the segment from the k-th joint that turns to the next; or products of turns,
which are segments of length 1. Everything is seen from the last body that carries both frames of
a loop, or from its second frame where the rows ask for that. What `bends` makes of these lengths
are bounds on derivatives at any pose.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import mul
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from pmjac_pin.errors import ArgumentError
from pmjac_pin.kinematics.dimensions import OfModel, Placements
from pmjac_pin.model.frames import Frame, find_frame
from pmjac_pin.model.joint_kinds import known_kind, pitch_of
from pmjac_pin.model.loop_spec import JointLoop, Loop
from pmjac_pin.model.rows import Rows
from pmjac_pin.values.arrays import Array

_NO_GROUP = -1
# Rounding makes no segment shorter, nor by chance as long as a number that it is not.
_LONGER = 1.0 + 1e-14
_ALIKE_BUT_FOR_ROUNDING = (
    1.0 - 1e-14
)  # of a length: those of symmetric machines are equal but for rounding


class _Freedom(NamedTuple):
    """The groups of a joint: what slides, or −1, and what turns, one after the other."""

    slide: int
    turns: tuple[int, ...]


class Segment(NamedTuple):
    """A segment of a chain.

    Attributes
    ----------
    turns : tuple of int
        The groups that turn it.
    length : float
        Without its slides, m; 1 for a product of turns.
    slides : tuple of int
        The groups whose motion is in it.
    lies : tuple of int
        The groups whose value is in it.
    """

    turns: tuple[int, ...]
    length: float
    slides: tuple[int, ...] = ()
    lies: tuple[int, ...] = ()


class BoundedRows(NamedTuple):
    """Rows that are bounded together.

    Attributes
    ----------
    rows : int
        How many; a coupling's has no segments.
    segments : tuple of Segment
    rod : float
        The length of a distance, m; 0 for others.
    exact : bool
        The rows as evaluated are those meant here off closure, too.
    """

    rows: int
    segments: tuple[Segment, ...] = ()
    rod: float = 0.0
    exact: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class Arms:
    """The arms of a mechanism's loops.

    Attributes
    ----------
    rates : ndarray, shape (groups, nv)
        The columns that are measured together, by the Euclidean norm: the slides of one joint,
        a ball's turn. How far a column slides per unit, in m, and 1 where it turns.
    values : ndarray, shape (groups, nq)
        The entries of q that a slide's value consists of, and how far it slides per unit.
    blocks : tuple of Block
        In the order of the rows.
    """

    rates: Array
    values: Array
    blocks: tuple[BoundedRows, ...]


def arms_of(
    model: pin.Model,
    loops: Sequence[Loop],
    values: Mapping[str, float],
    placements: Placements | None = None,
) -> Arms:
    """Return the arms of a model's loops.

    Parameters
    ----------
    model, loops, values
        As of `Loops`.
    placements : Placements, optional
        Where joints and frames are; as the model has them when None.

    Raises
    ------
    ArgumentError
        A joint or rows of a kind that is not known here.
    """
    groups, placed = _Groups(model), placements or OfModel(model)
    blocks: list[BoundedRows] = []
    for loop in loops:
        if isinstance(loop, JointLoop):
            blocks.append(BoundedRows(1))
            continue
        one, other = (find_frame(model, name) for name in loop.frames)
        chains = _chains(model, placed, groups, one, other)
        blocks += [_bounded_rows(rows, *chains) for rows in loop.rows(values)]
    return Arms(np.array(groups.rates), np.array(groups.values), _alike(blocks))


def _alike(blocks: Sequence[BoundedRows]) -> tuple[BoundedRows, ...]:
    """Return blocks whose segments are as long as those that they differ from by rounding alone.

    So programs of machines of other dimensions have the same terms.
    """
    longest: dict[float, float] = {}
    last = np.inf
    lengths = {one.length for block in blocks for one in block.segments}
    for length in sorted((one for one in lengths if isinstance(one, float)), reverse=True):
        last = last if length >= _ALIKE_BUT_FOR_ROUNDING * last else length
        longest[length] = last
    return tuple(
        block._replace(
            segments=tuple(
                one._replace(length=longest.get(one.length, one.length)) for one in block.segments
            )
        )
        for block in blocks
    )


def without_arms(model: pin.Model, rows: int) -> Arms:
    """Return what stands for loops with joints that are not known: nothing between is bounded."""
    return Arms(np.zeros((0, model.nv)), np.zeros((0, model.nq)), (BoundedRows(rows),))


class _Groups:
    def __init__(self, model: pin.Model) -> None:
        self.rates: list[Array] = []
        self.values: list[Array] = []
        self.of_joint = [_Freedom(_NO_GROUP, ())]
        for joint, name in list(zip(model.joints, model.names, strict=True))[1:]:
            kind = known_kind(joint, name, in_turn=True)
            slide, turning = _NO_GROUP, range(kind.slides, kind.nv)
            if kind.along:
                reach = abs(kind.reach(pitch_of(joint)))
                slide = self._add(model, joint, range(len(kind.along)), reach, lies=True)
            turns = [[column] for column in turning] if kind.in_turn else [turning] * bool(turning)
            groups = (self._add(model, joint, columns, 1.0, lies=False) for columns in turns)
            self.of_joint.append(_Freedom(slide, tuple(groups)))

    def _add(
        self,
        model: pin.Model,
        joint: pin.JointModel,
        columns: Sequence[int],
        reach: float,
        *,
        lies: bool,
    ) -> int:
        rates, values = np.zeros(model.nv), np.zeros(model.nq)
        for column in columns:
            rates[joint.idx_v + column] = reach
            values[joint.idx_q + column] = reach * lies
        self.rates.append(rates)
        self.values.append(values)
        return len(self.rates) - 1


def _chains(
    model: pin.Model, placed: Placements, groups: _Groups, one: Frame, other: Frame
) -> tuple[list[Segment], list[Segment]]:
    """Return the chains to two frames from the last body that carries both."""
    first, second = (list(model.supports[frame.joint]) for frame in (one, other))
    shared = sum(a == b for a, b in zip(first, second, strict=False))
    return _segments(placed, groups, first[shared:], one), _segments(
        placed, groups, second[shared:], other
    )


def _segments(
    placed: Placements, groups: _Groups, joints: list[int], frame: Frame
) -> list[Segment]:
    segments: list[Segment] = []
    turns: tuple[int, ...] = ()
    slides: tuple[int, ...] = ()
    lies: tuple[int, ...] = ()
    places: list[Any] = []
    for joint in joints:
        places.append(placed.of_joint(joint))
        slide, turning = groups.of_joint[joint]
        own = (slide,) * (slide != _NO_GROUP)
        lies += own
        if turning:
            segments.append(Segment(turns, _length(places), slides, lies))
            places, turns = [], turns + turning
            slides = lies = ()
        slides += own  # in axes that turn with the joint
    length = _length([*places, placed.of_frame(frame)])
    return [*segments, Segment(turns, length, slides, lies)]


def _length(places: Sequence[Any]) -> Any:
    """Return how far a chain of placements leads."""
    translation = reduce(mul, places).translation
    if translation.dtype != object:
        return _LONGER * float(np.linalg.norm(translation))
    # What records is imported with the first program.
    from pmjac_pin.rates.sparse_qr import norm  # noqa: PLC0415

    return norm(translation) * _LONGER


def _bounded_rows(rows: Rows, first: list[Segment], second: list[Segment]) -> BoundedRows:
    count = len(rows.names)
    match rows.measures:
        case "gap":
            return BoundedRows(count, (*first, *second), exact=False)
        case "distance":
            rod: float = rows.length  # type: ignore[attr-defined]
            return BoundedRows(count, (*first, *second), rod=rod)
        case "gap from second":
            return BoundedRows(count, _from_second(first, second))
        case "turns":
            every = first[-1].turns + second[-1].turns
            return BoundedRows(count, (Segment(every, 1.0),), exact=False)
    raise ArgumentError(f"rows of {type(rows).__name__}: how they bend is not known here")


def _from_second(first: list[Segment], second: list[Segment]) -> tuple[Segment, ...]:
    """Return the one chain from the second frame back to the common body and on to the first."""
    every = second[-1].turns
    back = []
    for k, segment in enumerate(second):
        # The motion of a free body is in axes that turn with it: its own turn counts as well.
        last = second[k - 1].turns if k and segment.slides else segment.turns
        turns = tuple(turn for turn in every if turn not in last)
        back.append(segment._replace(turns=turns))
    return (*back, *(segment._replace(turns=every + segment.turns) for segment in first))
