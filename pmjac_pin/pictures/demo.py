"""The lecture's pose B: the 3-RPS closed, its matrices, its ellipsoid and the figure.

Source: Ashitava Ghosal, *Robotics: Basics and Selected Advanced Concepts* (NPTEL), lecture 21,
"Parallel Manipulator Jacobian Matrix", equations (26) to (33).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pmjac_pin.errors import MissingDependencyError
from pmjac_pin.loading import load
from pmjac_pin.pictures.pose_figure import save_pose_figure
from pmjac_pin.values.brief import brief
from pmjac_pin.words.blocks import Block, Heading, Paragraph, Table, Verbatim
from pmjac_pin.words.numbers import matrix_numbers, number
from pmjac_pin.words.report import Report, report
from pmjac_pin.words.tables import (
    LEGEND,
    axes_table,
    ellipsoid_table,
    matrix_blocks,
    motor_line,
    singular_values_table,
)

LECTURE_CUT, CONTACT_CUT, POSE = "three_rps_ss", "three_rps", "lecture_b"
LENGTHS = (0.5, 1.0, 2.0)
FIGURE = Path("three_rps_lecture_b.png")

PRINTED_ANGLES = (0.4, 0.7535, 0.2402)
PRINTED_VELOCITIES = (0.3724, 0.3162, 0.2031)
PRINTED_DIRECTIONS = (
    (0.9921, -0.0394, 0.1187),
    (0.1166, 0.6338, -0.7646),
    (-0.0452, 0.7724, 0.6335),
)


@dataclass(frozen=True, eq=False)
class Demo:
    """What the demonstration computed.

    Attributes
    ----------
    report : Report
        Of the lecture's own cut, three distance loops.
    contact : Report
        Of the same pose, cut at the spherical joints.
    linear_difference, angular_difference : float
        Largest difference between the two [J_v]eq and the two [J_ω]eq.
    figure : Path
        The file written.
    unwritten : str
        Why it was not, "" where it was.
    """

    report: Report
    contact: Report
    linear_difference: float
    angular_difference: float
    figure: str | Path
    unwritten: str = ""


def run_demo(figure: str | Path | None = None) -> Demo:
    """Compute everything at the lecture's pose B and write the figure.

    Parameters
    ----------
    figure : str or Path, optional
        Its file. By default `FIGURE`, in this folder: where that cannot be written, all else is
        told, and why there is no figure.

    Raises
    ------
    ArgumentError, OSError
        The figure cannot be written.
    MissingDependencyError
        matplotlib is not installed.
    """
    here = load(LECTURE_CUT).close(LENGTHS, guess=POSE)
    there = load(CONTACT_CUT).close(LENGTHS, guess=POSE)
    mine, other = here.jacobian(), there.jacobian()
    lecture = report(here, pose=POSE)
    place, unwritten = FIGURE if figure is None else figure, ""
    try:
        save_pose_figure(lecture, mine.velocity_ellipsoid(), place)
    except (OSError, MissingDependencyError) as error:
        if figure is not None:
            raise
        unwritten = getattr(error, "strerror", None) or str(error)
    return Demo(
        report=lecture,
        contact=report(there, pose=POSE),
        linear_difference=float(np.abs(mine.Jv_eq - other.Jv_eq).max()),
        angular_difference=float(np.abs(mine.Jw_eq - other.Jw_eq).max()),
        figure=place,
        unwritten=unwritten,
    )


def demo_blocks(demo: Demo) -> Iterator[Block]:
    """Show the demonstration."""
    lecture = demo.report
    yield Heading(f"Lecture 21, pose B: 3-RPS, {motor_line(lecture.joints)}")
    yield Paragraph(_introduction(lecture))
    yield _angles_table(lecture)
    yield Paragraph(LEGEND)
    yield from matrix_blocks(lecture, ("K", "K_star", "Jv", "Jv_star", "Jw", "Jw_star"))
    yield from matrix_blocks(lecture, ("Jv_eq", "Jw_eq"))
    yield singular_values_table(lecture)
    yield from _principal_velocities(lecture)
    yield from _other_cut(demo)
    yield Heading("Figure: the ellipsoid in space and in the Z-Y, Z-X and X-Y planes")
    if demo.unwritten:
        why = f"{demo.figure} was not written ({demo.unwritten})"
        yield Paragraph(f"{why}; -o takes another place.")
    else:
        yield Verbatim(str(demo.figure))


def _introduction(report: Report) -> str:
    found = report.configuration
    return (
        f"Cut as the lecture cuts it ({report.name}): three open RP legs and three distance "
        f"loops, closed from the pose {POSE!r} (Newton iterations: {found.iterations}, gap: "
        f"{brief(found.residual_norm)} m). The twist is that of the platform's middle, in axes "
        f"parallel to the world's."
    )


def _angles_table(report: Report) -> Table:
    angles = [joint for joint in report.joints if joint.role == "passive"]
    rows = zip(angles, PRINTED_ANGLES, strict=True)
    return Table(
        "Direct kinematics: the leg angles φ",
        ("joint", "computed\n[rad]", "printed\n[rad]"),
        tuple((joint.name, number(joint.value), number(printed)) for joint, printed in rows),
        "<>>",
    )


def _principal_velocities(report: Report) -> Iterator[Block]:
    computed = report.ellipsoids["velocity"]
    if computed is None:  # impossible at this pose; the type cannot know
        return
    printed = (computed.unit, PRINTED_VELOCITIES, PRINTED_DIRECTIONS)
    yield Heading("Principal velocities of the platform's middle")
    yield ellipsoid_table("Computed: the singular values of [J_v]eq, equation (33)", computed)
    yield axes_table("Printed in the lecture", *printed)
    yield Paragraph(
        f"The printed {_triple(PRINTED_VELOCITIES)} m/s do not follow from the lecture's own "
        f"equations, which give {_triple(computed.radii)} m/s at this pose (and the same on its "
        f"mirror image below the base)."
    )


def _other_cut(demo: Demo) -> Iterator[Block]:
    yield Heading("The same machine, cut elsewhere")
    yield Paragraph(
        f"{demo.contact.name} closes the loops by point contacts between a free platform and "
        f"the three legs. K and K* are others, the equivalent Jacobian is the same."
    )
    yield Table(
        "The two cuts",
        ("model", "K", "K*", "det K*"),
        tuple(map(_cut_row, (demo.report, demo.contact))),
        "<<<<",
    )
    yield from matrix_blocks(demo.contact, ("Jv_eq", "Jw_eq"))
    yield Paragraph(
        f"Largest difference from the matrices above: {brief(demo.linear_difference)} in [J_v]eq, "
        f"{brief(demo.angular_difference)} rad/m in [J_ω]eq."
    )


def _cut_row(report: Report) -> tuple[str, ...]:
    split, det = report.split, report.det_K_star
    sizes = (f"{len(K)} × {K.shape[1]}" for K in (split.K, split.K_star))
    return (report.name, *sizes, f"{number(det.value)} {det.unit}" if det else "")


def _triple(values: Iterable[float]) -> str:
    return ", ".join(matrix_numbers([list(values)])[0])
