"""LoadReport: what moves and loads a pose, as far as it was asked for, with names and units."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import msgspec
import numpy as np
from numpy.typing import ArrayLike

from pmjac_pin.closing.motor_values import MotorValues
from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.model.inertias import massless
from pmjac_pin.rates.dynamics import Dynamics
from pmjac_pin.rates.motion import Motion
from pmjac_pin.rates.motor_limits import stated_effort_limits
from pmjac_pin.rates.statics import Statics
from pmjac_pin.values.arrays import Array, read_only
from pmjac_pin.values.checks import as_flag, as_vector
from pmjac_pin.values.named_values import named_values
from pmjac_pin.words.labelled import ANGULAR, LINEAR, Powers, force_unit, powers_of, unit
from pmjac_pin.words.labelled_matrix import LabelledMatrix, labelled
from pmjac_pin.words.labelled_values import Labels, Quantity

WRENCH = ("fx", "fy", "fz", "mx", "my", "mz")
"""A force by the world's axes, N, and a moment about the tool's origin, N m."""
WRENCH_UNITS = ("N",) * 3 + ("N m",) * 3
WRENCH_FRAME = "LOCAL_WORLD_ALIGNED"

_TWIST_RATES = ("a_x", "a_y", "a_z", "α_x", "α_y", "α_z")
_BEYOND = 1e-9  # of a limit: more than rounding


class MotorEffort(msgspec.Struct, frozen=True):
    """A motor's effort; `limit` is None where the model states none."""

    name: str
    value: float
    unit: str
    limit: float | None

    @property
    def is_beyond(self) -> bool:
        """Whether it is more than the motor may exert."""
        return self.limit is not None and abs(self.value) > self.limit * (1.0 + _BEYOND)


@dataclass(frozen=True, eq=False)
class LoadReport:
    """The answers to what a report was asked beside the pose; each None where it was not.

    Attributes
    ----------
    configuration : Configuration
    motion : Motion or None
    wrench : ndarray, shape (6,), or None
        `WRENCH`, in `WRENCH_FRAME`.
    statics : Statics or None
        What balances it at rest, beside the bodies' weight.
    dynamics : Dynamics or None
        At the rates of `motion`.
    efforts : ndarray, shape (n,), or None
        Of inverse dynamics: for the accelerations of `motion`, under `wrench`.
    weightless : tuple of str
        The joints whose bodies have no mass.
    """

    configuration: Configuration
    motion: Motion | None
    wrench: Array | None
    statics: Statics | None
    dynamics: Dynamics | None
    efforts: Array | None
    weightless: tuple[str, ...]

    @classmethod
    def of(
        cls,
        configuration: Configuration,
        frame: str,
        *,
        rates: MotorValues | None,
        accelerations: MotorValues | None,
        wrench: object | None,
        dynamics: bool,
    ) -> LoadReport:
        """Compute what is asked for: raises what the configuration's own methods raise."""
        moving = rates is not None or accelerations is not None
        still = np.zeros(len(configuration.mechanism.actuated))
        driving: MotorValues = still if rates is None else rates
        motion = configuration.motion(driving, accelerations, frame) if moving else None
        given = None if wrench is None else as_wrench(wrench)
        known = configuration.dynamics(driving) if as_flag(dynamics, "dynamics") else None
        wanted = still if motion is None else motion.accelerations
        return cls(
            configuration=configuration,
            motion=motion,
            wrench=given,
            statics=None if given is None else configuration.statics(given),
            dynamics=known,
            efforts=None if known is None else known.efforts(wanted, given),
            weightless=massless(configuration.mechanism.kinematics.model),
        )

    @property
    def labels(self) -> Labels:
        """The mechanism's."""
        return Labels.of(self.configuration.mechanism.problem.partition)


def as_wrench(given: object) -> Array:
    """Return a wrench (6,): six numbers, or some of them by the names of `WRENCH`.

    Raises
    ------
    ArgumentError
        Another number of values, or other names.

    Examples
    --------
    >>> as_wrench({"fz": -30.0}).tolist()
    [0.0, 0.0, -30.0, 0.0, 0.0, 0.0]
    """
    if (by_name := named_values(given, "a wrench")) is None:
        values: ArrayLike = given  # type: ignore[assignment]  # checked next
        return read_only(as_vector(values, len(WRENCH), "a wrench"))
    if unknown := [name for name in by_name if name not in WRENCH]:
        raise ArgumentError(f"a wrench has {', '.join(WRENCH)}; got {quoted(unknown[0])}")
    return read_only(as_vector([by_name.get(name, 0.0) for name in WRENCH], 6, "a wrench"))


def motor_efforts(configuration: Configuration, efforts: Array) -> tuple[MotorEffort, ...]:
    """Return efforts (n,) with the motors' names, units and limits."""
    partition = configuration.mechanism.problem.partition
    limits = stated_effort_limits(partition).tolist()
    powers = powers_of(partition.units_of(partition.actuated))
    rows = zip(partition.actuated_names, efforts.tolist(), powers, limits, strict=True)
    return tuple(
        MotorEffort(name, value, force_unit(power), limit if limit < np.inf else None)
        for name, value, power, limit in rows
    )


def loop_forces(statics: Statics, labels: Labels) -> tuple[Quantity, ...]:
    """Return the forces in the loops by the names of their equations."""
    units = map(force_unit, labels.equation_powers)
    return tuple(map(Quantity, labels.equations, statics.loop_forces.tolist(), units))


def mass_matrix(dynamics: Dynamics, labels: Labels) -> LabelledMatrix:
    """Return M: efforts by accelerations."""
    names, powers = labels.actuated, labels.actuated_powers
    columns = tuple(f"{unit(power)}/s²" for power in powers)
    efforts = tuple(map(force_unit, powers))
    return labelled(dynamics.mass_matrix, names, efforts, names, columns)


def load_told(report: LoadReport) -> dict[str, object]:
    """Return what is told of it: `motion`, `statics` and `dynamics`, None where not asked for."""
    return {
        "motion": report.motion and _motion_told(report.motion, report.labels),
        "statics": report.statics and _statics_told(report, report.statics),
        "dynamics": report.dynamics and _dynamics_told(report, report.dynamics),
    }


def _motion_told(motion: Motion, labels: Labels) -> dict[str, object]:
    motors, passive = labels.actuated_powers, labels.passive_powers
    return {
        "frame": motion.jacobian.frame,
        "rates": _rates_told(labels.actuated, motion.rates, motors, "/s"),
        "accelerations": _rates_told(labels.actuated, motion.accelerations, motors, "/s²"),
        "passive_rates": _rates_told(labels.passive, motion.passive_rates, passive, "/s"),
        "passive_accelerations": _rates_told(
            labels.passive, motion.passive_accelerations, passive, "/s²"
        ),
        "twist": _quantities(LINEAR + ANGULAR, motion.twist, _twist_units("/s")),
        "acceleration": _quantities(_TWIST_RATES, motion.acceleration, _twist_units("/s²")),
    }


def _statics_told(report: LoadReport, statics: Statics) -> dict[str, object]:
    return {
        "frame": WRENCH_FRAME,
        "wrench": None if report.wrench is None else wrench_told(report.wrench),
        "weightless": report.weightless,
        "efforts": motor_efforts(report.configuration, statics.efforts),
        "loop_forces": loop_forces(statics, report.labels),
        "determinate": statics.determinate,
        "self_stress": statics.self_stress.T,
        "internal_efforts": statics.internal_efforts.T,
    }


def _dynamics_told(report: LoadReport, dynamics: Dynamics) -> dict[str, object]:
    labels, efforts = report.labels, report.efforts
    units = [force_unit(power) for power in labels.actuated_powers]
    return {
        "mass_matrix": mass_matrix(dynamics, labels),
        "gravity": _quantities(labels.actuated, dynamics.gravity, units),
        "bias": _quantities(labels.actuated, dynamics.bias, units),
        "kinetic_energy": Quantity("kinetic energy", dynamics.kinetic_energy, "J"),
        "efforts": None if efforts is None else motor_efforts(report.configuration, efforts),
    }


def wrench_told(wrench: Array) -> tuple[Quantity, ...]:
    """Return the components of a wrench."""
    return _quantities(WRENCH, wrench, WRENCH_UNITS)


def _twist_units(per: str) -> tuple[str, ...]:
    return (f"m{per}",) * 3 + (f"rad{per}",) * 3


def _rates_told(
    names: Sequence[str], values: Array, powers: Sequence[Powers], per: str
) -> tuple[Quantity, ...]:
    return _quantities(names, values, [f"{unit(power)}{per}" for power in powers])


def _quantities(names: Iterable[str], values: Array, units: Iterable[str]) -> tuple[Quantity, ...]:
    return tuple(map(Quantity, names, values.tolist(), units))
