"""What a caller asks of a sweep, checked."""

from __future__ import annotations

import hashlib
import pickle
from collections.abc import Iterable, Mapping
from typing import Any

from pmjac_pin.errors import ArgumentError, unknown_name
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.limits import enforced
from pmjac_pin.model.spec import encode_spec
from pmjac_pin.studies.sweep.own_measures import OwnMeasure, asked_measures, own_measures
from pmjac_pin.studies.sweep.points import Points
from pmjac_pin.studies.sweep.variables import VARIABLES, AxisLabels, labels_of
from pmjac_pin.studies.sweep.work import SweepWork


def points_asked(mechanism: Mechanism, over: object, samples: object) -> Points:
    """Return which values of motors and parameters are asked for.

    Raises
    ------
    ArgumentError
    """
    if (over is None) == (samples is None):
        raise ArgumentError("either `over`, the axes of a grid, or `samples` is wanted")
    units = {name: mechanism.units.get(name, "") for name in mechanism.actuated}
    units |= {name: one.unit for name, one in mechanism.spec.parameters.items()}
    return Points.samples(samples, units) if over is None else Points.grid(over, units)


def question(
    mechanism: Mechanism,
    points: Points,
    measures: object,
    guess: str,
    enforce_limits: bool | str,
) -> SweepWork:
    """Return what is to be computed.

    Raises
    ------
    ArgumentError, UnknownNameError
        As `sweep`.
    """
    swept = _parameters(mechanism, points)
    wanted = asked_measures(measures)
    functions = {name: one for name, one in wanted.items() if one is not None}
    for name in wanted:
        if name not in VARIABLES and name not in functions:
            raise unknown_name("measure", name, tuple(VARIABLES))
    mechanism.pose(guess)
    enforced(enforce_limits)
    own = own_measures(functions, mechanism, guess)
    labels = labels_of(mechanism)
    _check_told_apart(points, labels, own)
    return SweepWork(
        machine=pickle.dumps(mechanism),
        points=points,
        motors=tuple(name for name in points.values if name not in swept),
        parameters=swept,
        measures=tuple(dict.fromkeys(("status", *wanted))),
        own=own,
        labels=labels | {dim: one for measure in own for dim, one in measure.dims.items()},
        designs=points.different(swept),
        guess=guess,
        enforce_limits=enforce_limits,
    )


def _check_told_apart(
    points: Points, labels: Mapping[str, AxisLabels], own: Iterable[OwnMeasure]
) -> None:
    """Raise ArgumentError where two things of the dataset have one name."""
    taken = {*labels, *VARIABLES, "done"}
    for name in points.dims:
        if name in taken:
            raise ArgumentError(f"an axis of this name cannot be told from another: {name!r}")
    taken |= {*points.dims, *points.values}
    for name in (name for one in own for name in (one.name, *one.dims)):
        if name in taken:
            raise ArgumentError(
                f"a measure of one's own cannot be told from what has this name already: {name!r}"
            )
        taken.add(name)


def identity(work: SweepWork, mechanism: Mechanism, chunk: tuple[int, ...]) -> dict[str, Any]:
    """Return what tells a sweep from others, as plain data."""
    values = {name: _digest(column.tobytes()) for name, column in work.points.values.items()}
    shapes = {one.name: [one.name, list(one.shape)] for one in work.own}  # all that is known
    said = encode_spec(mechanism.spec) + mechanism.model.saveToString().encode()
    return {
        "name": mechanism.name,
        "mechanism": _digest(said + repr(dict(mechanism.parameters)).encode()),
        "dimensions": list(work.points.dims),
        "values": values,
        "measures": [shapes.get(name, name) for name in work.measures],
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
