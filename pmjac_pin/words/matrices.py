"""The lecture's matrices with the names and units of their rows and columns."""

from __future__ import annotations

from collections.abc import Mapping
from functools import reduce

import numpy as np

from pmjac_pin.errors import UnknownNameError, did_you_mean, quoted
from pmjac_pin.rates.allowed import AllowedJacobian
from pmjac_pin.rates.jacobian import EquivalentJacobian
from pmjac_pin.rates.split import SplitJacobian
from pmjac_pin.rates.twist_map import TwistMap
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import check_kind
from pmjac_pin.words.labelled import (
    ANGULAR,
    LINEAR,
    METRE,
    RADIAN,
    Powers,
    metric_unit,
    rate_unit,
    unit,
)
from pmjac_pin.words.labelled_matrix import LabelledMatrix, labelled, stacked
from pmjac_pin.words.labelled_values import Labels

#: What there is where J_eq exists.
EQUIVALENT = ("passive_rates", "Jv_eq", "Jw_eq", "gv_eq", "gw_eq")


def table_of(jacobian: SplitJacobian, name: str) -> LabelledMatrix:
    """Return one of the matrices of a Jacobian with names and units.

    Raises
    ------
    UnknownNameError
        No such matrix.
    ArgumentError
        Matrices from elsewhere have no names and units.
    """
    found = matrices_of(jacobian)
    return reduce(stacked, [found[part] for part in parts_of(name, found)])


def parts_of(name: str, matrices: Mapping[str, object]) -> tuple[str, ...]:
    """Return the names of the matrices, one above the other, that have this name.

    Raises
    ------
    UnknownNameError
        There is none.
    """
    check_kind(name, str)
    if name in matrices:
        return (name,)
    whole = ("J_eq",) if "Jv_eq" in matrices else ()
    if name not in whole:
        known = (*whole, *matrices)
        raise UnknownNameError(f"no matrix {quoted(name)}{did_you_mean(name, known)}")
    return ("Jv_eq", "Jw_eq")


def matrices_of(jacobian: SplitJacobian) -> dict[str, LabelledMatrix]:
    """Return all matrices of a Jacobian, by name.

    Raises
    ------
    ArgumentError
        Matrices from elsewhere have no names and units.
    """
    labels = Labels.of(jacobian.partition)
    found = _split_matrices(jacobian, labels)
    return found | _twist_matrices(jacobian, labels) if isinstance(jacobian, TwistMap) else found


def _split_matrices(split: SplitJacobian, labels: Labels) -> dict[str, LabelledMatrix]:
    """Return the matrices before the passive rates are eliminated, by name."""
    equations = (
        tuple(labels.equations[k] for k in split.rows),
        tuple(unit(labels.equation_powers[k]) for k in split.rows),
    )
    motors = (labels.actuated, tuple(map(unit, labels.actuated_powers)))
    passive = (labels.passive, tuple(map(unit, labels.passive_powers)))
    motor_rates, passive_rates, linear, angular = _rate_labels(labels)
    v, w = split.tool_sizes.tolist()
    size = float(np.abs(split.constraint_jacobian).max(initial=0.0))
    return {
        "K": labelled(split.K, *equations, *motors, size=size),
        "K_star": labelled(split.K_star, *equations, *passive, size=size),
        "Jv": labelled(split.Jv, *linear, *motor_rates, size=v),
        "Jv_star": labelled(split.Jv_star, *linear, *passive_rates, size=v),
        "Jw": labelled(split.Jw, *angular, *motor_rates, size=w),
        "Jw_star": labelled(split.Jw_star, *angular, *passive_rates, size=w),
    }


def _twist_matrices(jacobian: TwistMap, labels: Labels) -> dict[str, LabelledMatrix]:
    """Return those after it, by the rates of all motors, or of those that lead others."""
    motor_rates, passive_rates, linear, angular = _rate_labels(labels)
    leading, (v, w) = motor_rates, jacobian.sizes.tolist()
    found = {}
    if isinstance(jacobian, AllowedJacobian):
        units = dict(zip(*motor_rates, strict=True))
        leading = (jacobian.leading, tuple(units[name] for name in jacobian.leading))
        found["motor_rates"] = labelled(jacobian.motor_rates, *motor_rates, *leading)
    found["passive_rates"] = labelled(jacobian.passive_rates, *passive_rates, *leading)
    found["Jv_eq"] = labelled(jacobian.Jv_eq, *linear, *leading, size=v)
    found["Jw_eq"] = labelled(jacobian.Jw_eq, *angular, *leading, size=w)
    if isinstance(jacobian, EquivalentJacobian):
        found["gv_eq"] = _metric(jacobian.gv_eq, METRE, labels, v)
        found["gw_eq"] = _metric(jacobian.gw_eq, RADIAN, labels, w)
    return found


def _rate_labels(labels: Labels) -> tuple[tuple[tuple[str, ...], tuple[str, ...]], ...]:
    """Return names and units of the rates of motors and passive joints, and of the tool's."""
    return (
        (labels.actuated, tuple(map(rate_unit, labels.actuated_powers))),
        (labels.passive, tuple(map(rate_unit, labels.passive_powers))),
        (LINEAR, (rate_unit(METRE),) * 3),
        (ANGULAR, (rate_unit(RADIAN),) * 3),
    )


def _metric(values: Array, twist: Powers, labels: Labels, size: float) -> LabelledMatrix:
    rows = tuple(metric_unit(twist, joint) for joint in labels.actuated_powers)
    columns = tuple(map(rate_unit, labels.actuated_powers))
    return labelled(values, labels.actuated, rows, labels.actuated, columns, size=size**2)
