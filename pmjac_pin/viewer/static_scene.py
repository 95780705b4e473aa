"""A scene as one self-contained HTML file: meshcat's viewer with the commands in it."""

from __future__ import annotations

import base64
import functools
import html
import os
import string
from dataclasses import dataclass

import msgspec

from pmjac_pin.configuration import Configuration
from pmjac_pin.files.output_file import check_place, write_file
from pmjac_pin.viewer.browser_files import PAGE, meshcat_files
from pmjac_pin.viewer.canvas import Canvas
from pmjac_pin.viewer.framing import Framing
from pmjac_pin.viewer.pose_facts import pose_facts
from pmjac_pin.viewer.scene_options import SceneOptions
from pmjac_pin.viewer.session import Session

_FRAME_STYLE = "width: 100%; height: 480px; border: 1px solid #d5d9de; border-radius: 6px"


@dataclass(frozen=True, slots=True)
class StaticScene:
    """A scene that needs no server: made by `static_scene`. In a notebook it shows itself.

    It can be turned and zoomed as the live page can; nothing of it moves.

    Attributes
    ----------
    title : str
    facts : tuple of str
        What stands below the title, a line each.
    commands : tuple of bytes
        meshcat's.
    framing : Framing
        The first view.
    """

    title: str
    facts: tuple[str, ...]
    commands: tuple[bytes, ...]
    framing: Framing

    @classmethod
    def of(cls, session: Session, canvas: Canvas) -> StaticScene:
        """Return what is shown now, framed anew."""
        commands = tuple(command for _, command in canvas.commands())
        facts = pose_facts(session.configuration)
        return cls(session.mechanism.name, facts, commands, session.framing())

    def html(self) -> str:
        """Return the scene as one page: about 0.9 MB, nearly all of it meshcat's viewer.

        It loads nothing, from nowhere: what it needs is in it.
        """
        return string.Template(_page_file("still.html")).substitute(
            title=html.escape(self.title),
            facts="".join(f"<p>{html.escape(line)}</p>" for line in self.facts),
            library=_library(),
            commands=",\n".join(f'"{base64.b64encode(each).decode()}"' for each in self.commands),
            style=_page_file("stage.css"),
            scripts="\n".join(map(_page_file, ("fit.js", "labels.js", "stage.js"))),
            framing=msgspec.json.encode(self.framing).decode(),
        )

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the page.

        Parameters
        ----------
        path : str or path-like
            Replaced at once when the file is complete; left alone if it cannot be written.

        Raises
        ------
        OutputError
            The file cannot be written, or it is none but a folder, a device or a pipe.
        """
        check_place(path)
        write_file(path, self.html().encode(errors="backslashreplace"))

    def notebook_frame(self, words: str) -> str:
        """Return a frame for a notebook, with the whole page in it, and words in HTML below it.

        A notebook of somebody else's that is not trusted yet shows the words only.
        """
        page, title = (html.escape(text, quote=True) for text in (self.html(), self.title))
        return (
            f'<iframe srcdoc="{page}" title="{title}" '
            f'sandbox="allow-scripts" style="{_FRAME_STYLE}"></iframe>'
            f"<p>{title}: {words}</p>"
        )

    def _repr_html_(self) -> str:
        """Return the frame for a notebook: it is kept with the notebook."""
        return self.notebook_frame("a still picture")

    def __repr__(self) -> str:
        return f"StaticScene({self.title})"


def static_scene(
    configuration: Configuration,
    *,
    linear: bool = True,
    angular: bool = False,
    force: bool = False,
    names: bool = True,
    velocity_polytope: bool = False,
    force_polytope: bool = False,
) -> StaticScene:
    """Draw a mechanism and its ellipsoids as a page of one file, without a server.

    Parameters
    ----------
    configuration : Configuration
    linear, angular, force : bool
        Which ellipsoids to draw at the tool.
    names : bool
        Whether to write the motors' names beside them.
    velocity_polytope, force_polytope : bool
        Whether to draw what the tool does within the rate, or effort, limits of each motor.

    Returns
    -------
    StaticScene
        `html` and `save` give the page; in a notebook it shows itself.

    Raises
    ------
    ArgumentError

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> scene = pj.static_scene(pj.load("four_bar").home, force=True)
    >>> scene
    StaticScene(four_bar)
    >>> scene.facts[0]
    'theta1 = 0.9 rad'
    >>> scene.html()[:15]
    '<!DOCTYPE html>'
    """
    options = SceneOptions(linear, angular, force, names, 1.0, velocity_polytope, force_polytope)
    session, canvas = Session(configuration, options), Canvas()
    canvas.update(session.scene().items)
    return StaticScene.of(session, canvas)


def _page_file(name: str) -> str:
    return (PAGE / name).read_text(encoding="utf-8")


@functools.cache
def _library() -> str:
    text = (meshcat_files() / "main.min.js").read_text(encoding="utf-8")
    # The browser would end the script at this, were it in one of the strings.
    return text.replace("</script", "<\\/script")
