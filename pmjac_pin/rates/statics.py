"""Statics: motor efforts and forces in the loops that balance a load.

With C = [K K*] on all rows and b (nv,) what acts against the tree's freedoms, motor efforts τ and
the loops' forces λ balance it where

    K*ᵀ λ = b_p,   τ = b_a − Kᵀ λ.

Redundant rows leave λ open by what the rows can do to each other, more motors than freedoms leave
τ open, too: the smallest are taken, of all or of those within limits, and what is open is told.
Linear algebra on arrays.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pmjac_pin.errors import EffortLimitError, NoEquilibriumError, enumerated
from pmjac_pin.rates.motor_limits import Limits, effort_limits
from pmjac_pin.rates.partition import LoopRates, Partition
from pmjac_pin.rates.within_limits import JUST_WITHIN, least_within, needed_limits
from pmjac_pin.values.arrays import Array, ReadOnlyArrays, norm

_BALANCED = 1e-9  # of the loads, without dimension: what rounding may leave on idle motions


@dataclass(frozen=True, eq=False, repr=False)
class Statics(ReadOnlyArrays):
    """What balances a load at rest. Made by `Configuration.statics`; all arrays are read-only.

    Attributes
    ----------
    efforts : ndarray, shape (n,)
        τ of the motors, N or N m; of all that balance it the smallest, where there are several.
    loop_forces : ndarray, shape (p,)
        λ, in the order of `Mechanism.rows`, that the loops exert on what opens a row: N where its
        unit is m, N m where it is rad, and N/m where it is m² (a rod of length l pulls with
        2 l λ). Of all that do the smallest, where rows are redundant.
    self_stress : ndarray, shape (p, r)
        Columns span what may be added to `loop_forces` with no effort of motors: none where the
        loops are statically determinate.
    internal_efforts : ndarray, shape (n, k)
        Columns span what may be added to `efforts`: motors that work against each other. Of
        length 1, and at right angles, where an effort is counted by its motor's natural rate.
    internal_forces : ndarray, shape (p, k)
        What each of these adds to `loop_forces`, the smallest that do.
    partition : Partition
        Whose motors and rows these are.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> statics = pj.load("three_rps").home.statics([0, 0, -30.0, 0, 0, 0], gravity=False)
    >>> statics.efforts.round(6).tolist(), statics.internal_efforts.shape
    ([11.547005, 11.547005, 11.547005], (3, 0))
    """

    efforts: Array
    loop_forces: Array
    self_stress: Array
    internal_efforts: Array
    internal_forces: Array
    partition: Partition

    @property
    def determinate(self) -> bool:
        """Whether equilibrium alone says what the forces in the loops are."""
        return not (self.self_stress.shape[1] or self.internal_efforts.shape[1])

    def within(self, limits: Limits = "model") -> Statics:
        """Return the smallest efforts that balance the load with |τᵢ| ≤ limit of each motor.

        Where motors work against each other that is a quadratic programme, solved to rounding by an
        active set; else it is asked whether the efforts, which are the only ones, are within.

        Parameters
        ----------
        limits : array_like, shape (n,), or "model"
            N or N m; or those that the model states.

        Raises
        ------
        EffortLimitError
            No efforts within the limits do: which motors lack how much.
        ArgumentError
            Limits that are none; a motor for which the model states none.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> tied = pj.load("five_bar", actuated=["theta1", "theta2", "phi2"]).home
        >>> statics = tied.statics([10.0, -30.0, 0, 0, 0, 0])
        >>> statics.efforts.round(3).tolist()
        [-1.725, 3.039, -5.165]
        >>> statics.within([5.0, 5.0, 5.0]).efforts.round(3).tolist()
        [-1.854, 3.245, -5.0]
        """
        bounds, scale = effort_limits(limits, self.partition), self.partition.motor_scale
        share = scale * self.efforts, scale[:, None] * self.internal_efforts, scale * bounds
        _refuse_beyond(needed_limits(*share) / scale, bounds, self.partition)
        added = least_within(*share)
        return replace(
            self,
            efforts=self.efforts + self.internal_efforts @ added,
            loop_forces=self.loop_forces + self.internal_forces @ added,
        )

    def __repr__(self) -> str:
        known = "determinate" if self.determinate else "of least norm"
        return f"Statics({self.efforts.size} motors, {self.loop_forces.size} rows, {known})"


def balanced(loads: Array, loops: LoopRates, partition: Partition) -> Statics:
    """Return what balances loads together.

    Parameters
    ----------
    loads : ndarray, shape (k, nv)
        b, in parts: what motors and loops have to exert on the tree's freedoms, N or N m.
    loops, partition
        As of `pmjac_pin.rates.second_order.following_rates`.

    Raises
    ------
    NoEquilibriumError
        The load drives what idles.
    """
    scale, actuated, passive = partition.column_scale, partition.actuated, partition.passive
    needed, rank = loads.sum(axis=0) * scale, partition.passive_rank
    left, values, right = (
        getattr(loops.passive, name) for name in ("left", "singular_values", "right")
    )
    size = float(np.linalg.norm(loads * scale, axis=1).sum())
    _refuse_driven_idle(right[rank:], needed[passive], size, partition)
    forces = left[:, :rank] @ ((right[:rank] @ needed[passive]) / values[:rank])
    driving = loops.scaled[:, actuated]
    efforts, open_ways = needed[actuated] - driving.T @ forces, left[:, rank:]
    # What rows do to each other with the passive joints at rest; motors may have to hold it.
    held = partition.factorise(driving.T @ open_ways, loops.size)
    least = held.solve(efforts)
    efforts, forces = efforts - held.matrix @ least, forces + open_ways @ least
    internal, rows = held.left[:, : held.rank], partition.row_scale[:, None]
    return Statics(
        efforts=efforts / scale[actuated],
        loop_forces=forces * partition.row_scale,
        self_stress=rows * (open_ways @ held.null_space),
        internal_efforts=internal / scale[actuated, None],
        internal_forces=-rows * (open_ways @ held.solve(internal)),
        partition=partition,
    )


def _refuse_beyond(needed: Array, limits: Array, partition: Partition) -> None:
    beyond = np.flatnonzero(needed > limits * (1.0 + JUST_WITHIN)).tolist()
    if not beyond:
        return
    names = partition.actuated_names
    told = [f"{names[k]} {needed[k]:.6g} of {limits[k]:.6g}" for k in beyond]
    raise EffortLimitError(
        "no efforts within the motors' limits balance the load: shared at best it takes "
        f"{enumerated(told)}",
        lacking={names[k]: float(needed[k] - limits[k]) for k in beyond},
    )


def _refuse_driven_idle(idle: Array, load: Array, size: float, partition: Partition) -> None:
    driven = idle @ load
    if norm(driven) <= _BALANCED * size:
        return
    motion = np.abs(idle.T @ driven)
    moving = [k for k in np.argsort(-motion)[:3].tolist() if motion[k] > 0.0]
    names = ", ".join(partition.passive_names[k] for k in moving)
    raise NoEquilibriumError(
        f"the load drives what idles ({names}), which neither motors nor loops hold: there is no "
        "equilibrium"
    )
