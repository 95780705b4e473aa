"""The complex unknowns of joints, and the complex parameters that motors are.

A joint that turns is its cosine and sine, with c² + s² = 1; a ball a quaternion of length 1;
slides are lengths in characteristic lengths. A free body is a quaternion e of length 1 for its
rotation and g = p e for its place p, with e · g = 0 (Study's coordinates). A motor that turns by
θ is one number u = exp(iθ), of which 2c = u + 1/u and 2is = u − 1/u.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin
from flint import acb, arb, fmpq_mpoly
from numpy.typing import NDArray

from pmjac_pin.errors import ArgumentError
from pmjac_pin.model.linkage import Edge

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
#: Of complex numbers, or of python-flint's balls.
Numbers = NDArray[Any]
#: Of polynomials.
Symbols = NDArray[Any]

_SIZES = {"revolute": 2, "continuous": 2, "prismatic": 1, "spherical": 4, "planar": 4, "free": 8}
# Where a joint's numbers of length 1 begin: cosine and sine, or a quaternion.
_UNIT = {"revolute": 0, "continuous": 0, "spherical": 0, "planar": 2, "free": 4}
_QUATERNION = ("x", "y", "z", "w")
_NAMES = {
    "revolute": ("cos", "sin"),
    "continuous": ("cos", "sin"),
    "prismatic": ("length",),
    "spherical": tuple(f"e{entry}" for entry in _QUATERNION),
    "planar": ("x", "y", "cos", "sin"),
    "free": tuple(f"{part}{entry}" for part in "ge" for entry in _QUATERNION),
}
_SLIDES = {"prismatic": [2], "planar": [0, 1]}


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
    def unit(self) -> slice | None:
        """The variables that have length 1, None for a slide."""
        if self.edge.kind not in _UNIT:
            return None
        return slice(self.columns.start + _UNIT[self.edge.kind], self.columns.stop)

    @property
    def names(self) -> tuple[str, ...]:
        """What each variable is."""
        return tuple(f"{what} {self.edge.name}" for what in _NAMES[self.edge.kind])

    @property
    def two_signs(self) -> bool:
        """Whether the variables and their negatives are the same pose."""
        return self.edge.kind in ("spherical", "free")

    def motion(self, variables: Symbols) -> tuple[Symbols, Symbols]:
        """Return the joint's rotation (3, 3) and translation (3, 1) in polynomials."""
        own, kind = variables[self.columns], self.edge.kind
        turn, slide = np.eye(3, dtype=int).astype(object), np.zeros((3, 1), dtype=object)
        for number, axis in enumerate(_SLIDES.get(kind, [])):
            slide[axis, 0] = own[number]
        if self.two_signs:
            turn = _rotation(*own[-4:])
            if kind == "free":
                slide = _times_conjugate(own[:4], own[4:])[:3, None]
        elif self.unit is not None:
            c, s = own[-2:]
            turn[0, 0], turn[0, 1], turn[1, 0], turn[1, 1] = c, -s, s, c
        return turn, slide

    def numbers(self, q: Array) -> Complex:
        """Return the joint's numbers (b, size) at rows of q."""
        entries = q[:, self.joint.idx_q : self.joint.idx_q + self.joint.nq].copy()
        if self.edge.kind == "revolute":
            entries = np.hstack([np.cos(entries), np.sin(entries)])
        if self.edge.kind == "free":
            place = np.hstack([entries[:, :3] / self.length, np.zeros((len(q), 1))])
            return np.hstack([_product(place, entries[:, 3:]), entries[:, 3:]]).astype(complex)
        entries[:, : _UNIT.get(self.edge.kind, 1)] /= self.length
        return entries.astype(complex)

    def put(self, x: Array, q: Array) -> None:
        """Write real numbers x (b, n) into rows of q."""
        entries, kind = x[:, self.columns].copy(), self.edge.kind
        if kind == "free":
            place = _times_conjugate(entries[:, :4].T, entries[:, 4:].T)[:3].T
            entries = np.hstack([place, entries[:, 4:]])
        unit = 3 if kind == "free" else _UNIT.get(kind, 1)
        entries[:, :unit] *= self.length
        if kind in _UNIT:
            entries[:, unit:] /= np.linalg.norm(entries[:, unit:], axis=1, keepdims=True)
        if kind == "revolute":
            entries = np.arctan2(entries[:, 1:], entries[:, :1])
        q[:, self.joint.idx_q : self.joint.idx_q + self.joint.nq] = entries

    def parameter(self, q: Array) -> complex:
        """Return u = exp(iθ) of a motor that turns, the length of one that slides."""
        own = self.numbers(q[None])[0]
        return complex(own[0] + 1j * own[1]) if self.unit is not None else complex(own[0])

    def balls(self, q: Array) -> list[acb]:
        """Return enclosures of a motor's numbers at one q; they are real."""
        entries = [arb(entry) for entry in q[self.joint.idx_q :][: self.joint.nq].tolist()]
        match self.edge.kind:
            case "revolute":
                return [acb(entries[0].cos()), acb(entries[0].sin())]
            case "prismatic":
                return [acb(entries[0] / arb(self.length))]
        return [acb(entry) for entry in entries]

    def from_parameter(self, p: Numbers) -> list[Numbers]:
        """Return a motor's numbers from its parameter."""
        if self.unit is None:
            return [p]
        inverse = 1.0 / p
        return [(p + inverse) * 0.5, (p - inverse) * -0.5j]

    def parameter_rates(self, p: Complex) -> list[Complex]:
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
        A motor of several degrees of freedom.
    """
    names, columns, first = list(model.names)[1:], {}, 0
    for name in sorted(names, key=lambda name: name not in passive):
        columns[name] = slice(first, first + _SIZES[edges[name].kind])
        first = columns[name].stop
        if name not in passive and edges[name].kind not in ("revolute", "continuous", "prismatic"):
            why = f"the motor {name!r} has several degrees of freedom"
            raise ArgumentError(f"{model.name}: no homotopy for this mechanism: {why}")
    return [
        JointUnknowns(joint, edges[name], columns[name], name not in passive, length)
        for joint, name in zip(list(model.joints)[1:], names, strict=True)
    ]


def _product(g: Array, e: Array) -> Array:
    """Return the products of quaternions (b, 4), x, y, z, w."""
    v, w = e[:, :3], e[:, 3:]
    imaginary = g[:, 3:] * v + g[:, :3] * w + np.cross(g[:, :3], v)
    real = g[:, 3:] * w - (g[:, :3] * v).sum(axis=1, keepdims=True)
    return np.hstack([imaginary, real])


def _times_conjugate(g: Symbols, e: Symbols) -> Symbols:
    """Return g e*, of quaternions x, y, z, w along the first axis."""
    (gx, gy, gz, gw), (x, y, z, w) = g, e
    entries = (
        gx * w - gw * x - gy * z + gz * y,
        gy * w - gw * y - gz * x + gx * z,
        gz * w - gw * z - gx * y + gy * x,
        gw * w + gx * x + gy * y + gz * z,
    )
    return symbols(entries) if g.ndim == 1 else np.array(entries)


def quaternion_of_gap(g: Symbols, e: Symbols, a: Symbols, b: Symbols) -> Symbols:
    """Return g + e a − b e = (p + R a − b) e for places a on the body and b on its base."""
    ex, ey, ez, ew = e
    (ax, ay, az), (bx, by, bz) = a, b
    sx, sy, sz, dx, dy, dz = ax + bx, ay + by, az + bz, ax - bx, ay - by, az - bz
    return g + symbols(
        (
            ew * dx + ey * sz - ez * sy,
            ew * dy + ez * sx - ex * sz,
            ew * dz + ex * sy - ey * sx,
            -(ex * dx + ey * dy + ez * dz),
        )
    )


def _rotation(x: fmpq_mpoly, y: fmpq_mpoly, z: fmpq_mpoly, w: fmpq_mpoly) -> Symbols:
    """Return the rotation of a quaternion of length 1."""
    entries = [
        *(w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)),
        *(2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)),
        *(2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z),
    ]
    return symbols(entries).reshape(3, 3)


def symbols(entries: Sequence[fmpq_mpoly]) -> Symbols:
    """Return polynomials as an array; NumPy would take each for a sequence of its terms."""
    found = np.empty(len(entries), dtype=object)
    for index, entry in enumerate(entries):
        found[index] = entry
    return found
