"""``pmjac plot``."""

from __future__ import annotations

from typing import Annotated

from pmjac_pin.cli.options import Choice, FrameOption, NameOption, PoseOption, output_option
from pmjac_pin.cli.output import Output
from pmjac_pin.pictures.pose_figure import save_pose_figure
from pmjac_pin.words.blocks import Verbatim
from pmjac_pin.words.report import report


def plot_command(
    mechanism: NameOption,
    /,
    *,
    output: Annotated[str, output_option("The file: .png, .pdf or .svg.")],
    pose: PoseOption = PoseOption(),
    frame: FrameOption = "LOCAL_WORLD_ALIGNED",
    choice: Choice = Choice(),
) -> Output:
    """Draw the velocity ellipsoid at one pose and its sections; print the file's path."""
    configuration, names = pose.configuration(choice.load(mechanism))
    ellipsoid = configuration.jacobian(frame).velocity_ellipsoid()
    found = report(configuration, frame, pose=names["pose"], start=names["start"])
    save_pose_figure(found, ellipsoid, output)
    return [Verbatim(str(output))]
