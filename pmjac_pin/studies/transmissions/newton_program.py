"""Newton's step of closed loops as a program, and how the closed pose goes as what drives it.

With C = [K K*], x the joints that drive, φ the others and gₖ the k-th column of the motion map G,

    δφ = −K*⁻¹ η,   ∂φ/∂x = −K*⁻¹ K,   ∂²φ/∂x₁∂x₂ = −K*⁻¹ dC[g₂] g₁,

on the columns of K* that are independent in general; dC[g₂] is how C changes along g₂.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pmjac_pin.algebra.arrays import Numbers
from pmjac_pin.algebra.named_outputs import named_outputs
from pmjac_pin.algebra.programs import PROGRAMS, objects, zeros
from pmjac_pin.algebra.tangents import tangents
from pmjac_pin.algebra.terms import Recording, Term
from pmjac_pin.closing.recorded_rates import RecordedRates
from pmjac_pin.errors import ArgumentError
from pmjac_pin.kinematics.joint_steps import entry_rates, moved_by
from pmjac_pin.kinematics.recorded import RecordedKinematics, Recorder
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.rates.sparse_qr import Triangle, norm
from pmjac_pin.values.arrays import Array, Index, Mask

_STEPS = 4  # of Newton's, from what is near: each doubles the digits
_ENDED = 1e-9  # rad: the next step is rounding
_PAIR = 2
_OF_RATES = ("condition", "motion", "forbidden", "ratio")
_FORBIDDEN = 1e-9  # beside [K K*]: rounding


@dataclass(frozen=True, slots=True, eq=False)
class RatesTold:
    """The rates of followers at b closed poses.

    Attributes
    ----------
    ratio : ndarray, shape (b, k, n)
    condition : ndarray, shape (b,)
        Largest by smallest singular value of it, dimensionless.
    loops_condition : ndarray, shape (b,)
        At least that of K*.
    regular : ndarray of bool, shape (b,)
        What drives determines the followers, and they determine it.
    allowed : ndarray of bool, shape (b,)
        The loops allow all rates of what drives.
    """

    ratio: Array
    condition: Array
    loops_condition: Array
    regular: Mask
    allowed: Mask


@dataclass(frozen=True, eq=False)
class NewtonProgram:
    """What is recorded of a mechanism at entries of q, the joints that drive it held.

    Parameters
    ----------
    mechanism : Mechanism
    followers : ndarray of int, shape (k,)
        Columns of v whose rates are told.
    q : ndarray, shape (nq,)
        A regular pose: which columns of K* are independent is seen there.

    Raises
    ------
    ArgumentError
        By what records: a joint that is not in the table of joints.
    """

    mechanism: Mechanism
    followers: Index
    q: Array

    @cached_property
    def recording(self) -> Recording:
        """The terms; its inputs are the entries of q, and values wanted of the followers."""
        return Recording(self.rates.recorder.nq + self.followers.size)

    @cached_property
    def rates(self) -> RecordedRates:
        """What is recorded of the mechanism's loops."""
        mechanism = self.mechanism
        recorder = Recorder(
            mechanism.kinematics.model, mechanism.spec, mechanism.parameters, mechanism.place
        )
        return RecordedRates.at(recorder, mechanism.problem, self.q)

    @cached_property
    def step(self) -> Mapping[str, Numbers]:
        """Recorded numbers, by name.

        `next` (nq,): q after a step. `size` (1,): of the step, rad or a share of the mechanism's
        length. `gap` (1,): how far the loops are open, m. `condition` (1,): ‖K*⁻¹‖ ‖[K K*]‖,
        dimensionless, at least the condition of K*. `forbidden` (1,): what K* cannot follow of K,
        beside [K K*]. `motion` (1,): ‖G‖, dimensionless. `ratio` (k, n): rates of the followers
        by those of what drives.
        """
        return self._stepped(self._correction)

    @cached_property
    def aimed(self) -> Mapping[str, Numbers]:
        """Recorded numbers of a step that leads the followers to values wanted: as of `step`.

        What drives moves by R⁻¹ (θ − θ(q) − δθ), R of one row or two, and all else with it.
        """
        correction, motions = self._correction, self._motions
        lacking = self._lacking() - correction[self.followers]
        return self._stepped(correction + motions @ _solved(motions[self.followers], lacking))

    def _stepped(self, step: Numbers) -> Mapping[str, Numbers]:
        """Return recorded numbers of a step (nv,)."""
        rates, partition = self.rates, self.rates.partition
        triangle, count = self._triangle, rates.kept.size
        whole = norm(rates.scaled(self._kinematics.rates))
        driven = range(count + 1, count + 1 + partition.actuated.size)
        size = norm(step * (1.0 / partition.column_scale)) * (1.0 / partition.length)
        numbers = (
            ("size", size),
            ("gap", rates.gap(self._kinematics)),
            ("condition", triangle.inverse_norm() * whole),
            ("motion", norm(self._motions * self._bare)),
            ("forbidden", norm(triangle.matrix[np.ix_(triangle.left_over, driven)]) / whole),
        )
        return {
            "next": moved_by(PROGRAMS, rates.recorder.tree, self._entries, step),
            **{name: objects([number]) for name, number in numbers},
            "ratio": self._motions[self.followers],
        }

    @cached_property
    def ways(self) -> Mapping[str, Numbers]:
        """Recorded numbers of closed poses, by name.

        `slopes` (nq, n): ∂q/∂x. `twist` (nq,): ∂²q/∂x₁∂x₂, of two joints that drive.
        `condition`, `motion`, `forbidden` and `ratio` as of `step`.
        """
        tree, motions = self.rates.recorder.tree, self._motions
        columns = [entry_rates(tree, self._entries, motion) for motion in motions.T]
        twist = self._twist(*columns) if len(columns) == _PAIR else zeros(0)
        return {"slopes": np.column_stack(columns), "twist": twist, **self.rates_outputs}

    def run(self, outputs: Mapping[str, Numbers], q: Array) -> dict[str, Array]:
        """Return outputs (b, ...) at rows of q, shape (b, nq)."""
        wanted = np.zeros((len(q), self.followers.size))
        return named_outputs(self.recording, outputs, np.hstack([q, wanted]))

    def polished(self, q: Array, x: Array) -> Array:
        """Return closed poses near rows of q (b, nq), by Newton's steps.

        Parameters
        ----------
        q : ndarray, shape (b, nq)
        x : ndarray, shape (b, n)
            The values of what drives, which q need not have.

        Raises
        ------
        ArgumentError
            The steps do not end.
        """
        outputs = {name: self.step[name] for name in ("next", "size")}
        driven = self.rates.partition.actuated
        q = self.mechanism.coordinates.with_values(q, driven, x)
        for _ in range(_STEPS):
            told = self.run(outputs, q)
            q = told["next"]
        if not (told["size"] < _ENDED).all():
            raise ArgumentError("Newton's steps from the table do not end: take more `points`")
        return q

    @property
    def rates_outputs(self) -> Mapping[str, Numbers]:
        """What `RatesTold` is made of."""
        return {name: self.step[name] for name in _OF_RATES}

    def judged(self, told: Mapping[str, Array]) -> RatesTold:
        """Return the ratio of some closed poses, and whether it holds.

        Parameters
        ----------
        told : mapping of str to ndarray
            What `run` gives of `rates_outputs`, or of `ways`.
        """
        bare = told["ratio"] * self._bare[self.followers]
        sizes = np.linalg.svd(np.where(np.isfinite(bare), bare, 0.0), compute_uv=False)
        least, tolerance = sizes[:, -1], self.rates.partition.rank_tolerance
        with np.errstate(divide="ignore", invalid="ignore"):
            condition = np.where(least > 0.0, sizes[:, 0] / least, np.inf)
        regular = (told["condition"][:, 0] * tolerance < 1.0) & np.isfinite(bare).all(axis=(1, 2))
        return RatesTold(
            ratio=told["ratio"],
            condition=condition,
            loops_condition=told["condition"][:, 0],
            regular=regular & (least > tolerance * told["motion"][:, 0]),
            allowed=np.abs(told["forbidden"][:, 0]) < _FORBIDDEN,
        )

    @property
    def _bare(self) -> Array:
        """What makes the motion map G dimensionless."""
        scale = self.rates.partition.column_scale
        return np.outer(1.0 / scale, scale[self.rates.partition.actuated])

    @cached_property
    def _entries(self) -> Numbers:
        return objects(self._inputs)

    @property
    def _inputs(self) -> Sequence[Term]:
        return self.recording.inputs[: self.rates.recorder.nq]

    @cached_property
    def _correction(self) -> Numbers:
        """Newton's step at held joints (nv,)."""
        rates = self.rates
        step, scale = zeros(rates.recorder.nv), rates.partition.column_scale
        step[rates.kept] = -self._triangle.solve([rates.kept.size])[:, 0] * scale[rates.kept]
        return step

    def _lacking(self) -> Numbers:
        """Return how far the followers are from the values wanted of them."""
        coordinates, entries = self.mechanism.coordinates, self._entries
        found = []
        wanted = self.recording.inputs[self.rates.recorder.nq :]
        for column, value in zip(self.followers.tolist(), wanted, strict=True):
            entry = coordinates.entry(column)
            if coordinates.wraps[column]:
                c, s = (self.recording.term(wave, value) for wave in ("cos", "sin"))
                x, y = entries[entry], entries[entry + 1]
                found.append(self.recording.term("atan2", s * x - c * y, c * x + s * y))
            else:
                found.append(value - entries[entry])
        return objects(found)

    @cached_property
    def _kinematics(self) -> RecordedKinematics:
        return self.rates.recorder.at(self._inputs)

    @cached_property
    def _triangle(self) -> Triangle:
        """K* on its kept columns, reduced, with η and K beside it."""
        rates, known = self.rates, self._kinematics
        matrix, error = rates.scaled(known.rates), known.residual * rates.partition.row_scale
        kept, driven = matrix[:, rates.kept], matrix[:, rates.partition.actuated]
        return Triangle.of(np.column_stack([kept, error, driven]), rates.kept.size)

    @cached_property
    def _motions(self) -> Numbers:
        """The motion map G (nv, n)."""
        partition, kept = self.rates.partition, self.rates.kept
        scale, driven = partition.column_scale, partition.actuated
        motions = zeros(scale.size, driven.size)
        motions[driven] = np.eye(driven.size)
        beside = range(kept.size + 1, kept.size + 1 + driven.size)
        followed = self._triangle.solve(beside)
        motions[kept] = -followed * np.outer(scale[kept], 1.0 / scale[driven])
        return motions

    def _twist(self, first: Numbers, second: Numbers) -> Numbers:
        """Return how the rates by one joint change as the other one moves."""
        rates, motion, kept = self.rates, self._motions[:, 0], self.rates.kept
        scale, known = rates.partition.column_scale, self._kinematics.rates
        along = tangents(known.ravel().tolist(), self._inputs, second.tolist())
        opening = (objects(along).reshape(known.shape) @ motion) * rates.partition.row_scale
        columns = np.column_stack([rates.scaled(known)[:, kept], opening])
        bent = zeros(scale.size)
        bent[kept] = -Triangle.of(columns, kept.size).solve([kept.size])[:, 0] * scale[kept]
        moving = [k for k, term in enumerate(motion) if isinstance(term, Term)]
        return objects(
            tangents(
                first.tolist(),
                [*self._inputs, *motion[moving]],
                [*second, *bent[moving]],
            )
        )


def _solved(matrix: Numbers, right: Numbers) -> Numbers:
    """Return M⁻¹ b of one row or two, by Cramer's rule."""
    if right.size < _PAIR:
        return objects([right[0] / matrix[0, 0]])
    (a, b), (c, d) = matrix
    determinant = a * d - b * c
    one, other = d * right[0] - b * right[1], a * right[1] - c * right[0]
    return objects([one / determinant, other / determinant])
