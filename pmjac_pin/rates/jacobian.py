"""EquivalentJacobian: J_eq = J − J* K*⁻¹ K (Ghosal, equations 26 to 33).

Linear algebra on plain arrays: it imports no Pinocchio and works on matrices from elsewhere.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from pmjac_pin.errors import NoGradientError
from pmjac_pin.model.tool_rows import TWIST_ROWS, checked_rows
from pmjac_pin.rates.error_estimate import error_estimate
from pmjac_pin.rates.gradients import gradient_of
from pmjac_pin.rates.partition import LoopRates
from pmjac_pin.rates.second_order import hessian, passive_hessian
from pmjac_pin.rates.tool_motion import TwistRanks
from pmjac_pin.rates.tool_reach import ToolReach
from pmjac_pin.values.arrays import Array, read_only
from pmjac_pin.values.found_once import found_once


@dataclass(frozen=True, eq=False, repr=False)
class EquivalentJacobian(ToolReach):
    """The map from motor rates to the tool twist, and the matrices that it is made of.

    Attributes
    ----------
    passive_rates : ndarray, shape (m_p, n)
        Φ = −K*⁻¹ K, so that φ̇ = Φ θ̇ (29).
    J_eq : ndarray, shape (6, n)
        J − J* K*⁻¹ K (30)–(32), linear rows first, in `frame`.
    """

    @found_once
    def _loops(self) -> LoopRates:
        """What the loops allow here: [K K*] without dimension, K* factorised."""
        if self.pose is not None:
            return self.pose.loop_rates()
        return self.partition.loop_rates(self.constraint_jacobian)

    @found_once
    def idle_map(self) -> Array:
        """N, shape (nv, i): what idles, orthonormal on dimensionless rates; C N = 0 and J N = 0."""
        partition, passive = self.partition, self._loops.passive
        idle = np.zeros((self.tool_jacobian.shape[1], partition.passive.size - passive.rank))
        idle[partition.passive] = passive.null_space
        return read_only(partition.column_scale[:, None] * idle)

    @found_once
    def gv_eq(self) -> Array:
        """[J_v]eqᵀ [J_v]eq, shape (n, n) (33). For display: its rank is not decided on it."""
        return read_only(self.Jv_eq.T @ self.Jv_eq)

    @found_once
    def gw_eq(self) -> Array:
        """[J_ω]eqᵀ [J_ω]eq, shape (n, n) (33)."""
        return read_only(self.Jw_eq.T @ self.Jw_eq)

    @found_once
    def tool_ranks(self) -> TwistRanks:
        """Ranks of J_eq, of its linear and of its angular rows, judged as `Singularity` does.

        On an orthonormal basis of the motions G θ̇: near a singularity of K*, where G grows
        beyond bounds, one large column must not hide the others.
        """
        motions = np.linalg.qr(self.motion_map / self.partition.column_scale[:, None])[0]
        return self.partition.tool_motion(self.tool_jacobian).ranks(motions)

    @found_once
    def error_estimate(self) -> Array:
        """How far the entries of J_eq may be off, shape (6, n), in the units of J_eq.

        |J_eq − J| ≤ error_estimate, entry by entry, with J that of the pose beside this one that
        closes the loops exactly, the motors at their values and the model's numbers as they are
        in memory, or off by a few units in the last place. An estimate, not a proof: to first
        order in the error of the pose, with roundings that are counted generously. It is some ten
        to a thousand times the error that is met.

        Beside a singularity the pose's own error, 1e-16 m over the smallest singular value of K*,
        counts most: relative to J_eq, about cond(K*)² 1e-16. It is infinite where the pose may be
        too far from a closed one to tell, and NaN throughout where the matrices came from
        elsewhere: how exact they are is not known here.

        Found when first asked for, by one evaluation for each passive degree of freedom.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> jacobian = pj.load("four_bar").home.jacobian()
        >>> jacobian.error_estimate.shape, bool((jacobian.error_estimate < 1e-12).all())
        ((6, 1), True)
        """
        if self.pose is None:
            return read_only(np.full(self.J_eq.shape, np.nan))
        return read_only(
            error_estimate(
                self.constraint_jacobian,
                self.tool_jacobian,
                self.motion_map,
                self.partition,
                self.pose,
            )
        )

    @found_once
    def hessian(self) -> Array:
        """∂J_eq/∂θ in `frame`, shape (6, n, n), the last axis along which motor.

        ∂J_eq/∂θₖ = (dJ[gₖ] − J* K*⁺ dC[gₖ]) G, with dJ, dC the derivatives of the tool and of the
        constraint Jacobian along gₖ, the k-th column of the motion map G: so the twist's rate
        that motor rates alone make is J̇_eq θ̇ = Σₖ (∂J_eq/∂θₖ) θ̇ θ̇ₖ. In LOCAL_WORLD_ALIGNED the
        linear rows are then the acceleration of the tool's origin. To rounding, as J_eq is; of
        joints that are not in the table of joints, by differences, to half of the digits. NaN
        throughout where the matrices came from elsewhere.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> jacobian = pj.load("serial_2r").close([0.0, 0.0], enforce_limits=False).jacobian()
        >>> jacobian.hessian[0, :, 1].tolist()  # of vx = −(l₁ s₁ + l₂ s₁₂, l₂ s₁₂), by θ₂
        [-0.8, -0.8]
        """
        slopes, G = self.slopes(self.motion_map), self.motion_map
        return read_only(hessian(slopes, self.tool_jacobian, G, self._loops, self.partition))

    @found_once
    def passive_hessian(self) -> Array:
        """∂Φ/∂θ of the passive rates φ̇ = Φ θ̇, shape (m_p, n, n), as `hessian` is of J_eq."""
        slopes, G = self.slopes(self.motion_map), self.motion_map
        return read_only(passive_hessian(slopes[0], G, self._loops, self.partition))

    def slopes(self, motions: Array) -> tuple[Array, Array]:
        """Return how the constraint and the tool Jacobian change along motions, (nv, k).

        In one unit of time each: shapes (k, p, nv) and (k, 6, nv). NaN where the matrices came
        from elsewhere.
        """
        if self.pose is not None:
            return self.pose.slopes(motions)
        of_loops, of_tool = self.constraint_jacobian.shape, self.tool_jacobian.shape
        count = motions.shape[1]
        return np.full((count, *of_loops), np.nan), np.full((count, *of_tool), np.nan)

    def gradient(self, measure: str, rows: Iterable[str] = TWIST_ROWS[:3]) -> Array:
        """Return the gradient by θ of a measure of J_eq, shape (n,).

        Parameters
        ----------
        measure : str
            "smallest singular value", "largest singular value", "product of singular values"
            (Yoshikawa's manipulability), "condition number" or "log det" (of half of
            log det B Bᵀ, the sum of the logarithms of the singular values).
        rows : iterable of str, optional
            The rows B of J_eq that are measured, of "vx", "vy", "vz", "wx", "wy" and "wz", in
            `frame`: the linear ones by default. Rows that are never moved, such as vz of a planar
            machine, are better left out: they make the smallest of three singular values 0.

        Raises
        ------
        UnknownNameError, ArgumentError
            No such measure or rows.
        NoGradientError
            Singular values that are equal or zero.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> jacobian = pj.load("serial_2r").close([0.3, 0.9]).jacobian()
        >>> rows = ["vx", "vy"]  # l₁ l₂ |sin θ₂|
        >>> jacobian.gradient("product of singular values", rows).round(6) + 0.0
        array([0.      , 0.497288])
        """
        chosen = checked_rows(rows)
        if self.pose is None:
            raise NoGradientError("matrices from elsewhere: how they change is not known")
        which = [TWIST_ROWS.index(name) for name in chosen]
        return read_only(gradient_of(measure, self.J_eq[which], self.hessian[which]))

    def __repr__(self) -> str:
        return f"EquivalentJacobian({self._sizes()})"
