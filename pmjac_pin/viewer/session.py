"""What the page does, as plain Python: a pose, what is drawn, and commands that change them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import assert_never

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError, ClosureError, LimitError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.limits import Violation
from pmjac_pin.pictures.within_limits import ToolQuantity
from pmjac_pin.studies.follow.trajectory import Trajectory
from pmjac_pin.viewer.design import Design, is_sibling
from pmjac_pin.viewer.framing import Framing, frame
from pmjac_pin.viewer.leaving import beside_singularity, shortly_before
from pmjac_pin.viewer.load import Load
from pmjac_pin.viewer.messages import (
    Home,
    MoveMotors,
    NamedPose,
    Notice,
    Options,
    PoseCommand,
    SetLoad,
    ShowMoment,
)
from pmjac_pin.viewer.motors import WIDEST_SLIDER
from pmjac_pin.viewer.readout import Readout, make_readout
from pmjac_pin.viewer.replay import Replay
from pmjac_pin.viewer.scene import Scene
from pmjac_pin.viewer.scene_options import SceneOptions

_NO_NOTICE = Notice("", "")


class Session:
    """The pose that all tabs see, and what is drawn of it. Not thread-safe.

    A command either succeeds, or raises a `PmjacError` and changes nothing. A motion that meets
    the end of its assembly mode is no error: it goes as far as the loops close, and `notice`
    says why.

    Parameters
    ----------
    configuration : Configuration
        The first pose.
    options : SceneOptions

    Raises
    ------
    ArgumentError
        What is to be shown is no configuration.

    Attributes
    ----------
    design : Design
        The mechanism with the parameters of now.
    configuration : Configuration
    options : SceneOptions
    load : Load
        At the tool.
    notice : Notice
        Why the last motion ended early, if it did.
    pose : str or None
        The name of the pose, if it is a named one.
    replay : Replay or None
        A trajectory that is played.
    moment : float or None
        Its parameter, where the pose is one of it.
    """

    def __init__(self, configuration: Configuration, options: SceneOptions) -> None:
        if not isinstance(configuration, Configuration):
            kind = type(configuration).__name__
            hint = "; its home pose is mechanism.home" if kind == "Mechanism" else ""
            raise ArgumentError(f"a viewer shows a Configuration, got a {kind}{hint}")
        self.design = Design.of(configuration.mechanism)
        self.configuration = configuration
        self.options = options
        self.load = Load()
        self.notice = _NO_NOTICE
        self.pose = self._name_of(configuration)
        self.replay: Replay | None = None
        self.moment: float | None = None
        self._start = configuration
        self._directions: Mapping[ToolQuantity, NDArray[np.float64]] = {}

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism, with the parameters of now."""
        return self.design.mechanism

    @property
    def start(self) -> Configuration:
        """From where motors go on: right before a pose at which a motion has ended, or the pose."""
        return self._start

    def obey(self, command: PoseCommand) -> None:
        """Carry out a command of a page.

        Raises
        ------
        PmjacError
            It cannot be carried out; nothing has changed.
        """
        match command:
            case MoveMotors():
                self.move(command.values)
            case ShowMoment():
                self.show_moment(command.values)
            case Home():
                self._go_to(self.mechanism.home)
            case NamedPose():
                self._go_to(self.mechanism.pose(command.name))
            case Options():
                self.options = SceneOptions(**command.told())
            case SetLoad():
                self.load = Load(**command.told())
            case _:
                assert_never(command)

    def move(self, values: Sequence[float | None]) -> None:
        """Move motors, on this assembly mode, as far as the loops close.

        Parameters
        ----------
        values : sequence of float or None
            One for each motor, m or rad; None where it stays.

        Raises
        ------
        ArgumentError
            Another number of values, a value that is not finite, or one beyond the limits.
        """
        target = self._target(values)
        try:
            found, notice = self._close(target), _NO_NOTICE
        except LimitError as error:
            beyond = Violation(error.value, error.lower, error.upper, error.unit)
            raise ArgumentError(f"{error.joint} = {beyond.words}") from None
        except ClosureError as error:
            if error.reached is None:
                raise
            found, notice = error.reached, self._stop(target, error)
        ended = bool(notice.kind) or found.singularity().is_singular
        self._set(found, shortly_before(self._start, found) if ended else found, notice)

    def _target(self, values: Sequence[float | None]) -> list[float]:
        count = len(self.design.motors)
        if len(values) != count:
            raise ArgumentError(f"{count} motor values expected, got {len(values)}")
        names = self.mechanism.actuated
        target: list[float] = self.configuration.actuated.tolist()
        for motor, value in zip(self.design.motors, values, strict=True):
            if value is None:
                continue
            if not math.isfinite(value):
                raise ArgumentError("motor values must be finite numbers")
            farthest = max(WIDEST_SLIDER, -motor.lower, motor.upper)
            if abs(value) > farthest:
                message = f"{motor.name} = {value:g} is beyond ±{farthest:g} {motor.unit}"
                raise ArgumentError(message)
            target[names.index(motor.name)] = value
        return target

    def _close(self, target: list[float]) -> Configuration:
        try:
            return self.mechanism.close(target, guess=self._start)
        except ClosureError as error:
            if error.share > 0.0 or not self._start.singularity().is_singular:
                raise
            # The first pose, or one that Python has sent, was singular itself.
            beside = beside_singularity(self._start, np.asarray(target))
            if beside is None:
                raise
            return self.mechanism.close(target, guess=beside)

    def show(self, configuration: Configuration) -> None:
        """Go to a configuration of this mechanism, or of it with other parameters.

        Raises
        ------
        ArgumentError
            It is of another mechanism.
        """
        theirs = configuration.mechanism
        if theirs != self.mechanism:
            if not is_sibling(self.mechanism, theirs):
                ours = self.mechanism.name
                raise ArgumentError(
                    f"a configuration of {theirs.name!r}; this viewer shows {ours!r}"
                )
            self.design, self.replay = Design.of(theirs), None
        self._set(configuration, configuration, _NO_NOTICE)

    def play(self, trajectory: Trajectory) -> None:
        """Go to the beginning of a trajectory of this mechanism, to be played.

        Raises
        ------
        ArgumentError
            It is of another mechanism.
        """
        self.show(trajectory[0])
        self.replay = Replay(trajectory)
        self.moment = float(trajectory.t[0])

    def show_moment(self, values: Sequence[float]) -> None:
        """Go to a parameter of the trajectory, the one of these values.

        Raises
        ------
        ArgumentError
            No trajectory, another number of values, or one beyond its ends.
        """
        if self.replay is None or len(values) != 1:
            raise ArgumentError("one parameter of a trajectory is wanted, where one is shown")
        found = self.replay.at(values[0])
        self._set(found, found, _NO_NOTICE)
        self.moment = values[0]

    def adopt(self, design: Design, configuration: Configuration) -> None:
        """Go to a configuration of a design that is made already."""
        self.design, self.replay = design, None
        self._set(configuration, configuration, _NO_NOTICE)

    def _set(self, configuration: Configuration, start: Configuration, notice: Notice) -> None:
        self.configuration = configuration
        self._start = start
        self.notice = notice
        self.moment = None
        self.pose = self._name_of(configuration)

    def _go_to(self, configuration: Configuration) -> None:
        self.show(configuration)
        self._directions = {}  # a named pose always looks the same

    def scene(self) -> Scene:
        """Return what is to be drawn now; its arrows go on from those of the last one."""
        force = self.load.force(self.mechanism)
        maker = self.design.maker
        scene = maker.scene(self.configuration, self.options, self._directions, force)
        self._directions = scene.directions
        return scene

    def _name_of(self, configuration: Configuration) -> str | None:
        # The same value, not an equal one: other assembly modes share the motor values.
        named = self.design.poses.items()
        return next((name for name, pose in named if np.array_equal(pose.q, configuration.q)), None)

    def readout(self) -> Readout:
        """Return the numbers at the current pose."""
        return make_readout(self.configuration, self.design.ranks)

    def framing(self) -> Framing:
        """Return how a camera sees all that is shown now."""
        return frame(self.scene().items)

    def _stop(self, values: list[float], error: ClosureError) -> Notice:
        """Say which motors have stopped on the way to these values, and why.

        The same words wherever beyond the end the values are.
        """
        reached = error.reached
        ways = np.array(values) - reached.actuated
        stops = tuple(int(np.sign(way)) if abs(way) > 1e-9 else 0 for way in ways)
        stopped = ", ".join(
            f"{motor.name} stops at {there:.4f} {motor.unit}"
            for motor, stop, there in zip(self.design.motors, stops, reached.actuated, strict=True)
            if stop
        )
        text = f"End of the reachable range: {stopped}. This assembly mode goes no further."
        if error.ties:
            ties = f"{error.ties[0].upper()}{error.ties[1:]}"
            text = f"{ties}. {text if error.share else f'They do not move so together: {stopped}.'}"
        return Notice("stop", text, stops)
