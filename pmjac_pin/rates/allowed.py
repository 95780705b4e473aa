"""AllowedJacobian: the tool's twist where motors are tied to each other, on rates that fit.

More motors than freedoms agree at closed poses, but not at every rate: where the loops forbid some,
no J_eq of all rates exists. On those that they allow, θ̇ = A u, it does:
J_eq = (J − J* K*⁻¹ K) A. Linear algebra on plain arrays: it imports no Pinocchio.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from numpy.typing import ArrayLike

from pmjac_pin.errors import ArgumentError, ForbiddenRatesError
from pmjac_pin.rates.actuation import analyse_actuation
from pmjac_pin.rates.elimination import refuse_felt_idle_motion, refuse_singular
from pmjac_pin.rates.partition import LoopRates
from pmjac_pin.rates.singularity import Singularity, analyse_singularity
from pmjac_pin.rates.split import SplitJacobian
from pmjac_pin.rates.twist_map import TwistMap
from pmjac_pin.values.arrays import Array, norm, read_only
from pmjac_pin.values.checks import as_numbers, check_kind


@dataclass(frozen=True, eq=False, repr=False)
class AllowedJacobian(TwistMap):
    """The map from the motor rates that the loops allow to the tool twist.

    Attributes
    ----------
    leading : tuple of str, length a
        Motors whose rates determine those of the others: the columns u of what follows.
    motor_rates : ndarray, shape (n, a)
        A with θ̇ = A u: the rates that fit, 1 for each leading motor in its own column.
    passive_rates : ndarray, shape (m_p, a)
        Φ with φ̇ = Φ u.
    J_eq : ndarray, shape (6, a)
        The tool twist for each unit rate of a leading motor, the other motors following, linear
        rows first, in `frame`.
    """

    leading: tuple[str, ...]
    motor_rates: Array

    def _of_all_motors(self) -> Array:
        return self.motor_rates

    def twist(self, motor_rates: ArrayLike) -> Array:
        """Return the tool twist (6,) of rates of all motors, if these fit each other.

        Parameters
        ----------
        motor_rates : array_like, shape (n,)
            rad/s or m/s, in the order of the motors.

        Raises
        ------
        ForbiddenRatesError
            The loops do not allow them; the message says what the leading motors would lead to.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> tied = pj.load("four_bar", actuated=["theta1", "phi1"]).home.allowed_jacobian()
        >>> twice = tied.twist(2.0 * tied.motor_rates[:, 0])
        >>> bool(abs(twice - 2.0 * tied.J_eq[:, 0]).max() < 1e-12)
        True
        """
        names = self.partition.actuated_names
        given = as_numbers(motor_rates, "motor rates")
        if given.shape != (len(names),):
            raise ArgumentError(f"{len(names)} motor rates are needed, got shape {given.shape}")
        led_by = given[[names.index(name) for name in self.leading]]
        fitting, scale = self.motor_rates @ led_by, self.partition.column_scale
        off = (given - fitting) / scale[self.partition.actuated]
        size = norm(given / scale[self.partition.actuated])
        if norm(off) > self.partition.rank_tolerance * size:
            wanted = ", ".join(
                f"{name} {rate:.6g}" for name, rate in zip(names, fitting.tolist(), strict=True)
            )
            lead = " and ".join(self.leading) or "no motor"
            raise ForbiddenRatesError(
                f"the loops forbid these motor rates; those that {lead} lead to are {wanted}",
                forbidden_rates=read_only((given - fitting)[:, None] / norm(given - fitting)),
            )
        return read_only(self.J_eq @ led_by)

    def __repr__(self) -> str:
        return f"AllowedJacobian(leading={', '.join(self.leading) or 'none'}, {self._sizes()})"


def allowed_jacobian(
    split: SplitJacobian,
    singularity: Callable[[], Singularity] | None = None,
    *,
    loops: LoopRates | None = None,
) -> AllowedJacobian:
    """Eliminate the passive rates on the motor rates that the loops allow.

    Parameters
    ----------
    split, singularity, loops
        As of `equivalent_jacobian`.

    Raises
    ------
    SingularError
        K* is below its generic rank, or no pose near home closes.
    IdleMotionError
        A passive motion that no motor commands moves the tool.
    """
    check_kind(split, SplitJacobian)
    partition, constraint, J = split.partition, split.constraint_jacobian, split.tool_jacobian
    found = loops or partition.loop_rates(constraint)
    refuse_singular(
        found, partition, singularity or partial(analyse_singularity, constraint, J, partition)
    )
    actuated, passive, factors = partition.actuated, partition.passive, found.passive
    if factors.rank < passive.size:
        refuse_felt_idle_motion(factors, J, partition)
    actuation, scale = analyse_actuation(constraint, J, partition), partition.column_scale
    driving = found.scaled[:, actuated] @ (actuation.allowed / scale[actuated, None])
    rates = factors.solve(driving)
    rates += factors.solve(driving - found.scaled[:, passive] @ rates)
    rates *= -scale[passive, None]
    return AllowedJacobian(
        constraint,
        J,
        split.frame,
        partition,
        rates,
        J[:, actuated] @ actuation.allowed + J[:, passive] @ rates,
        tuple(partition.actuated_names[k] for k in actuation.sufficient),
        actuation.allowed,
        pose=split.pose,
    )
