"""Motors of several freedoms, which not every format has."""

from __future__ import annotations

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.studies.export.plain_machine import PlainMachine


def refuse_planar_motors(machine: PlainMachine, to: str) -> None:
    """Refuse a planar motor, whose rates are along axes that turn with it: steps do not turn.

    Raises
    ------
    ArgumentError
    """
    for joint in machine.joints:
        if joint.kind == "planar" and joint.driven:
            what = f"{to} has no planar motor, as {quoted(joint.name)} is"
            raise ArgumentError(f"{what}; extended-urdf or toml would do")


def refuse_turning_motors(machine: PlainMachine, to: str) -> None:
    """Refuse a motor that turns in several ways at once.

    Raises
    ------
    ArgumentError
    """
    for joint in machine.joints:
        if not all(step.single for step in joint.steps if step.driven):
            what = f"{to} has no motor that turns any way, as {quoted(joint.name)} does"
            raise ArgumentError(f"{what}; mjcf, extended-urdf or toml would do")
