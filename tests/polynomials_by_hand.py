"""Loop equations as polynomials, written by hand in SymPy: the reference for counts of solutions.

Coefficients are rational, to 40 digits, so that every solver gets the same numbers.
"""

from __future__ import annotations

from dataclasses import dataclass

import hand_spatial
import sympy as sp
from sympy.algebras.quaternion import Quaternion

DIGITS = 40
PATCH = (0.7, -0.8, 0.6, 0.9)  # of the projective space of orientations: any general numbers


@dataclass(frozen=True)
class PolynomialSystem:
    """As many polynomials as unknowns.

    The unknowns stand in groups, of which each polynomial has its own degree: fewer paths lead to
    the solutions where the groups are chosen well (multihomogeneous Bezout number).
    """

    polynomials: tuple[sp.Poly, ...]
    groups: tuple[tuple[sp.Symbol, ...], ...]

    @property
    def unknowns(self):
        return tuple(symbol for group in self.groups for symbol in group)


def exact(number):
    """A rational number of 40 digits; a float stands for the decimals it is printed with."""
    value = sp.sympify(str(number)) if isinstance(number, float) else sp.sympify(number)
    return sp.Rational(str(value.evalf(DIGITS)))


def polynomial_system(equations, *groups):
    unknowns = [symbol for group in groups for symbol in group]
    polynomials = (sp.Poly(equation, unknowns) for equation in equations)
    rational = tuple(
        sp.Poly({power: exact(number) for power, number in one.as_dict().items()}, unknowns)
        for one in polynomials
    )
    return PolynomialSystem(rational, tuple(tuple(group) for group in groups))


def thirds(radius, index):
    """A point on a circle at 0, 120 or 240 degrees."""
    return radius * sp.Matrix([sp.cos(2 * sp.pi * index / 3), sp.sin(2 * sp.pi * index / 3)])


def four_bar(motors, lengths=(4, 1, 3, 3.5)):
    """Coupler tip = rocker tip; (c1, s1) of the rocker, (c2, s2) of the coupler from the crank."""
    c1, s1, c2, s2 = sp.symbols("c1 s1 c2 s2")
    l0, l1, l2, l3 = (exact(length) for length in lengths)
    c, s = sp.cos(exact(motors[0])), sp.sin(exact(motors[0]))
    x = l1 * c + l2 * (c * c2 - s * s2) - l0 - l3 * c1
    y = l1 * s + l2 * (s * c2 + c * s2) - l3 * s1
    return polynomial_system([x, y, c1**2 + s1**2 - 1, c2**2 + s2**2 - 1], [c1, s1, c2, s2])


def planar_3rpr(motors, a=0.2, b=0.5):
    """Three distances |p + R a_i - b_i| = l_i; p = (x, y), and R by (c, s)."""
    x, y, c, s = sp.symbols("x y c s")
    turn = sp.Matrix([[c, -s], [s, c]])
    equations = [c**2 + s**2 - 1]
    for index, length in enumerate(motors):
        leg = sp.Matrix([x, y]) + turn * thirds(exact(a), index) - thirds(exact(b), index)
        equations.append(leg.dot(leg) - exact(length) ** 2)
    return polynomial_system(equations, [x, y, c, s])


def three_rps(motors, a=0.5):
    """The lecture's equations of the S-S pairs, in the cosines and sines of the leg angles."""
    c, s, lengths = sp.symbols("c1:4"), sp.symbols("s1:4"), [exact(length) for length in motors]
    equations = [c[leg] ** 2 + s[leg] ** 2 - 1 for leg in range(3)]
    for i, j in ((0, 1), (1, 2), (2, 0)):
        li, lj = lengths[i], lengths[j]
        turning = li * lj * (c[i] * c[j] - 2 * s[i] * s[j]) - 3 * (li * c[i] + lj * c[j])
        equations.append(3 - 3 * exact(a) ** 2 + li**2 + lj**2 + turning)
    return polynomial_system(equations, *zip(c, s, strict=True))


def stewart_gough(
    motors, base=hand_spatial.DIETMAIER_BASE, platform=hand_spatial.DIETMAIER_PLATFORM
):
    """Six distances in Study's coordinates e (orientation) and g = p e (place), quaternions.

    R a = e a e* / |e|^2 makes |e|^2 |p + R a - b|^2 = |g + e a - b e|^2, and p has no real part
    where e . g = 0. (e, g) and its multiples are one pose: one is chosen by a linear equation.
    """
    e, g = sp.symbols("e0:4"), sp.symbols("g0:4")
    orientation, place = Quaternion(*e), Quaternion(*g)

    def leg(length, low, high):
        low, high = (Quaternion(0, *(exact(x) for x in point)) for point in (low, high))
        reach = place + orientation * high - low * orientation
        return _square(reach.args[:4]) - exact(length) ** 2 * _square(e)

    first, *others = (leg(*one) for one in zip(motors, base, platform, strict=True))
    study = sum(one * other for one, other in zip(e, g, strict=True))
    chosen = sum(exact(number) * one for number, one in zip(PATCH, e, strict=True)) - 1
    return polynomial_system([first, *(other - first for other in others), study, chosen], [*e, *g])


def _square(entries):
    return sum(entry**2 for entry in entries)


SYSTEMS = {
    "four_bar": four_bar,
    "planar_3rpr": planar_3rpr,
    "three_rps_ss": three_rps,
    "stewart_gough_dietmaier": stewart_gough,
}
