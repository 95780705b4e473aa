"""Report: everything that is known at one pose, with names and units.

A view of the `Configuration`: the numbers are the Python interface's, unchanged. `Report.told` is
what ``pmjac report --json`` writes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, reduce

import msgspec
import numpy as np
from numpy.typing import ArrayLike

from pmjac_pin.closing.motor_values import MotorValues
from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import NoJacobianError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.rates.allowed import AllowedJacobian
from pmjac_pin.rates.ellipsoid import Ellipsoid
from pmjac_pin.rates.jacobian import EquivalentJacobian
from pmjac_pin.rates.singularity import Singularity
from pmjac_pin.rates.split import SplitJacobian
from pmjac_pin.values.checks import check_kind
from pmjac_pin.values.encodable import encodable
from pmjac_pin.values.shown import Printed
from pmjac_pin.words.labelled import common_unit, unit
from pmjac_pin.words.labelled_matrix import LabelledMatrix, stacked
from pmjac_pin.words.labelled_values import (
    LabelledJoint,
    Labels,
    Quantity,
    determinant,
    joint_values,
    limits_told,
    parameters_told,
)
from pmjac_pin.words.load_report import LoadReport, load_told
from pmjac_pin.words.matrices import EQUIVALENT, matrices_of, parts_of
from pmjac_pin.words.plain import told
from pmjac_pin.words.rates_report import ellipsoid_told, singularity_told

_ELLIPSOIDS = ("velocity", "angular", "force")


class SingularValues(msgspec.Struct, frozen=True):
    """Singular values, descending; `unit` is None where rows or columns mix units."""

    values: list[float]
    unit: str | None


@dataclass(frozen=True, eq=False, repr=False)
class Report(Printed):
    """What is known of a mechanism at one pose. It prints, and in a notebook shows, all of it.

    Attributes
    ----------
    configuration : Configuration
    split : SplitJacobian
        In the frame of the report.
    jacobian : EquivalentJacobian or None
        None where it does not exist.
    refusal : str or None
        Why not.
    load : LoadReport
        What was asked for beside the pose: `motion`, `statics`, `dynamics`.
    pose : str or None
        The pose's name; None where motor values were asked for.
    start : str or None
        The named pose from which the motors were walked to those values.
    """

    configuration: Configuration
    split: SplitJacobian
    jacobian: EquivalentJacobian | None
    refusal: str | None
    load: LoadReport
    pose: str | None = None
    start: str | None = None

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism."""
        return self.configuration.mechanism

    @property
    def name(self) -> str:
        """The mechanism's name."""
        return encodable(self.mechanism.name)

    @property
    def notes(self) -> tuple[str, ...]:
        """What the reader of a file of another format decided."""
        return tuple(map(encodable, self.mechanism.notes))

    @property
    def singularity(self) -> Singularity:
        """The ranks here."""
        return self.configuration.singularity()

    @cached_property
    def labels(self) -> Labels:
        """The mechanism's."""
        return Labels.of(self.mechanism.problem.partition)

    @property
    def joints(self) -> tuple[LabelledJoint, ...]:
        """The values of all degrees of freedom, motors first."""
        return joint_values(self.configuration, self.labels)

    @property
    def residual(self) -> tuple[Quantity, ...]:
        """The p loop equations."""
        labels = self.labels
        units = map(unit, labels.equation_powers)
        values = self.configuration.residual.tolist()
        return tuple(map(Quantity, labels.equations, values, units))

    @property
    def det_K_star(self) -> Quantity | None:
        """The determinant of K*; None where K* is not square."""
        return determinant(self.split, self.labels)

    @cached_property
    def allowed(self) -> AllowedJacobian | None:
        """J_eq on the motor rates that fit each other, where the loops forbid others; else None."""
        if self.jacobian is not None or not self.singularity.forbidden_rates.shape[1]:
            return None
        try:
            found = self.configuration.allowed_jacobian(self.split.frame)
        except NoJacobianError:
            return None
        return found if found.leading else None

    @cached_property
    def matrices(self) -> dict[str, LabelledMatrix | None]:
        """The lecture's, by name; those from "passive_rates" on are None where J_eq is."""
        if self.jacobian is None:
            return {**matrices_of(self.split), **dict.fromkeys(EQUIVALENT)}
        return {**matrices_of(self.jacobian)}

    @property
    def singular_values(self) -> dict[str, SingularValues | None]:
        """Of "K_star" as shown, of "Jv_eq" and "Jw_eq"; None where J_eq does not exist."""
        rows = [self.labels.equation_powers[k] for k in self.split.rows]
        spectrum = np.linalg.svd(self.split.K_star, compute_uv=False).tolist()
        motors, ellipsoids = len(self.labels.actuated), self.ellipsoids
        return {
            "K_star": SingularValues(spectrum, common_unit(rows, self.labels.passive_powers)),
            "Jv_eq": _first_radii(ellipsoids["velocity"], motors),
            "Jw_eq": _first_radii(ellipsoids["angular"], motors),
        }

    @cached_property
    def ellipsoids(self) -> dict[str, Ellipsoid | None]:
        """The "velocity", "angular" and "force" ellipsoids; None where J_eq does not exist."""
        jacobian = self.jacobian
        if jacobian is None:
            return dict.fromkeys(_ELLIPSOIDS)
        return {name: getattr(jacobian, f"{name}_ellipsoid")() for name in _ELLIPSOIDS}

    def table(self, name: str) -> LabelledMatrix:
        """Return one matrix with names and units.

        Parameters
        ----------
        name : str
            "J_eq", or one of `matrices`: "K", "K_star", "Jv", "Jv_star", "Jw", "Jw_star",
            "passive_rates", "Jv_eq", "Jw_eq", "gv_eq", "gw_eq".

        Raises
        ------
        UnknownNameError
            No such matrix.
        NoJacobianError
            It does not exist here.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> table = pj.report(pj.load("four_bar").home).table("K_star")
        >>> table.rows, table.columns
        (('coupler_tip-rocker_tip x', 'coupler_tip-rocker_tip y'), ('phi1', 'phi2'))
        """
        parts = parts_of(name, self.matrices)
        found = [matrix for part in parts if (matrix := self.matrices[part]) is not None]
        if not found:
            raise NoJacobianError(f"{name} does not exist here: {self.refusal}")
        return reduce(stacked, found)

    def told(self) -> dict[str, object]:
        """Return all of it as plain data, with the dimensions in the lecture's letters."""
        mechanism, configuration, singularity = self.mechanism, self.configuration, self.singularity
        return {
            "mechanism": self.name,
            "description": mechanism.spec.description,
            "notes": self.notes,
            "parameters": parameters_told(mechanism),
            "dimensions": {
                "n": len(mechanism.actuated),
                "m_p": len(mechanism.passive),
                "p": len(mechanism.rows),
                "m": self.split.rows.size,
                **told(mechanism, "mobility", "nq", "nv"),
            },
            **told(self, "pose", "start"),
            "frame": self.split.frame,
            "joints": self.joints,
            "limits_violated": limits_told(configuration, self.labels),
            "iterations": configuration.iterations,
            "residual": self.residual,
            "residual_norm": configuration.residual_norm,
            "tool": configuration.tool_pose(),
            **told(self, "matrices", "det_K_star", "singular_values"),
            "singularity": singularity_told(singularity, mechanism.characteristic_length),
            "ellipsoids": {
                name: None if one is None else ellipsoid_told(one)
                for name, one in self.ellipsoids.items()
            },
            "refusal": self.refusal,
            **load_told(self.load),
        }


def report(
    configuration: Configuration,
    frame: str = "LOCAL_WORLD_ALIGNED",
    *,
    pose: str | None = None,
    start: str | None = None,
    rates: MotorValues | None = None,
    accelerations: MotorValues | None = None,
    wrench: ArrayLike | Mapping[str, float] | None = None,
    dynamics: bool = False,
) -> Report:
    """Collect what is known at a configuration.

    Complete at singular poses too: what does not exist there is None, and `refusal` says why. But
    where rates, a wrench or dynamics are asked for, there is all of that or an error.

    Parameters
    ----------
    configuration : Configuration
    frame : {"LOCAL_WORLD_ALIGNED", "LOCAL", "WORLD"}
        Frame of the tool's twist, with Pinocchio's meaning.
    pose : str, optional
        The pose's name, if it has one.
    start : str, optional
        The named pose from which the configuration was reached.
    rates, accelerations : array_like, shape (n,), or mapping of str to float, optional
        θ̇ and θ̈ of the motors, m or rad per s and s², 0 where only the other is given: `load.motion`
        is what follows.
    wrench : array_like, shape (6,), or mapping of str to float, optional
        On the tool: a force in N by the world's axes and a moment in N m about the tool's origin,
        or some of "fx", "fy", "fz", "mx", "my", "mz". `load.statics` balances it and the weight of
        the bodies.
    dynamics : bool
        Whether `load.dynamics` has mass matrix, gravity and bias, and `load.efforts` those of
        inverse dynamics, τ = M θ̈ + h − J_eqᵀ w.

    Raises
    ------
    ArgumentError, UnknownNameError
        No such frame, motor or component; other numbers than one for each.
    SingularError, ForbiddenRatesError, IdleMotionError
        Rates or dynamics are asked for, or a wrench, where `Configuration.motion`, `dynamics` or
        `statics` refuse them.
    NoInertiaError
        Dynamics of motors that move what has no mass.
    NoEquilibriumError
        The weight drives what idles.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> found = pj.report(pj.load("four_bar").home, pose="home")
    >>> found.matrices["K_star"].columns, found.det_K_star.unit
    (('phi1', 'phi2'), 'm²/rad²')
    >>> found = pj.report(pj.load("three_rps").home, wrench={"fz": -30.0})
    >>> found.load.statics.efforts.round(6).tolist()
    [11.547005, 11.547005, 11.547005]
    """
    check_kind(configuration, Configuration)
    split = configuration.split_jacobian(frame)
    load = LoadReport.of(
        configuration,
        frame,
        rates=rates,
        accelerations=accelerations,
        wrench=wrench,
        dynamics=dynamics,
    )
    try:
        jacobian, refusal = configuration.jacobian(frame), None
    except NoJacobianError as error:
        return Report(configuration, split, None, str(error), load, pose, start)
    return Report(configuration, split, jacobian, refusal, load, pose, start)


def _first_radii(ellipsoid: Ellipsoid | None, motors: int) -> SingularValues | None:
    if ellipsoid is None:
        return None
    return SingularValues(ellipsoid.radii[:motors].tolist(), ellipsoid.unit)
