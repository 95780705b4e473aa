"""Replay: a trajectory on the page, at any of its parameters."""

from __future__ import annotations

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError, ClosureError
from pmjac_pin.studies.follow.step import hermite
from pmjac_pin.studies.follow.trajectory import Trajectory
from pmjac_pin.viewer.messages import Happening, Slider


class Replay:
    """The poses of a trajectory, and those between them.

    Attributes
    ----------
    trajectory : Trajectory
    """

    def __init__(self, trajectory: Trajectory) -> None:
        self.trajectory = trajectory

    def slider(self) -> Slider:
        """Return the slider of its parameter."""
        t = self.trajectory.t
        return Slider("t", "", float(t[0]), float(t[-1]), True, "the parameter of the path")

    def happenings(self) -> tuple[Happening, ...]:
        """Return what happens on it."""
        return tuple(Happening(event.t, event.kind, event.what) for event in self.trajectory.events)

    def at(self, t: float) -> Configuration:
        """Return the pose at a parameter: closed from the sample before it.

        The motors are on cubics between the samples. Where they do not lead, it is that sample.

        Raises
        ------
        ArgumentError
            A parameter beyond its ends.
        """
        times = self.trajectory.t
        if not times[0] <= t <= times[-1]:
            raise ArgumentError(f"t = {t:g} is not from {times[0]:g} to {times[-1]:g}")
        k = int(np.searchsorted(times, t, "right")) - 1
        sample = self.trajectory[k]
        if times[k] == t:
            return sample
        width = times[k + 1] - times[k]
        first, last = self.trajectory.actuated[k : k + 2]
        leaving, arriving = width * self.trajectory.rates[k : k + 2]
        values = first + hermite((t - times[k]) / width, last - first, leaving, arriving)
        try:
            return self.trajectory.mechanism.close(values, sample, enforce_limits=False)
        except ClosureError:
            return sample
