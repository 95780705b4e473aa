"""Trajectory: the closed poses along a path, what happened on it, and why it ended."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.coordinates import entry_names
from pmjac_pin.rates.second_order import following_rates
from pmjac_pin.studies.datasets import Dataset, dataset
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.follow.event import Event
from pmjac_pin.studies.follow.homecoming import Homecoming
from pmjac_pin.values.arrays import Array, ReadOnlyArrays, read_only
from pmjac_pin.values.found_once import found_once

PathStatus: TypeAlias = Literal[
    "end",
    "limit",
    "fold",
    "branch point",
    "singular",
    "forbidden",
    "not covered",
    "not proven",
    "interrupted",
]


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory(ReadOnlyArrays):
    """Closed poses along a path of the motors. Made by `follow`.

    Attributes
    ----------
    mechanism : Mechanism
    t : ndarray, shape (N,)
        The path's parameter.
    q : ndarray, shape (N, nq)
        Pinocchio's configuration vectors.
    rates, accelerations : ndarray, shape (N, n)
        dθ/dt and d²θ/dt² of the motors, m or rad per unit of the parameter; of a kink those after
        it.
    v : ndarray, shape (N, nv)
        Pinocchio's velocity dq/dt; NaN at a singular pose where none is known.
    events : tuple of Event
        In the order of t.
    status : str
        "end": all of the path was followed. Else why it stopped: at a "limit", a "fold", a "branch
        point", at a pose that is "singular" and no more is known; "forbidden", where loops lead
        motors elsewhere; "not covered", "not proven", "interrupted".
    reason : str
        In one sentence.
    evidence : Evidence
        What it rests on that all poses are on one branch.
    homecoming : Homecoming or None
        Of a path that is closed in motor values, whether the machine ends as it began.
    steps : ndarray, shape (S + 1,)
        Where covered steps meet.
    radii : ndarray, shape (k,)
        Of the proven tube about each step, rad or a share of the characteristic length; empty where
        nothing was to be proven. Of the last steps up to a fold or a branch point, up to 1e-5 of t
        before it, there may be none: `evidence` says up to where the proof goes.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> trajectory = pj.follow(pj.load("four_bar"), [[0.9], [1.5]])
    >>> trajectory.status, trajectory.end.actuated.tolist()
    ('end', [1.5])
    """

    mechanism: Mechanism
    t: Array
    q: Array
    rates: Array
    accelerations: Array
    v: Array
    events: tuple[Event, ...]
    status: PathStatus
    reason: str
    evidence: Evidence
    homecoming: Homecoming | None
    steps: Array
    radii: Array

    @property
    def reached(self) -> bool:
        """Whether all of the path was followed."""
        return self.status == "end"

    @found_once
    def configurations(self) -> tuple[Configuration, ...]:
        """The closed poses."""
        return tuple(self.mechanism.configuration(q) for q in self.q)

    @property
    def end(self) -> Configuration:
        """The last pose."""
        return self.configurations[-1]

    @found_once
    def actuated(self) -> Array:
        """Motor values, shape (N, n), m or rad."""
        return self._values(self.mechanism.problem.partition.actuated)

    @found_once
    def passive(self) -> Array:
        """Passive values, shape (N, m_p), m or rad."""
        return self._values(self.mechanism.problem.partition.passive)

    @found_once
    def a(self) -> Array:
        """Pinocchio's acceleration, shape (N, nv); NaN where v is or where nothing tells."""
        rows = zip(self.configurations, self.v, self.accelerations, strict=True)
        return read_only(np.array([acceleration_along(*row) for row in rows]))

    @found_once
    def tool_poses(self) -> Array:
        """The tool in the world, homogeneous matrices of shape (N, 4, 4), m."""
        self.mechanism.need_tool()
        return read_only(np.array([one.tool_pose().homogeneous for one in self.configurations]))

    def __len__(self) -> int:
        return len(self.t)

    def __getitem__(self, index: int) -> Configuration:
        return self.configurations[index]

    def to_xarray(self) -> Dataset:
        """Return the arrays with names.

        Returns
        -------
        xarray.Dataset
            Dimension `t`, and "entry" of q, "motor", "joint" (motors first) and "passive_joint".
            Events are in the attributes, as text.

        Raises
        ------
        MissingDependencyError
            xarray is not installed.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> found = pj.follow(pj.load("four_bar"), [[0.9], [1.5]], samples=4).to_xarray()
        >>> found.v.dims, found.actuated.values[:, 0].round(3).tolist()
        (('t', 'joint'), [0.9, 1.1, 1.3, 1.5])
        """
        mechanism, partition = self.mechanism, self.mechanism.problem.partition
        joints = list(partition.columns.values())
        variables: dict[str, Any] = {
            "q": (("t", "entry"), self.q),
            "actuated": (("t", "motor"), self.actuated),
            "passive": (("t", "passive_joint"), self.passive),
            "rates": (("t", "motor"), self.rates),
            "accelerations": (("t", "motor"), self.accelerations),
            "v": (("t", "joint"), self.v[:, joints]),
            "a": (("t", "joint"), self.a[:, joints]),
        }
        if not mechanism.spec.tool.is_none:
            variables["tool_poses"] = (("t", "row", "column"), self.tool_poses)
        labels = {
            "t": self.t,
            "entry": list(entry_names(mechanism.model)),
            "motor": list(mechanism.actuated),
            "passive_joint": list(mechanism.passive),
            "joint": list(partition.columns),
        }
        told = {
            "status": self.status,
            "reason": self.reason,
            "evidence": str(self.evidence),
            "events": [repr(event) for event in self.events],
        }
        return dataset(variables, labels, told)

    def _values(self, columns: Any) -> Array:
        return read_only(self.mechanism.coordinates.values_of(self.q, columns))

    def __repr__(self) -> str:
        count = f"{len(self.events)} event" + "s" * (len(self.events) != 1)
        return (
            f"Trajectory({self.mechanism.name}, {len(self)} poses, t={self.t[0]:.6g} to "
            f"{self.t[-1]:.6g}, {count}, {self.status!r})"
        )


def acceleration_along(pose: Configuration, v: Array, motors: Array) -> Array:
    """Return Pinocchio's acceleration: of passive joints −K*⁺ (K θ̈ + γ), γ = dC[v] v.

    NaN where v is, or where a joint is not in the table of joints.
    """
    slopes, partition = pose.mechanism.slopes, pose.problem.partition
    if slopes is None or not np.isfinite(v).all():
        return np.full(v.size, np.nan)
    slope = slopes.at(pose.q, v[:, None]).constraint[0]
    jacobian = pose.split_jacobian().constraint_jacobian
    found = np.zeros(v.size)
    found[partition.actuated] = motors
    opening = jacobian[:, partition.actuated] @ motors + slope @ v
    following = following_rates(opening[:, None], partition.loop_rates(jacobian), partition)
    found[partition.passive] = following[:, 0]
    return found


def sample_times(given: Any, start: float, end: float) -> Array | None:
    """Return the parameters that a caller asks for; None for those of the steps."""
    if given is None:
        return None
    if isinstance(given, int) and not isinstance(given, bool):
        if given < 2:
            raise ArgumentError(f"samples are 2 or more, got {given}")
        return np.linspace(start, end, given)
    times = np.atleast_1d(np.asarray(given, dtype=float))
    inside = times.size and times.ndim == 1 and times[0] >= start and times[-1] <= end
    if not inside or not (np.diff(times) > 0.0).all():
        wanted = f"samples ascend from {start:g} to {end:g} at most"
        raise ArgumentError(f"{wanted}, got {quoted(given)}")
    return times
