"""SymPy knows no machine: its solvers are given the loop equations, by own lines."""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp
from compared.known import (
    BEYOND,
    CRANK,
    LENGTHS,
    SHORT,
    SHORT_ENDS,
    error,
    none,
    rocker,
    rocker_rate,
)

COUPLER, ROCKER, ANGLE = sp.symbols("coupler rocker crank")


def gaps(lengths: Mapping[str, float]) -> list[sp.Expr]:
    """Return η: by how much the ends of coupler and rocker are apart, in x and y."""
    l0, l1, l2, l3 = lengths.values()
    return [
        l1 * sp.cos(ANGLE) + l2 * sp.cos(COUPLER) - l0 - l3 * sp.cos(ROCKER),
        l1 * sp.sin(ANGLE) + l2 * sp.sin(COUPLER) - l3 * sp.sin(ROCKER),
    ]


def ways() -> int:
    """Count the real solutions of two circles, in exact numbers; the crank's cosine is rounded."""
    l0, l1, l2, l3 = (sp.Rational(length) for length in LENGTHS.values())
    x, y = sp.symbols("x y", real=True)
    tip = [l1 * sp.Rational(float(turn(CRANK))) for turn in (sp.cos, sp.sin)]
    circles = [(x - tip[0]) ** 2 + (y - tip[1]) ** 2 - l2**2, (x - l0) ** 2 + y**2 - l3**2]
    return sum(root.is_real for root in sp.real_roots(sp.resultant(*circles, y), x))


def end() -> float:
    """Return the crank's angle where det K* is zero beside the loop equations."""
    unknown = [COUPLER, ROCKER]
    eta = sp.Matrix(gaps(SHORT))
    equations = [*eta, eta.jacobian(unknown).det()]
    return float(sp.nsolve(equations, [*unknown, ANGLE], [-1.5, 1.6, 1.3])[2])


def answers() -> Mapping[str, str]:
    """Return what it says, by question."""
    unknown, start = [COUPLER, ROCKER], [0.9, 2.0]
    equations = [gap.subs(ANGLE, CRANK) for gap in gaps(LENGTHS)]
    found = sp.nsolve(equations, unknown, start)
    try:
        sp.nsolve([gap.subs(ANGLE, BEYOND) for gap in gaps(SHORT)], unknown, start)
        beyond = "a pose"
    except ValueError:
        beyond = "refused: nsolve finds no root"
    eta = sp.Matrix(gaps(LENGTHS))
    rates = -eta.jacobian(unknown).inv() * eta.diff(ANGLE)
    pose = {ANGLE: CRANK, COUPLER: found[0], ROCKER: found[1]}
    return {
        "close": f"by own lines, {error(float(found[1]), rocker(CRANK))}",
        "beyond": beyond,
        "rate": f"by own lines, {error(float(rates[1].subs(pose)), rocker_rate(CRANK))}",
        "singular": f"by own lines, {error(end(), SHORT_ENDS)}",
        "modes": f"by own lines, {ways()}",
        "mobility": none(sp, "mobility"),
        "simulate": none(sp, "simulate"),
    }
