"""Journey: walking a course with all that is watched on it, to its end or where it stops."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.follow.bordered import SingularSpot
from pmjac_pin.studies.follow.branch_crossing import crossed
from pmjac_pin.studies.follow.course import Course
from pmjac_pin.studies.follow.event import Event
from pmjac_pin.studies.follow.homecoming import homecoming
from pmjac_pin.studies.follow.joint_limits import JointLimits
from pmjac_pin.studies.follow.passage import Passage
from pmjac_pin.studies.follow.path_end import path_end
from pmjac_pin.studies.follow.step import CoveredStep
from pmjac_pin.studies.follow.stretch import PathPose, Stretch
from pmjac_pin.studies.follow.tool_losses import what_is_lost
from pmjac_pin.studies.follow.trajectory import PathStatus, Trajectory, acceleration_along
from pmjac_pin.studies.follow.tubes import PathProof
from pmjac_pin.studies.follow.user_events import UserEvents
from pmjac_pin.studies.follow.walker import CourseWalker
from pmjac_pin.values.arrays import Array

_SAME_T = 1e-10  # of the parameter
_BESIDE_ITS_END = (
    1e-5  # of the parameter: so near to a fold or a branch point need steps not be proven
)
_SINGULAR_ENDS = ("fold", "branch point", "singular")
_STOPS_AT = {"motors": ("motor limit",), "all": ("motor limit", "passive limit"), "none": ()}


class Journey:
    """A path, followed.

    Parameters
    ----------
    course : Course
    pose : PathPose
        Where it begins, regular or not.
    begin : Configuration
    watched : UserEvents
    whose : {"motors", "all", "none"}
        At which limits to stop.
    passing, certified : bool
        As of `follow`.
    """

    def __init__(
        self,
        course: Course,
        pose: PathPose,
        begin: Configuration,
        watched: UserEvents,
        *,
        whose: str,
        passing: bool,
        certified: bool,
    ) -> None:
        self._course, self._pose, self._begin = course, pose, begin
        self._limits, self._losses = JointLimits(course), what_is_lost(course, begin)
        self._watched, self._stopping = watched, _STOPS_AT[whose]
        self._passing = passing
        self._proof = PathProof(course, pose) if certified else None
        self._stretches: list[Stretch] = []
        self._events: list[Event] = []
        self._last = pose
        self._status: PathStatus = "end"
        self._reason = "all of the path was followed"

    def go(self) -> Iterator[float]:
        """Walk, and prove each step where that is asked for; yield the parameter after it."""
        yield from self._walk()
        proof = self._proof
        if proof is not None and proof.failed and not self._ends_singular():
            self._keep_proven("not proven", proof.failed)

    def _walk(self) -> Iterator[float]:
        pose: PathPose | None = self._pose
        while pose is not None:
            walker = CourseWalker(self._course, pose)
            for step in walker.steps():
                found = self._happening(step)
                if not self._proves(step):
                    return
                self._stretches.append(step)
                if self._stops(step, found):
                    return
                yield step.end.t
            pose = self._after(walker)

    def _proves(self, step: CoveredStep) -> bool:
        """Tell whether a step is proven, or need not be: one may lead to a singular pose."""
        proof = self._proof
        if proof is None or proof.takes(step):
            return True
        return step.end.t - proof.end.t <= _BESIDE_ITS_END * max(1.0, abs(proof.end.t))

    def _ends_singular(self) -> bool:
        return bool(self._events) and self._events[-1].kind in _SINGULAR_ENDS

    def interrupted(self) -> Journey:
        """Return this as far as it is known, and proven, as somebody has interrupted it."""
        why = "somebody interrupted it"
        self._stop("interrupted", why, self._last)
        if self._proof is not None:
            self._keep_proven("interrupted", why)
        return self

    def _keep_proven(self, status: PathStatus, reason: str) -> None:
        """Leave out what comes after the last step that is proven."""
        done = 0 if self._proof is None else len(self._proof.radii)
        self._stretches = self._stretches[:done]
        last = self._stretches[-1].end if self._stretches else self._pose
        self._events = [event for event in self._events if event.t <= last.t]
        self._stop(status, reason, last)

    def _happening(self, stretch: Stretch) -> list[Event]:
        """Return what happens on a part, in its order."""
        watchers = (self._limits, self._losses, self._watched)
        found = [event for one in watchers if one for event in one.events(stretch)]
        return sorted(found, key=lambda event: event.t)

    def _stops(self, stretch: Stretch, found: Sequence[Event]) -> bool:
        """Note what happens on a part; tell whether it stops there, at a limit."""
        self._last = stretch.end
        for event in found:
            known = [one for one in self._events if one.kind == event.kind in ("loss", "gain")]
            if any(abs(one.t - event.t) <= _SAME_T * max(1.0, abs(event.t)) for one in known):
                continue  # where two steps meet
            self._events.append(event)
            if event.leaves and event.kind in self._stopping:
                self._stop("limit", event.what, stretch.at(event.t))
                return True
        return False

    def _stop(self, status: PathStatus, reason: str, pose: PathPose) -> None:
        self._status, self._reason, self._last = status, reason, pose

    def _after(self, walker: CourseWalker) -> PathPose | None:
        """Return from where to walk on after a walk has ended, None where it does not go on."""
        if walker.halt == "end":
            return None
        if walker.halt == "strayed":
            far = self._course.strayed(walker.pose.q, walker.piece, walker.pose.t)
            self._stop(
                "forbidden",
                f"the loops lead motors elsewhere than the path wants them, by {far:.2g}",
                self._last,
            )
            return None
        end = path_end(walker, [one for one in self._stretches if isinstance(one, CoveredStep)])
        return self._at_spot(walker, end.spot, end.event)

    def _at_spot(
        self, walker: CourseWalker, spot: SingularSpot | None, event: Event
    ) -> PathPose | None:
        self._events.append(event)
        if spot is None:
            where = "begins" if not self._stretches else "stops"
            halted: PathStatus = "singular" if walker.halt == "singular" else "not covered"
            self._stop(halted, f"the path {where} at t = {event.t:.9g}: {event.what}", walker.pose)
            return None
        there = PathPose(
            spot.t, self._course.pose_at(spot.q), np.full_like(walker.pose.velocity, np.nan)
        )
        if spot.t >= self._course.path.end - _SAME_T * max(1.0, abs(self._course.path.end)):
            self._stop("end", f"all of the path was followed; at its end {event.what}", there)
            return None
        meet = event.kind == "branch point" and self._passing and self._proof is None
        passage = crossed(walker, spot) if meet else None
        if passage is None:
            what: PathStatus = "fold" if event.kind == "fold" else "branch point"
            self._stop(what, f"at t = {event.t:.9g} {event.what}", there)
            return None
        found = self._happening(passage)
        self._stretches.append(passage)
        return None if self._stops(passage, found) else passage.end

    def trajectory(self, wanted: Array | None) -> Trajectory:
        """Return what was found, at the parameters that are wanted."""
        poses = [self._pose] if not self._stretches else self._sampled(wanted)
        events = tuple(sorted(self._events, key=lambda event: event.t))
        end = self._course.configuration(self._last.q)
        shown = self._course.shown
        rates, accelerations = self._motor_rates(poses)
        return Trajectory(
            mechanism=shown,
            t=np.array([pose.t for pose in poses]),
            q=np.array([pose.q for pose in poses])[:, : shown.nq],
            rates=rates,
            accelerations=accelerations,
            v=np.array([pose.velocity for pose in poses])[:, : shown.nv],
            events=events,
            status=self._status,
            reason=self._reason,
            evidence=self._evidence(),
            homecoming=homecoming(self._begin, end, events) if self._status == "end" else None,
            steps=np.array([one.start.t for one in self._stretches] + [self._last.t]),
            radii=self._radii(),
        )

    def _radii(self) -> Array:
        proven = [] if self._proof is None else self._proof.radii
        return np.array(proven[: len(self._stretches)], dtype=float)

    def _motor_rates(self, poses: Sequence[PathPose]) -> tuple[Array, Array]:
        """Return rates and accelerations (N, n) of the motors of the machine that is shown."""
        course = self._course
        pieces = [(course.path.piece_at(pose.t), pose) for pose in poses]
        given = np.array([piece.accelerations(pose.t) for piece, pose in pieces])
        if not course.by_tool:
            return np.array([piece.rates(pose.t) for piece, pose in pieces]), given
        motors = course.shown.problem.partition.actuated
        trail = [(course.driven_configuration(pose.q), pose.velocity) for pose in poses]
        found = [acceleration_along(*one, led) for one, led in zip(trail, given, strict=True)]
        rates = np.array([pose.velocity for pose in poses])
        return rates[:, motors], np.array(found)[:, motors]

    def _sampled(self, wanted: Array | None) -> list[PathPose]:
        """Return the poses at the parameters that are wanted, and the last one."""
        last = self._last
        if wanted is None:
            found = [pose for one in self._stretches for pose in _kept(one)]
            return [*(pose for pose in found if pose.t < last.t), last]
        starts = [one.start.t for one in self._stretches]
        found = []
        for t in wanted.tolist():
            if t < last.t:
                number = int(np.searchsorted(starts, t, "right")) - 1
                found.append(self._stretches[number].at(t))
        return [*found, last]

    def _evidence(self) -> Evidence:
        if self._proof is not None:
            return self._proof.evidence()
        told = "each step is covered: in a tube about it each t has exactly one closed pose"
        passed = sum(isinstance(one, Passage) for one in self._stretches)
        if passed:
            told += (
                f"; {passed} branch point{'s' * (passed > 1)} passed along the tangent that goes on"
            )
        nothing = self._course.by_tool and not self._course.shown.problem.partition.passive_rank
        if self._losses is None and not nothing:
            told += "; what is lost on the way was not watched"
        return Evidence("tolerance", told)


def _kept(stretch: Stretch) -> list[PathPose]:
    """Return the poses to tell of a part: where it begins, and a branch point on it."""
    return [stretch.start, *([stretch.spot] if isinstance(stretch, Passage) else [])]
