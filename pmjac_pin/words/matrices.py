"""The lecture's matrices with the names and units of their rows and columns."""

from __future__ import annotations

import numpy as np

from pmjac_pin.rates.jacobian import EquivalentJacobian
from pmjac_pin.rates.split import SplitJacobian
from pmjac_pin.values.arrays import Array
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
from pmjac_pin.words.labelled_matrix import LabelledMatrix, labelled
from pmjac_pin.words.labelled_values import Labels

EQUIVALENT = ("passive_rates", "Jv_eq", "Jw_eq", "gv_eq", "gw_eq")


def split_matrices(split: SplitJacobian, labels: Labels) -> dict[str, LabelledMatrix]:
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


def equivalent_matrices(jacobian: EquivalentJacobian, labels: Labels) -> dict[str, LabelledMatrix]:
    """Return those after it: what there is where J_eq exists, `EQUIVALENT`."""
    motor_rates, passive_rates, linear, angular = _rate_labels(labels)
    v, w = jacobian.sizes.tolist()
    return {
        "passive_rates": labelled(jacobian.passive_rates, *passive_rates, *motor_rates),
        "Jv_eq": labelled(jacobian.Jv_eq, *linear, *motor_rates, size=v),
        "Jw_eq": labelled(jacobian.Jw_eq, *angular, *motor_rates, size=w),
        "gv_eq": _metric(jacobian.gv_eq, METRE, labels, v),
        "gw_eq": _metric(jacobian.gw_eq, RADIAN, labels, w),
    }


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
