"""RateSeries: loop equations and rates as series in the motors' values, over a cube of these.

Passive joints follow polynomials of degree 2 there, within some radii of them: first-order changes
of K* are told with their signs, not by how far each joint may go, and cancel as they do.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.algebra.series import Exponents, Series, SeriesAlgebra
from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError
from pmjac_pin.kinematics.joint_steps import entry_rates
from pmjac_pin.kinematics.loops import Loops, riding
from pmjac_pin.kinematics.tree import Link, Poses, Tree
from pmjac_pin.model.joint_kind import JointMotion
from pmjac_pin.studies.certificates.tool_rates import ToolRates
from pmjac_pin.values.arrays import Array

_DEGREE_KEPT = 2
_ALL_WAYS = 2.0  # more than √3: of three slides, and of axes that turn

#: Coefficients of a matrix by their exponents: at the pose below the order, else over the cube.
Coefficients = Mapping[Exponents, Intervals]


@dataclass(frozen=True, slots=True, eq=False)
class SeriesRates:
    """What is enclosed over a cube.

    Attributes
    ----------
    residual : mapping of exponents to Intervals, shape (p,)
    rates : mapping of exponents to Intervals, shape (p + rows, nv)
        [K K*] above the judged rows of the tool.
    cosine : float
        The least between axes that the rows want to coincide.
    """

    residual: Coefficients
    rates: Coefficients
    cosine: float


class RateSeries:
    """The series of a machine about a pose.

    Parameters
    ----------
    configuration : Configuration
    tool : ToolRates, optional
        For the rows of the tool.

    Raises
    ------
    ArgumentError
        A joint of a kind that cannot be taken apart; gears; a motor of several freedoms.
    """

    def __init__(self, configuration: Configuration, tool: ToolRates | None) -> None:
        mechanism = configuration.mechanism
        model, self._tool = mechanism.kinematics.model, tool
        self._tree = Tree(model)
        self._loops = Loops(model, self._tree, mechanism.spec.loops, mechanism.parameters)
        self._partition = configuration.problem.partition
        self._q, self._nv = configuration.q, model.nv
        self._values = mechanism.coordinates.values(configuration.q)
        motors = self._partition.actuated.tolist()
        single = {link.column for link in self._tree.links.values() if link.kind.nv == 1}
        if self._loops.couplings or not single.issuperset(motors):
            raise ArgumentError("gears, or motors of several freedoms")
        self._algebra = SeriesAlgebra(len(motors), _DEGREE_KEPT)
        self._variables = [
            self._algebra.variable(
                k, Intervals(np.array([[0.0, -1.0]]), np.array([[0.0, 1.0]])), _exactly(1.0)
            )
            for k in range(len(motors))
        ]

    def over(self, ways: Mapping[Exponents, Array], radii: Array) -> SeriesRates:
        """Return what is enclosed with all joints on polynomials, within some radii of them.

        Parameters
        ----------
        ways : mapping of exponents to ndarray, shape (nv,)
            How the joints move, m or rad: those of degree 1 and 2.
        radii : ndarray, shape (nv,)
            m or rad, the same for the turns of a joint.
        """
        entries = {
            key: entry_rates(self._tree, self._q[:, None], way[:, None])[:, 0]
            for key, way in ways.items()
        }

        def motion(link: Link) -> JointMotion:
            return self._motion(link, ways, entries, radii)

        poses = Poses(self._tree, self._algebra, motion, range(self._nv))
        columns, rows = ((), []) if self._tool is None else self._tool.rows_of(poses)
        constant, count, cosine = (0,) * len(self._variables), self._loops.count, 1.0
        residual = _Collected((count,), constant)
        rates = _Collected((count + len(rows), self._nv), constant)
        for pair in self._loops.pairs:
            for (where, _), block in zip(pair.blocks, riding(pair, poses), strict=True):
                residual.put(where, block.rows.value.each(lambda term: term[:, 0]))
                rates.put((where, list(block.rows.columns)), block.rows.rates)
                if block.cosine is not None:
                    cosine = min(cosine, _least_cosine(block.cosine.value))
        for row, one in enumerate(rows, count):
            rates.put((row, list(columns)), one)
        return SeriesRates(residual.intervals(), rates.intervals(), cosine)

    def _motion(
        self,
        link: Link,
        ways: Mapping[Exponents, Array],
        entries: Mapping[Exponents, Array],
        radii: Array,
    ) -> JointMotion:
        kind, column, pitch = link.kind, link.column, link.edge.pitch
        if kind.nv == 1:
            along = {key: float(way[column]) for key, way in ways.items()}
            value = self._polynomial(float(self._values[column]), along)
            return kind.at(self._algebra, self._near(value, float(radii[column])), pitch)
        stop = link.entries.stop
        parts = [
            self._polynomial(
                float(self._q[k]), {key: float(way[k]) for key, way in entries.items()}
            )
            for k in range(link.entries.start, stop)
        ]
        known = kind.motion(self._algebra, self._algebra.stack(parts), pitch)
        own = radii[column : column + kind.nv]
        slide, turn = (
            _ALL_WAYS * float(part.max(initial=0.0)) for part in np.split(own, [kind.slides])
        )
        return JointMotion(
            tuple(self._near(x, slide) for x in known.slides),
            tuple(self._near(x, turn) for x in known.turn),
        )

    def _polynomial(self, at: float, along: Mapping[Exponents, float]) -> Series:
        total = self._algebra.boxes(_exactly(at))
        for key, slope in along.items():
            if slope:
                first, *others = [
                    one
                    for one, power in zip(self._variables, key, strict=True)
                    for _ in range(power)
                ]
                for other in others:
                    first = first * other
                total = total + first.each(_exactly(slope).__mul__)
        return total

    def _near(self, x: Series, radius: float) -> Series:
        if not radius:
            return x
        return x + self._algebra.boxes(Intervals(_full(-radius), _full(radius)))


class _Collected:
    """Coefficients of a matrix, put together of blocks."""

    def __init__(self, shape: tuple[int, ...], constant: Exponents) -> None:
        self._shape = shape
        self._ends: dict[Exponents, tuple[Array, Array]] = {
            constant: (np.zeros(shape), np.zeros(shape))
        }

    def put(self, where: Any, block: Series | None) -> None:
        """Write the coefficients of a block (..., 2): of the pose, or all over the cube."""
        for exponents, term in block.terms.items() if block is not None else ():
            part = 1 if sum(exponents) == _DEGREE_KEPT else 0
            ends = self._ends.setdefault(exponents, (np.zeros(self._shape), np.zeros(self._shape)))
            for side, end in zip(ends, (term.lower, term.upper), strict=True):
                side[where] = end[..., part if end.shape[-1] > 1 else 0]

    def intervals(self) -> dict[Exponents, Intervals]:
        """Return what was put."""
        return {exponents: Intervals(*ends) for exponents, ends in self._ends.items()}


def _exactly(value: float) -> Intervals:
    return Intervals.exact(_full(value))


def _full(value: float) -> Array:
    return np.full((1, 2), value)


def _least_cosine(cosine: Series) -> float:
    """Return a lower bound on a series over the cube: its first coefficient there is all of it."""
    return float(np.asarray(cosine.value.lower).min())
