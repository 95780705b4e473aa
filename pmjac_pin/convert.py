"""Writing a mechanism of any format as our own model file and its URDF."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Mapping, Set
from pathlib import Path
from xml.etree.ElementTree import indent, tostring

import msgspec
import tomli_w

from pmjac_pin.catalog import find_model_file
from pmjac_pin.errors import ModelFileError
from pmjac_pin.loading import adjusted, build, load
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.source import read_source
from pmjac_pin.spec import JointValue, MechanismSpec, encode_spec
from pmjac_pin.urdf_xml import parse_xml


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
    force: bool = False,
) -> tuple[Path, Path]:
    """Write a mechanism as a model file, its URDF beside it.

    The poses are written as they close, so that the new file loads with the same home pose and
    the same J_eq. Meshes stay where they are: the URDF names them as it did.

    Parameters
    ----------
    name_or_path, actuated, tool, tool_rows, tool_axes, locked, tolerance
        As in `load`.
    output : str or Path
        The new model file; its name ends in ``.toml``.
    force : bool
        Replace files that exist; never those that are read.

    Returns
    -------
    tuple of Path
        The model file and the URDF.

    Raises
    ------
    ModelFileError
        The output exists or is no ``.toml``, besides what `load` raises.
    OSError
        The output cannot be written. Then nothing has changed: both files are written under
        other names first, and loaded.

    Examples
    --------
    >>> import tempfile, pmjac_pin as pj
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     model_file, urdf = convert("four_bar", f"{folder}/mine.toml")
    ...     pj.load(model_file)
    Mechanism(mine, actuated=(theta1), 2 passive, 1 loop, mobility 1)
    """
    path, target = find_model_file(name_or_path), Path(output).expanduser()
    source = adjusted(read_source(path, actuated, tool), locked, tool_rows, tool_axes, tolerance)
    read = {path.resolve(), Path(source.urdf.path).resolve()}
    tree = _urdf_beside(target, read)
    _check_places(target, tree, read, force)
    mechanism = build(source)
    spec = msgspec.structs.replace(
        source.spec, name="", urdf=tree.name, poses=_closed_poses(mechanism)
    )
    texts = {
        tree: _indented(source.urdf.text),
        target: _toml(spec, (f"From {path.name}.", *source.notes)),
    }
    _write_together(texts, target)
    return target, tree


def _urdf_beside(target: Path, read: Set[Path]) -> Path:
    """Return where the tree goes: not where a file is that was read."""
    beside = target.with_suffix(".urdf")
    return beside.with_name(f"{target.stem}_tree.urdf") if beside.resolve() in read else beside


def _check_places(target: Path, tree: Path, read: Set[Path], force: bool) -> None:
    if target.suffix != ".toml":
        raise _refused(target, "a model file's name ends in .toml")
    if not target.parent.is_dir():
        raise _refused(target, f"there is no folder {target.parent}")
    for place in (target, tree):
        if place.resolve() in read:
            raise _refused(place, "is what is read, and is not replaced")
        if place.exists() and not (force and place.is_file()):
            raise _refused(place, "exists already" + "; --force replaces it" * place.is_file())


def _refused(place: Path, why: str) -> ModelFileError:
    return ModelFileError(f"{place}: {why}", path=str(place))


def _closed_poses(mechanism: Mechanism) -> dict[str, Mapping[str, JointValue]]:
    return {name: mechanism.pose(name).joint_values for name in mechanism.poses}


def _indented(urdf: str) -> str:
    robot = parse_xml(urdf)
    indent(robot)
    return tostring(robot, encoding="unicode") + "\n"


def _toml(spec: MechanismSpec, comments: Iterable[str]) -> str:
    lines = ("".join(c if c.isprintable() else " " for c in comment) for comment in comments)
    contents = msgspec.json.decode(encode_spec(spec))
    if not spec.parameters:
        del contents["parameters"]
    return "".join(f"# {line}\n" for line in lines) + tomli_w.dumps(contents)


def _write_together(texts: Mapping[Path, str], model_file: Path) -> None:
    """Write all under other names and load the model file; then put them in their places."""
    with tempfile.TemporaryDirectory(dir=model_file.parent, prefix=".pmjac_") as staging:
        for place, text in texts.items():
            (Path(staging) / place.name).write_text(text, encoding="utf-8")
        load(Path(staging) / model_file.name)
        for place in texts:
            (Path(staging) / place.name).replace(place)
