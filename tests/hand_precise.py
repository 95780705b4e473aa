"""Machines written down by hand, with fifty digits: the oracle for errors of J_eq.

Each takes the model's numbers as they are in memory. The equations F(θ, x) = 0 are solved by
Newton's method, and J = ∂y/∂θ − ∂y/∂x (∂F/∂x)⁻¹ ∂F/∂θ follows for the tool's coordinates y. Imports
nothing of the library.
"""

from __future__ import annotations

import mpmath as mp
import numpy as np

DIGITS = 50
_STEP = mp.mpf(10) ** -20  # of central differences, which then are off by some 1e-40


class Precise:
    """Equations and tool of a machine: `closed(θ, x, y)` gives F and the tool's six coordinates.

    The coordinates change with the tool's twist, linear rows first: dy = (v, ω) dt.
    """

    def equations(self, motors, unknowns):
        raise NotImplementedError

    def tool(self, motors, unknowns):
        raise NotImplementedError

    def settle(self, unknowns):
        """Start anew at these unknowns, where they are measured from a pose."""
        return unknowns

    def solved(self, motors, unknowns):
        """Return the unknowns that solve the equations, from a start near them."""
        with mp.workdps(DIGITS):
            theta, x = _given(motors), mp.matrix(list(map(mp.mpf, unknowns)))
            for _ in range(8):
                F = self.equations(theta, x)
                if mp.norm(F) < mp.mpf(10) ** -40:
                    return x
                x = self.settle(x - mp.lu_solve(_slope(self.equations, theta, x, 1), F))
        raise ArithmeticError("the oracle did not close its loops")

    def jacobian(self, motors, unknowns):
        """Return J, shape (6, n), as a matrix of mpmath, from a start near the pose."""
        with mp.workdps(DIGITS):
            theta, x = _given(motors), self.solved(motors, unknowns)
            by_motors, by_unknowns = (_slope(self.equations, theta, x, k) for k in (0, 1))
            rates = -mp.inverse(by_unknowns) * by_motors
            return _slope(self.tool, theta, x, 0) + _slope(self.tool, theta, x, 1) * rates


def _given(motors):
    return mp.matrix(list(map(float, motors)))


def _slope(function, theta, x, place):
    columns = []
    for k in range(len((theta, x)[place])):
        both = []
        for way in (1, -1):
            moved = [theta.copy(), x.copy()]
            moved[place][k] += way * _STEP
            both.append(function(*moved))
        columns.append((both[0] - both[1]) / (2 * _STEP))
    slope = mp.matrix(len(columns[0]), len(columns))
    for k, column in enumerate(columns):
        slope[:, k] = column
    return slope


def errors(J_eq, precise):
    """Return |J_eq − J|, shape (6, n), of a float matrix and a precise one."""
    with mp.workdps(DIGITS):
        return np.array(
            [
                [float(abs(mp.mpf(float(J_eq[i, j])) - precise[i, j])) for j in range(precise.cols)]
                for i in range(6)
            ]
        )


class FourBar(Precise):
    """Ground, crank, coupler, rocker; unknowns φ₁ of the rocker and φ₂ of the coupler."""

    def __init__(self, l0, l1, l2, l3, half):
        self.lengths = [mp.mpf(float(x)) for x in (l0, l1, l2, l3, half)]

    def equations(self, motors, unknowns):
        l0, l1, l2, l3, _ = self.lengths
        theta, rocker, coupler = motors[0], unknowns[0], motors[0] + unknowns[1]
        return mp.matrix(
            [
                l1 * mp.cos(theta) + l2 * mp.cos(coupler) - l0 - l3 * mp.cos(rocker),
                l1 * mp.sin(theta) + l2 * mp.sin(coupler) - l3 * mp.sin(rocker),
            ]
        )

    def tool(self, motors, unknowns):
        _, l1, _, _, half = self.lengths
        theta, coupler = motors[0], motors[0] + unknowns[1]
        x = l1 * mp.cos(theta) + half * mp.cos(coupler)
        return mp.matrix([x, l1 * mp.sin(theta) + half * mp.sin(coupler), 0, 0, 0, coupler])


class SliderCrank(Precise):
    """Crank r, rod l, the piston's line at y = e; unknowns β of the rod and x of the piston."""

    def __init__(self, r, length, e):
        self.sizes = [mp.mpf(float(x)) for x in (r, length, e)]

    def equations(self, motors, unknowns):
        r, length, e = self.sizes
        theta, rod = motors[0], motors[0] + unknowns[0]
        return mp.matrix(
            [
                r * mp.cos(theta) + length * mp.cos(rod) - unknowns[1],
                r * mp.sin(theta) + length * mp.sin(rod) - e,
            ]
        )

    def tool(self, motors, unknowns):
        return mp.matrix([unknowns[1], 0, 0, 0, 0, 0])


class ThreeRPS(Precise):
    """Three legs that lean about tangents of the base, and a platform on their ends.

    Unknowns: three leans, the platform's place, and a rotation vector from where it is.

    Parameters
    ----------
    feet, corners : sequence of three (3,)
        Of the legs in the base, and of the ball joints in the platform.
    turns : sequence of three float
        Of the legs about the vertical.
    rotation : (3, 3)
        The platform's, near the pose.
    """

    def __init__(self, feet, turns, corners, quaternion):
        with mp.workdps(DIGITS):
            self.feet = [mp.matrix(list(map(float, foot))) for foot in feet]
            self.turns = [mp.mpf(float(turn)) for turn in turns]
            self.corners = [mp.matrix(list(map(float, corner))) for corner in corners]
            self.rotation = _of_quaternion([mp.mpf(float(x)) for x in quaternion])

    def equations(self, motors, unknowns):
        place, rotation = unknowns[3:6, 0], _turn(unknowns[6:9, 0]) * self.rotation
        rows = []
        for k in range(3):
            lean, out = unknowns[k], -motors[k] * mp.cos(unknowns[k])
            up = motors[k] * mp.sin(lean)
            c, s = mp.cos(self.turns[k]), mp.sin(self.turns[k])
            end = self.feet[k] + mp.matrix([c * out, s * out, up])
            rows += list(place + rotation * self.corners[k] - end)
        return mp.matrix(rows)

    def tool(self, motors, unknowns):
        return unknowns[3:9, 0]

    def settle(self, unknowns):
        self.rotation = _turn(unknowns[6:9, 0]) * self.rotation
        unknowns[6:9, 0] = mp.zeros(3, 1)
        return unknowns


def _turn(vector):
    angle = mp.norm(vector)
    X = mp.matrix(
        [[0, -vector[2], vector[1]], [vector[2], 0, -vector[0]], [-vector[1], vector[0], 0]]
    )
    if angle == 0:
        return mp.eye(3)
    return mp.eye(3) + mp.sin(angle) / angle * X + 2 * (mp.sin(angle / 2) / angle) ** 2 * X * X


def _of_quaternion(xyzw):
    size = mp.sqrt(sum(x * x for x in xyzw))
    x, y, z, w = (c / size for c in xyzw)
    return mp.matrix(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
