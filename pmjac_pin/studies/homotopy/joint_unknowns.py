"""The complex unknowns of joints, and the complex parameters that motors are.

A joint that turns is its cosine and sine, with c² + s² = 1; a ball a quaternion of length 1;
slides are lengths in characteristic lengths. A free body is a quaternion e of length 1 for its
rotation and g = p e for its place p, with e · g = 0 (Study's coordinates). A motor that turns by
θ is one number u = exp(iθ), of which 2c = u + 1/u and 2is = u − 1/u.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from flint import acb, arb

from pmjac_pin.algebra.arrays import Numbers
from pmjac_pin.algebra.polynomials import Symbols
from pmjac_pin.errors import ArgumentError
from pmjac_pin.model.joint_kind import JointKind, JointMotion
from pmjac_pin.model.linkage import Edge
from pmjac_pin.values.arrays import Array, Complex

#: Of complex numbers, of a program's, or of python-flint's balls.
_QUATERNION = ("x", "y", "z", "w")


@dataclass(frozen=True, slots=True, eq=False)
class JointUnknowns:
    """A joint of the tree, and which of the polynomials' variables are its numbers.

    Attributes
    ----------
    joint : pin.JointModel
    edge : Edge
    columns : slice
        Of the variables: the passive joints' come first.
    motor : bool
    length : float
        The characteristic length, m.
    """

    joint: pin.JointModel
    edge: Edge
    columns: slice
    motor: bool
    length: float

    @property
    def kind(self) -> JointKind:
        """The kind of the joint."""
        return self.edge.kind

    @property
    def floating(self) -> bool:
        """Whether it is a free body, in Study's coordinates."""
        return _floats(self.kind)

    @property
    def slides(self) -> int:
        """How many of its variables are lengths: the first ones."""
        return 4 if self.floating else self.kind.slides

    @property
    def unit(self) -> slice | None:
        """The variables that have length 1, None for a slide."""
        if not self.kind.turns:
            return None
        return slice(self.columns.start + self.slides, self.columns.stop)

    @property
    def names(self) -> tuple[str, ...]:
        """What each variable is."""
        slides = [f"g{entry}" for entry in _QUATERNION] if self.floating else ["x", "y", "z"]
        slides = ["length"] if self.slides == 1 else slides[: self.slides]
        turns = {0: [], 1: ["cos", "sin"], 3: [f"e{entry}" for entry in _QUATERNION]}
        return tuple(f"{what} {self.edge.name}" for what in slides + turns[self.kind.turns])

    @property
    def two_signs(self) -> bool:
        """Whether the variables and their negatives are the same pose."""
        return self.kind.turns == 3

    def motion(self, variables: Symbols) -> JointMotion:
        """Return the joint's motion in polynomials, lengths in characteristic lengths."""
        own = [variables[k : k + 1, None] for k in range(self.columns.start, self.columns.stop)]
        slides, turn = own[: self.slides], own[self.slides :]
        if self.floating:
            slides = _times_conjugate(slides, turn)[:3]
        return JointMotion(tuple(slides), tuple(turn))

    def numbers(self, q: Array) -> Complex:
        """Return the joint's numbers (b, size) at rows of q."""
        entries = q[:, self.joint.idx_q : self.joint.idx_q + self.joint.nq].copy()
        if self.kind.angle:
            angle = entries[:, self.slides :]
            entries = np.hstack([entries[:, : self.slides], np.cos(angle), np.sin(angle)])
        if self.floating:
            place, e = (
                np.hstack([entries[:, :3] / self.length, np.zeros((len(q), 1))]),
                entries[:, 3:],
            )
            g = _times_conjugate([*place.T], [*(e * [-1.0, -1.0, -1.0, 1.0]).T])
            return np.column_stack([*g, e]).astype(complex)
        entries[:, : self.slides] /= self.length
        return entries.astype(complex)

    def put(self, x: Array, q: Array) -> None:
        """Write real numbers x (b, n) into rows of q."""
        entries = x[:, self.columns].copy()
        if self.floating:
            place = np.array(_times_conjugate([*entries[:, :4].T], [*entries[:, 4:].T])[:3]).T
            entries = np.hstack([place, entries[:, 4:]])
        unit = self.kind.slides
        entries[:, :unit] *= self.length
        if self.kind.turns:
            entries[:, unit:] /= np.linalg.norm(entries[:, unit:], axis=1, keepdims=True)
        if self.kind.angle:
            angle = np.arctan2(entries[:, unit + 1 :], entries[:, unit : unit + 1])
            entries = np.hstack([entries[:, :unit], angle])
        q[:, self.joint.idx_q : self.joint.idx_q + self.joint.nq] = entries

    def parameter(self, q: Array) -> complex:
        """Return u = exp(iθ) of a motor that turns, the length of one that slides."""
        own = self.numbers(q[None])[0]
        return complex(own[0] + 1j * own[1]) if self.unit is not None else complex(own[0])

    def balls(self, q: Array) -> list[acb]:
        """Return enclosures of a motor's numbers at one q; they are real."""
        entries = [arb(entry) for entry in q[self.joint.idx_q :][: self.joint.nq].tolist()]
        if self.kind.angle:
            return [acb(entries[0].cos()), acb(entries[0].sin())]
        if not self.kind.turns:
            return [acb(entries[0] / arb(self.length))]
        return [acb(entry) for entry in entries]

    def from_parameter(self, p: Numbers) -> list[Numbers]:
        """Return a motor's numbers from its parameter."""
        if self.unit is None:
            return [p]
        inverse = 1.0 / p
        return [(p + inverse) * 0.5, (p - inverse) * -0.5j]

    def parameter_rates(self, p: Numbers) -> list[Numbers]:
        """Return the derivatives of a motor's numbers by its parameter."""
        if self.unit is None:
            return [np.ones_like(p)]
        square = 1.0 / (p * p)
        return [0.5 * (1.0 - square), -0.5j * (1.0 + square)]


def joint_unknowns(
    model: pin.Model, edges: dict[str, Edge], passive: list[str], length: float
) -> list[JointUnknowns]:
    """Return the joints of a tree in Pinocchio's order.

    Raises
    ------
    ArgumentError
        A motor of several degrees of freedom, a screw.
    """
    names, columns, first = list(model.names)[1:], {}, 0
    for name in sorted(names, key=lambda name: name not in passive):
        kind = edges[name].kind
        columns[name] = slice(first, first + _variables(kind))
        first, why = columns[name].stop, ""
        if name not in passive and kind.nv > 1:
            why = f"the motor {name!r} has several degrees of freedom"
        if kind.screw:
            why = f"the screw {name!r} is no polynomial in its cosine and sine"
        if why:
            raise ArgumentError(f"{model.name}: no homotopy for this mechanism: {why}")
    return [
        JointUnknowns(joint, edges[name], columns[name], name not in passive, length)
        for joint, name in zip(list(model.joints)[1:], names, strict=True)
    ]


def _floats(kind: JointKind) -> bool:
    return kind.slides == kind.turns == 3


def _variables(kind: JointKind) -> int:
    """Return how many variables a joint has."""
    return 8 if _floats(kind) else kind.slides + {0: 0, 1: 2, 3: 4}[kind.turns]


def _times_conjugate(g: Sequence[Numbers], e: Sequence[Numbers]) -> list[Numbers]:
    """Return g e*, of quaternions x, y, z, w."""
    (gx, gy, gz, gw), (x, y, z, w) = g, e
    return [
        gx * w - gw * x - gy * z + gz * y,
        gy * w - gw * y - gz * x + gx * z,
        gz * w - gw * z - gx * y + gy * x,
        gw * w + gx * x + gy * y + gz * z,
    ]


def quaternion_of_gap(
    g: Sequence[Numbers], e: Sequence[Numbers], a: Numbers, b: Numbers
) -> list[Numbers]:
    """Return g + e a − b e = (p + R a − b) e for places a on the body and b on its base."""
    ex, ey, ez, ew = e
    (ax, ay, az), (bx, by, bz) = a, b
    sx, sy, sz, dx, dy, dz = ax + bx, ay + by, az + bz, ax - bx, ay - by, az - bz
    turned = (
        ew * dx + ey * sz - ez * sy,
        ew * dy + ez * sx - ex * sz,
        ew * dz + ex * sy - ey * sx,
        -(ex * dx + ey * dy + ez * dz),
    )
    return [one + other for one, other in zip(g, turned, strict=True)]
