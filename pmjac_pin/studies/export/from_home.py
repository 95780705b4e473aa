"""From where values count: from the home pose in formats that have no other, or from zero."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from pmjac_pin.files.joint_dialects import listed
from pmjac_pin.model.loop_spec import JointLoop
from pmjac_pin.studies.export.plain_machine import PlainMachine, PlainStep

_AT_A_LIMIT = 1e-9  # m or rad: of a limit at which home stands


class FromHome:
    """A machine's values as they count from home, where all are 0.

    Parameters
    ----------
    machine : PlainMachine
    """

    pose = "home"

    def __init__(self, machine: PlainMachine) -> None:
        self._machine, self._home = machine, machine.poses["home"]
        self._widened: list[str] = []

    def limits(self, step: PlainStep) -> tuple[float, float]:
        """Return a step's limits, with home within them."""
        home = self._home[step.name][0]
        lower, upper = step.limits[0] - home, step.limits[1] - home
        if max(lower, -upper) > _AT_A_LIMIT:
            self._widened.append(step.name)
        return min(lower, 0.0), max(upper, 0.0)

    def gears(self) -> list[JointLoop]:
        """Return the joint loops."""
        loops = [loop for loop in self._machine.loops if isinstance(loop, JointLoop)]
        return [
            JointLoop(joints=gear.joints, ratio=gear.ratio, offset=self._offset(gear))
            for gear in loops
        ]

    def _offset(self, gear: JointLoop) -> float:
        first, second = (self._home[name][0] for name in gear.joints)
        return gear.offset + gear.ratio * first - second

    def notes(self) -> Iterator[str]:
        """Yield what is to be said of values that are others in the file."""
        moved = [
            step.name
            for step in self._machine.steps
            if step.single and abs(self._home[step.name][0]) > _AT_A_LIMIT
        ]
        if moved:
            yield f"values in the file count from home, where they are 0: {listed(moved)}"
        if self._widened:
            beyond = listed(self._widened)
            yield f"home is beyond the limits of {beyond}, which are widened to hold it"


class FromZero:
    """A machine's values as they are, for files that have a home pose of their own."""

    pose = None

    def limits(self, step: PlainStep) -> tuple[float, float]:
        """Return a step's limits."""
        return step.limits


def counted(machine: PlainMachine) -> Collection[str]:
    """Return the steps whose turns count, since they are geared."""
    geared = (loop.joints for loop in machine.loops if isinstance(loop, JointLoop))
    return {name for joints in geared for name in joints}
