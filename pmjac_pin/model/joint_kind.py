"""What a kind of joint is: how it moves, what q holds, and what else is asked of it.

A joint slides along some of its axes and then turns: about z, or any way. Its unit twists, seen
from the moved frame, are a slide along an axis, or a turn about one, with a pitch where it is a
screw. q holds the slides, then an angle, a cosine and sine, or a quaternion x, y, z, w.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import NamedTuple, Protocol

import numpy as np
import pinocchio as pin

from pmjac_pin.algebra import Algebra, Number
from pmjac_pin.errors import ArgumentError
from pmjac_pin.model.loop_between_frames import LoopBetweenFrames
from pmjac_pin.values.arrays import Array

_Z = 2


class JointMotion(NamedTuple):
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
    name : str
    written : str
        A pattern of what Pinocchio's joints of this kind are called, without "JointModel".
    model : callable or None
        Pinocchio's joint along and about z, of the pitch where it is a screw; None for a weld,
        and for what turns in turn, which nothing builds.
    along : tuple of int
        The axes it slides along.
    about : tuple of int
        The axes it turns about: none, z, or all three.
    loop : type of loop, or None
        What holds its two bodies as it does, with z as the axis; None where no loop does, so that
        it is cut behind its hub.
    angle : bool
        q holds angles, not a cosine and sine or a quaternion. Where these are several, it turns
        by one after the other, about axes that move, which only Pinocchio computes (`in_turn`).
    screw : bool
        The slide is no freedom, but the pitch times the turn.
    title : str
        What it is called where that is not its name: as in URDF.

    Examples
    --------
    >>> kind = JointKind("planar", "Planar", pin.JointModelPlanar, (0, 1), (2,))
    >>> kind.nq, kind.nv, kind.letters
    (4, 3, ('x', 'y', 'rz'))
    """

    name: str
    written: str
    model: Callable[..., pin.JointModel] | None
    along: tuple[int, ...] = ()
    about: tuple[int, ...] = ()
    loop: type[LoopBetweenFrames] | None = None
    _: KW_ONLY
    angle: bool = False
    screw: bool = False
    title: str = ""

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
        return self.slides + (self.turns if self.angle else {0: 0, 1: 2, 3: 4}[self.turns])

    @property
    def in_turn(self) -> bool:
        """Whether it turns by several angles, one after the other."""
        return self.angle and self.turns > 1

    @property
    def axial(self) -> bool:
        """Whether it moves along and about z alone: turned round it keeps its values."""
        return {*self.along, *self.about} <= {_Z}

    @property
    def endless(self) -> bool:
        """Whether its one value is an angle that is the same after a full turn."""
        return (self.slides, self.turns, self.screw) == (0, 1, False)

    @property
    def curved(self) -> bool:
        """Whether steps in v do not add up in q."""
        return not (self.axial or self.in_turn or not self.turns)

    @property
    def ball(self) -> bool:
        """Whether it turns in several ways about one point."""
        return self.turns > 1 and not self.along

    @property
    def loose(self) -> bool:
        """Whether its origin is no place of the mechanism, but where its coordinates start."""
        return len(self.along) > 1

    @property
    def letters(self) -> tuple[str, ...]:
        """What each of several freedoms is called."""
        if self.in_turn:
            return tuple(map(str, range(self.nv)))
        return tuple("xyz"[k] for k in self.along) + tuple(f"r{'xyz'[k]}" for k in self.about)

    def reads(self, joint: pin.JointModel) -> bool:
        """Tell whether one of Pinocchio's joints is of this kind."""
        return re.fullmatch(f"JointModel({self.written})", joint.shortname()) is not None

    def built(self, pitch: float) -> pin.JointModel:
        """Return Pinocchio's joint."""
        if self.model is None:
            raise ArgumentError(f"no joint of Pinocchio's is built for a {self.name} one here")
        return self.model(pitch) if self.screw else self.model()

    def reach(self, pitch: float) -> float:
        """Return how far it slides per unit of what q holds of that: 1, or the pitch, m/rad."""
        return pitch if self.screw else 1.0

    def twists(self, pitch: float) -> Array:
        """Return the unit twists in the moved frame, shape (6, nv), linear rows first."""
        whole = np.eye(6)
        whole[:3, 3:] = pitch * self.screw * np.eye(3)
        return whole[:, [*self.along[: self.slides], *(3 + k for k in self.about)]]

    def motion(self, algebra: Entries, entries: Number, pitch: float = 0.0) -> JointMotion:
        """Return the motion at entries of q, their components."""
        slides = tuple(entries[k] for k in range(self.slides))
        if not self.turns:
            return JointMotion(slides, ())
        if not self.angle:
            turn = algebra.unit(entries[self.slides :])
            return JointMotion(slides, tuple(turn[k] for k in range(len(turn))))
        whole = self._turning(algebra, entries[self.slides], pitch)
        return JointMotion(slides + whole.slides, whole.turn)

    def at(self, algebra: Waves, value: Number, pitch: float = 0.0) -> JointMotion:
        """Return the motion of a joint of one freedom at its value, rad or m."""
        return self._turning(algebra, value, pitch) if self.turns else JointMotion((value,), ())

    def _turning(self, algebra: Waves, angle: Number, pitch: float) -> JointMotion:
        turn = (algebra.cos(angle), algebra.sin(angle))
        if not self.screw:
            return JointMotion((), turn)
        return JointMotion((algebra.times(np.array([[pitch]]), angle[None])[0],), turn)

    def entries(self, motion: pin.SE3, pitch: float = 0.0) -> tuple[float, ...]:
        """Return the entries of q at a motion; of a screw, those of the turn next to its slide."""
        x, y, z, *quaternion = pin.SE3ToXYZQUAT(motion).tolist()
        slides = tuple((x, y, z)[k] for k in self.along)
        if not self.turns:
            return slides
        if self.turns > 1:
            return (*slides, *quaternion)
        cosine, sine = float(motion.rotation[0, 0]), float(motion.rotation[1, 0])
        if not self.angle:
            return (*slides, cosine, sine)
        angle = math.atan2(sine, cosine)
        if not self.screw:
            return (*slides, angle)
        return (angle + math.tau * round((z / pitch - angle) / math.tau),)

    def of_value(self, values: Array) -> Array:
        """Return the entries (b, nq) of a joint of one freedom at its values (b,), rad or m."""
        return values[:, None] if self.nq == 1 else _on_circle(values)

    def drawn(self, rng: np.random.Generator, slides: Array, turn: tuple[float, float]) -> Array:
        """Return random entries of q, shape (b, nq).

        Parameters
        ----------
        rng : numpy.random.Generator
        slides : ndarray, shape (b, along)
            What q holds of its slides: of a screw, the angle.
        turn : tuple of float
            Where an angle is drawn between, rad, uniformly; orientations are over all rotations.
        """
        if self.screw or not self.turns:
            return slides
        if self.turns > 1:
            turned = rng.normal(size=(len(slides), 4))
            turned /= np.linalg.norm(turned, axis=1, keepdims=True)
        else:
            angles = rng.uniform(*turn, len(slides))
            turned = angles[:, None] if self.angle else _on_circle(angles)
        return np.hstack([slides, turned])


def rotation_of(quaternion: Sequence[Number]) -> list[list[Number]]:
    """Return the entries of the rotation of a quaternion (x, y, z, w) of length 1, by rows."""
    x, y, z, w = quaternion
    xx, yy, zz, ww = (n * n for n in quaternion)
    xy, wz, xz, wy, yz, wx = x * y, w * z, x * z, w * y, y * z, w * x
    return [
        [ww + xx - yy - zz, (xy - wz) + (xy - wz), (xz + wy) + (xz + wy)],
        [(xy + wz) + (xy + wz), ww - xx + yy - zz, (yz - wx) + (yz - wx)],
        [(xz - wy) + (xz - wy), (yz + wx) + (yz + wx), ww - xx - yy + zz],
    ]


def _on_circle(angles: Array) -> Array:
    return np.column_stack([np.cos(angles), np.sin(angles)])
