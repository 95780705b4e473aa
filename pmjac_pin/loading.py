"""From a name or a model file to a Mechanism: spec, URDF with its parameters, Pinocchio model."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path

import msgspec

from pmjac_pin.closing.blueprint import Blueprint
from pmjac_pin.errors import ArgumentError, PmjacError, enumerated, quoted
from pmjac_pin.files.catalog import find_model_file
from pmjac_pin.files.source import Source, read_source
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.spec import JointValue

_NO_JOINTS: tuple[str, ...] = ()


def load(
    name_or_path: str | Path,
    parameters: Mapping[str, float] | None = None,
    *,
    locked: Iterable[str] | Mapping[str, JointValue] = _NO_JOINTS,
    actuated: Iterable[str] | None = None,
    tool: str | None = None,
    tool_rows: Iterable[str] | None = None,
    tool_axes: str | None = None,
    tolerance: float | None = None,
    include_root: str | Path | None = None,
    enforce_limits: bool | None = None,
) -> Mechanism:
    """Load a mechanism of the catalogue, a model file of your own, or a file of another format.

    Parameters
    ----------
    name_or_path : str or Path
        A name from `list_mechanisms`, or the path of a model file (.toml), of a URDF with loops
        or with a YAML file beside it (.urdf), of MJCF (.xml) or of SDF (.sdf).
    parameters : mapping of str to float, optional
        Values for parameters that the model file declares, m or rad.
    locked : iterable of str, or mapping of str to float or floats, optional
        Joints to hold, beside those that the model file locks: at their values in the home pose,
        or at the values given, rad or m. A motor among them is none then, and `notes` says so.
    actuated : iterable of str, optional
        The motors, in the order of the columns of K and J, instead of those that the file tells.
    tool : str, optional
        The tool's frame, instead of the one that the file tells; all rows of its twist count
        then, unless `tool_rows` says which.
    tool_rows : iterable of str, optional
        The rows of the tool's twist that count where ranks are judged, of "vx", "vy", "vz", "wx",
        "wy" and "wz", instead of those that the file tells: ``["vx", "vy"]`` for a machine that
        moves a point in a plane.
    tool_axes : {"LOCAL_WORLD_ALIGNED", "LOCAL"}, optional
        The axes of these rows: the world's, or the tool's own.
    tolerance : float, optional
        The gap in m up to which the loops count as closed, instead of the file's, for models
        whose numbers are rounded.
    include_root : str or Path, optional
        A folder above that of an MJCF file, which you trust: the files that it includes or
        attaches may be anywhere below it, and not only below the file's own folder.
    enforce_limits : bool, optional
        Whether the file's poses keep within the limits of the joints, instead of what the file
        says, which is True unless it says so. With False a pose that is given beyond them, or
        closes only there, is taken as it is; `Configuration.limits_violated` tells.

    Raises
    ------
    UnknownNameError
        No such mechanism, parameter, motor or frame.
    ModelFileError
        The file or its URDF cannot be read, contradicts itself, or does not say which joints
        are motors (`NoMotorsError`, which has the candidates).
    ArgumentError
        A parameter outside its range, or neither a name nor a path.
    ClosureError
        The home pose does not assemble.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> pj.load("four_bar", parameters={"l1": 1.2}).parameters["l1"]
    1.2
    """
    source = read_source(find_model_file(name_or_path), actuated, tool, include_root)
    try:
        given = adjusted(
            source,
            locked,
            tool_rows,
            tool_axes,
            tolerance=tolerance,
            enforce_limits=enforce_limits,
        )
        return mechanism_of(given, parameters)
    except PmjacError as error:
        error.source = source
        raise


def adjusted(
    source: Source,
    locked: Iterable[str] | Mapping[str, JointValue],
    tool_rows: Iterable[str] | None,
    tool_axes: str | None,
    *,
    tolerance: float | None,
    enforce_limits: bool | None,
) -> Source:
    """Return what a file says, but for what `load` was given in place of it.

    Raises
    ------
    ArgumentError
        A motor that was given is locked; values that are none.
    """
    spec = source.spec
    if locked is not _NO_JOINTS:
        spec = spec.with_locked(locked)
    if not (tool_rows is None and tool_axes is None):
        spec = spec.with_tool_rows(tool_rows, tool_axes)
    if both := [name for name in source.driven if name not in spec.actuated]:
        raise ArgumentError(f"joint {quoted(both[0])} is given as `actuated` and as `locked`")
    if held := [name for name in source.spec.actuated if name not in spec.actuated]:
        note = f"held, and so no motor: {enumerated(held)}"
        source = replace(source, notes=(*source.notes, note))
    if tolerance is not None:
        spec = msgspec.structs.replace(spec, tolerance=tolerance)
    if enforce_limits is not None:
        spec = msgspec.structs.replace(spec, enforce_limits=enforce_limits)
    return replace(source, spec=spec)


def mechanism_of(source: Source, parameters: Mapping[str, float] | None = None) -> Mechanism:
    """Return the mechanism that a file describes, at these values of its parameters.

    Raises
    ------
    ModelFileError, ClosureError, UnknownNameError, ArgumentError
        As in `load`.
    """
    blueprint = Blueprint(str(source.path), source.spec, source.urdf)
    parts = blueprint.parts(parameters)
    return Mechanism(parts, notes=source.all_notes, unread=source.unread, blueprint=blueprint)
