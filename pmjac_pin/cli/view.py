"""``pmjac view``."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from pmjac_pin.cli.options import Choice, NameOption, PoseOption
from pmjac_pin.cli.output import Output

#: The pose that the page opens on, where a mechanism has it.
VIEW = "view"


def view_command(
    mechanism: NameOption,
    /,
    *,
    pose: PoseOption = PoseOption(),
    choice: Choice = Choice(),
    port: Annotated[
        int | None, Parameter(help="The first port to try (default: 7000); 0 for any.")
    ] = None,
    no_browser: Annotated[bool, Parameter(help="Do not open a browser.")] = False,
) -> Output:
    """Show a live page with sliders, on this machine only, until Ctrl-C.

    It opens on the pose "view" where the mechanism has one, else at home.
    """
    loaded = choice.load(mechanism)
    opening = VIEW if VIEW in loaded.poses else "home"
    configuration, _ = pose.configuration(loaded, opening)
    # Imported when needed: it brings a web server along.
    from pmjac_pin.viewer.serving import serve_until_interrupted  # noqa: PLC0415

    serve_until_interrupted(configuration, port, open_browser=not no_browser)
    return None
