"""Export: a mechanism, closed, in a file of the format that another program reads."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from xml.etree.ElementTree import indent, tostring

from pmjac_pin.errors import ArgumentError, OutputError, did_you_mean, quoted
from pmjac_pin.files.output_file import check_new, check_place, write_files
from pmjac_pin.files.urdf.extended_urdf import closure_yaml_beside
from pmjac_pin.files.user_path import followed_link, output_path, readable, real, shown_path
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.convert import checked_model_file, model_file_places, model_file_texts
from pmjac_pin.studies.export.exported import Exported
from pmjac_pin.studies.export.extended_urdf import extended_urdf
from pmjac_pin.studies.export.mjcf import mjcf
from pmjac_pin.studies.export.model_file import as_built, as_read
from pmjac_pin.studies.export.names import check_names
from pmjac_pin.studies.export.plain_machine import PlainMachine, Written
from pmjac_pin.studies.export.sdf import sdf
from pmjac_pin.studies.export.take_apart import taken_apart
from pmjac_pin.studies.export.urdf_plus import urdf_plus
from pmjac_pin.studies.export.written_again import compared, link_places, read_again
from pmjac_pin.values.checks import as_flag, check_kind

#: What writes a machine for a folder, and the ends of the files' names.
WRITERS: Mapping[str, tuple[Callable[[PlainMachine, Path], Written], tuple[str, ...]]] = (
    MappingProxyType(
        {
            "mjcf": (mjcf, (".xml", ".mjcf")),
            "sdf": (sdf, (".sdf",)),
            "extended-urdf": (extended_urdf, (".urdf",)),
            "urdf-plus": (urdf_plus, (".urdf",)),
        }
    )
)
_MODEL_FILE = "toml"
FORMATS = (*WRITERS, _MODEL_FILE)


def export(mechanism: Mechanism, *, to: str, file: str | Path, force: bool = False) -> Exported:
    """Write a mechanism, closed, for another program.

    The machine is the mechanism at its parameters' values. Before anything is put in its place the
    files are read again by the library's own readers, and compared: mobility, and J_eq at home.

    Parameters
    ----------
    mechanism : Mechanism
    to : {"mjcf", "sdf", "extended-urdf", "urdf-plus", "toml"}
        `docs/export.md` says which joints and loops each format has, and what becomes of others.
    file : str or Path
        Ends in ``.xml`` (or ``.mjcf``), ``.sdf``, ``.urdf`` or ``.toml``. Beside an extended URDF
        goes a YAML file of its name, beside a model file a URDF.
    force : bool
        Replace files that exist; never those that the mechanism was read from.

    Returns
    -------
    Exported
        The files, and one sentence for each thing that they say otherwise than the mechanism.

    Raises
    ------
    ArgumentError
        No such format; or the machine has what the format cannot say.
    OutputError
        The file exists, or has another ending, or cannot be written. Then nothing has changed.

    Examples
    --------
    >>> import tempfile, pmjac_pin as pj
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     exported = pj.export(pj.load("four_bar"), to="urdf-plus", file=f"{folder}/bar.urdf")
    ...     again = pj.load(exported.paths[0], tool="coupler_midpoint")
    >>> again.actuated, again.mobility
    (('theta1',), 1)
    """
    check_kind(mechanism, Mechanism)
    force = as_flag(force, "force")
    if to not in FORMATS:
        raise ArgumentError(f"`to` is a format, got {quoted(to)}{did_you_mean(str(to), FORMATS)}")
    if to == _MODEL_FILE:
        return _as_model_file(mechanism, file, force)
    write, suffixes = WRITERS[to]
    target = _file_to_write(file, to, suffixes)
    machine = taken_apart(mechanism)
    check_names(machine)
    written = write(machine, target.parent)
    files = {target: _text(written)}
    if written.beside:
        files[target.with_suffix(".yaml")] = written.beside.encode()
    _check_targets(mechanism, target, files, force)
    again = read_again(
        mechanism, written.machine, {path.name: text for path, text in files.items()}
    )
    write_files(files, replace=force)
    return Exported(
        paths=tuple(files),
        actuated=written.machine.motors,
        tool=written.machine.tool,
        notes=(*written.notes, *_unsaid(mechanism, written.machine.tool, to)),
        evidence=again,
    )


def _as_model_file(mechanism: Mechanism, file: str | Path, force: bool) -> Exported:
    given = checked_model_file(file)
    places = model_file_places(given, _files_read(mechanism), force)
    if (found := as_read(mechanism)) is None:
        machine = taken_apart(mechanism)
        check_names(machine)
        found = as_built(mechanism, machine, places[1])
    spec, urdf = found
    comments = (f"From {mechanism.name}.", *mechanism.notes)
    files, again = model_file_texts(places, spec, urdf, comments)
    evidence = compared(mechanism, again, link_places(mechanism))
    write_files(files, replace=force)
    tool = () if spec.tool.is_none else spec.tool.names
    return Exported(places, spec.actuated, tool, (), evidence)


def _file_to_write(file: str | Path, to: str, suffixes: tuple[str, ...]) -> Path:
    """Return where the file goes: where a link leads."""
    given = output_path(file)
    target = followed_link(given)
    for path in (given, target):
        if path.suffix.lower() not in suffixes:
            ends = " or ".join(suffixes)
            raise OutputError(f"{shown_path(path)}: the name of a file of {to} ends in {ends}")
    if readable(target.name) != target.name:
        raise OutputError(f"{shown_path(target)}: the file's name is no UTF-8 text")
    check_place(target)
    return target


def _files_read(mechanism: Mechanism) -> set[Path]:
    """Return the files that a mechanism was read from, which are never replaced."""
    if (blueprint := mechanism.blueprint) is None:
        return set()
    return {real(Path(path)) for path in (blueprint.path, blueprint.urdf.path)}


def _check_targets(
    mechanism: Mechanism, target: Path, files: Mapping[Path, bytes], force: bool
) -> None:
    """Refuse to replace what was read or, unless told to, what exists; and what would be read."""
    for path in files:
        if real(path) in _files_read(mechanism):
            raise OutputError(f"{shown_path(path)}: is what was read, and is not replaced")
        check_new(path, force)
    other = closure_yaml_beside(target) if target.suffix.lower() == ".urdf" else None
    if other is not None and target.with_suffix(".yaml") not in files:
        why = f"would be read with {shown_path(target.name)}, as an extended URDF; move it away"
        raise OutputError(f"{shown_path(other)}: {why}")


def _text(written: Written) -> bytes:
    indent(written.root)
    text = tostring(written.root, encoding="unicode")
    return f'<?xml version="1.0"?>\n{text}\n'.encode()


def _unsaid(mechanism: Mechanism, tool: tuple[str, ...], to: str) -> tuple[str, ...]:
    """Return what no format but our own says of a mechanism."""
    spec, notes = mechanism.spec, []
    if tool:
        names = ", ".join(map(repr, tool))
        notes.append(f"{to} does not say what the tool is: {names}")
    if spec.parameters:
        notes.append(f"{to} has no parameters: they are at their values")
    if spec.tolerance is not None:
        notes.append(f"{to} has no tolerance: read it with {spec.tolerance:g} m")
    if to != "mjcf" and len(mechanism.poses) > 1:
        notes.append(f"{to} has one pose: home")
    return tuple(notes)
