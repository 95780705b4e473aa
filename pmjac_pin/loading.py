"""From a name or a model file to a Mechanism: spec, URDF with its parameters, Pinocchio model."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pinocchio as pin

from pmjac_pin.assembly import build_parts
from pmjac_pin.catalog import find_model_file, find_urdf
from pmjac_pin.errors import ClosureError, ModelFileError, PmjacError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model_file import read_model_file
from pmjac_pin.urdf import read_urdf


def load(name_or_path: str | Path, parameters: Mapping[str, float] | None = None) -> Mechanism:
    """Load a mechanism of the catalogue, or a model file of your own.

    Parameters
    ----------
    name_or_path : str or Path
        A name from `list_mechanisms`, or the path of a model file.
    parameters : mapping of str to float, optional
        Values for parameters that the model file declares, m or rad.

    Raises
    ------
    UnknownNameError
        No such mechanism or parameter.
    ModelFileError
        The model file or its URDF cannot be read, or contradicts itself.
    ArgumentError
        A parameter outside its range.
    ClosureError
        The home pose does not assemble.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> pj.load("four_bar", parameters={"l1": 1.2}).parameters["l1"]
    1.2
    """
    path = find_model_file(name_or_path)
    spec = read_model_file(path)
    values = spec.parameter_values(parameters)
    try:
        urdf = read_urdf(find_urdf(spec.urdf, path)).moved(spec.moves(values))
        return Mechanism(build_parts(_pinocchio_model(urdf.kinematic_xml()), spec, values))
    except (ClosureError, ModelFileError):
        raise
    except PmjacError as error:
        raise ModelFileError(f"{path}: {error}", path=str(path)) from error


def _pinocchio_model(xml: str) -> pin.Model:
    try:
        return pin.buildModelFromXML(xml)
    except (RuntimeError, ValueError) as error:
        message = f"Pinocchio cannot build the tree: {str(error).splitlines()[0]}"
        raise ModelFileError(message) from None
