"""SingularityFree: a proof that no singularity of K* is within a distance of motors from a pose.

Let θ and φ be how far motors and passive joints are from the pose, A an approximate inverse of K*
there, and for all joints within R of it

    Z ≥ ‖I − A K*‖,    B ≥ ‖A K‖,    Y ≥ |A η(pose)|.

For each |θ| ≤ ρ ≤ R the map φ ↦ φ − A η(θ, φ) takes 0 to within Y + B ρ of it, and any two of the
ball |φ| ≤ R to within Z of their distance. Where

    Y + B ρ + Z R ≤ R    and    Z < 1

it maps the ball into itself and contracts: with the motors at θ there is exactly one closed pose in
it. A K* is invertible all over it, so K* is regular at each of them, and the one that motors lead
to from the pose, however they move within ρ, is among them. `docs/singularities.md` has it in full.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from pmjac_pin.algebra.balls import OUTWARDS, euclidean_norm, exactly, precise, upper
from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError
from pmjac_pin.studies.certificates.certificate import independent_square, others_of
from pmjac_pin.studies.certificates.equations import LoopEquations
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.krawczyk import contraction, norms_of
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import check_kind

#: R, rad, the first the pose itself: a factor of 10, then of 2^(1/8), apart.
_RADII = np.concatenate([[0.0], 10.0 ** np.arange(-9.0, -3.0), 2.0 ** np.arange(-10.0, 1.1, 0.125)])


@dataclass(frozen=True, slots=True)
class SingularityFree:
    """How far motors may move from a pose, each for itself, with K* proven regular.

    True where some distance is proven.

    Attributes
    ----------
    radius : float
        Each motor may move by this, in `unit`, either way; 0 where nothing is proven.
    unit : "m" or "rad"
        m where all motors slide; else rad, a slide by `characteristic_length` counting as 1 rad.
    passive_radius : float
        How far passive joints are from the pose at most, rad, slides by `characteristic_length`.
    rank : int
        Of K*, which it has there.
    failed : str
        Why nothing is proven; empty where something is.
    left_out : tuple of str
        Rows of the loop equations that depend on the others at the pose: nothing is asked of them.
    held : tuple of str
        Passive degrees of freedom that the loops leave free: held where they are.
    """

    radius: float
    unit: Literal["m", "rad"]
    passive_radius: float
    rank: int
    failed: str = ""
    left_out: tuple[str, ...] = ()
    held: tuple[str, ...] = ()

    def __bool__(self) -> bool:
        return not self.failed

    @property
    def evidence(self) -> Evidence:
        """What is proven."""
        if self.failed:
            return Evidence("nothing", self.failed)
        if not self.rank:
            return Evidence("proof", "no loop ties a passive joint: K* has no rank to lose")
        parts = [
            f"while each motor is within {self.radius:.3g} {self.unit} of the pose, there is "
            f"exactly one pose within {self.passive_radius:.3g} rad that closes the loops, and K* "
            f"has rank {self.rank} there"
        ]
        if self.held:
            parts.append(f"with {', '.join(self.held)} held")
        if self.left_out:
            parts.append(f"by all rows but {len(self.left_out)} that depend on them at the pose")
        return Evidence("proof", "; ".join(parts))


def singularity_free(configuration: Configuration) -> SingularityFree:
    """Return how far motors may move from a pose with no singularity of K* met: a proof.

    By interval arithmetic in one step, so that it is some fraction of the distance to the nearest
    singularity, which `nearest_singularity` estimates from above. Motors that slide or turn on
    their own are asked to stay within a box, each within `radius` of where it is.

    Parameters
    ----------
    configuration : Configuration

    Returns
    -------
    SingularityFree
        False where nothing is proven; `failed` then says why.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> home = pj.load("five_bar").home
    >>> proven, nearest = pj.singularity_free(home), pj.nearest_singularity(home, kind="gain")
    >>> 0.05 < proven.radius < nearest.distance
    True
    """
    check_kind(configuration, Configuration)
    mechanism, partition = configuration.mechanism, configuration._problem.partition
    slides = all(unit == "m" for unit in partition.units_of(partition.actuated))
    unit: Literal["m", "rad"] = "m" if slides else "rad"
    if not partition.passive_rank:
        return SingularityFree(np.inf, unit, 0.0, 0)
    columns = [*partition.passive.tolist(), *partition.actuated.tolist()]
    try:
        with precise(), np.errstate(over="ignore", invalid="ignore"):
            equations = LoopEquations(
                mechanism.kinematics.model, mechanism.spec.loops, mechanism.parameters, columns
            )
            found = _Ball(equations, configuration)
            radius, passive = found.largest()
    except ArgumentError as error:
        return SingularityFree(0.0, unit, 0.0, partition.passive_rank, str(error))
    failed = "" if radius > 0.0 else found.failed
    return SingularityFree(
        radius * (partition.length if slides else 1.0) / OUTWARDS,
        unit,
        passive,
        partition.passive_rank,
        failed,
        found.left_out,
        found.held,
    )


class _Ball:
    """Bounds over all joints within R of a pose, for each R."""

    def __init__(self, equations: LoopEquations, configuration: Configuration) -> None:
        partition, names = configuration._problem.partition, configuration.mechanism.rows
        at = equations.at(configuration.q)
        residual = equations.residual(at, configuration.q)
        around = equations.around(at, _RADII, partition.length)
        passive = np.arange(partition.passive.size)
        scaled = around.jacobian.middle[0][:, passive] * partition.row_scale[:, None]
        rows, columns = independent_square(scaled, partition.passive_rank)
        self.left_out = tuple(names[k] for k in others_of(len(names), rows).tolist())
        self.held = tuple(
            partition.passive_names[k] for k in others_of(passive.size, columns).tolist()
        )
        self.failed = ""
        K_star, K = around.jacobian[:, rows][:, :, columns], around.jacobian[:, rows]
        K = K[:, :, passive.size :]
        groups = equations.unknowns.groups
        mine, motors = groups[:, columns], groups[:, passive.size :]
        A = self._inverse(K_star.middle[0])
        step = exactly(A) @ residual[rows]
        self._Y = max(
            (upper(euclidean_norm(step[row > 0.0])) for row in mine if row.any()), default=0.0
        )
        self._Z = norms_of(contraction(A, K_star), mine, mine)
        self._N = norms_of(K_star.after(A), mine, mine)
        self._B = norms_of(K.after(A), mine, motors)
        self._turned = around.cosine > 0.0

    def _inverse(self, matrix: Array) -> Array:
        try:
            return np.asarray(np.linalg.inv(matrix), dtype=np.float64)
        except np.linalg.LinAlgError:
            self.failed = "K* has no inverse at the pose: its determinant is zero"
            return np.zeros(matrix.shape)

    def largest(self) -> tuple[float, float]:
        """Return the largest ρ that is proven, and its R; zeros where none is.

        Along the ways there, from the pose by the motors and then by the passive joints, B and Z
        count in the mean:

            Y + ∫₀^ρ B + ρ Z(ρ) + ∫_ρ^R Z ≤ R.
        """
        B, Z = (_integrals(bounds) for bounds in (self._B, self._Z))
        best = (0.0, 0.0)
        for j in range(1, _RADII.size):
            R, single = _RADII[j], self._Z[j] + 0.5 * self._N[j] * _RADII[j]
            if not (OUTWARDS * single < 1.0 and self._turned[j]):
                continue
            reached = self._Y + B[: j + 1] + _RADII[: j + 1] * self._Z[: j + 1] + Z[j] - Z[: j + 1]
            holds = np.flatnonzero(OUTWARDS * reached <= R)
            if holds.size and _RADII[holds[-1]] > best[0]:
                best = float(_RADII[holds[-1]]), float(R)
        if not best[0]:
            self.failed = self.failed or (
                f"Y + B ρ + Z R ≤ R does not hold for any R: ‖I − A K*‖ may be {self._Z[1]:.3g} at "
                f"the pose itself, and Newton's step is {self._Y:.3g} rad"
            )
        return best


def _integrals(bounds: Array) -> Array:
    """Return more than the integrals from 0 to each R of what does not decrease."""
    pieces = bounds[1:] * np.diff(_RADII)
    found: Array = OUTWARDS * np.concatenate([[0.0], np.cumsum(pieces)])
    return found
