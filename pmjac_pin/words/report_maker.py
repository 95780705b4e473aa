"""From a Configuration to its Report: the numbers are the Python interface's, unchanged."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import NoJacobianError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.rates.ellipsoid import Ellipsoid
from pmjac_pin.rates.jacobian import EquivalentJacobian, SplitJacobian
from pmjac_pin.values.encodable import encodable
from pmjac_pin.words.labelled import (
    ANGULAR,
    LINEAR,
    METRE,
    RADIAN,
    LabelledMatrix,
    Powers,
    common_unit,
    labelled,
    metric_unit,
    rate_unit,
    unit,
)
from pmjac_pin.words.labelled_values import (
    Labels,
    beyond_limits,
    determinant,
    joint_values,
    parameter_values,
    tool_pose,
    vector,
)
from pmjac_pin.words.report import (
    Dimensions,
    EllipsoidReport,
    Matrices,
    Quantity,
    Report,
    SingularityReport,
    SingularValues,
)

Array = NDArray[np.float64]


def make_report(
    configuration: Configuration,
    frame: str = "LOCAL_WORLD_ALIGNED",
    *,
    pose: str | None = None,
    start: str | None = None,
) -> Report:
    """Collect what is known at a configuration.

    Complete at singular poses too: what does not exist there is None, and `refusal` says why.

    Parameters
    ----------
    configuration : Configuration
    frame : {"LOCAL_WORLD_ALIGNED", "LOCAL", "WORLD"}
        Frame of the tool's twist, with Pinocchio's meaning.
    pose : str, optional
        The pose's name, if it has one.
    start : str, optional
        The named pose from which the configuration was reached.

    Raises
    ------
    ArgumentError
        No such frame.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> report = make_report(pj.load("four_bar").home, pose="home")
    >>> report.dimensions.m, report.matrices.K_star.columns, report.det_K_star.unit
    (2, ('phi1', 'phi2'), 'm²/rad²')
    """
    mechanism = configuration.mechanism
    labels = Labels.of(mechanism)
    split = configuration.split_jacobian(frame)
    jacobian, refusal = _equivalent(configuration, frame)
    return Report(
        mechanism=encodable(mechanism.name),
        description=mechanism.spec.description,
        notes=tuple(map(encodable, mechanism.notes)),
        parameters=parameter_values(mechanism),
        dimensions=_dimensions(mechanism, split),
        pose=pose,
        start=start,
        frame=split.frame,
        joints=joint_values(configuration, labels),
        limits_violated=beyond_limits(configuration, labels),
        iterations=configuration.iterations,
        residual=_residual(configuration, labels),
        residual_norm=configuration.residual_norm,
        tool=tool_pose(configuration),
        matrices=_matrices(split, jacobian, labels),
        det_K_star=determinant(split, labels),
        singular_values=_singular_values(split, jacobian, labels),
        singularity=_singularity(configuration),
        ellipsoids=_ellipsoids(jacobian),
        refusal=refusal,
    )


def _equivalent(
    configuration: Configuration, frame: str
) -> tuple[EquivalentJacobian | None, str | None]:
    try:
        return configuration.jacobian(frame), None
    except NoJacobianError as error:
        return None, str(error)


def _dimensions(mechanism: Mechanism, split: SplitJacobian) -> Dimensions:
    return Dimensions(
        n=len(mechanism.actuated),
        m_p=len(mechanism.passive),
        p=len(mechanism.rows),
        m=int(split.rows.size),
        mobility=mechanism.mobility,
        nq=mechanism.nq,
        nv=mechanism.nv,
    )


def _residual(configuration: Configuration, labels: Labels) -> tuple[Quantity, ...]:
    rows = zip(labels.equations, configuration.residual, labels.equation_powers, strict=True)
    return tuple(Quantity(name, float(value), unit(power)) for name, value, power in rows)


def _matrices(
    split: SplitJacobian, jacobian: EquivalentJacobian | None, labels: Labels
) -> Matrices:
    equations = tuple(labels.equations[k] for k in split.rows)
    equation_units = tuple(unit(labels.equation_powers[k]) for k in split.rows)
    motors = (labels.actuated, tuple(map(unit, labels.actuated_powers)))
    passive = (labels.passive, tuple(map(unit, labels.passive_powers)))
    motor_rates = (labels.actuated, tuple(map(rate_unit, labels.actuated_powers)))
    passive_rates = (labels.passive, tuple(map(rate_unit, labels.passive_powers)))
    linear = (LINEAR, (rate_unit(METRE),) * 3)
    angular = (ANGULAR, (rate_unit(RADIAN),) * 3)
    v, w = split.tool_sizes.tolist()
    size = float(np.abs(split.constraint_jacobian).max(initial=0.0))
    known = {
        "K": labelled(split.K, equations, equation_units, *motors, size=size),
        "K_star": labelled(split.K_star, equations, equation_units, *passive, size=size),
        "Jv": labelled(split.Jv, *linear, *motor_rates, size=v),
        "Jv_star": labelled(split.Jv_star, *linear, *passive_rates, size=v),
        "Jw": labelled(split.Jw, *angular, *motor_rates, size=w),
        "Jw_star": labelled(split.Jw_star, *angular, *passive_rates, size=w),
    }
    if jacobian is not None:
        v, w = jacobian.sizes.tolist()
        known |= {
            "passive_rates": labelled(jacobian.passive_rates, *passive_rates, *motor_rates),
            "Jv_eq": labelled(jacobian.Jv_eq, *linear, *motor_rates, size=v),
            "Jw_eq": labelled(jacobian.Jw_eq, *angular, *motor_rates, size=w),
            "gv_eq": _metric(jacobian.gv_eq, METRE, labels, v),
            "gw_eq": _metric(jacobian.gw_eq, RADIAN, labels, w),
        }
    return Matrices(**known)


def _metric(values: Array, twist: Powers, labels: Labels, size: float) -> LabelledMatrix:
    rows = tuple(metric_unit(twist, joint) for joint in labels.actuated_powers)
    columns = tuple(map(rate_unit, labels.actuated_powers))
    return labelled(values, labels.actuated, rows, labels.actuated, columns, size=size**2)


def _singular_values(
    split: SplitJacobian, jacobian: EquivalentJacobian | None, labels: Labels
) -> dict[str, SingularValues | None]:
    rows = [labels.equation_powers[k] for k in split.rows]
    K_star_unit = common_unit(rows, labels.passive_powers)
    found: dict[str, SingularValues | None] = {
        "K_star": SingularValues(_spectrum(split.K_star), K_star_unit),
        "Jv_eq": None,
        "Jw_eq": None,
    }
    if jacobian is not None:
        motors = len(labels.actuated)
        linear, angular = jacobian.velocity_ellipsoid(), jacobian.angular_ellipsoid()
        found["Jv_eq"] = SingularValues(vector(linear.radii[:motors]), linear.unit)
        found["Jw_eq"] = SingularValues(vector(angular.radii[:motors]), angular.unit)
    return found


def _singularity(configuration: Configuration) -> SingularityReport:
    singularity = configuration.singularity()
    actuated, passive = singularity.actuated_names, singularity.passive_names
    return SingularityReport(
        kind=singularity.kind,
        singular_values=vector(singularity.singular_values),
        smallest=singularity.smallest,
        condition=singularity.condition,
        tolerance=singularity.tolerance,
        characteristic_length=configuration.mechanism.characteristic_length,
        rank=singularity.rank,
        generic_rank=singularity.generic_rank,
        constraint_rank=singularity.constraint_rank,
        generic_constraint_rank=singularity.generic_constraint_rank,
        tool_rows=singularity.tool_rows.names,
        tool_axes=singularity.tool_rows.axes,
        tool_rank=singularity.tool_rank,
        generic_tool_rank=singularity.generic_tool_rank,
        idle=singularity.idle,
        gained=singularity.gained,
        lost=singularity.lost,
        free_motions=_by_name(passive, singularity.free_motions),
        idle_motions=_by_name(passive, singularity.idle_motions),
        forbidden_rates=_by_name(actuated, singularity.forbidden_rates),
    )


def _ellipsoids(jacobian: EquivalentJacobian | None) -> dict[str, EllipsoidReport | None]:
    if jacobian is None:
        return {"velocity": None, "angular": None, "force": None}
    return {
        "velocity": _ellipsoid(jacobian.velocity_ellipsoid()),
        "angular": _ellipsoid(jacobian.angular_ellipsoid()),
        "force": _ellipsoid(jacobian.force_ellipsoid()),
    }


def _ellipsoid(ellipsoid: Ellipsoid) -> EllipsoidReport:
    directions = tuple(map(vector, ellipsoid.axes.T))
    return EllipsoidReport(ellipsoid.unit, ellipsoid.rank, vector(ellipsoid.radii), directions)


def _spectrum(matrix: Array) -> tuple[float, ...]:
    return vector(np.linalg.svd(matrix, compute_uv=False)) if matrix.size else ()


def _by_name(names: tuple[str, ...], columns: Array) -> tuple[dict[str, float], ...]:
    return tuple(dict(zip(names, vector(column), strict=True)) for column in columns.T)
