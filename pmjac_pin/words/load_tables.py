"""What moves and loads a pose, as headings, paragraphs and tables with units."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from pmjac_pin.errors import enumerated
from pmjac_pin.rates.dynamics import Dynamics
from pmjac_pin.rates.motion import Motion
from pmjac_pin.rates.statics import Statics
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.brief import brief
from pmjac_pin.words.blocks import Block, Heading, Paragraph, Table
from pmjac_pin.words.labelled import force_unit, unit
from pmjac_pin.words.labelled_values import Labels
from pmjac_pin.words.load_report import (
    LoadReport,
    MotorEffort,
    loop_forces,
    mass_matrix,
    motor_efforts,
    wrench_told,
)
from pmjac_pin.words.numbers import matrix_numbers

_NO_LIMIT = "none stated"
_AXES = ("linear x", "linear y", "linear z", "angular x", "angular y", "angular z")


def load_blocks(report: LoadReport) -> Iterator[Block]:
    """Show what was asked for: motion, statics, dynamics."""
    if report.motion is not None:
        yield from _motion_blocks(report.motion, report.labels)
    if report.statics is not None:
        yield from _statics_blocks(report, report.statics)
    if report.dynamics is not None:
        yield from _dynamics_blocks(report, report.dynamics)


def _motion_blocks(motion: Motion, labels: Labels) -> Iterator[Block]:
    yield Heading("Motion")
    joints = [
        *_joint_rows(labels.actuated, "actuated", labels, motion.rates, motion.accelerations),
        *_joint_rows(
            labels.passive, "passive", labels, motion.passive_rates, motion.passive_accelerations
        ),
    ]
    header = ("joint", "role", "rate", "unit", "acceleration", "unit")
    yield Table("Rates and accelerations of the joints", header, tuple(joints), "<<><><")
    columns = [_column(motion.twist), _column(motion.acceleration)]
    tool = tuple(
        (axis, twist, f"{length}/s", rate, f"{length}/s²")
        for axis, length, twist, rate in zip(_AXES, ["m"] * 3 + ["rad"] * 3, *columns, strict=True)
    )
    yield Table(
        f"Tool, frame {motion.jacobian.frame}",
        ("", "twist", "unit", "its rate", "unit"),
        tool,
        "<><><",
    )


def _joint_rows(
    names: Sequence[str], role: str, labels: Labels, rates: Array, accelerations: Array
) -> Iterator[tuple[str, ...]]:
    powers = labels.actuated_powers if role == "actuated" else labels.passive_powers
    rows = zip(names, powers, _column(rates), _column(accelerations), strict=True)
    for name, power, rate, acceleration in rows:
        yield name, role, rate, f"{unit(power)}/s", acceleration, f"{unit(power)}/s²"


def _statics_blocks(report: LoadReport, statics: Statics) -> Iterator[Block]:
    yield Heading("Statics")
    wrench = () if report.wrench is None else wrench_told(report.wrench)
    acting = ", ".join(f"{one.name} = {one.value:.6g} {one.unit}" for one in wrench if one.value)
    about = "a force by the world's axes and a moment about the tool's origin"
    load = f"On the tool acts {acting} ({about})" if acting else "No wrench acts on the tool"
    yield Paragraph(f"{load}, beside the weight of the bodies.{_weightless(report.weightless)}")
    efforts = motor_efforts(report.configuration, statics.efforts)
    yield from _efforts_blocks("Motor efforts that balance it", efforts)
    if count := statics.internal_efforts.shape[1]:
        yield Paragraph(
            f"These are the smallest: motors may work against each other in {_ways_text(count)}."
        )
    if forces := loop_forces(statics, report.labels):
        numbers = _column(statics.loop_forces)
        rows = tuple(
            (one.name, number, one.unit) for one, number in zip(forces, numbers, strict=True)
        )
        header = ("equation", "force", "unit")
        yield Table("Forces in the loops, on what opens them", header, rows, "<><")
    if count := statics.self_stress.shape[1]:
        yield Paragraph(
            f"These are the smallest: equilibrium does not say what redundant rows do to each "
            f"other, in {_ways_text(count)}."
        )


def _dynamics_blocks(report: LoadReport, dynamics: Dynamics) -> Iterator[Block]:
    labels = report.labels
    yield Heading("Dynamics")
    yield mass_matrix(dynamics, labels).block("Mass matrix M (efforts by motor accelerations)")
    numbers = (_column(dynamics.gravity), _column(dynamics.bias))
    units = map(force_unit, labels.actuated_powers)
    yield Table(
        f"Gravity, and bias h: with gravity, what the rates ask for (kinetic energy "
        f"{brief(dynamics.kinetic_energy)} J)",
        ("motor", "gravity", "bias", "unit"),
        tuple(zip(labels.actuated, *numbers, units, strict=True)),
        "<>><",
    )
    if report.efforts is not None:
        under = "under the wrench" if report.wrench is not None else "without a wrench"
        heading = f"Motor efforts τ = M θ̈ + h − J_eqᵀ w, {under}"
        yield from _efforts_blocks(heading, motor_efforts(report.configuration, report.efforts))


def _efforts_blocks(heading: str, efforts: Sequence[MotorEffort]) -> Iterator[Block]:
    numbers = _column(np.array([one.value for one in efforts]))
    rows = tuple(
        (one.name, number, _NO_LIMIT if one.limit is None else brief(one.limit), one.unit)
        for one, number in zip(efforts, numbers, strict=True)
    )
    yield Table(heading, ("motor", "effort", "limit", "unit"), rows, "<>><")
    if beyond := [one.name for one in efforts if one.is_beyond]:
        yield Paragraph(f"Warning: more than the limit of {enumerated(beyond)}.")


def _weightless(names: tuple[str, ...]) -> str:
    if not names:
        return ""
    return f" The model gives no mass to the bodies of {enumerated(names)}: they weigh nothing."


def _ways_text(count: int) -> str:
    return "one way" if count == 1 else f"{count} independent ways"


def _column(values: Iterable[float]) -> list[str]:
    return [number for [number] in matrix_numbers([[float(value)] for value in values])]
