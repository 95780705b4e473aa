"""Where idle motions are at the ends of many paths, by programs: `IdleWay` has the mathematics."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pmjac_pin.algebra.arrays import Numbers
from pmjac_pin.algebra.programs import PROGRAMS, objects, zeros
from pmjac_pin.algebra.tape import Tape
from pmjac_pin.algebra.terms import Term
from pmjac_pin.closing.arms import Arms
from pmjac_pin.closing.recorded_idle import idle_motions
from pmjac_pin.closing.recorded_rates import RecordedRates
from pmjac_pin.closing.recorded_step import LEG_STAGES, leg
from pmjac_pin.kinematics.joint_steps import arriving, between, moved_by
from pmjac_pin.rates.sparse_qr import Triangle, norm
from pmjac_pin.values.arrays import Mask


def idle_tape(loops: RecordedRates) -> Tape:
    """Return q ↦ (‖K* N‖, ‖K*⁻¹‖, N), N a basis of null K* without dimension.

    Of its entries those that are not the same at every pose.
    """

    def make(q: Sequence[Term]) -> list[Any]:
        matrix = loops.scaled(loops.recorder.loops_at(q).rates)
        motions, open_by = idle_motions(matrix, loops.idle)
        inverse = Triangle.of(matrix[:, loops.kept], loops.kept.size).inverse_norm()
        return [open_by, inverse, *motions[_changing(motions)]]

    return loops.recordings.tape("idle", loops.recorder.nq, make)


def return_tape(loops: RecordedRates, idle: Tape) -> Tape:
    """Return (q, q₀, N₀) ↦ (‖K*⁻¹‖, ‖[K K*]‖, ‖v‖, ‖P‖², gap, ‖N (N₀ᵀ L N)⁻¹ N₀ᵀ x‖, q ⊕ v).

    The gap, m, and x are those at q ⊕ v; norms are without dimension. Of N₀ the entries that
    `idle_tape` gives.
    """
    nq, nv, tree = loops.recorder.nq, loops.recorder.nv, loops.recorder.tree

    def make(inputs: Sequence[Term]) -> list[Any]:
        q, start, given = np.split(objects(inputs), [nq, 2 * nq])
        kinematics = loops.recorder.loops_at(q.tolist())
        matrix, scale = loops.scaled(kinematics.rates), loops.partition.column_scale
        error = kinematics.residual * loops.partition.row_scale
        kept, on_loops = loops.kept, zeros(nv, 1)
        triangle = Triangle.of(np.column_stack([matrix[:, kept], error]), kept.size)
        on_loops[kept] = -triangle.solve([kept.size])
        motions, _ = idle_motions(matrix, loops.idle)
        at_start = motions.copy()
        at_start[_changing(motions)] = given
        back, inverse = _way_back(loops, (start, q), on_loops, motions, at_start)
        # ‖N G⁻¹ N₀ᵀ‖² by small products.
        squares = inverse @ (at_start.T @ at_start) @ inverse.T
        turned = np.trace((motions.T @ motions) @ squares)
        ahead = moved_by(PROGRAMS, tree, q, back * scale)
        gap = loops.gap(loops.recorder.loops_at(ahead.tolist()))
        left = inverse @ (at_start.T @ (between(PROGRAMS, tree, start, ahead) / scale))
        sizes = [triangle.inverse_norm(), norm(matrix), norm(back), turned]
        return [*sizes, gap, norm(motions @ left), *ahead]

    return loops.recordings.tape("return", 2 * nq + idle.outputs - 2, make)


def cover_tape(loops: RecordedRates, arms: Arms, idle: Tape) -> Tape:
    """Return (q₁, q₂, q₀, N₀) ↦ what `leg_tape` tells of the step from q₁ to q₂.

    These differ by what idles, with the motors at rest: N₀ᵀ x goes straight from its value at the
    one to that at the other. Of N₀ the entries that `idle_tape` gives.
    """
    nq, tree = loops.recorder.nq, loops.recorder.tree

    def make(inputs: Sequence[Term]) -> list[Any]:
        *poses, start, given = np.split(objects(inputs), [nq, 2 * nq, 3 * nq])
        scale, none = loops.partition.column_scale, zeros(loops.recorder.nv, 1)
        rows = [loops.scaled(loops.recorder.loops_at(q.tolist()).rates) for q in poses]
        triangles = [Triangle.of(matrix[:, loops.kept], loops.kept.size) for matrix in rows]
        motions = [idle_motions(matrix, loops.idle)[0] for matrix in rows]
        at_start = motions[0].copy()
        at_start[_changing(motions[0])] = given
        ways = [at_start.T @ (between(PROGRAMS, tree, start, q) / scale) for q in poses]
        rates = []
        for q, own in zip(poses, motions, strict=True):
            _, inverse = _way_back(loops, (start, q), none, own, at_start)
            rates.append(own @ (inverse @ (ways[1] - ways[0])) * scale)
        inverses = [triangle.inverse_norm() for triangle in triangles]
        return leg(loops, arms, [*np.concatenate([*poses, *rates]), *inverses])

    count = 3 * nq + idle.outputs - 2
    return loops.recordings.tape("cover", count, make, LEG_STAGES)


def _changing(motions: Numbers) -> Mask:
    """Tell which entries are terms."""
    return np.array([isinstance(x, Term) for x in motions.ravel()]).reshape(motions.shape)


def _way_back(
    loops: RecordedRates,
    poses: tuple[Numbers, Numbers],
    on_loops: Numbers,
    idle: Numbers,
    at_start: Numbers,
) -> tuple[Numbers, Numbers]:
    """Return Newton's step (nv,), without dimension, and (N₀ᵀ L N)⁻¹."""
    scale, tree, count = loops.partition.column_scale[:, None], loops.recorder.tree, idle.shape[1]
    way = between(PROGRAMS, tree, *poses)[:, None]
    motions = np.hstack([on_loops, idle]) * scale
    rates = arriving(PROGRAMS, tree, np.repeat(way, 1 + count, axis=1), motions)
    rates[:, :1] = rates[:, :1] + way
    seen = at_start.T @ (rates / scale)
    sides = np.hstack([seen[:, 1:], seen[:, :1], np.eye(count)])
    solved = Triangle.of(sides, count).solve(range(count, sides.shape[1]))
    return (on_loops - idle @ solved[:, :1])[:, 0], solved[:, 1:]
