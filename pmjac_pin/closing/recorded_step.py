"""What the step guard asks of a step of a path, as a program, in Frobenius' norms.

`StepGuard` has the mathematics and measures entry by entry; here, with A⁺ the inverse of K* on its
kept columns at the start, B⁺ that at the end, and norms of dimensionless matrices,

    N = ‖A⁺ΔA‖ + ‖A⁺ΔM‖ + ‖A⁺‖ ‖left out‖,    ΔA = K*(q₁) − A,    ΔM = K*(p(½)) − A − ½ ΔA,
    τ = ‖A⁺‖ ρ / (1 − N),    W = ‖how K* changes within 2τ‖,

a step is covered where W τ ≤ ρ and N + ‖A⁺‖ W < 1. Products with A⁺ are most of the work. Less is
asked first: K* changes by s ΔA from the start and by (1 − s) ΔA from the end, so that

    N = ‖A⁺‖ ‖B⁺‖ / (‖A⁺‖ + ‖B⁺‖) ‖ΔA‖ + max(‖A⁺‖, ‖B⁺‖) (‖ΔM‖ + ‖left out‖)

serves one Newton's map with A⁺ up to s = ‖B⁺‖ / (‖A⁺‖ + ‖B⁺‖), and one with B⁺ from there on. Both
find the closed pose there: each finds one that is the only one within 2τ, with the larger of both
norms in τ. So N, and what follows from it, is told three times: with norms only, with A⁺ΔA, and
with both.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pmjac_pin.algebra.arrays import Numbers
from pmjac_pin.algebra.programs import PROGRAMS, largest, objects, roots, zeros
from pmjac_pin.algebra.tape import Tape
from pmjac_pin.algebra.terms import Term
from pmjac_pin.closing.arms import Arms
from pmjac_pin.closing.bends import Bends, MotionSeries
from pmjac_pin.closing.recorded_rates import RecordedRates
from pmjac_pin.closing.step_guard import CUBIC, QUADRATIC, SLOPES
from pmjac_pin.kinematics.joint_steps import arriving, between, moved_by
from pmjac_pin.kinematics.recorded import Recorder
from pmjac_pin.rates.sparse_qr import Triangle, norm

BOUNDS = 3  #: that are told of a step
LEG_STAGES = range(4, 4 * BOUNDS + 1, 4)  #: outputs until each of them is told


def leg_tape(loops: RecordedRates, arms: Arms) -> Tape:
    """Return (q₀, q₁, leaving, onward, ‖A⁺‖, ‖B⁺‖) ↦ (N, ρ, W τ, N + ‖A⁺‖ W), `BOUNDS` times.

    The quickest first.

    Rates of the path at both ends: what leaves q₀ is one of the way, what moves on from q₁ is made
    one.
    """
    count = leg_inputs(loops.recorder)
    return loops.recordings.tape("leg", count, lambda inputs: leg(loops, arms, inputs), LEG_STAGES)


def leg_inputs(recorder: Recorder) -> int:
    """Return how many numbers `leg_tape` is a function of."""
    return int(2 * recorder.nq + 2 * recorder.nv + 2)


def leg(loops: RecordedRates, arms: Arms, inputs: Sequence[Term]) -> list[Any]:
    """Record `leg_tape`."""
    nq, nv, tree = loops.recorder.nq, loops.recorder.nv, loops.recorder.tree
    ends = [nq, 2 * nq, 2 * nq + nv, 2 * nq + 2 * nv]
    start, end, leaving, onward, inverses = np.split(objects(inputs), ends)
    way = between(PROGRAMS, tree, start, end)
    at_end = arriving(PROGRAMS, tree, way, onward)
    half = moved_by(PROGRAMS, tree, start, 0.5 * way + 0.125 * (leaving - at_end))
    poses, rates = np.array([start, end, half]), np.array([leaving, at_end, way])
    return _covered(loops, arms, poses, rates, inverses)


def _covered(
    loops: RecordedRates, arms: Arms, poses: Numbers, rates: Numbers, inverses: Numbers
) -> list[Any]:
    """Return the bounds of q₀, q₁ and p(½), and of leaving, arriving and way."""
    kept, at = loops.kept, [loops.recorder.loops_at(q.tolist()) for q in poses]
    first, last, middle = (loops.scaled(pose.rates)[:, kept] for pose in at)
    straight, bends = last - first, Bends(arms, roots)
    bent = middle - first - 0.5 * straight
    motion = _series(bends, poses[0], *rates)
    row_scale = loops.partition.row_scale
    open_by = (CUBIC * bends.residual(motion) + bends.rounding(motion)) * row_scale
    slopes = (at[1].residual - at[0].residual) * row_scale
    rho = norm(open_by) + SLOPES * norm(slopes)
    left_out = norm(loops.scaled(QUADRATIC * bends.rates(motion))[:, kept])

    def bounds(change: Any, inverse: Any) -> list[Any]:
        tau = inverse * rho / (1.0 - change)
        reach = zeros(loops.recorder.nv)
        reach[kept] = [2.0 * tau * scale for scale in loops.partition.column_scale[kept].tolist()]
        within = norm(loops.scaled(bends.within(motion, reach))[:, kept])
        return [change, rho, within * tau, change + inverse * within]

    at_start, at_end = inverses
    both = at_start * at_end / (at_start + at_end)
    larger = largest(at_start, at_end)
    told = bounds(both * norm(straight) + larger * (norm(bent) + left_out), larger)
    triangle = Triangle.of(np.hstack([first, straight, bent]), kept.size)
    count = kept.size
    solved = norm(triangle.solve(range(count, 2 * count)))
    told += bounds(solved + at_start * (norm(bent) + left_out), at_start)
    solved = solved + norm(triangle.solve(range(2 * count, 3 * count)))
    return told + bounds(solved + at_start * left_out, at_start)


def _series(
    bends: Bends, q: Numbers, leaving: Numbers, at_end: Numbers, way: Numbers
) -> MotionSeries:
    """Return the series along the cubic curve that `StepGuard` takes."""
    third = 6.0 * (leaving + at_end - 2.0 * way)
    second = 6.0 * way - 4.0 * leaving - 2.0 * at_end
    rates = np.array([leaving, at_end, third, second, second + third])
    u0, u1, c, b0, b1 = bends.speeds(rates)
    most = np.frompyfunc(largest, 2, 1)
    return bends.motion(q, np.array([most(u0, u1) + c / 8.0, most(b0, b1), c]))
