"""``pmjac reach``."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
import pinocchio as pin
from cyclopts import Parameter

from pmjac_pin.cli.options import Choice, NameOption, parsed_values
from pmjac_pin.cli.output import Json, Output, Verdict
from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.tool_rows import TWIST_ROWS
from pmjac_pin.studies.reach.reach import reach
from pmjac_pin.studies.reach.working_modes import working_modes
from pmjac_pin.words.reach_tables import (
    reached_blocks,
    reached_told,
    working_modes_blocks,
    working_modes_told,
)

_OF_ORIENTATION = 3  # roll, pitch, yaw


def reach_command(
    mechanism: NameOption,
    /,
    *,
    target: Annotated[
        str,
        Parameter(
            help="Of the tool, m and rad: x,y,z, or with roll,pitch,yaw behind them; some of x, y, "
            "z and angle by name, such as x=0.2,y=0.4; or joints by theirs, such as pitch=0.1."
        ),
    ],
    from_: Annotated[
        str, Parameter(name="--from", help="The pose from which to go there (home).")
    ] = "home",
    mask: Annotated[
        str | None,
        Parameter(
            help="What of it counts, 1 or 0 for each of vx,vy,vz,wx,wy,wz: 1,1,1,0,0,0 is the "
            "position of a pose."
        ),
    ] = None,
    modes: Annotated[
        bool, Parameter(help="All working modes there, not that of the pose.")
    ] = False,
    choice: Choice = Choice(),
    json: Json = False,
) -> Verdict:
    """Find the motor values that put the tool somewhere, or say what keeps it from there."""
    machine = choice.load(mechanism)
    given, limits = _target(target), machine.spec.enforce_limits
    counts = None if mask is None else _mask(mask)
    if modes:
        return Verdict(_modes(machine, given, counts, limits, json), 0)
    found = reach(machine, given, mask=counts, guess=from_, limits=limits)
    return Verdict(reached_told(found) if json else reached_blocks(found), 0 if found else 1)


def _modes(
    machine: Mechanism, target: Any, mask: list[bool] | None, limits: bool, json: bool
) -> Output:
    found = working_modes(machine, target, mask=mask, rng=0, limits=limits)
    return working_modes_told(machine, found) if json else working_modes_blocks(found)


def _target(text: str) -> Any:
    """Return the target that an option gives."""
    given = parsed_values("--target", text)
    if isinstance(given, dict):
        return given
    if not np.isfinite(given).all():
        raise ArgumentError(f"--target takes finite numbers, got {text}")
    match given:
        case [_, _, _]:
            return given
        case [x, y, z, *angles] if len(angles) == _OF_ORIENTATION:
            return pin.SE3(pin.rpy.rpyToMatrix(*angles), np.array([x, y, z]))
        case _:
            wanted = "x,y,z, or x,y,z,roll,pitch,yaw, or some by name, such as x=0.2,y=0.4"
            raise ArgumentError(f"--target takes {wanted}; got {len(given)} numbers: {text}")


def _mask(text: str) -> list[bool]:
    """Return the mask that an option gives."""
    given = [item.strip() for item in text.split(",")]
    if len(given) != len(TWIST_ROWS) or not set(given) <= {"0", "1"}:
        wanted = f"1 or 0 for each of {','.join(TWIST_ROWS)}, such as 1,1,1,0,0,0"
        raise ArgumentError(f"--mask takes {wanted}; got {quoted(text)}")
    return [item == "1" for item in given]
