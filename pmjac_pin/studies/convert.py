"""Writing a mechanism of any format as our own model file and its URDF."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Set
from pathlib import Path
from xml.etree.ElementTree import indent, tostring

import msgspec
import tomli_w

from pmjac_pin.errors import OutputError
from pmjac_pin.files.catalog import find_model_file
from pmjac_pin.files.model_file import parse_model_file
from pmjac_pin.files.output_file import check_new, check_place, write_files
from pmjac_pin.files.source import Source, read_source
from pmjac_pin.files.urdf.robot import Urdf, parse_urdf
from pmjac_pin.files.user_path import (
    followed_link,
    is_file,
    output_path,
    readable,
    real,
    shown_path,
)
from pmjac_pin.loading import adjusted, mechanism_of
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.spec import JointValue, MechanismSpec, encode_spec
from pmjac_pin.values.checks import as_flag


def convert(
    name_or_path: str | Path,
    output: str | Path,
    *,
    actuated: Iterable[str] | None = None,
    tool: str | None = None,
    tool_rows: Iterable[str] | None = None,
    tool_axes: str | None = None,
    locked: Iterable[str] | Mapping[str, JointValue] = (),
    tolerance: float | None = None,
    include_root: str | Path | None = None,
    enforce_limits: bool | None = None,
    force: bool = False,
) -> tuple[Path, Path]:
    """Write a mechanism as a model file, its URDF beside it.

    The poses are written as they close, so that the new file loads with the same home pose and
    the same J_eq. Meshes stay where they are: the URDF names them as it did.

    Parameters
    ----------
    name_or_path, actuated, tool, tool_rows, tool_axes, locked
        As in `load`.
    tolerance, include_root, enforce_limits
        As in `load`.
    output : str or Path
        The new model file; its name ends in ``.toml``. Of a link, where that leads.
    force : bool
        Replace files that exist; never those that are read.

    Returns
    -------
    tuple of Path
        The model file and the URDF.

    Raises
    ------
    ModelFileError, UnknownNameError, ArgumentError, ClosureError
        As `load`.
    OutputError
        The output exists, is no ``.toml`` or cannot be written. Then nothing has changed: what
        is to be written is loaded first, and both files are written or none.

    Examples
    --------
    >>> import tempfile, pmjac_pin as pj
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     model_file, urdf = convert("four_bar", f"{folder}/mine.toml")
    ...     pj.load(model_file)
    Mechanism(mine, actuated=(theta1), 2 passive, 1 loop, mobility 1)
    """
    force = as_flag(force, "force")
    path = find_model_file(name_or_path)
    given = checked_model_file(output)
    source = read_source(path, actuated, tool, include_root)
    source = adjusted(
        source, locked, tool_rows, tool_axes, tolerance=tolerance, enforce_limits=enforce_limits
    )
    read = {real(path), real(Path(source.urdf.path))}
    places = model_file_places(given, read, force)
    spec = msgspec.structs.replace(source.spec, poses=closed_poses(mechanism_of(source)))
    files, _ = model_file_texts(places, spec, source.urdf, _comments(path, source))
    write_files(files, replace=force)
    return places


def checked_model_file(output: str | Path) -> Path:
    """Return the path of a model file that may be written, as far as its name tells.

    Raises
    ------
    ArgumentError, OutputError
    """
    given = output_path(output)
    _check_name(given)
    check_place(given)
    _check_name(followed_link(given))
    return given


def model_file_places(given: Path, read: Set[Path], force: bool) -> tuple[Path, Path]:
    """Return where a model file and its URDF go: nowhere where a file is that was read.

    Raises
    ------
    OutputError
    """
    target = followed_link(given)  # the URDF goes beside the file that a link leads to
    tree = _urdf_beside(target, read)
    _check_places(target, tree, read, force)
    _check_beside(given, tree)
    return target, tree


def model_file_texts(
    places: tuple[Path, Path], spec: MechanismSpec, urdf: Urdf, comments: Iterable[str]
) -> tuple[dict[Path, bytes], Mechanism]:
    """Return what is to be written of a model file and its URDF, and what loads from that.

    Raises
    ------
    ModelFileError, ClosureError
    """
    target, tree = places
    text = _indented(urdf)
    contents = _toml(msgspec.structs.replace(spec, name="", urdf=tree.name), comments)
    source = Source(target, parse_model_file(contents, target), parse_urdf(text, str(tree)))
    return {tree: text.encode(), target: contents.encode()}, mechanism_of(source)


def _comments(path: Path, source: Source) -> Iterable[str]:
    return (f"From {path.name}.", *source.all_notes)


def _urdf_beside(target: Path, read: Set[Path]) -> Path:
    """Return where the tree goes: not where a file is that was read."""
    beside = target.with_suffix(".urdf")
    return beside.with_name(f"{target.stem}_tree.urdf") if real(beside) in read else beside


def _check_places(target: Path, tree: Path, read: Set[Path], force: bool) -> None:
    for place in (target, tree):
        if real(place) in read:
            raise _not_written(place, "is what is read, and is not replaced")
        check_new(place, force)


def _check_beside(output: Path, tree: Path) -> None:
    """Refuse a link beside which there is another file of the tree's name: it would be read."""
    other = output.with_name(tree.name)
    if is_file(other) and real(other) != real(tree):
        instead = f"{shown_path(output.name)} in place of {shown_path(tree)}"
        why = f"would be read with {instead}; move it away"
        raise _not_written(other, why)


def _check_name(target: Path) -> None:
    if target.suffix != ".toml":
        raise _not_written(target, "a model file's name ends in .toml")
    if readable(target.name) != target.name:
        raise _not_written(target, "a model file's name is UTF-8 text, since it names its URDF so")


def _not_written(place: Path, why: str) -> OutputError:
    return OutputError(f"{shown_path(place)}: {why}")


def closed_poses(mechanism: Mechanism) -> dict[str, Mapping[str, JointValue]]:
    """Return the joint values of each pose as it closes."""
    return {name: mechanism.pose(name).joint_values for name in mechanism.poses}


def _indented(urdf: Urdf) -> str:
    robot = urdf.robot()
    indent(robot)
    return tostring(robot, encoding="unicode") + "\n"


def _toml(spec: MechanismSpec, comments: Iterable[str]) -> str:
    lines = ("".join(c if c.isprintable() else " " for c in comment) for comment in comments)
    contents = msgspec.json.decode(encode_spec(spec))
    if not spec.parameters:
        del contents["parameters"]
    return "".join(f"# {line}\n" for line in lines) + tomli_w.dumps(contents)
