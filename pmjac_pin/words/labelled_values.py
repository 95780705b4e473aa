"""Values of a mechanism and of a pose with their names and units, for every report."""

from __future__ import annotations

from dataclasses import dataclass

import msgspec
from msgspec.structs import asdict

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.rates.partition import Partition
from pmjac_pin.rates.split import SplitJacobian
from pmjac_pin.values.arrays import Array
from pmjac_pin.words.labelled import Powers, powers_of, quotient, unit
from pmjac_pin.words.plain import told


class Quantity(msgspec.Struct, frozen=True):
    """A number with its unit."""

    name: str
    value: float
    unit: str


class LabelledJoint(msgspec.Struct, frozen=True):
    """The value of one degree of freedom; its role is "actuated" or "passive"."""

    name: str
    role: str
    value: float
    unit: str


@dataclass(frozen=True, slots=True)
class Labels:
    """Names and units of one mechanism's motors, passive joints and loop equations."""

    actuated: tuple[str, ...]
    passive: tuple[str, ...]
    equations: tuple[str, ...]
    actuated_powers: tuple[Powers, ...]
    passive_powers: tuple[Powers, ...]
    equation_powers: tuple[Powers, ...]

    @classmethod
    def of(cls, partition: Partition) -> Labels:
        """Return the labels of a mechanism's columns and rows.

        Raises
        ------
        ArgumentError
            Matrices from elsewhere have none.
        """
        if len(partition.units) != partition.column_scale.size:
            raise ArgumentError("matrices from elsewhere have no names and units for a table")
        return cls(
            partition.actuated_names,
            partition.passive_names,
            partition.row_names,
            powers_of(partition.units_of(partition.actuated)),
            powers_of(partition.units_of(partition.passive)),
            powers_of(partition.row_units),
        )


def parameters_told(mechanism: Mechanism) -> list[dict[str, object]]:
    """Return what is told of the parameters of a mechanism."""
    declared = mechanism.spec.parameters
    return [
        {"name": name, "value": value, **told(declared[name], "unit", "meaning", "default")}
        for name, value in mechanism.parameters.items()
    ]


def labelled_motor_values(values: Array, labels: Labels) -> tuple[LabelledJoint, ...]:
    """Return the values (n,) of the actuated degrees of freedom."""
    return _joint_values(values, labels.actuated, labels.actuated_powers, "actuated")


def joint_values(configuration: Configuration, labels: Labels) -> tuple[LabelledJoint, ...]:
    """Return the values of all degrees of freedom, motors first."""
    passive = (labels.passive, labels.passive_powers, "passive")
    motors = labelled_motor_values(configuration.actuated, labels)
    return motors + _joint_values(configuration.passive, *passive)


def limits_told(configuration: Configuration, labels: Labels) -> list[dict[str, object]]:
    """Return what is told of the joints outside their limits, motors first."""
    found = configuration.limits_violated
    return [
        asdict(joint) | told(found[joint.name], "lower", "upper")
        for joint in joint_values(configuration, labels)
        if joint.name in found
    ]


def _joint_values(
    values: Array, names: tuple[str, ...], powers: tuple[Powers, ...], role: str
) -> tuple[LabelledJoint, ...]:
    joints = zip(names, values.tolist(), powers, strict=True)
    return tuple(LabelledJoint(name, role, value, unit(power)) for name, value, power in joints)


def determinant(split: SplitJacobian, labels: Labels) -> Quantity | None:
    """Return det K* with its unit, None where K* is not square."""
    value = split.det_K_star
    if value is None:
        return None
    rows = (labels.equation_powers[k] for k in split.rows)
    return Quantity("det K*", value, unit(quotient(rows, labels.passive_powers)))
