"""The lecture's figure of one pose: its velocity ellipsoid under the mechanism's name."""

from __future__ import annotations

import textwrap
from pathlib import Path

from pmjac_pin.ellipsoid import Ellipsoid
from pmjac_pin.plotting import plot_ellipsoid, save_figure
from pmjac_pin.report import Report
from pmjac_pin.tables import motor_values, title

_TITLE_WIDTH, _SUBTITLE_WIDTH = 70, 95  # characters that fit the figure


def save_pose_figure(report: Report, ellipsoid: Ellipsoid, path: Path) -> None:
    """Draw an ellipsoid of a pose; the titles say mechanism, pose, motor values and frame.

    Raises
    ------
    ArgumentError, OSError
        The file cannot be written.
    MissingDependencyError
        matplotlib is not installed.
    """
    lines = [f"frame {report.frame}"]
    if report.pose is not None:
        lines.insert(0, motor_values(report))
    subtitle = "\n".join(textwrap.fill(line, _SUBTITLE_WIDTH) for line in lines)
    heading = textwrap.fill(title(report), _TITLE_WIDTH)
    # matplotlib would take what stands between two dollar signs for a formula.
    figure = plot_ellipsoid(
        ellipsoid, title=heading.replace("$", r"\$"), subtitle=subtitle.replace("$", r"\$")
    )
    try:
        save_figure(figure, path)
    except OSError as error:  # it names a draft, which nobody asked for
        raise OSError(error.errno, error.strerror, str(path)) from error
