"""A picture as one self-contained HTML file: meshcat's viewer with the commands in it."""

from __future__ import annotations

import base64
import functools
import html
import os
from dataclasses import dataclass

import msgspec

from pmjac_pin.files.output_file import check_place, write_file
from pmjac_pin.viewer.browser_files import PAGE, meshcat_files
from pmjac_pin.viewer.framing import Framing

_TEMPLATE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>{style}</style>
</head>
<body>
<aside id="facts"><h1>{title}</h1>{facts}</aside>
<div id="pane" role="application" tabindex="0"
 aria-label="Picture of {title}: arrow keys turn it, plus and minus zoom"></div>
<script>{library}</script>
<script>
{scripts}
const stage = makeStage(document.getElementById("pane"));
const commands = [
{commands}
];
if (stage) {{
  for (const command of commands) {{
    stage.viewer.handle_command_bytearray(Uint8Array.from(atob(command), (c) => c.charCodeAt(0)));
  }}
  stage.frameOn({framing});
}}
</script>
</body>
</html>
"""


@dataclass(frozen=True, slots=True)
class Picture:
    """What a page without a server needs to know.

    Attributes
    ----------
    title : str
    facts : tuple of str
        What stands below the title, a line each.
    commands : list of bytes
        meshcat's.
    framing : Framing
        The first view.
    """

    title: str
    facts: tuple[str, ...]
    commands: list[bytes]
    framing: Framing


def static_page(picture: Picture) -> str:
    """Return the page: about 0.9 MB, nearly all of it meshcat's viewer."""
    encoded = ",\n".join(f'"{base64.b64encode(command).decode()}"' for command in picture.commands)
    return _TEMPLATE.format(
        title=html.escape(picture.title),
        facts="".join(f"<p>{html.escape(line)}</p>" for line in picture.facts),
        library=_library(),
        commands=encoded,
        style=_page_file("stage.css"),
        scripts="\n".join(map(_page_file, ("fit.js", "labels.js", "stage.js"))),
        framing=msgspec.json.encode(picture.framing).decode(),
    )


def save_page(picture: Picture, path: str | os.PathLike[str]) -> None:
    """Write the page; a failure leaves a file that is already there untouched."""
    check_place(path)
    write_file(path, static_page(picture).encode(errors="backslashreplace"))


def notebook_frame(picture: Picture, url: str | None) -> str:
    """Return a frame for a notebook, with the whole page in it, and where it is live.

    A notebook of somebody else's that is not trusted yet shows the words only.
    """
    page = html.escape(static_page(picture), quote=True)
    live = f'<a href="{url}" target="_blank">live page</a>' if url else "a still picture"
    style = "width: 100%; height: 480px; border: 1px solid #d5d9de; border-radius: 6px"
    return (
        f'<iframe srcdoc="{page}" title="{html.escape(picture.title, quote=True)}" '
        f'sandbox="allow-scripts" style="{style}"></iframe>'
        f"<p>{html.escape(picture.title)}: {live}</p>"
    )


def _page_file(name: str) -> str:
    return (PAGE / name).read_text(encoding="utf-8")


@functools.cache
def _library() -> str:
    text = (meshcat_files() / "main.min.js").read_text(encoding="utf-8")
    # The browser would end the script at this, were it in one of the strings.
    return text.replace("</script", "<\\/script")
