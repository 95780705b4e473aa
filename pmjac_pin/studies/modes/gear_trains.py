"""Gear trains: passive joints that joint loops tie together, so that one value gives all.

A joint of a train is not the same after a full turn, as the others have turned with it: a pinion
whose rack has moved. The whole train is, where all of its joints turn and its ratios are those of
small whole numbers: after as many turns as bring each of them back.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import pinocchio as pin

from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.model.loop_spec import JointLoop, Loop
from pmjac_pin.values.arrays import Array, Index

_MOST_TEETH = 1000  # in a ratio of whole numbers
_MOST_TURNS = 64  # after which a train is the same again
_TURNS_ASIDE = 10  # turns to either side of home, for a train that is never the same again
_FULL_TURN = 2.0 * math.pi
_ROUNDED_SLACK = 1e-9  # m or rad: rounding on the way to a limit is no violation


@dataclass(frozen=True, slots=True, eq=False)
class GearTrain:
    """Joints whose values are slopes · t + offsets, with t that of the first.

    Attributes
    ----------
    names : tuple of str
    columns : ndarray of int
    slopes, offsets : ndarray
    turning : bool
        No joint slides, nor is a screw.
    period : float
        After which, in t, all bodies are where they were; infinite where they never are.
    driver : int or None
        Which of the joints is a motor, which leaves nothing to choose.
    """

    names: tuple[str, ...]
    columns: Index
    slopes: Array
    offsets: Array
    turning: bool
    period: float
    driver: int | None

    def values(self, t: Array) -> Array:
        """Return all joints' values (b, joints) where the first has these, (b,)."""
        return np.asarray(t[:, None] * self.slopes + self.offsets)

    def first(self, joint: int, value: float) -> float:
        """Return t where one of the joints has this value."""
        return float((value - self.offsets[joint]) / self.slopes[joint])

    def between(self, lower: Array, upper: Array) -> tuple[float, float]:
        """Return between which t all joints are within these bounds."""
        tied = self.slopes != 0.0
        bounds = np.array([lower[tied], upper[tied]])
        ends = np.sort((bounds - self.offsets[tied]) / self.slopes[tied], axis=0)
        return float(ends[0].max()), float(ends[1].min())

    def window(self, lower: float, upper: float, home: float) -> tuple[float, float, bool]:
        """Return the part of an interval of t that stands for all of it, and whether it does not.

        It does not where nothing bounds a train that is never the same again.
        """
        width = min(
            self.period, upper - lower, 2.0 * _TURNS_ASIDE * _FULL_TURN if self.turning else np.inf
        )
        if not width < upper - lower:
            return lower, upper, False
        middle = min(max(home, lower + 0.5 * width), upper - 0.5 * width)
        return middle - 0.5 * width, middle + 0.5 * width, width < self.period

    def turned_back(self, t: float, lower: float, upper: float) -> float:
        """Return t less whole periods: next to 0, or within these bounds where that can be."""
        if not math.isfinite(self.period):
            return t
        t -= self.period * round(t / self.period)
        if lower <= t <= upper:
            return t
        if math.isfinite(lower):
            return t + self.period * math.ceil((lower - t - _ROUNDED_SLACK) / self.period)
        return t - self.period * math.ceil((t - upper - _ROUNDED_SLACK) / self.period)


def gear_trains(
    model: pin.Model, loops: Iterable[Loop], motors: Collection[str]
) -> tuple[GearTrain, ...]:
    """Return the trains that joint loops make.

    Parameters
    ----------
    model : pin.Model
    loops : iterable of Loop
    motors : collection of str
    """
    gears = [loop for loop in loops if isinstance(loop, JointLoop)]
    coordinates, known = JointCoordinates(model), set[str]()
    trains: list[GearTrain] = []
    still = {gear.joints[1] for gear in gears if not gear.ratio}

    def tells_nothing(name: str) -> bool:
        """Tell whether others do not follow from a joint: it does not move, or count its turns."""
        return name in still or bool(coordinates.wraps[coordinates.columns([name])[0]])

    for name in sorted(_all(gears), key=tells_nothing):
        if name not in known:
            lines = _gear_lines(name, gears)
            known.update(lines)
            trains.append(_train(coordinates, lines, motors))
    return tuple(trains)


def _all(gears: Sequence[JointLoop]) -> list[str]:
    return list(dict.fromkeys(name for gear in gears for name in gear.joints))


def _gear_lines(first: str, gears: Sequence[JointLoop]) -> dict[str, tuple[float, float]]:
    """Return slope and offset of each joint that hangs together with the first."""
    lines, waiting = {first: (1.0, 0.0)}, [first]
    while waiting:
        name = waiting.pop()
        slope, offset = lines[name]
        for gear in gears:
            one, other = gear.joints
            if name == one and other not in lines:
                lines[other] = gear.ratio * slope, gear.ratio * offset + gear.offset
                waiting.append(other)
            if name == other and one not in lines and gear.ratio:
                lines[one] = slope / gear.ratio, (offset - gear.offset) / gear.ratio
                waiting.append(one)
    return lines


def _train(
    coordinates: JointCoordinates,
    lines: Mapping[str, tuple[float, float]],
    motors: Collection[str],
) -> GearTrain:
    columns = coordinates.columns(lines)
    slopes, offsets = (np.array(numbers) for numbers in zip(*lines.values(), strict=True))
    turning = bool((coordinates.angles | coordinates.wraps)[columns].all())
    driver = next((k for k, name in enumerate(lines) if name in motors and slopes[k]), None)
    period = _FULL_TURN * _turns(slopes.tolist()) if turning else math.inf
    return GearTrain(tuple(lines), columns, slopes, offsets, turning, period, driver)


def _turns(slopes: Iterable[float]) -> float:
    """Return after how many turns of the first joint all others have made whole turns.

    Examples
    --------
    >>> _turns([1.0, -0.5, 2 / 3]), _turns([1.0, 0.7071])
    (6, inf)
    """
    teeth = [(slope, Fraction(slope).limit_denominator(_MOST_TEETH)) for slope in slopes]
    if any(abs(float(ratio) - slope) > 1e-12 * abs(slope) for slope, ratio in teeth):
        return math.inf
    turns = math.lcm(*(ratio.denominator for _, ratio in teeth))
    return turns if turns <= _MOST_TURNS else math.inf


def unwound(
    coordinates: JointCoordinates,
    trains: Iterable[GearTrain],
    q: Array,
    passive: Index,
    limits: bool,
) -> Array:
    """Return q with angles less full turns, those of a train together: the same pose.

    Parameters
    ----------
    coordinates : JointCoordinates
    trains : iterable of GearTrain
    q : ndarray, shape (nq,)
    passive : ndarray of int
        Columns; motors keep their values.
    limits : bool
        Turn between the joints' limits rather than next to 0.
    """
    trains = tuple(trains)
    geared = [train.columns for train in trains]
    q = coordinates.unwound(q, passive[~np.isin(passive, np.concatenate([[], *geared]))], limits)
    for train in trains:
        if train.driver is None:
            values = coordinates.values(q)[train.columns]
            bounds = coordinates.lower[train.columns], coordinates.upper[train.columns]
            between = train.between(*bounds) if limits else (-math.inf, math.inf)
            turned = train.turned_back(float(values[0]), *between) - values[0]
            if turned:
                q = coordinates.with_values(q, train.columns, values + turned * train.slopes)
    return q
