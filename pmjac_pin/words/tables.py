"""A report as headings, paragraphs and tables with units, in the lecture's order."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

from pmjac_pin.configuration import Configuration
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.rates.ellipsoid import Ellipsoid
from pmjac_pin.values.brief import brief
from pmjac_pin.words.blocks import Block, Heading, Paragraph, Table
from pmjac_pin.words.labelled_matrix import LabelledMatrix
from pmjac_pin.words.labelled_values import LabelledJoint
from pmjac_pin.words.load_tables import load_blocks
from pmjac_pin.words.matrices import matrices_of
from pmjac_pin.words.numbers import matrix_numbers, number
from pmjac_pin.words.report import Report
from pmjac_pin.words.singularity_tables import singularity_blocks

TITLES = {
    "K": "K = ∂η/∂θ (loop equations by motors)",
    "K_star": "K* = ∂η/∂φ (loop equations by passive joints)",
    "Jv": "J_v (linear velocity of the tool by motor rates, cut tree)",
    "Jv_star": "J_v* (linear velocity by passive rates, cut tree)",
    "Jw": "J_ω (angular velocity by motor rates, cut tree)",
    "Jw_star": "J_ω* (angular velocity by passive rates, cut tree)",
    "passive_rates": "Φ = −K*⁻¹ K (passive rates by motor rates)",
    "Jv_eq": "[J_v]eq = J_v − J_v* K*⁻¹ K (linear velocity by motor rates, loops closed)",
    "Jw_eq": "[J_ω]eq = J_ω − J_ω* K*⁻¹ K (angular velocity by motor rates, loops closed)",
    "gv_eq": "g_v = [J_v]eqᵀ [J_v]eq",
    "gw_eq": "g_ω = [J_ω]eqᵀ [J_ω]eq",
}

ALLOWED_TITLES = {
    "motor_rates": "A = ∂θ̇/∂u (rates of all motors by those that lead)",
    "Jv_eq": "[J_v]eq (linear velocity by rates of the motors that lead, loops closed)",
    "Jw_eq": "[J_ω]eq (angular velocity by rates of the motors that lead, loops closed)",
}

SYMBOLS = {"K_star": "K*", "Jv_eq": "[J_v]eq", "Jw_eq": "[J_ω]eq"}

ELLIPSOIDS = {
    "velocity": "Linear velocity of the tool, all motor rates together of length 1",
    "angular": "Angular velocity of the tool, all motor rates together of length 1",
    "force": "Force at the tool that motor efforts of length 1 together can hold",
}

LEGEND = "The unit of an entry is its row's unit over its column's."


def report_blocks(report: Report) -> Iterator[Block]:
    """Show all of a report."""
    yield Heading(title(report))
    if description := report.mechanism.spec.description:
        yield Paragraph(description)
    if report.notes:
        yield Paragraph("\n".join(f"Note: {note}" for note in report.notes))
    independent = f"m = {report.split.rows.size} of them independent"
    yield Paragraph(sizes_line(report.mechanism, independent))
    yield Paragraph(_origin_line(report))
    if report.configuration.limits_violated:
        yield Paragraph(limits_warning(report.configuration))
    yield from _pose_blocks(report)
    yield Heading("Loop closure and tool Jacobian")
    yield Paragraph(LEGEND)
    yield from matrix_blocks(report, ("K", "K_star"))
    yield from matrix_blocks(report, ("Jv", "Jv_star", "Jw", "Jw_star"))
    yield Heading("Equivalent Jacobian")
    if report.refusal:
        yield Paragraph(f"J_eq does not exist here: {report.refusal}")
    if report.mechanism.passive:
        yield from matrix_blocks(report, ("passive_rates", "Jv_eq", "Jw_eq"))
    else:
        yield Paragraph("Nothing is passive: [J_v]eq = J_v and [J_ω]eq = J_ω.")
    yield from matrix_blocks(report, ("gv_eq", "gw_eq"))
    if report.allowed is not None:
        yield Paragraph(
            f"Rates that fit each other are led by {', '.join(report.allowed.leading)}:"
        )
        yield from titled_matrices(matrices_of(report.allowed), ALLOWED_TITLES)
    yield Heading("Singularity")
    yield from singularity_blocks(report.singularity, length=report.mechanism.characteristic_length)
    yield singular_values_table(report)
    yield from ellipsoid_blocks(report, ("velocity", "angular", "force"))
    yield from load_blocks(report.load)


def title(report: Report) -> str:
    """Return what is shown: the mechanism and its pose."""
    if report.pose is not None:
        return f"{report.name}, pose {report.pose}"
    return f"{report.name} at {motor_line(report.joints)}"


def motor_line(joints: Iterable[LabelledJoint]) -> str:
    """Return the values of the motors among these joints in one line."""
    motors = (joint for joint in joints if joint.role == "actuated")
    return ", ".join(f"{joint.name} = {joint.value:.6g} {joint.unit}" for joint in motors)


def matrix_blocks(report: Report, names: tuple[str, ...]) -> Iterator[Block]:
    """Show these matrices; without rows or columns there is nothing to show."""
    for name in names:
        yield from titled_matrices(report.matrices, {name: TITLES[name]})
        if name == "K_star" and report.mechanism.rows:
            yield Paragraph(_determinant(report))


def titled_matrices(
    matrices: Mapping[str, LabelledMatrix | None], titles: Mapping[str, str]
) -> Iterator[Table]:
    """Show matrices under their titles; without rows or columns there is nothing to show."""
    for name, title_of_it in titles.items():
        matrix = matrices[name]
        if matrix is not None and matrix.rows and matrix.columns:
            yield matrix.block(title_of_it)


def singular_values_table(report: Report) -> Table:
    """Show the singular values in one table, matrix by matrix."""
    rows = []
    for name, found in report.singular_values.items():
        if found is None or not found.values:
            continue
        unit = found.unit or "mixed units"
        rows.append((f"{SYMBOLS[name]} [{unit}]", *matrix_numbers([found.values])[0]))
    relative = report.singularity.singular_values.tolist()
    if relative:
        rows.append(("K*, dimensionless, relative to [K K*]", *matrix_numbers([relative])[0]))
    count = max((len(row) for row in rows), default=1)
    padded = tuple((*row, *[""] * (count - len(row))) for row in rows)
    header = ("", *(f"σ{k}" for k in range(1, count)))
    return Table("Singular values", header, padded, "<" + ">" * (count - 1))


def ellipsoid_blocks(report: Report, names: tuple[str, ...]) -> Iterator[Block]:
    """Show the principal values and directions of these ellipsoids, where they exist."""
    for name in names:
        ellipsoid = report.ellipsoids[name]
        if ellipsoid is not None:
            yield ellipsoid_table(f"{ELLIPSOIDS[name]}{motors_told(ellipsoid)}", ellipsoid)


def motors_told(ellipsoid: Ellipsoid) -> str:
    """Return in which the motors of an ellipsoid are counted, behind a comma; "" if not known."""
    return f", motors in {ellipsoid.motor_unit}" if ellipsoid.motor_unit else ""


def ellipsoid_table(heading: str, ellipsoid: Ellipsoid) -> Table:
    """Show an ellipsoid: one principal axis a row.

    Where several radii are zero, or infinite, their directions are any in a plane or in space.
    """
    return axes_table(heading, ellipsoid.unit, ellipsoid.radii.tolist(), ellipsoid.axes.T.tolist())


def axes_table(
    heading: str, unit: str, radii: Sequence[float], directions: Sequence[Sequence[float]]
) -> Table:
    """Show the radii and directions of principal axes as those of an ellipsoid are."""
    ends = [radius for radius in radii if radius in (0.0, math.inf)]
    axes = [
        ["-"] * 3 if ends.count(radius) > 1 else axis
        for radius, axis in zip(radii, matrix_numbers(directions), strict=True)
    ]
    rows = zip(matrix_numbers([radii])[0], axes, strict=True)
    return Table(
        heading,
        ("axis", f"radius\n[{unit}]", "direction\nx", "\ny", "\nz"),
        tuple((str(k), radius, *axis) for k, (radius, axis) in enumerate(rows, start=1)),
        "<>>>>",
    )


def sizes_line(found: Mechanism, rank: str) -> str:
    """Return the numbers of a mechanism in one line, the rank of its loops in these words."""
    mobility = "not known" if found.mobility is None else found.mobility
    return (
        f"n = {len(found.actuated)} motors, m_p = {len(found.passive)} passive; "
        f"p = {len(found.rows)} loop equations, {rank}; "
        f"mobility {mobility}; nq = {found.nq}, nv = {found.nv}."
    )


def limits_warning(configuration: Configuration) -> str:
    """Return the warning that joints are outside their limits."""
    beyond = configuration.limits_violated.items()
    told = "; ".join(f"{name} = {found.words}" for name, found in beyond)
    return f"Warning: {told}. The loops close here, but the machine cannot be here."


def _origin_line(report: Report) -> str:
    walked = f"Reached from the pose {report.start!r}. " if report.start else ""
    return f"{walked}The tool's twist is in the frame {report.split.frame}."


def _pose_blocks(report: Report) -> Iterator[Block]:
    if report.mechanism.parameters:
        yield parameters_table(report.mechanism)
    yield joints_table(report)
    if report.residual:
        yield Table(
            f"Loop equations η (Newton iterations: {report.configuration.iterations}, "
            f"gap: {brief(report.configuration.residual_norm)} m)",
            ("equation", "value", "unit"),
            tuple((row.name, brief(row.value), row.unit) for row in report.residual),
            "<><",
        )
    yield _tool_table(report)


def parameters_table(mechanism: Mechanism) -> Table:
    """Show the parameters, their values and what they mean."""
    values = mechanism.parameters
    declared = [mechanism.spec.parameters[name] for name in values]
    columns = {
        "name": values,
        "value": map(number, values.values()),
        "unit": [one.unit for one in declared],
        "meaning": [one.meaning for one in declared],
    }
    return Table.of("Parameters", "<><<", columns)


def joints_table(report: Report) -> Table:
    """Show the values of all joints, motors first."""
    values = matrix_numbers([joint.value] for joint in report.joints)
    rows = tuple(
        (joint.name, joint.role, value, joint.unit)
        for joint, [value] in zip(report.joints, values, strict=True)
    )
    return Table("Joints", ("joint", "role", "value", "unit"), rows, "<<><")


def _tool_table(report: Report) -> Table:
    tool, size = report.configuration.tool_pose(), report.mechanism.characteristic_length
    position = matrix_numbers([[x] for x in tool.translation], size)
    rows = zip("xyz", position, matrix_numbers(tool.rotation), strict=True)
    return Table(
        "Tool in the world",
        ("", "position\n[m]", "rotation\nx", "\ny", "\nz"),
        tuple((axis, *place, *direction) for axis, place, direction in rows),
        "<>>>>",
    )


def _determinant(report: Report) -> str:
    det = report.det_K_star
    if det is None:
        rows, columns = report.split.K_star.shape
        return f"K* is {rows} × {columns}, not square: it has no determinant."
    return f"det K* = {number(det.value)} {det.unit}"
