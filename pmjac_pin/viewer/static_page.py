"""A picture as one self-contained HTML file: meshcat's viewer with the commands in it."""

from __future__ import annotations

import base64
import contextlib
import functools
import html
import os
import shutil
import uuid
from dataclasses import dataclass
from pathlib import Path

import msgspec

from pmjac_pin.viewer.browser_files import PAGE, meshcat_files
from pmjac_pin.viewer.framing import Framing

_TEMPLATE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>
html, body {{ margin: 0; height: 100%; background: #f4f6f8; }}
#pane {{ width: 100vw; height: 100vh; overflow: hidden; }}
</style>
</head>
<body>
<div id="pane"></div>
<script>{library}</script>
<script>
var viewer = new MeshCat.Viewer(document.getElementById("pane"));
viewer.gui.domElement.style.display = "none";
{labels}
tidyLabels(viewer);
for (const command of [
{commands}
]) {{
  viewer.handle_command_bytearray(Uint8Array.from(atob(command), (c) => c.charCodeAt(0)));
}}
{fit}
const framing = {framing};
const fit = () => fitView(viewer, framing, window.innerWidth, window.innerHeight);
fit();
let touched = false;
for (const event of ["pointerdown", "wheel"]) {{
  window.addEventListener(event, () => {{ touched = true; }}, {{ passive: true }});
}}
window.addEventListener("resize", () => {{ if (!touched) fit(); }});
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
    commands : list of bytes
        meshcat's.
    framing : Framing
        The first view.
    """

    title: str
    commands: list[bytes]
    framing: Framing


def static_page(picture: Picture) -> str:
    """Return the page: about 0.9 MB, nearly all of it meshcat's viewer."""
    encoded = ",\n".join(f'"{base64.b64encode(command).decode()}"' for command in picture.commands)
    return _TEMPLATE.format(
        title=html.escape(picture.title),
        library=_library(),
        commands=encoded,
        labels=(PAGE / "labels.js").read_text(encoding="utf-8"),
        fit=(PAGE / "fit.js").read_text(encoding="utf-8"),
        framing=msgspec.json.encode(picture.framing).decode(),
    )


def save_page(picture: Picture, path: str | os.PathLike[str]) -> None:
    """Write the page; a failure leaves a file that is already there untouched."""
    # Following links here, because the rename would replace the link and not its target.
    target = Path(path).resolve()
    temporary = target.with_name(f".pmjac-{uuid.uuid4().hex[:8]}")
    try:
        temporary.write_text(static_page(picture), encoding="utf-8")
        if target.exists():
            shutil.copymode(target, temporary)
        temporary.replace(target)
    except BaseException:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)
        raise


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


@functools.cache
def _library() -> str:
    text = (meshcat_files() / "main.min.js").read_text(encoding="utf-8")
    # The browser would end the script at this, were it in one of the strings.
    return text.replace("</script", "<\\/script")
