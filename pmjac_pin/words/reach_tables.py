"""What `reach` and `working_modes` found, as plain data and as tables."""

from __future__ import annotations

from collections.abc import Iterator

from pmjac_pin.configuration import Configuration
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.reach.reached import Reached
from pmjac_pin.studies.reach.working_modes import WorkingModes
from pmjac_pin.values.brief import brief
from pmjac_pin.words.blocks import Block, Heading, Paragraph, Table
from pmjac_pin.words.numbers import matrix_numbers
from pmjac_pin.words.plain import told


def reached_told(found: Reached) -> dict[str, object]:
    """Return what is known of an answer as plain data."""
    return {
        **told(found, "status", "message", "share", "joints"),
        "mechanism": found.configuration.mechanism.name,
        "error": {"linear": found.error.linear, "angular": found.error.angular},
        "actuated": _values_by_motor(found.configuration),
        "pose": found.configuration.tool_pose(),
        "q": found.configuration.q,
        "evidence": found.evidence,
    }


def working_modes_told(mechanism: Mechanism, modes: WorkingModes) -> dict[str, object]:
    """Return the working modes as plain data."""
    return {
        "mechanism": mechanism.name,
        "evidence": modes.evidence,
        "starts": modes.starts,
        "modes": [{"actuated": _values_by_motor(one), "q": one.q} for one in modes],
    }


def reached_blocks(found: Reached) -> Iterator[Block]:
    """Show the motor values of an answer, and how far from the target they are."""
    pose = found.configuration
    yield Heading(f"{pose.mechanism.name}: {found.status}")
    yield Paragraph(f"{found.message[0].upper()}{found.message[1:]}.")
    yield _motor_table(pose.mechanism, [pose], ["value"])
    miss = found.error
    yield Paragraph(f"From the target: {brief(miss.linear)} m and {brief(miss.angular)} rad.")
    yield Paragraph(f"{found.evidence}.")


def working_modes_blocks(modes: WorkingModes) -> Iterator[Block]:
    """Show the motor values of all working modes."""
    count = len(modes)
    title = f"{count} working mode{'s' * (count != 1)}"
    if count:
        mechanism = modes[0].mechanism
        yield Heading(f"{mechanism.name}: {title}")
        yield _motor_table(mechanism, list(modes), [str(k) for k in range(1, count + 1)])
    else:
        yield Heading(title)
    yield Paragraph(f"{modes.evidence}.")


def _motor_table(mechanism: Mechanism, poses: list[Configuration], names: list[str]) -> Table:
    """Return a row a pose, a column a motor."""
    units = mechanism.units
    columns = tuple(f"{name} [{units[name]}]" for name in mechanism.actuated)
    values = matrix_numbers([pose.actuated.tolist() for pose in poses], size=1.0)
    rows = tuple((name, *row) for name, row in zip(names, values, strict=True))
    return Table("Motors", ("", *columns), rows, "<" + ">" * len(columns))


def _values_by_motor(pose: Configuration) -> dict[str, float]:
    return dict(zip(pose.mechanism.actuated, pose.actuated.tolist(), strict=True))
