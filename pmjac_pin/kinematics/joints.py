"""Joints: what each kind of joint is, in one entry of a table.

A joint slides along some of its axes and then turns: about z, or any way. Its unit twists, seen
from the moved frame, are a slide along an axis, or a turn about one, with a pitch where it is a
screw. q holds the slides, then an angle, a cosine and sine, or a quaternion x, y, z, w.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from scipy.spatial.transform import Rotation

from pmjac_pin.algebra import Algebra, Number
from pmjac_pin.values.arrays import Array

_Z = 2


class Motion(NamedTuple):
    """The numbers by which a joint moves.

    Attributes
    ----------
    slides : tuple of number
        Along each axis of `JointKind.along`, m.
    turn : tuple of number
        (cos, sin) about z; a quaternion of length 1; or nothing.
    """

    slides: tuple[Number, ...]
    turn: tuple[Number, ...]


class Waves(Algebra, Protocol):
    """An algebra that knows the motion of an angle."""

    def cos(self, x: Number) -> Number: ...  # noqa: D102
    def sin(self, x: Number) -> Number: ...  # noqa: D102


class Entries(Waves, Protocol):
    """An algebra that knows the motion of all that q may hold."""

    def unit(self, x: Number) -> Number: ...  # noqa: D102


@dataclass(frozen=True, slots=True)
class JointKind:
    """A kind of joint.

    Attributes
    ----------
    along : tuple of int
        The axes it slides along.
    about : tuple of int
        The axes it turns about: none, z, or all three.
    angle : bool
        q holds the angle, not its cosine and sine.
    screw : bool
        The slide is no freedom, but the pitch times the turn.
    """

    along: tuple[int, ...]
    about: tuple[int, ...]
    angle: bool = False
    screw: bool = False

    @property
    def slides(self) -> int:
        """How many freedoms slide: the first ones."""
        return 0 if self.screw else len(self.along)

    @property
    def turns(self) -> int:
        """How many freedoms turn: the last ones."""
        return len(self.about)

    @property
    def nv(self) -> int:
        """The number of freedoms."""
        return self.slides + self.turns

    @property
    def nq(self) -> int:
        """The number of entries in q."""
        return self.slides + {0: 0, 1: 1 if self.angle else 2, 3: 4}[self.turns]

    def motion(self, algebra: Entries, entries: Number, pitch: float = 0.0) -> Motion:
        """Return the motion at entries of q, their components."""
        slides = tuple(entries[k] for k in range(self.slides))
        if not self.turns:
            return Motion(slides, ())
        if not self.angle:
            turn = algebra.unit(entries[self.slides :])
            return Motion(slides, tuple(turn[k] for k in range(len(turn))))
        return self.at(algebra, entries[self.slides], pitch)

    def at(self, algebra: Waves, value: Number, pitch: float = 0.0) -> Motion:
        """Return the motion of a joint of one freedom at its value, rad or m."""
        if not self.turns:
            return Motion((value,), ())
        turn = (algebra.cos(value), algebra.sin(value))
        if not self.screw:
            return Motion((), turn)
        return Motion((algebra.times(np.array([[pitch]]), value[None])[0],), turn)

    def moved(self, entries: Array, v: Array) -> Array:
        """Return entries ⊕ v for each row, shapes (b, nq) and (b, nv): slides, then a turn."""
        s = self.slides
        slid = entries[:, :s] + self._turned_slides(entries[:, s:], v[:, :s])
        return np.hstack([slid, self._turned(entries[:, s:], v[:, s:])])

    def _turned_slides(self, turn: Array, v: Array) -> Array:
        """Return slides in the moved axes as slides in those before."""
        if not (self.slides and self.turns):
            return v
        if self.turns == 3:
            return np.asarray(Rotation.from_quat(turn).apply(v))
        (x, y), (c, s) = v.T, turn.T
        return np.column_stack([c * x - s * y, s * x + c * y])

    def _turned(self, turn: Array, v: Array) -> Array:
        if self.turns == 3:
            whole = Rotation.from_quat(turn) * Rotation.from_rotvec(v)
            return np.asarray(whole.as_quat())
        if self.angle or not self.turns:
            return turn + v
        angle = np.arctan2(turn[:, 1], turn[:, 0]) + v[:, 0]
        return np.column_stack([np.cos(angle), np.sin(angle)])


JOINT_KINDS: dict[str, JointKind] = {
    "revolute": JointKind((), (_Z,), angle=True),
    "continuous": JointKind((), (_Z,)),
    "prismatic": JointKind((_Z,), ()),
    "helical": JointKind((_Z,), (_Z,), angle=True, screw=True),
    "spherical": JointKind((), (0, 1, _Z)),
    "planar": JointKind((0, 1), (_Z,)),
    "free": JointKind((0, 1, _Z), (0, 1, _Z)),
}


def rotation_of(algebra: Algebra, quaternion: Sequence[Number]) -> list[list[Number]]:
    """Return the entries of the rotation of a quaternion (x, y, z, w) of length 1, by rows."""
    x, y, z, w = quaternion
    xx, yy, zz, ww = (n * n for n in quaternion)
    xy, wz, xz, wy, yz, wx = x * y, w * z, x * z, w * y, y * z, w * x
    return [
        [ww + xx - yy - zz, (xy - wz) + (xy - wz), (xz + wy) + (xz + wy)],
        [(xy + wz) + (xy + wz), ww - xx + yy - zz, (yz - wx) + (yz - wx)],
        [(xz - wy) + (xz - wy), (yz + wx) + (yz + wx), ww - xx - yy + zz],
    ]
