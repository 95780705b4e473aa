"""For TSID: a closed machine's equations of motion, as constraints of its solvers' problem."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pmjac_pin.adapters import importing
from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.inertias import massless
from pmjac_pin.rates.dynamics import check_inertia_of_tree
from pmjac_pin.rates.independent_equations import independent_loops
from pmjac_pin.values.arrays import Array, ReadOnlyArrays
from pmjac_pin.values.checks import as_number, as_vector, check_kind

with importing("tsid"):
    import tsid


@dataclass(frozen=True, eq=False)
class EquationsOfMotion(ReadOnlyArrays):
    """What holds of y = (v̇, f), the tree's accelerations and its loops' forces, at one (q, v).

    M v̇ + h = Sᵀ τ + Aᵀ f, with efforts τ of the motors alone. Made by `equations_of_motion`.

    Attributes
    ----------
    closure, passive : tsid.ConstraintEquality
        A v̇ = −γ − Kd A v − Kp e, shape (r, nv + r), and the rows of M v̇ − Aᵀ f = −h of the joints
        that nothing drives: for level 0.
    effort_map, effort_bias : ndarray, shapes (n, nv + r) and (n,)
        The motors' rows: τ = effort_map y + effort_bias.
    """

    closure: Any
    passive: Any
    effort_map: Array
    effort_bias: Array

    def accelerations(self, y: ArrayLike) -> Array:
        """Return v̇, shape (nv,), m/s² or rad/s², of a solution's `x`."""
        return as_vector(y, self.closure.cols, "y")[: self.closure.cols - self.closure.rows]

    def efforts(self, y: ArrayLike) -> Array:
        """Return τ, shape (n,), N or N m, of a solution's `x`."""
        return self.effort_map @ as_vector(y, self.closure.cols, "y") + self.effort_bias

    def of_accelerations(self, task: Any) -> Any:
        """Return a ConstraintEquality on v̇, as TSID's tasks compute them, as one on y."""
        if not getattr(task, "isEquality", False):  # `vector` of an inequality: its lower ends
            raise ArgumentError(f"a ConstraintEquality expected, got a {type(task).__name__}")
        if task.cols != (nv := self.closure.cols - self.closure.rows):
            raise ArgumentError(f"a task on {nv} accelerations expected, got one on {task.cols}")
        # Of one row, `matrix` comes as a vector.
        wide = np.pad(np.reshape(task.matrix, (task.rows, nv)), ((0, 0), (0, self.closure.rows)))
        return tsid.ConstraintEquality("accelerations", wide, task.vector)

    def of_efforts(self, efforts: ArrayLike) -> Any:
        """Return the ConstraintEquality on y that the motors' efforts are these, (n,)."""
        given = as_vector(efforts, self.effort_bias.size, "motor efforts")
        return tsid.ConstraintEquality("efforts", self.effort_map, given - self.effort_bias)

    def effort_bounds(self, lower: ArrayLike, upper: ArrayLike) -> Any:
        """Return the ConstraintInequality on y that they stay between these, each (n,)."""
        given = [as_vector(b, self.effort_bias.size, "effort bounds") for b in (lower, upper)]
        if (given[0] > given[1]).any():
            raise ArgumentError(f"effort bounds from lower to upper expected, got {quoted(given)}")
        ends = [bound - self.effort_bias for bound in given]
        return tsid.ConstraintInequality("effort bounds", self.effort_map, *ends)


def equations_of_motion(
    mechanism: Mechanism, q: ArrayLike, v: ArrayLike, Kp: float = 0.0, Kd: float = 0.0
) -> EquationsOfMotion:
    """Return the equations of motion of a closed machine at q (nq,) and v (nv,).

    The loops' equations e, in m, are in as many combinations as are independent. Open loops close
    by ë + Kd ė + Kp e = 0, but for γ = Ȧ v, which is that of closed ones: off by some v ė and v² e.

    Parameters
    ----------
    mechanism : Mechanism
    q, v : array_like
        Pinocchio's, measured or simulated.
    Kp, Kd : float
        1/s² and 1/s, as of TSID's tasks.

    Raises
    ------
    ArgumentError
        Values that do not fit, or a joint that is not in the table of joints.
    SingularError
        The loops' equations lose rank.
    NoInertiaError
        Some motion that the loops allow moves no mass.
    """
    check_kind(mechanism, Mechanism)
    q, v = as_vector(q, mechanism.nq, "q"), as_vector(v, mechanism.nv, "v")
    Kp, Kd = as_number(Kp, "Kp"), as_number(Kd, "Kd")
    partition, tree = mechanism.problem.partition, mechanism.kinematics
    if (slopes := mechanism.recorded.slopes() or mechanism.slopes) is None:
        raise ArgumentError(f"{mechanism.name} has a joint that is not in the table of joints")
    eta, by_v = mechanism.loop_equations(q)
    leading = independent_loops(partition, by_v, mechanism.name)
    A, gamma = leading @ by_v, leading @ slopes.at(q, v[:, None]).constraint[0] @ v
    mass, bias = tree.mass_matrix(q), tree.efforts(q, v, np.zeros(mechanism.nv))
    check_inertia_of_tree(mass, A, partition.column_scale, lambda: massless(tree.model))
    rows, closed = np.hstack([mass, -A.T]), np.pad(A, ((0, 0), (0, len(A))))
    motors, passive = partition.actuated, partition.passive
    closing = tsid.ConstraintEquality("closure", closed, -gamma - Kd * A @ v - Kp * leading @ eta)
    undriven = tsid.ConstraintEquality("passive joints", rows[passive], -bias[passive])
    return EquationsOfMotion(closing, undriven, rows[motors], bias[motors])
