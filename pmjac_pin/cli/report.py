"""``pmjac report``."""

from __future__ import annotations

from pmjac_pin.cli.options import Choice, FrameOption, Json, NameOption, PoseOption
from pmjac_pin.cli.output import Output
from pmjac_pin.words.plain import to_json
from pmjac_pin.words.report import make_report
from pmjac_pin.words.tables import report_blocks


def report_command(
    mechanism: NameOption,
    /,
    *,
    pose: PoseOption = PoseOption(),
    frame: FrameOption = "LOCAL_WORLD_ALIGNED",
    choice: Choice = Choice(),
    json: Json = False,
) -> Output:
    """Show all that is known at one pose, as tables or as JSON."""
    configuration, names = pose.configuration(choice.load(mechanism))
    report = make_report(configuration, frame.upper(), **names)
    return f"{to_json(report.told())}\n" if json else report_blocks(report)
