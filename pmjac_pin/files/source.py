"""Source: what a file says of a mechanism, whatever its format."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import msgspec

from pmjac_pin.errors import ArgumentError, ModelFileError, enumerated
from pmjac_pin.files.catalog import SUFFIXES, find_urdf
from pmjac_pin.files.foreign_model import ForeignModel, check_frame, checked_motors
from pmjac_pin.files.massless import mass_notes
from pmjac_pin.files.model_file import read_model_file
from pmjac_pin.files.robot_folder import YAML, urdf_of
from pmjac_pin.files.text_file import at_file
from pmjac_pin.files.urdf.dialects import Said, read_cut_tree
from pmjac_pin.files.urdf.robot import Urdf
from pmjac_pin.files.urdf.stated_gears import with_gears
from pmjac_pin.files.urdf.ties import CLOSING, closing_frames
from pmjac_pin.files.user_path import is_folder, shown_path, user_path
from pmjac_pin.model.spec import MechanismSpec
from pmjac_pin.model.tool_spec import Tool
from pmjac_pin.values.checks import as_names


@dataclass(frozen=True)
class Source:
    """What a file says.

    Attributes
    ----------
    path : Path
        The file.
    spec : MechanismSpec
    urdf : Urdf
        The cut tree at the parameters' defaults.
    notes : tuple of str
        One sentence for each decision that the reader of another format took.
    unread : tuple of str
        One sentence for each kind of thing in the file that nobody reads.
    driven : tuple of str
        The motors, where they were given in place of those that the file tells.
    """

    path: Path
    spec: MechanismSpec
    urdf: Urdf
    notes: tuple[str, ...] = ()
    unread: tuple[str, ...] = ()
    driven: tuple[str, ...] = ()

    @property
    def all_notes(self) -> tuple[str, ...]:
        """What was not read, and what was decided."""
        return (*self.unread, *self.notes)


def read_source(
    path: Path,
    actuated: Iterable[str] | None = None,
    tool: str | None = None,
    include_root: str | Path | None = None,
) -> Source:
    """Read a model file of ours or a file of another format, told by its suffix.

    Parameters
    ----------
    path : Path
        One without a suffix is a model file of ours, as one in ``.toml`` is. A folder, or the YAML
        file of an extended URDF, stands for the URDF in it.
    actuated : iterable of str, optional
        The motors, instead of those that the file tells.
    tool : str, optional
        The tool's frame, instead of the one that the file tells.
    include_root : str or Path, optional
        A folder above that of an MJCF, below which the files that it includes may be.

    Raises
    ------
    ModelFileError, UnknownNameError, ArgumentError
    """
    motors = None if actuated is None else as_names(actuated, "actuated is a list of joint names")
    if path.suffix.lower() in YAML or is_folder(path):
        path = urdf_of(path)
    root = _include_root(path, include_root)
    if (reader := READERS.get(path.suffix.lower())) is not None:
        model = reader(path, motors or ()) if root is None else _read_mjcf(path, motors or (), root)
        spec = model.spec(motors, tool)
        return Source(path, spec, model.urdf, model.notes, model.unread, motors or ())
    if path.suffix.lower() not in ("", ".toml"):
        raise ModelFileError(f"{shown_path(path)}: {_other_format(path)}", path=str(path))
    spec = read_model_file(path)
    urdf, said = read_cut_tree(find_urdf(spec.urdf, path))
    if said != Said():
        with at_file(urdf.path):
            spec = _with_said(spec, said)
    if motors is not None:
        # The order of the passive joints was given for other motors.
        spec = msgspec.structs.replace(spec, actuated=checked_motors(urdf, motors), passive=None)
    if tool is not None:
        spec = msgspec.structs.replace(spec, tool=Tool(frame=check_frame(urdf, tool)))
    unread = (*urdf.unread, *_open_frames(urdf, spec))
    notes = (*said.notes, *mass_notes(urdf, urdf.links))
    return Source(path, spec, urdf, notes, unread, motors or ())


def _with_said(spec: MechanismSpec, said: Said) -> MechanismSpec:
    """Return what a model file says together with its URDF."""
    return msgspec.structs.replace(
        spec,
        loops=with_gears(spec.loops, [*said.mimics, *said.couplings]),
        spherical=tuple(dict.fromkeys((*spec.spherical, *said.balls))),
        armature={**said.armature, **spec.armature},
    )


def _include_root(path: Path, given: str | Path | None) -> Path | None:
    """Return the folder below which a file may include others, if one is given for it."""
    if given is None:
        return None
    if READERS.get(path.suffix.lower()) is not _read_mjcf:
        what = "`include_root` is of MJCF files, which alone include others"
        raise ArgumentError(f"{what}; got it for {shown_path(path)}")
    return user_path(given)


def _other_format(path: Path) -> str:
    if (step := _READABLE_BY.get(path.suffix.lower())) is not None:
        return step
    return f"the end of its name tells no format; there are {enumerated(SUFFIXES)}"


def _open_frames(urdf: Urdf, spec: MechanismSpec) -> list[str]:
    """Return a sentence for each frame or pair that is made to close a loop, and is in none."""
    if not any(link.startswith(CLOSING) for link in urdf.links):
        return []
    joined = [name for loop in spec.loops for name in loop.ends]
    loops, lone = closing_frames(urdf.links, (), joined)
    pairs = (" and ".join(repr(end.get("link")) for end in loop) for loop in loops)
    return [
        *(f"not read: the frames {pair} are in no [[loop]]" for pair in pairs),
        *(f"not read: {one}" for one in lone if one.startswith("link ")),
    ]


_FROM_WEBOTS = "export the robot as URDF: robot.getUrdf() in a controller of its own writes it"
#: Formats that are not read, by their suffixes: what makes one of them that is.
_READABLE_BY = {
    ".xacro": "xacro's macros are not read; write what they make with: xacro FILE > robot.urdf",
    ".wbt": f"Webots' worlds are not read; {_FROM_WEBOTS}",
    ".proto": f"Webots' PROTO files are not read; {_FROM_WEBOTS}",
    **dict.fromkeys(
        (".usd", ".usda", ".usdc"),
        "USD is not read; export the robot as URDF or MJCF: Isaac Sim's URDF exporter does",
    ),
}


# What reads another format is imported when a file of it is read.
def _read_urdf(path: Path, motors: Collection[str]) -> ForeignModel:
    from pmjac_pin.files.urdf.extended_urdf import (  # noqa: PLC0415
        closure_yaml_beside,
        read_extended_urdf,
    )
    from pmjac_pin.files.urdf.looped_urdf import read_looped_urdf  # noqa: PLC0415

    extended = closure_yaml_beside(path) is not None
    return (read_extended_urdf if extended else read_looped_urdf)(path, motors)


def _read_sdf(path: Path, motors: Collection[str]) -> ForeignModel:
    from pmjac_pin.files.sdf.reader import read_sdf  # noqa: PLC0415

    return read_sdf(path, motors)


def _read_mjcf(path: Path, motors: Collection[str], root: Path | None = None) -> ForeignModel:
    from pmjac_pin.files.mjcf.reader import read_mjcf  # noqa: PLC0415

    model = read_mjcf(path, root)  # its loops are cut already
    return model if motors else model.with_open_chain()


# The readers of other formats, by the suffix of the file; each is told which joints stay uncut.
READERS: Mapping[str, Callable[[Path, Collection[str]], ForeignModel]] = {
    ".urdf": _read_urdf,
    ".sdf": _read_sdf,
    ".world": _read_sdf,
    ".xml": _read_mjcf,
    ".mjcf": _read_mjcf,
}
