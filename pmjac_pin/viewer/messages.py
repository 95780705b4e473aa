"""The messages between page and server, and the one place that trusts neither their shape.

Numbers beyond what their type holds, unknown keys, unknown commands and wrong types are refused
by msgspec; what a value means (limits, names) is checked by `Session`.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeAlias

import msgspec

from pmjac_pin.errors import ArgumentError
from pmjac_pin.viewer.framing import Framing
from pmjac_pin.viewer.load_readout import LoadReadout
from pmjac_pin.viewer.readout import Readout
from pmjac_pin.viewer.scene_options import SceneOptions

#: Longer messages are answered with an error: the longest sensible one is far shorter.
MAXIMAL_MESSAGE = 64 * 1024

Scale: TypeAlias = Annotated[float, msgspec.Meta(ge=0.05, le=20.0)]
WholeNumber: TypeAlias = Annotated[int, msgspec.Meta(ge=0, le=2**53)]


class _Command(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="command"):
    """A command of the page; its number comes back with the answer."""

    id: WholeNumber = 0

    def told(self) -> dict[str, Any]:
        """Return all of it but its number."""
        return {name: getattr(self, name) for name in self.__struct_fields__ if name != "id"}


class MoveMotors(_Command, frozen=True, tag="move", kw_only=True):
    """Move the motors to these values, m or rad; those that are None stay where they are."""

    values: list[float | None]


class SetParameters(_Command, frozen=True, tag="set", kw_only=True):
    """Give the parameters these values, m or rad; those that are None stay as they are."""

    values: list[float | None]


class Home(_Command, frozen=True, tag="home"):
    """Go to the home pose."""


class ShowMoment(_Command, frozen=True, tag="moment", kw_only=True):
    """Go to a parameter of the trajectory, the one of these values."""

    values: list[float]


class NamedPose(_Command, frozen=True, tag="pose", kw_only=True):
    """Go to a named pose."""

    name: str


class Options(_Command, frozen=True, tag="options", kw_only=True):
    """Choose which ellipsoids are drawn, how large, and whether motors are named."""

    linear: bool
    angular: bool
    force: bool
    names: bool
    scale: Scale
    velocity_polytope: bool = False
    force_polytope: bool = False


class SetLoad(_Command, frozen=True, tag="load", kw_only=True):
    """Hang a mass at the tool, kg, or push it, N, along a direction in rad."""

    kind: Literal["weight", "force"]
    mass: float
    size: float
    azimuth: float
    elevation: float


class Reframe(_Command, frozen=True, tag="frame"):
    """Say how to frame what is shown now; nothing changes."""


class FindModes(_Command, frozen=True, tag="find modes"):
    """Search for the assembly modes at the motor values of now."""


class StopSearch(_Command, frozen=True, tag="stop search"):
    """Give up the search for them."""


class ShowMode(_Command, frozen=True, tag="mode", kw_only=True):
    """Go to one of the modes that were found, by its number."""

    number: WholeNumber


class DrawSlice(_Command, frozen=True, tag="draw slice", kw_only=True):
    """Draw what is reached, and what is singular, over the values of two motors."""

    first: str
    second: str


class StopSlice(_Command, frozen=True, tag="stop slice"):
    """Give up drawing it."""


SliceCommand: TypeAlias = DrawSlice | StopSlice
ModesCommand: TypeAlias = FindModes | StopSearch | ShowMode
PoseCommand: TypeAlias = MoveMotors | ShowMoment | Home | NamedPose | Options | SetLoad
Command: TypeAlias = PoseCommand | SetParameters | Reframe | ModesCommand | SliceCommand


class Slider(msgspec.Struct, frozen=True):
    """A motor or a parameter: its unit, the range of its slider, and whether that is its limits."""

    name: str
    unit: str
    lower: float
    upper: float
    limited: bool
    meaning: str = ""


class Passive(msgspec.Struct, frozen=True):
    """A passive joint, or one of its degrees of freedom."""

    name: str
    unit: str


class Happening(msgspec.Struct, frozen=True):
    """What happens on a trajectory."""

    t: float
    kind: str
    what: str


class Key(msgspec.Struct, frozen=True):
    """An entry of the legend: what is drawn in these colours, such as "#d55e00"."""

    text: str
    colours: tuple[str, ...]


class About(msgspec.Struct, frozen=True):
    """What is the same at all poses.

    Attributes
    ----------
    counted : str
        In what the ellipsoids count motor rates and efforts.
    replay : Slider or None
        Of the parameter of a trajectory, where there is one.
    """

    mechanism: str
    description: str
    counted: str
    motors: tuple[Slider, ...]
    parameters: tuple[Slider, ...]
    passive: tuple[Passive, ...]
    poses: tuple[str, ...]
    home: Readout
    legend: tuple[Key, ...]
    load: tuple[Slider, ...]
    replay: Slider | None = None
    happenings: tuple[Happening, ...] = ()


class Notice(msgspec.Struct, frozen=True):
    """What the status line says.

    Attributes
    ----------
    kind : str
        "", or "stop" at the end of the range.
    text : str
    stops : tuple of int
        Of a stop, for each motor: the side, 1 or −1, on which it cannot go on; 0 if it can.
    """

    kind: str
    text: str
    stops: tuple[int, ...] = ()


class Drawn(SceneOptions, frozen=True, kw_only=True):
    """What is drawn, and why polytopes that are chosen are not, by their kinds."""

    no_polytopes: dict[str, str]


class State(msgspec.Struct, frozen=True, kw_only=True, tag="state", tag_field="type"):
    """Everything that the page shows.

    Attributes
    ----------
    id : int or None
        Of the command that it answers.
    pose : str or None
    values, parameters : tuple of float
        Of the motors, and of the parameters.
    readout : Readout
    notice : Notice
    drawn : Drawn
    load : LoadReadout
    moment : float or None
        The parameter of the trajectory, where the pose is one of it.
    about : About, optional
        Where it has changed, or the page does not know it yet.
    framing : Framing, optional
        What the view is to fit now.
    jump : Framing, optional
        What has to be in view now: the pose is another one, perhaps far from the last.
    """

    id: int | None
    pose: str | None
    values: tuple[float, ...]
    parameters: tuple[float, ...]
    readout: Readout
    notice: Notice
    drawn: Drawn
    load: LoadReadout
    moment: float | None = None
    about: About | None = None
    framing: Framing | None = None
    jump: Framing | None = None


class Refusal(msgspec.Struct, frozen=True, tag="error", tag_field="type"):
    """The answer to a message that changed nothing."""

    id: int | None
    message: str


class Modes(msgspec.Struct, frozen=True, kw_only=True, tag="modes", tag_field="type"):
    """The assembly modes at the current motor values, as far as they are known.

    Attributes
    ----------
    status : str
        "unknown", "searching", "found" or "failed".
    text : str
        How many there are and what this rests on; or why there is no answer.
    current : int or None
        The number of the mode that is shown.
    modes : tuple of dict
        What `ModeReport.told` tells of each.
    """

    status: Literal["unknown", "searching", "found", "failed"]
    text: str
    current: int | None = None
    modes: tuple[dict[str, object], ...] = ()


_decoder = msgspec.json.Decoder(Command)


def decode(message: str | bytes) -> Command:
    """Read one message of a page.

    Raises
    ------
    ArgumentError
        Too long, binary, not JSON, no known command, or values of another type.
    """
    if isinstance(message, bytes):
        raise ArgumentError("binary messages are not understood; send JSON text")
    size = len(message.encode("utf-8", "replace"))
    if size > MAXIMAL_MESSAGE:
        raise ArgumentError(f"a message of {size} bytes is too long; {MAXIMAL_MESSAGE} are allowed")
    try:
        command: Command = _decoder.decode(message)
    except (msgspec.MsgspecError, RecursionError, UnicodeError) as error:
        raise ArgumentError(f"not understood: {error}") from None
    return command
