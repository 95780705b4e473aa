"""What a caller asks of a sweep, checked."""

from __future__ import annotations

import hashlib
import pickle
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from pmjac_pin.errors import ArgumentError, unknown_name
from pmjac_pin.loading import load
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.limits import enforced
from pmjac_pin.model.spec import encode_spec
from pmjac_pin.studies.sweep.points import Points
from pmjac_pin.studies.sweep.variables import VARIABLES, labels_of
from pmjac_pin.studies.sweep.work import SweepWork
from pmjac_pin.values.checks import as_names


def question(
    machine: Mechanism | str | Path,
    points: Points,
    measures: Iterable[str],
    guess: str,
    enforce_limits: bool | str,
) -> tuple[SweepWork, Mechanism]:
    """Return what is to be computed, and the machine at its own parameters.

    Raises
    ------
    ArgumentError, UnknownNameError
        As `sweep`.
    """
    mechanism = machine if isinstance(machine, Mechanism) else load(machine)
    swept = _parameters(mechanism, points)
    wanted = as_names(measures, "`measures` is a list of names")
    for name in wanted:
        if name not in VARIABLES:
            raise unknown_name("measure", name, tuple(VARIABLES))
    mechanism.pose(guess)
    enforced(enforce_limits)
    labels = labels_of(mechanism)
    if taken := [name for name in points.dims if name in {*labels, *VARIABLES, "done"}]:
        raise ArgumentError(f"an axis of this name cannot be told from another: {taken[0]!r}")
    work = SweepWork(
        machine=pickle.dumps(mechanism),
        points=points,
        motors=tuple(name for name in points.values if name not in swept),
        parameters=swept,
        measures=tuple(dict.fromkeys(("status", *wanted))),
        labels=labels,
        designs=points.different(swept),
        guess=guess,
        enforce_limits=enforce_limits,
    )
    return work, mechanism


def identity(work: SweepWork, mechanism: Mechanism, chunk: tuple[int, ...]) -> dict[str, Any]:
    """Return what tells a sweep from others, as plain data."""
    values = {name: _digest(column.tobytes()) for name, column in work.points.values.items()}
    said = encode_spec(mechanism.spec) + mechanism.model.saveToString().encode()
    return {
        "name": mechanism.name,
        "mechanism": _digest(said + repr(dict(mechanism.parameters)).encode()),
        "dimensions": list(work.points.dims),
        "values": values,
        "measures": list(work.measures),
        "guess": work.guess,
        "enforce_limits": work.enforce_limits,
        "chunk": list(chunk),
    }


def _digest(contents: bytes) -> str:
    return hashlib.sha256(contents).hexdigest()


def _parameters(mechanism: Mechanism, points: Points) -> tuple[str, ...]:
    """Return the parameters among the points' names, their values checked."""
    motors, parameters = mechanism.actuated, mechanism.spec.parameters
    swept = tuple(name for name in points.values if name in parameters)
    for name in points.values:
        if name in motors and name in parameters:
            raise ArgumentError(f"{name!r} is a motor and a parameter: rename one of them")
        if name not in (*motors, *parameters):
            raise unknown_name("motor or parameter", name, (*motors, *parameters))
    for extreme in ("min", "max"):
        mechanism.spec.parameter_values(
            {name: float(getattr(points.values[name], extreme)()) for name in swept}
        )
    return swept
