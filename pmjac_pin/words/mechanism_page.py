"""A mechanism on a page: what moves it, what closes it, its sizes."""

from __future__ import annotations

from collections.abc import Iterator

from pmjac_pin.mechanism import Mechanism
from pmjac_pin.words.blocks import Block, Heading, Paragraph, Table
from pmjac_pin.words.numbers import matrix_numbers
from pmjac_pin.words.tables import parameters_table, sizes_line


def mechanism_blocks(mechanism: Mechanism) -> Iterator[Block]:
    """Show a mechanism: its degrees of freedom with their limits, parameters, loops and poses."""
    yield Heading(mechanism.name)
    if description := mechanism.spec.description:
        yield Paragraph(description)
    for note in mechanism.notes:
        yield Paragraph(f"Note: {note}")
    rank = mechanism.problem.partition.constraint_rank
    yield Paragraph(sizes_line(mechanism, f"rank of [K K*] {rank}"))
    yield _freedoms_table(mechanism)
    if mechanism.parameters:
        yield parameters_table(mechanism)
    if mechanism.spec.loops:
        yield _loops_table(mechanism)
    yield Paragraph(f"Poses: {', '.join(mechanism.poses)}. Tool: {_tool_text(mechanism)}.")


def _freedoms_table(mechanism: Mechanism) -> Table:
    home, units = mechanism.home, mechanism.units
    values = [*home.actuated.tolist(), *home.passive.tolist()]
    names = mechanism.actuated + mechanism.passive
    rows = []
    for number, (name, value) in enumerate(zip(names, values, strict=True)):
        role = "actuated" if number < len(mechanism.actuated) else "passive"
        size = 1.0 if units[name] == "rad" else mechanism.characteristic_length
        [told] = matrix_numbers([[*mechanism.limits(name), value]], size)
        rows.append((name, role, *told, units[name]))
    header = ("name", "role", "lower", "upper", "home", "unit")
    return Table("Degrees of freedom", header, tuple(rows), "<<>>><")


def _loops_table(mechanism: Mechanism) -> Table:
    slices = mechanism.kinematics.loops.slices
    rows = tuple(
        (" – ".join(loop.ends), str(loop.__struct_config__.tag), str(rows.stop - rows.start))
        for loop, rows in zip(mechanism.spec.loops, slices, strict=True)
    )
    return Table("Loops", ("between", "kind", "equations"), rows, "<<>")


def _tool_text(mechanism: Mechanism) -> str:
    tool = mechanism.spec.tool
    if tool.is_none:
        return "none is named"
    return f"{', '.join(tool.names)}, judged on {tool.judged}"
