"""BallBounds: Krawczyk's test over all motor values within a distance of a pose, in one step.

Let θ and φ be how far motors and passive joints are from the pose, A an approximate inverse of K*
there, and for all joints within R of it

    Z ≥ ‖I − A K*‖,    B ≥ ‖A K‖,    Y ≥ |A η(pose)|.

For each |θ| ≤ ρ ≤ R the map φ ↦ φ − A η(θ, φ) takes 0 to within Y + ∫₀^ρ B of it, and what is |φ|
away to within ρ Z(ρ) + ∫_ρ^|φ| Z of that. Where

    Y + ∫₀^ρ B + ρ Z(ρ) + ∫_ρ^R Z ≤ R    and    Z < 1

it maps the ball |φ| ≤ R into itself and contracts: with the motors at θ there is exactly one closed
pose in it. A K* is invertible all over it, so K* is regular at each of them, and the one that
motors lead to from the pose, however they move within ρ, is among them.

That the tool loses nothing is asked of the same balls: with M the rows of [K K*] and the judged
ones of the tool, as many as are independent at the pose, and A_M about their inverse,
‖I − A_M M‖ < 1 up to R. As many rows stay independent then.
"""

from __future__ import annotations

import numpy as np

from pmjac_pin.algebra.balls import OUTWARDS, euclidean_norm, exactly, upper
from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.configuration import Configuration
from pmjac_pin.kinematics.tree import Poses
from pmjac_pin.rates.partition import Partition
from pmjac_pin.studies.certificates.certificate import independent_square
from pmjac_pin.studies.certificates.chains import WIDE_BOXES
from pmjac_pin.studies.certificates.equations import LoopEquations
from pmjac_pin.studies.certificates.neighbourhoods import Neighbourhoods
from pmjac_pin.studies.certificates.tool_rates import ToolRates
from pmjac_pin.studies.krawczyk import contraction, norms_of
from pmjac_pin.values.arrays import Array, Index, Mask

#: R, rad, the first the pose itself: a factor of 10, then of 2^(1/8), apart.
_RADII = np.concatenate([[0.0], 10.0 ** np.arange(-9.0, -3.0), 2.0 ** np.arange(-10.0, 1.1, 0.125)])


class BallBounds:
    """Bounds over all joints within R of a pose, for each R.

    Parameters
    ----------
    equations : LoopEquations
        The passive joints its first unknowns, then the motors.
    configuration : Configuration
    kept : tuple of ndarray of int, optional
        Rows and passive columns of the square K*; independent ones at the pose by default.
    tool : ToolRates, optional
        What the tool may not lose either.
    """

    def __init__(
        self,
        equations: LoopEquations,
        configuration: Configuration,
        kept: tuple[Index, Index] | None = None,
        tool: ToolRates | None = None,
    ) -> None:
        partition = configuration.problem.partition
        at, count = equations.at(configuration.q), partition.passive.size
        residual = equations.residual(at, configuration.q)
        around = equations.around(at, _RADII, partition.length)
        if kept is None:
            scaled = around.jacobian.middle[0][:, :count] * partition.row_scale[:, None]
            kept = independent_square(scaled, partition.passive_rank)
        self.kept, self.failed = kept, ""
        rows, columns = kept
        own = around.jacobian[:, rows]
        K_star, K, groups = own[:, :, columns], own[:, :, count:], equations.unknowns.groups
        mine, motors = groups[:, columns], groups[:, count:]
        A = self._inverse(K_star.middle[0])
        step = exactly(A) @ residual[rows]
        self._Y = max(
            (upper(euclidean_norm(step[row > 0.0])) for row in mine if row.any()), default=0.0
        )
        if rows.size:
            self._Z = norms_of(contraction(A, K_star), mine, mine)
            self._N = norms_of(K_star.after(A), mine, mine)
            self._B = norms_of(K.after(A), mine, motors)
        else:  # no loop ties a passive joint
            self._Z = self._N = self._B = np.zeros(_RADII.size)
        self._turned = around.cosine > 0.0
        self._kept_by_tool = np.ones(_RADII.size, dtype=bool)
        if tool is not None:
            rates = self._tool_rates(tool, equations, at, partition)
            self._kept_by_tool = self._keeps(around.jacobian, rates, partition, groups)

    def _tool_rates(
        self, tool: ToolRates, equations: LoopEquations, at: Poses, partition: Partition
    ) -> Intervals:
        """Return the tool's rows up to each R, by the units of the unknowns."""
        length, places = partition.length, equations.unknowns.places
        slides = np.nextafter(_RADII * length, np.inf)
        rates = tool.around(Neighbourhoods(WIDE_BOXES, at, places, _RADII, slides))
        return rates * Intervals.exact(equations.unknowns.scale(length))

    def _keeps(
        self, loops: Intervals, tool: Intervals, partition: Partition, groups: Array
    ) -> Mask:
        """Tell up to which R as many rows of loops and tool are independent as generically."""
        rank = partition.constraint_rank + partition.tool_rank
        both = Intervals.join([loops, tool], axis=1)
        scale = np.concatenate([partition.row_scale, np.ones(tool.shape[1])])
        rows, columns = independent_square(both.middle[0] * scale[:, None], rank)
        own, mine = both[:, rows][:, :, columns], groups[:, columns]
        found = norms_of(contraction(self._inverse(own.middle[0]), own), mine, mine)
        return np.asarray(OUTWARDS * found < 1.0)

    def _inverse(self, matrix: Array) -> Array:
        try:
            return np.asarray(np.linalg.inv(matrix), dtype=np.float64)
        except np.linalg.LinAlgError:
            self.failed = "K*, or its rows with the tool's, has no inverse at the pose"
            return np.zeros(matrix.shape)

    def largest(self) -> tuple[float, float]:
        """Return the largest ρ that is proven, and the least R for it; zeros where none is."""
        holds = self._holds()
        proven = holds.any(axis=0) & self._kept_by_tool[holds.argmax(axis=0)]
        radius = float(_RADII[proven].max(initial=0.0))
        if not radius:
            self.failed = self.failed or self._why(holds)
            return 0.0, 0.0
        return radius, self.passive_radii(radius)[0]

    def _why(self, holds: Mask) -> str:
        if holds.any():
            return "‖I − A M‖ < 1 does not hold for the rows M of the loops and of the tool"
        return (
            f"Y + B ρ + Z R ≤ R does not hold for any R: ‖I − A K*‖ may be {self._Z[1]:.3g} at "
            f"the pose itself, and Newton's step is {self._Y:.3g} rad"
        )

    def passive_radii(self, radius: float) -> tuple[float, float]:
        """Return the least and the largest R that is proven for a ρ; infinite and 0 for none.

        The closed pose is within the first, where the tool loses nothing if that is asked, and no
        other one within the second.
        """
        column = int(np.searchsorted(_RADII, radius))
        if column == _RADII.size or not (holds := self._holds()[:, column]).any():
            return np.inf, 0.0
        if not self._kept_by_tool[holds.argmax()]:
            return np.inf, 0.0
        return float(_RADII[holds].min()), float(_RADII[holds].max())

    def _holds(self) -> Mask:
        """Tell for which R (rows) and ρ (columns) there is exactly one closed pose in the ball."""
        B, Z = (_integrals(bounds) for bounds in (self._B, self._Z))
        single = OUTWARDS * (self._Z + 0.5 * self._N * _RADII) < 1.0
        reached = self._Y + (B + _RADII * self._Z - Z)[None, :] + Z[:, None]
        inside = (OUTWARDS * reached <= _RADII[:, None]) & (_RADII[None, :] <= _RADII[:, None])
        return np.asarray(inside & (single & self._turned)[:, None])


def _integrals(bounds: Array) -> Array:
    """Return more than the integrals from 0 to each R of what does not decrease."""
    pieces = bounds[1:] * np.diff(_RADII)
    found: Array = OUTWARDS * np.concatenate([[0.0], np.cumsum(pieces)])
    return found
