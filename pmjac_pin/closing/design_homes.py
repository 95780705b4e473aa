"""Home poses of many designs at once, as a mechanism of each would have them.

Each is followed from home at the parameters' defaults, the motors at rest, by programs that take
parameters as inputs: at once where Newton's first step certainly leads there, else in twelve steps
(`home_on_the_way`). What is less certain than that, comes near a singularity, or has other scales
or ranks than the machine that was recorded, is left to the design's own mechanism.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pmjac_pin.algebra.tape_runner import run
from pmjac_pin.closing.allowed_designs import allowed_designs
from pmjac_pin.closing.blueprint import Blueprint
from pmjac_pin.closing.closure_problem import CLOSURE_TOLERANCE, ROUNDING
from pmjac_pin.closing.design_programs import DesignPrograms
from pmjac_pin.closing.machine_size import (
    BESIDE_ITSELF,
    NO_LENGTH,
    ROUNDING_OF_PLACES,
    SMALL,
    invertible,
)
from pmjac_pin.closing.parts import Parts
from pmjac_pin.model.limits import beyond_limits
from pmjac_pin.rates.rank_bounds import RankBounds
from pmjac_pin.values.arrays import Array, Mask

_STEPS_OF_HOME = 12  # on the way from the defaults: as many as a single design takes at least
_MOST_CORRECTIONS = 12  # of Newton's method: what takes more is not near
# Half of what a single design is asked for, of one step and of the whole way: lengths or rad, and
# shares of a step.
_FARTHEST, _STRAIGHT = 0.15, 0.12
_NEAR, _NEARLY_STRAIGHT = 0.05, 0.05
_HARDLY_MOVED = 5e-7
_STAYS_REGULAR = 0.5  # of the smallest singular value of K* at first
_SAME_LENGTH = 1e-9  # relative: of a design's own length
_LEAST_LENGTH = 1e-3  # beside the places of frames and tool: a machine with such arms is spherical
_ROOM = 0.1  # of what rounding may be before a tolerance becomes larger


@dataclass(frozen=True, slots=True, eq=False)
class DesignHomes:
    """Home poses of designs.

    Attributes
    ----------
    q : ndarray, shape (d, nq)
    designs : ndarray, shape (d, k)
        What programs take of each.
    length, size : ndarray, shape (d,)
        Their characteristic lengths, m, and the size of [K K*], dimensionless.
    certain : ndarray of bool, shape (d,)
        Whether each is the home pose of its own mechanism, K* of the same generic rank there.
    """

    q: Array
    designs: Array
    length: Array
    size: Array
    certain: Mask


class DesignsOfFile:
    """The designs that a file allows for one mechanism.

    Parameters
    ----------
    parts : Parts
        Of one of them.
    blueprint : Blueprint
    swept : iterable of str
        The parameters that they differ in.

    Attributes
    ----------
    programs : DesignPrograms

    Raises
    ------
    ArgumentError
        A machine that is not served.
    """

    def __init__(self, parts: Parts, blueprint: Blueprint, swept: Iterable[str]) -> None:
        self._parts, self._blueprint = parts, blueprint
        defaults = parts.spec.parameter_values()
        others = [name for name, value in defaults.items() if parts.values[name] != value]
        names = tuple(dict.fromkeys([*swept, *others]))
        self.programs = DesignPrograms(parts, blueprint, names)

    @cached_property
    def _way(self) -> _Way | None:
        """The way from the parameters' defaults; None where these have no home pose."""
        first, home_q = self._blueprint.beginning
        if home_q is None or not _is_measured_so(self.programs, self._parts):
            return None
        defaults = np.array([first.values[name] for name in self.programs.names])
        return _Way(self.programs, self._parts, defaults, home_q)

    def homes(self, swept: Array) -> DesignHomes:
        """Return home poses at values (d, k) of the parameters that are swept."""
        own = [self._parts.values[name] for name in self.programs.names[swept.shape[1] :]]
        values = np.column_stack([swept, np.tile(own, (len(swept), 1))])
        allowed = allowed_designs(self._blueprint, self.programs.names, values)
        parts, programs, way = self._parts, self.programs, self._way
        if way is None:
            return _no_homes(programs, parts, values)
        q, certain = way.at_once(values)
        far = np.flatnonzero(~certain)
        q[far], certain[far] = way.in_steps(values[far])
        measured = _Measured.of(programs, parts, q, values)
        designs = programs.numbers(values, measured.length)
        size, regular = _regular_homes(programs, parts, q, designs, measured.length)
        certain &= allowed & measured.plain & regular
        if parts.spec.enforce_limits:
            certain &= ~beyond_limits(parts.coordinates, q)
        return DesignHomes(q, designs, measured.length, size, certain)


def _no_homes(programs: DesignPrograms, parts: Parts, values: Array) -> DesignHomes:
    ones = np.ones(len(values))
    length = parts.problem.partition.length * ones
    q, designs = np.tile(parts.home_q, (len(values), 1)), programs.numbers(values, length)
    return DesignHomes(q, designs, length, ones, np.zeros(len(values), dtype=bool))


class _Way:
    """The way of home poses from the defaults to designs."""

    def __init__(
        self, programs: DesignPrograms, parts: Parts, defaults: Array, home_q: Array
    ) -> None:
        self._programs, self._parts = programs, parts
        self._defaults, self._home_q = defaults, home_q
        self._length = parts.problem.partition.length  # of all, here: steps are judged alike
        designs = programs.numbers(defaults[None], self._length)
        self._smallest = float(programs.nearness(np.vstack([home_q[:, None], designs.T]))[0])

    def at_once(self, values: Array) -> tuple[Array, Mask]:
        """Return home poses that one step leads to, and which are certain."""
        start = np.tile(self._home_q, (len(values), 1))
        return self._stepped(start, values, _NEAR, _NEARLY_STRAIGHT)

    def in_steps(self, values: Array) -> tuple[Array, Mask]:
        """Return home poses that some steps lead to, and which are certain."""
        q, certain = np.tile(self._home_q, (len(values), 1)), np.ones(len(values), dtype=bool)
        for step in range(1, _STEPS_OF_HOME + 1 if len(values) else 1):
            between = self._defaults + step / _STEPS_OF_HOME * (values - self._defaults)
            q, good = self._stepped(q, between, _FARTHEST, _STRAIGHT)
            certain &= good
        return q, certain

    def _stepped(
        self, before: Array, values: Array, farthest: float, straight: float
    ) -> tuple[Array, Mask]:
        designs = self._programs.numbers(values, self._length)
        q, expected, closed = self._closed(before, designs)
        scale = self._parts.problem.partition.column_scale[:, None] * self._length
        moved = run(self._programs.between, np.vstack([before.T, q.T])) / scale
        size = np.linalg.norm(moved, axis=0)
        missed = np.linalg.norm(moved - expected / scale, axis=0)
        good = closed & (size <= farthest) & ((missed <= straight * size) | (size <= _HARDLY_MOVED))
        nearness = self._programs.nearness(np.vstack([q.T, designs.T]))
        return q, good & (nearness >= _STAYS_REGULAR * self._smallest)

    def _closed(self, q: Array, designs: Array) -> tuple[Array, Array, Mask]:
        """Return where Newton's method leads to, its first step, and where that closes loops."""
        nq, nv = self._parts.model.nq, self._parts.model.nv
        still = np.zeros((nv + self._parts.problem.partition.actuated.size, len(q)))
        motion, expected = still[:nv], still[:nv]
        for tries in range(_MOST_CORRECTIONS):
            inputs = np.vstack([q.T, motion, still[nv:], designs.T])
            found = run(self._programs.arrival, inputs)
            q, motion = found[:nq].T.copy(), found[nq + 5 :][:nv]
            if not tries:
                expected = motion
            if not (found[nq] > ROUNDING).any():
                break
        return q, expected, found[nq] <= CLOSURE_TOLERANCE


@dataclass(frozen=True, slots=True, eq=False)
class _Measured:
    """The characteristic lengths of designs, as `Size` has them.

    Attributes
    ----------
    length : ndarray, shape (d,)
    plain : ndarray of bool, shape (d,)
        Whether it alone makes scales: no loop is small, and no place far away.
    """

    length: Array
    plain: Mask

    @classmethod
    def of(cls, programs: DesignPrograms, parts: Parts, q: Array, values: Array) -> _Measured:
        """Measure designs at their home poses."""
        designs = programs.numbers(values, parts.problem.partition.length)
        told = run(programs.sizes, np.vstack([q.T, designs.T]))
        loops = programs.arms_of_loops
        arms, places = told[: loops[-1].stop], told[loops[-1].stop :].reshape(-1, 3, len(q))
        with np.errstate(all="ignore"):
            each = np.array([_weighted_mean(arms[own]) for own in loops])
            length = _weighted_mean(arms)
        farthest = np.abs(places).max(axis=(0, 1))
        rounding = ROUNDING_OF_PLACES * farthest
        plain = np.isfinite(length) & (each > 2.0 * SMALL * length).all(axis=0)
        plain &= (arms.min(axis=0) >= 0.0) & (length > _LEAST_LENGTH * farthest)
        plain &= rounding < _ROOM * CLOSURE_TOLERANCE * length
        plain &= each.min(axis=0) > np.maximum(NO_LENGTH, 3.0 * rounding)
        middle = np.abs(places.mean(axis=0)).max(axis=0)
        plain &= middle < 0.5 * BESIDE_ITSELF * length
        exact = [invertible(one) if good else 1.0 for one, good in zip(length, plain, strict=True)]
        return cls(np.array(exact), plain)


def _is_measured_so(programs: DesignPrograms, parts: Parts) -> bool:
    """Tell whether the machine that was recorded has the length that is measured so."""
    own = np.array([[parts.values[name] for name in programs.names]])
    length, known = _Measured.of(programs, parts, parts.home_q[None], own).length[0], parts.problem
    return bool(abs(length - known.partition.length) <= _SAME_LENGTH * length)


def _weighted_mean(arms: Array) -> Array:
    mean: Array = (arms * arms).sum(axis=0) / arms.sum(axis=0)
    return mean


def _regular_homes(
    programs: DesignPrograms, parts: Parts, q: Array, designs: Array, length: Array
) -> tuple[Array, Mask]:
    """Return the size of [K K*], and where loops are closed, K* has full rank and follows K."""
    partition = parts.problem.partition
    told = run(programs.jacobian, np.vstack([q.T, designs.T]))
    gap, inverse, size, forbidden = told[:4]
    bounds = RankBounds.of(partition)
    certain = bounds.regular(inverse, size) & bounds.follows(forbidden, size)
    return size, np.asarray(certain & (gap <= CLOSURE_TOLERANCE * length))
