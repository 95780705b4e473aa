"""The lecture's figure of one pose: its velocity ellipsoid under the mechanism's name."""

from __future__ import annotations

import textwrap
from pathlib import Path

from pmjac_pin.pictures.figures import save_figure
from pmjac_pin.pictures.plotting import plot_ellipsoid
from pmjac_pin.rates.ellipsoid import Ellipsoid
from pmjac_pin.words.report import Report
from pmjac_pin.words.tables import motor_line, title

_TITLE_WIDTH, _SUBTITLE_WIDTH = 70, 95  # characters that fit the figure


def save_pose_figure(report: Report, ellipsoid: Ellipsoid, path: str | Path) -> None:
    """Draw an ellipsoid of a pose; the titles say mechanism, pose, motor values and frame.

    Raises
    ------
    ArgumentError, OSError
        The file cannot be written.
    MissingDependencyError
        matplotlib is not installed.
    """
    heading, lines = headings(report)
    save_figure(plot_ellipsoid(ellipsoid, title=heading, subtitle=lines), path)


def headings(report: Report) -> tuple[str, str]:
    """Return the title of a pose's picture, and the smaller lines below it."""
    heading, lines = title(report), [f"frame {report.split.frame}"]
    if len(heading) > _TITLE_WIDTH:
        heading = report.name
    if heading != title(report) or report.pose is not None:
        lines.insert(0, wrapped(motor_line(report.joints), _SUBTITLE_WIDTH))
    if beyond := ", ".join(report.configuration.limits_violated):
        lines.append(wrapped(f"beyond limits: {beyond}", _SUBTITLE_WIDTH))
    return heading, "\n".join(lines)


def wrapped(values: str, width: int) -> str:
    """Break lines between motors only: no-break spaces keep a name, its value and its unit."""
    together = values.replace(" ", "\u00a0").replace(",\u00a0", ", ")
    return textwrap.fill(together, width)
