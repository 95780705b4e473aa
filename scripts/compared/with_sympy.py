"""SymPy knows no machine: its solvers are given the loop equations, by own lines."""

from __future__ import annotations

from collections.abc import Mapping

import sympy
from compared.known import (
    BEYOND,
    CRANK,
    LENGTHS,
    SHORT,
    SHORT_ENDS,
    error,
    none,
    own_lines,
    rocker,
    rocker_rate,
)

COUPLER, ROCKER, ANGLE = sympy.symbols("coupler rocker crank")


def gaps(lengths: Mapping[str, float]) -> list[sympy.Expr]:
    """Return η: by how much the ends of coupler and rocker are apart, in x and y."""
    l0, l1, l2, l3 = lengths.values()
    return [
        l1 * sympy.cos(ANGLE) + l2 * sympy.cos(COUPLER) - l0 - l3 * sympy.cos(ROCKER),
        l1 * sympy.sin(ANGLE) + l2 * sympy.sin(COUPLER) - l3 * sympy.sin(ROCKER),
    ]


def ways() -> int:
    """Count the real solutions of two circles, in exact numbers; the crank's cosine is rounded."""
    l0, l1, l2, l3 = (sympy.Rational(length) for length in LENGTHS.values())
    x, y = sympy.symbols("x y", real=True)
    tip = [l1 * sympy.Rational(float(turn(CRANK))) for turn in (sympy.cos, sympy.sin)]
    circles = [(x - tip[0]) ** 2 + (y - tip[1]) ** 2 - l2**2, (x - l0) ** 2 + y**2 - l3**2]
    return sum(root.is_real for root in sympy.real_roots(sympy.resultant(*circles, y), x))


def end() -> float:
    """Return the crank's angle where det K* is zero beside the loop equations."""
    unknown = [COUPLER, ROCKER]
    eta = sympy.Matrix(gaps(SHORT))
    equations = [*eta, eta.jacobian(unknown).det()]
    return float(sympy.nsolve(equations, [*unknown, ANGLE], [-1.5, 1.6, 1.3])[2])


def bennett() -> int:
    """Return its mobility: four joints less the rank of their screws, in sixty digits.

    Sides 1/2 and 1 with twists of 30 and 90 degrees; tan(θ₁/2) tan(θ₂/2) is sin 60° / sin 30°.
    """
    crank = sympy.pi / 3
    other = 2 * sympy.atan(sympy.sqrt(3) / sympy.tan(crank / 2))
    screws, place = [], sympy.eye(4)
    for angle, side, twist in (
        (crank, sympy.Rational(1, 2), sympy.pi / 6),
        (other, sympy.Integer(1), sympy.pi / 2),
        (-crank, sympy.Rational(1, 2), sympy.pi / 6),
        (-other, sympy.Integer(1), sympy.pi / 2),
    ):
        axis, point = place[:3, 2], place[:3, 3]
        screws.append(axis.col_join(point.cross(axis)))
        c, s, ct, st = sympy.cos(angle), sympy.sin(angle), sympy.cos(twist), sympy.sin(twist)
        place *= sympy.Matrix(
            [[c, -s * ct, s * st, side * c], [s, c * ct, -c * st, side * s], [0, st, ct, 0],
             [0, 0, 0, 1]]
        )  # fmt: skip
    if max(abs(entry.evalf(60)) for entry in place - sympy.eye(4)) > 1e-50:
        raise ValueError("Bennett's linkage does not close")
    rank = sympy.Matrix.hstack(*screws).evalf(60).rank(iszerofunc=lambda x: abs(x) < 1e-40)
    return len(screws) - rank


def answers() -> Mapping[str, str]:
    """Return what it says, by question."""
    unknown, start = [COUPLER, ROCKER], [0.9, 2.0]
    equations = [gap.subs(ANGLE, CRANK) for gap in gaps(LENGTHS)]
    found = sympy.nsolve(equations, unknown, start)
    try:
        sympy.nsolve([gap.subs(ANGLE, BEYOND) for gap in gaps(SHORT)], unknown, start)
        beyond = "a pose"
    except ValueError:
        beyond = "refused: nsolve finds no root"
    eta = sympy.Matrix(gaps(LENGTHS))
    rates = -eta.jacobian(unknown).inv() * eta.diff(ANGLE)
    pose = {ANGLE: CRANK, COUPLER: found[0], ROCKER: found[1]}
    return {
        "close": f"by own lines, {error(float(found[1]), rocker(CRANK))}",
        "beyond": beyond,
        "rate": f"by own lines, {error(float(rates[1].subs(pose)), rocker_rate(CRANK))}",
        "singular": f"by own lines, {error(end(), SHORT_ENDS)}",
        "modes": f"by own lines, {ways()}",
        "mobility": own_lines(sympy, "mobility", str(bennett())),
        "simulate": none(sympy, "simulate"),
    }
