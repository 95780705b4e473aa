"""From a name or a model file to a Mechanism: spec, URDF with its parameters, Pinocchio model."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from pmjac_pin.closing.assembly import build_parts, home_pose
from pmjac_pin.errors import ArgumentError, ClosureError, ModelFileError, PmjacError
from pmjac_pin.files.catalog import find_model_file
from pmjac_pin.files.source import Source, read_source
from pmjac_pin.files.urdf.locking import lock_joints
from pmjac_pin.files.urdf.robot import Urdf
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.linkage import with_helical, with_spherical
from pmjac_pin.model.spec import JointValue, MechanismSpec

_PARAMETER_STEPS = 12
_LEAST_SHARE = 0.4  # of home's σ_min: below, the motors move on the way to other parameters


def load(
    name_or_path: str | Path,
    parameters: Mapping[str, float] | None = None,
    *,
    locked: Iterable[str] | Mapping[str, JointValue] = (),
    actuated: Iterable[str] | None = None,
    tool: str | None = None,
    tool_rows: Iterable[str] | None = None,
    tool_axes: str | None = None,
    tolerance: float | None = None,
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
        or at the values given, rad or m.
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

    Raises
    ------
    UnknownNameError
        No such mechanism, parameter, motor or frame.
    ModelFileError
        The file or its URDF cannot be read, contradicts itself, or does not say which joints
        are motors and which frame is the tool.
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
    source = read_source(find_model_file(name_or_path), actuated, tool)
    try:
        return mechanism_of(adjusted(source, locked, tool_rows, tool_axes, tolerance), parameters)
    except PmjacError as error:
        error.source = source
        raise


def adjusted(
    source: Source,
    locked: Iterable[str] | Mapping[str, JointValue],
    tool_rows: Iterable[str] | None,
    tool_axes: str | None,
    tolerance: float | None,
) -> Source:
    """Return what a file says, but for what `load` was given in place of it."""
    spec = source.spec.with_locked(locked).with_tool_rows(tool_rows, tool_axes)
    if tolerance is not None:
        spec = msgspec.structs.replace(spec, tolerance=tolerance)
    return replace(source, spec=spec)


def mechanism_of(source: Source, parameters: Mapping[str, float] | None = None) -> Mechanism:
    """Return the mechanism that a file describes, at these values of its parameters.

    Raises
    ------
    ModelFileError, ClosureError, UnknownNameError, ArgumentError
        As in `load`.
    """
    spec = source.spec
    values = spec.parameter_values(parameters)
    try:
        urdf = _set(source.urdf, spec, values)
        start = _home_on_the_way(source.urdf, spec, values)
        parts = build_parts(_pinocchio_model(urdf, spec), spec, values, urdf, start)
        return Mechanism(parts, notes=source.all_notes, unread=source.unread)
    except (ClosureError, ModelFileError):
        raise
    except PmjacError as error:
        raise ModelFileError(f"{source.path}: {error}", path=str(source.path)) from error


def _home_on_the_way(
    urdf: Urdf, spec: MechanismSpec, values: Mapping[str, float]
) -> NDArray[np.float64] | None:
    """Return the home pose just before these parameters, followed from their defaults.

    At once, an assembly from the default's home pose might end on another assembly mode; and
    with the motors at rest as long as they can be, beside a singularity.
    """
    defaults, q, least = spec.parameter_values(), None, (0, 0.0)
    if dict(values) == dict(defaults):
        return None
    for share in np.arange(_PARAMETER_STEPS) / _PARAMETER_STEPS:
        between = {name: start + share * (values[name] - start) for name, start in defaults.items()}
        model = _pinocchio_model(_set(urdf, spec, between), spec)
        with contextlib.suppress(ClosureError):  # parameters in between need not close
            q, (rank, smallest) = home_pose(model, spec, between, q, least)
            least = least if least[0] else (rank, _LEAST_SHARE * smallest)
    return q


def _set(plain: Urdf, spec: MechanismSpec, values: Mapping[str, float]) -> Urdf:
    """Return the URDF with its parameters at these values and its locked joints fixed."""
    return lock_joints(plain.moved(spec.moves(values)), spec.locked, spec.helical)


def _pinocchio_model(urdf: Urdf, spec: MechanismSpec) -> pin.Model:
    try:
        model = pin.buildModelFromXML(urdf.kinematic_xml())
    except (RuntimeError, ValueError) as error:
        message = f"Pinocchio cannot build the tree: {str(error).splitlines()[0]}"
        raise ArgumentError(message) from None
    if spec.spherical:
        model = with_spherical(model, spec.spherical)
    helical = {name: pitch for name, pitch in spec.helical.items() if name not in spec.locked}
    return with_helical(model, helical) if helical else model
