"""What was written, read again: whether it is the same machine."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from pmjac_pin.errors import ArgumentError, MissingDependencyError, NoJacobianError, PmjacError
from pmjac_pin.loading import load
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.export.plain_machine import PlainMachine
from pmjac_pin.values.arrays import Array

_SAME_JACOBIAN = 1e-9  # relative, between J_eq of the file and of the mechanism


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
    if again.mobility != mechanism.mobility:
        got = f"its mobility is {again.mobility} in the file and {mechanism.mobility} here"
        raise ArgumentError(f"{mechanism.name} cannot be written so: {got}")
    return _compared(mechanism, again)


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


def _compared(mechanism: Mechanism, again: Mechanism) -> Evidence:
    try:
        expected = mechanism.home.jacobian().J_eq
    except NoJacobianError:
        return Evidence("tolerance", "read again, the file closes at home and has its mobility")
    difference = _relative(again.home.jacobian().J_eq, expected, mechanism.characteristic_length)
    if not difference <= max(_SAME_JACOBIAN, mechanism.tolerance / mechanism.characteristic_length):
        got = f"J_eq of the file differs by {difference:.1g}"
        raise ArgumentError(f"{mechanism.name} cannot be written so: {got}")
    statement = f"read again, the file has this J_eq at home to {difference:.1g}, and its mobility"
    return Evidence("tolerance", statement)


def _relative(found: Array, expected: Array, length: float) -> float:
    """Return the largest difference of a J_eq, beside its largest entry."""
    weights = np.repeat([1.0, length], 3)[:, None]
    size = np.abs(weights * expected).max(initial=0.0)
    return float(np.abs(weights * (found - expected)).max(initial=0.0) / (size or 1.0))
