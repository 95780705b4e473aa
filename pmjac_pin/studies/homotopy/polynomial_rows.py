"""The rows of η in polynomials, in characteristic lengths.

Tilts and turns are taken as t·a = 0 and as the skew part of R, which vanish at half a turn as well.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pinocchio as pin
from flint import fmpq_mpoly
from numpy.typing import ArrayLike

from pmjac_pin.algebra.jets import Jets
from pmjac_pin.algebra.polynomials import Polynomials, Symbols, rational
from pmjac_pin.kinematics.loops import Pair
from pmjac_pin.kinematics.tree import Link, Poses, Tree
from pmjac_pin.model.frames import Frame
from pmjac_pin.model.joint_kind import JointMotion
from pmjac_pin.model.rows import Distance
from pmjac_pin.studies.homotopy.joint_unknowns import JointUnknowns, quaternion_of_gap

_POLYNOMIALS = Polynomials()
_ENTRY_ROUNDING = 1e-15  # of an entry of a rotation, which is of size 1


class LengthPolynomials(Polynomials):
    """Polynomials in characteristic lengths: a model's own lengths, m, are measured by them."""

    __slots__ = ("_length",)

    def __init__(self, length: float) -> None:
        self._length = length

    def measured(self, values: ArrayLike) -> Symbols:
        """Return a model's numbers, which are lengths, exactly."""
        exact = [rational(value) / rational(self._length) for value in np.ravel(values).tolist()]
        found = np.empty((len(exact), 1, 1), dtype=object)
        found[:, 0, 0] = exact
        return found.reshape(*np.shape(values), 1, 1)


class PolynomialRows:
    """The rows between frames of a tree whose joints have these unknowns.

    Parameters
    ----------
    model : pin.Model
    joints : sequence of JointUnknowns
    variables : ndarray of fmpq_mpoly
    length : float
        The characteristic length, m.
    """

    __slots__ = ("_joints", "_length", "_lengths", "_poses", "_variables", "tree")

    def __init__(
        self,
        model: pin.Model,
        joints: Sequence[JointUnknowns],
        variables: Symbols,
        length: float,
    ) -> None:
        self._variables, self._length = variables, length
        self._lengths = LengthPolynomials(length)
        self._joints: Mapping[int, JointUnknowns] = {one.edge.child: one for one in joints}
        self.tree = Tree(model, self._placed)
        self._poses = Poses(self.tree, _POLYNOMIALS, self._motion)

    def of(self, pair: Pair, square: Symbols | None) -> tuple[list[fmpq_mpoly], list[fmpq_mpoly]]:
        """Return the rows of a loop, and what is 0 at a closed pose and not at half a turn.

        `square` is that of a rod's length where this is a variable.
        """
        rows: list[Symbols] = []
        turned_over: list[Symbols] = []
        one, other = (self._poses.riding(pair.base, frame) for frame in (pair.first, pair.second))
        for _, block in pair.blocks:
            if isinstance(block, Distance):
                length = _exact_number(rational(block.length / self._length) ** 2)
                rows.append(self._rod(pair, length if square is None else square))
                continue
            found = block.equations(Jets(self._lengths), one, other)
            rows += list(found.rows.value)
            if found.cosine is not None:
                turned_over.append(found.cosine.value - _POLYNOMIALS.constant(1.0))
        return [row[0, 0] for row in rows], [row[0, 0] for row in turned_over]

    def _rod(self, pair: Pair, square: Symbols) -> Symbols:
        """Return |gap|² − square, for a free body times |e|² = 1: of lower degree so."""
        ends = (pair.first, pair.second)
        floating = [self._floating(pair.base, frame) for frame in ends]
        if not any(floating):
            one, other = (self._poses.riding(pair.base, frame).origin().value for frame in ends)
            return np.asarray(_POLYNOMIALS.squared(one - other) - square)
        own, other = ends if floating[0] else ends[::-1]
        joint = self._joints[own.joint]
        start, stop = joint.columns.start, joint.columns.stop
        numbers = [self._variables[k : k + 1, None] for k in range(start, stop)]
        link = self.tree.links[own.joint]
        base, _ = self._poses.before(pair.base, link)
        away = self._poses.riding(pair.base, other).origin().value - base.p
        seen = _POLYNOMIALS.dot(_POLYNOMIALS.swapped(_POLYNOMIALS.stack(base[:3])), away[:, None])
        place = self._placed(joint.edge.after * own.placement).translation
        gap = quaternion_of_gap(numbers[:4], numbers[4:], _POLYNOMIALS.constant(place), seen)
        e = _POLYNOMIALS.squared(_POLYNOMIALS.stack(numbers[4:]))
        return np.asarray(_POLYNOMIALS.squared(_POLYNOMIALS.stack(gap)) - square * e)

    def _floating(self, base: int, frame: Frame) -> bool:
        return frame.joint != base and self._joints[frame.joint].floating

    def _motion(self, link: Link) -> JointMotion:
        return self._joints[link.edge.child].motion(self._variables)

    def _placed(self, placement: pin.SE3) -> pin.SE3:
        """Return a placement in characteristic lengths, entries below rounding zero."""
        rotation = placement.rotation
        turn = np.where(np.abs(rotation) < _ENTRY_ROUNDING, 0.0, rotation)
        return pin.SE3(turn, placement.translation / self._length)


def _exact_number(number: object) -> Symbols:
    found = np.empty((1, 1), dtype=object)
    found[0, 0] = number
    return found
