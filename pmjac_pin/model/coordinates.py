"""JointCoordinates: joint names and values on one side, Pinocchio's q and columns on the other.

Each degree of freedom has one value, in m or rad, whatever Pinocchio stores for it: a
``continuous`` joint is (cos, sin) in q and an angle in (−π, π] here; a ``floating`` joint is
translation and quaternion in q, translation and rotation vector here.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from pmjac_pin.errors import ArgumentError, did_you_mean, unknown_name
from pmjac_pin.model.joint_kind import JointKind
from pmjac_pin.model.joint_kinds import kind_of
from pmjac_pin.model.unit_turns import NEARLY_UNIT, with_unit_turns
from pmjac_pin.values.arrays import Array, Index, read_only
from pmjac_pin.values.checks import LARGEST, as_numbers

LIMIT_SLACK = 1e-9  # m or rad: rounding on the way to a limit is no violation


@dataclass(frozen=True, slots=True)
class _Joint:
    """A joint; of one that is Pinocchio's alone, only numbers are known."""

    name: str
    kind: JointKind | None
    idx_q: int
    nq: int
    idx_v: int
    nv: int

    @property
    def dof_names(self) -> tuple[str, ...]:
        if self.nv == 1:
            return (self.name,)
        letters = self.kind.letters if self.kind else map(str, range(self.nv))
        return tuple(f"{self.name}.{letter}" for letter in letters)

    @property
    def translation(self) -> int:
        """How many entries of q are a translation that turns, and that q shows as it is."""
        return self.kind.slides if self.kind and self.kind.curved else 0


class JointCoordinates:
    """Names, columns, values and limits of the joints of a Pinocchio model.

    Parameters
    ----------
    model : pin.Model
        Kept, not copied: it must not be changed afterwards.

    Attributes
    ----------
    names : tuple of str
        The joints, in Pinocchio's order.
    rotational, angles, wraps, curved : ndarray of bool, shape (nv,)
        Which rates are in rad/s; which of these are of one angle in q, full turns and all; which
        of an angle that q has as (cos, sin); and which are of a joint of several freedoms whose
        steps do not add up in q.
    lower, upper : ndarray, shape (nv,)
        Limits, m or rad, infinite where there are none.
    """

    def __init__(self, model: pin.Model) -> None:
        joints = [
            _Joint(name, kind_of(kind), kind.idx_q, kind.nq, kind.idx_v, kind.nv)
            for name, kind in zip(model.names[1:], list(model.joints)[1:], strict=True)
        ]
        self._model = model
        self._neutral: Array = pin.neutral(model)
        self._joints = {joint.name: joint for joint in joints}
        if len(self._joints) < len(joints):
            names = [joint.name for joint in joints]
            twice = next(name for name in names if names.count(name) > 1)
            raise ArgumentError(f"two joints of the model are named {twice!r}")
        self.names: tuple[str, ...] = tuple(self._joints)
        self.rotational = _rotational(model, joints)
        self.wraps, self.curved = np.zeros((2, model.nv), dtype=bool)
        self.lower, self.upper = np.full(model.nv, -np.inf), np.full(model.nv, np.inf)
        self.angles = np.zeros(model.nv, dtype=bool)
        self._entries_of = np.zeros(model.nv, dtype=np.intp)
        self._translating = [joint for joint in joints if joint.translation]
        least, most = model.lowerPositionLimit.tolist(), model.upperPositionLimit.tolist()
        for joint in joints:
            self.wraps[joint.idx_v] = (joint.nq, joint.nv) == (2, 1)
            own = slice(joint.idx_v, joint.idx_v + joint.nv)
            self._entries_of[own] = joint.idx_q + np.arange(joint.nv)
            self.curved[own] = joint.nv > 1 and joint.nq != joint.nv
            if joint.nq == 1:
                self.angles[joint.idx_v] = joint.kind is not None and joint.kind.endless
                lower, upper = least[joint.idx_q], most[joint.idx_q]
                # Pinocchio writes the largest double where there is no limit.
                self.lower[joint.idx_v] = lower if lower > -LARGEST else -np.inf
                self.upper[joint.idx_v] = upper if upper < LARGEST else np.inf
        for name in ("angles", "curved", "lower", "rotational", "upper", "wraps"):
            setattr(self, name, read_only(getattr(self, name)))
        self._straight = not (self.wraps.any() or self.curved.any())  # values are entries of q

    def columns(self, names: Iterable[str]) -> Index:
        """Return the velocity columns of these joints, in this order."""
        joints = [self._joint(name) for name in names]
        return np.array(
            [joint.idx_v + k for joint in joints for k in range(joint.nv)], dtype=np.intp
        )

    def dof_names(self, names: Iterable[str]) -> tuple[str, ...]:
        """Return one name for each velocity column of these joints."""
        return tuple(dof for name in names for dof in self._joint(name).dof_names)

    def degrees_of_freedom(self, name: str) -> int:
        """Return the number of degrees of freedom of a joint."""
        return self._joint(name).nv

    def is_known(self, name: str) -> bool:
        """Tell whether a joint is of a kind in the table of joints."""
        return self._joint(name).kind is not None

    def entry(self, column: int) -> int:
        """Return where q holds a freedom's value, or its cosine and behind it its sine."""
        return int(self._entries_of[column])

    def values(self, q: Array) -> Array:
        """Return the value of every degree of freedom, shape (nv,), in the columns' order."""
        values: Array = pin.difference(self._model, self._neutral, q)
        for joint in self._translating:
            # SE(2) and SE(3) logarithms mix the rotation into the translation.
            size = joint.translation
            values[joint.idx_v : joint.idx_v + size] = q[joint.idx_q : joint.idx_q + size]
        return values

    def with_values(self, q: Array, columns: Index, values: Array) -> Array:
        """Return q with the values of these columns; both may have any leading axes, the same.

        A curved joint takes them where all its columns are among these, and stays elsewhere.
        """
        q = q.copy()
        if self._straight:
            q[..., self._entries_of[columns]] = values
            return q
        if (curved := self.curved[columns]).any():
            self._set_curved(q, columns, values)
            columns, values = columns[~curved], values[..., ~curved]
        entries, wraps = self._entries_of[columns], self.wraps[columns]
        if wraps.any():
            q[..., entries[wraps] + 1] = np.sin(values[..., wraps])
            values = np.where(wraps, np.cos(values), values)
        q[..., entries] = values
        return q

    def values_of(self, q: Array, columns: Index) -> Array:
        """Return the values of these columns; q may have any leading axes."""
        if self._straight:
            own: Array = q[..., self._entries_of[columns]]
            return own
        if self.curved[columns].any():
            rows = [self.values(row)[columns] for row in q.reshape(-1, q.shape[-1])]
            return np.reshape(rows, (*q.shape[:-1], columns.size))
        entries, wraps = self._entries_of[columns], self.wraps[columns]
        values: Array = q[..., entries]
        if wraps.any():
            values[..., wraps] = np.arctan2(q[..., entries[wraps] + 1], values[..., wraps])
        return values

    def shorter_way(self, here: Array, there: Array, columns: Index) -> Array:
        """Return how far it is from values of these columns to others, (..., n).

        What turns endlessly goes the shorter way.
        """
        way: Array = there - here
        if (wraps := self.wraps[columns]).any():
            ends, whole = there[..., wraps], 2.0 * np.pi
            # After many turns a difference has lost the digits that `with_values` still has.
            near = np.arctan2(np.sin(ends), np.cos(ends)) - here[..., wraps]
            near -= whole * np.round(near / whole)
            way[..., wraps] = np.where(np.abs(way[..., wraps]) <= np.pi, way[..., wraps], near)
        return way

    def motion_to(self, q: Array, columns: Index, values: Array) -> Array:
        """Return the rates of these columns that take q to these values in one unit of time.

        What turns endlessly goes the shorter way; a curved joint goes along a constant twist.
        """
        motion = self.shorter_way(self.values_of(q, columns), values, columns)
        if (curved := self.curved[columns]).any():
            there = self.with_values(q, columns, values)
            motion[curved] = pin.difference(self._model, q, there)[columns[curved]]
        return motion

    def q(self, poses: Mapping[str, float | Sequence[float]], base: Array | None = None) -> Array:
        """Return q with these joints' values, the others as in `base` (neutral when None).

        A joint takes its nv values as `values` shows them, or Pinocchio's own nq entries.

        Raises
        ------
        UnknownNameError, ArgumentError
        """
        q: Array = (self._neutral if base is None else base).copy()
        for name, given in poses.items():
            joint = self._joint(name)
            q[joint.idx_q : joint.idx_q + joint.nq] = self._entries(joint, given)
        return q

    def joint_values(self, q: Array, names: Iterable[str]) -> dict[str, float | tuple[float, ...]]:
        """Return each of these joints' value, or its tuple of values, by name."""
        values, joints = self.values(q), [self._joint(name) for name in names]
        return {j.name: _one_or_several(values[j.idx_v : j.idx_v + j.nv]) for j in joints}

    def pose(self, q: Array) -> dict[str, float | tuple[float, ...]]:
        """Return what `q` takes to give this configuration back, bit by bit."""
        joints = self._joints.values()
        return {j.name: _one_or_several(q[j.idx_q : j.idx_q + j.nq]) for j in joints}

    def limits(self, name: str) -> tuple[float, float]:
        """Return the lower and upper limit of a joint with one degree of freedom."""
        column = self._joint(name).idx_v
        return float(self.lower[column]), float(self.upper[column])

    def unwound(self, q: Array, columns: Index, limits: bool) -> Array:
        """Return q with angles less full turns: into [−π, π], or between their limits."""
        turned = columns[self.angles[columns]]
        values = np.remainder(self.values(q)[turned] + np.pi, 2.0 * np.pi) - np.pi
        if limits:
            lower, upper = self.lower[turned], self.upper[turned]
            beyond = np.isfinite(lower) & ((values < lower) | (values > upper))
            up = values + 2.0 * np.pi * np.ceil((lower - values - LIMIT_SLACK) / (2.0 * np.pi))
            values = np.where(beyond, up, values)
        return self.with_values(q, turned, values)

    def room(self, q: Array) -> tuple[Array, Array]:
        """Return how far each degree of freedom is from its limits, below and above, (nv,)."""
        values = self.values(q)
        return values - self.lower, self.upper - values

    def beyond(self, values: Array, columns: Index) -> NDArray[np.bool_]:
        """Tell which values of these columns are outside their limits; with any leading axes."""
        below = values < self.lower[columns] - LIMIT_SLACK
        return np.asarray(below | (values > self.upper[columns] + LIMIT_SLACK))

    def outside(self, values: Array, columns: Index) -> list[str]:
        """Return the joints of these columns whose values are outside their limits."""
        beyond = self.beyond(values, columns)
        if not beyond.any():
            return []
        wrong = set(columns[beyond].tolist())
        return [joint.name for joint in self._joints.values() if joint.idx_v in wrong]

    def _set_curved(self, q: Array, columns: Index, values: Array) -> None:
        """Set entries of curved joints, in place."""
        place = {column: k for k, column in enumerate(columns.tolist())}
        for joint in self._joints.values():
            own = [place.get(joint.idx_v + k) for k in range(joint.nv)]
            if None in own or not self.curved[joint.idx_v]:
                continue
            taken = values[..., np.array(own, dtype=np.intp)].reshape(-1, joint.nv)
            entries = np.array([self._of_values(joint, row) for row in taken])
            q[..., joint.idx_q : joint.idx_q + joint.nq] = entries.reshape(
                *values.shape[:-1], joint.nq
            )

    def _joint(self, name: str) -> _Joint:
        joint = self._joints.get(name) if isinstance(name, str) else None
        if joint is not None:
            return joint
        if isinstance(name, str) and name in [frame.name for frame in self._model.frames]:
            raise ArgumentError(f"{name!r} is no joint that moves{did_you_mean(name, self.names)}")
        raise unknown_name("joint", name, self.names)

    def _entries(self, joint: _Joint, given: float | Sequence[float]) -> Array:
        values = np.atleast_1d(as_numbers(given, f"the value of joint {joint.name!r}"))
        if values.shape == (joint.nq,):
            return values if joint.nq == joint.nv else self._normalised(joint, values)
        if values.shape != (joint.nv,):
            wanted = f"{joint.nv}" if joint.nv == joint.nq else f"{joint.nv} or {joint.nq}"
            plural = "" if wanted == "1" else "s"
            message = f"joint {joint.name!r} takes {wanted} value{plural}, got {values.size}"
            raise ArgumentError(message)
        return self._of_values(joint, values)

    def _of_values(self, joint: _Joint, values: Array) -> Array:
        """Return a joint's entries of q at its nv values."""
        tangent = np.zeros(self._model.nv)
        tangent[joint.idx_v : joint.idx_v + joint.nv] = values
        size = joint.translation
        tangent[joint.idx_v : joint.idx_v + size] = 0.0
        entries: Array = pin.integrate(self._model, self._neutral, tangent)
        entries = entries[joint.idx_q : joint.idx_q + joint.nq]
        entries[:size] = values[:size]
        return entries

    def _normalised(self, joint: _Joint, entries: Array) -> Array:
        q = self._neutral.copy()
        q[joint.idx_q : joint.idx_q + joint.nq] = entries
        if not pin.isNormalized(self._model, q, NEARLY_UNIT):
            message = f"the quaternion or (cos, sin) of joint {joint.name!r} is not of unit length"
            raise ArgumentError(message)
        return with_unit_turns(self._model, q)[joint.idx_q : joint.idx_q + joint.nq]


def _rotational(model: pin.Model, joints: Sequence[_Joint]) -> NDArray[np.bool_]:
    """Return which columns are rotations: those of a joint behind its slides."""
    turns = np.zeros(model.nv, dtype=bool)
    for joint in joints:
        if joint.kind is None:
            return _seen_to_turn(model)
        turns[joint.idx_v + joint.kind.slides : joint.idx_v + joint.nv] = True
    return turns


def _seen_to_turn(model: pin.Model) -> NDArray[np.bool_]:
    """Return the same as Pinocchio computes it, which takes a ``pin.Data`` of its own."""
    motions = pin.computeJointJacobians(model, model.createData(), pin.neutral(model))
    motions = motions.reshape(6, -1)  # a vector where there is one degree of freedom
    return np.asarray(np.abs(motions[3:]).max(axis=0, initial=0.0) > 0.0)


def _one_or_several(values: Array) -> float | tuple[float, ...]:
    numbers = tuple(values.tolist())
    return numbers[0] if len(numbers) == 1 else numbers


def entry_names(model: pin.Model) -> tuple[str, ...]:
    """Return a name of each entry of q: its joint's, with a number where that has several.

    Examples
    --------
    >>> entry_names(pin.buildSampleModelManipulator())[:2]
    ('shoulder1_joint', 'shoulder2_joint')
    """
    joints = zip(list(model.names)[1:], list(model.joints)[1:], strict=True)
    return tuple(
        name if joint.nq == 1 else f"{name}[{k}]" for name, joint in joints for k in range(joint.nq)
    )
