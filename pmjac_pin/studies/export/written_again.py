"""What was written, read again: whether it is the same machine."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pinocchio as pin

from pmjac_pin.errors import ArgumentError, MissingDependencyError, NoJacobianError, PmjacError
from pmjac_pin.loading import load
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.export.plain_machine import PlainMachine
from pmjac_pin.values.arrays import Array

_ONE_MACHINE = 1e-9  # relative, between the file and the mechanism


def read_again(mechanism: Mechanism, machine: PlainMachine, files: dict[str, bytes]) -> Evidence:
    """Return what is known of files, the first of which is loaded where nobody sees it.

    Raises
    ------
    ArgumentError
        It cannot be read, or is another machine.
    """
    with TemporaryDirectory() as folder:
        for name, contents in files.items():
            (Path(folder) / name).write_bytes(contents)
        try:
            again = _loaded(Path(folder) / next(iter(files)), mechanism, machine)
        except MissingDependencyError as error:
            return Evidence("nothing", f"the file was not read again: {error}")
        except PmjacError as error:
            said = str(error).replace(f"{folder}/", "")
            raise ArgumentError(f"{mechanism.name} cannot be written so: {said}") from error
    placed = machine.placements()
    ends = machine.frames.items()
    places = {name: (placed[body] * place).translation for name, (body, place) in ends}
    return compared(mechanism, again, places)


def _loaded(path: Path, mechanism: Mechanism, machine: PlainMachine) -> Mechanism:
    spec = mechanism.spec
    again = load(
        path,
        actuated=machine.motors,
        tolerance=spec.tolerance,
        enforce_limits=spec.enforce_limits,
    )
    return (
        again.with_tool(machine.tool if len(machine.tool) > 1 else machine.tool[0])
        if machine.tool
        else again
    )


def compared(mechanism: Mechanism, again: Mechanism, places: Mapping[str, Array]) -> Evidence:
    """Return what is known of a mechanism that was read again.

    Parameters
    ----------
    mechanism, again : Mechanism
    places : mapping of str to ndarray, shape (3,)
        Where links are at home, by their names in the file, m.

    Raises
    ------
    ArgumentError
        It is another machine.
    """
    if again.mobility != mechanism.mobility:
        got = f"its mobility is {again.mobility} in the file and {mechanism.mobility} here"
        raise ArgumentError(f"{mechanism.name} cannot be written so: {got}")
    length = mechanism.characteristic_length
    allowed = max(_ONE_MACHINE, 10.0 * mechanism.tolerance / length)
    found_places = link_places(again)
    ways = [places[name] - found_places[name] for name in set(places) & set(found_places)]
    apart = float(np.abs(ways).max(initial=0.0)) / length
    differences = {"links": apart}
    with contextlib.suppress(NoJacobianError):
        expected = mechanism.home.jacobian().J_eq
        found = again.home.jacobian().J_eq
        differences["J_eq"] = _relative(found, expected, length)
    for what, difference in differences.items():
        if not difference <= allowed:
            got = f"{what} at home differ by {difference:.1g} in the file"
            raise ArgumentError(f"{mechanism.name} cannot be written so: {got}")
    numbers = " and ".join(f"{what} to {number:.1g}" for what, number in differences.items())
    return Evidence("tolerance", f"read again, the file has at home the same {numbers}")


def link_places(mechanism: Mechanism) -> dict[str, Array]:
    """Return where links are at home, m."""
    model = mechanism.model
    data = model.createData()
    pin.framesForwardKinematics(model, data, mechanism.home.q)
    return {
        frame.name: data.oMf[k].translation.copy()
        for k, frame in enumerate(model.frames)
        if frame.type == pin.FrameType.BODY
    }


def _relative(found: Array, expected: Array, length: float) -> float:
    """Return the largest difference of a J_eq, beside its largest entry."""
    weights = np.repeat([1.0, length], 3)[:, None]
    size = np.abs(weights * expected).max(initial=0.0)
    return float(np.abs(weights * (found - expected)).max(initial=0.0) / (size or 1.0))
