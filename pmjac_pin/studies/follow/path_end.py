"""What a path has come to where no step is covered: a fold, branches that meet, or unknown."""

from __future__ import annotations

from dataclasses import dataclass

from pmjac_pin.studies.follow.bordered import SingularSpot, singular_spot
from pmjac_pin.studies.follow.branching import branches
from pmjac_pin.studies.follow.event import Event
from pmjac_pin.studies.follow.path_equations import PathEquations
from pmjac_pin.studies.follow.step import CoveredStep
from pmjac_pin.studies.follow.walker import CourseWalker
from pmjac_pin.values.arrays import norm

_NEAR_SPOT = 1e-2  # lengths or rad: from where no step is covered to the spot
_APART = 1e-11  # of a length: μ of branches that count as meeting
_WELL_AWAY = 1e-3  # relative singular value of K* at the pose whose rows are taken
_TRANSVERSAL = 3e-6  # wᵀ G_s beside |w|, at a fold: of two with μ apart about √μ
_AT_THE_END = 1e-10  # of the parameter


@dataclass(frozen=True, slots=True, eq=False)
class PathEnd:
    """A singular pose on the path, with what is known of it."""

    spot: SingularSpot | None
    event: Event


def path_end(walker: CourseWalker, steps: list[CoveredStep]) -> PathEnd:
    """Return what is where a walker has stopped, at a pose that is or nearly is singular."""
    course, pose = walker.course, walker.pose
    regular = _well_away(steps)
    q, t = (pose.q, pose.t) if regular is None else (regular.start.q, regular.start.t)
    equations = PathEquations.near(course, walker.piece, q, t)
    if equations is not None and regular is not None:
        for what in ("branches", "fold"):
            spot = singular_spot(equations, pose.q, pose.t, what)
            if spot is not None and _belongs(walker, spot):
                if what == "branches":
                    return PathEnd(spot, _branch_event(walker, spot))
                if _is_fold(spot):
                    return PathEnd(spot, _fold_event(walker, spot))
    here = course.configuration(pose.q)
    smallest = course.driven_configuration(pose.q).singularity().smallest
    what = (
        f"K* is singular as far as can be told (relative singular value {smallest:.2g}), and "
        "neither a fold nor branches that meet are found"
    )
    return PathEnd(None, Event("singular", pose.t, here, what))


def _well_away(steps: list[CoveredStep]) -> CoveredStep | None:
    """Return the last step that began at a pose well away from singular ones, or the first."""
    for step in reversed(steps):
        factors = step.start.point.factors
        if factors.exceeds(step.course.problem.partition.passive_rank, _WELL_AWAY * factors.size):
            return step
    return steps[0] if steps else None


def _belongs(walker: CourseWalker, spot: SingularSpot) -> bool:
    """Tell whether a spot is where the path leads next."""
    course, pose = walker.course, walker.pose
    away = course.size(course.problem.difference(pose.q, spot.q))
    slack = _AT_THE_END * max(1.0, abs(pose.t))
    within = pose.t - slack <= spot.t <= walker.piece.end + slack
    return away <= _NEAR_SPOT and within and abs(spot.apart) <= _APART


def _is_fold(spot: SingularSpot) -> bool:
    _, Gx = spot.equations.at(spot.q, spot.t)
    return abs(float(spot.left @ Gx[:, -1])) > _TRANSVERSAL * norm(spot.left)


def _fold_event(walker: CourseWalker, spot: SingularSpot) -> Event:
    configuration = walker.course.configuration(spot.q)
    kind = configuration.singularity().kind
    mode = "working" if walker.course.by_tool else "assembly"
    back = "the tool has" if walker.course.by_tool else "the motors have"
    what = (
        f"this {mode} mode ends, where it meets another one (singular by {kind}): beyond, the "
        f"loops do not close on either; {back} to turn back"
    )
    return Event("fold", spot.t, configuration, what)


def _branch_event(walker: CourseWalker, spot: SingularSpot) -> Event:
    configuration = walker.course.configuration(spot.q)
    kind = configuration.singularity().kind
    found = branches(spot, walker.pose.velocity)
    what = f"two branches of closed poses meet (singular by {kind})"
    if not found:
        what = f"branches of closed poses meet and touch, or more than two (singular by {kind})"
    return Event("branch point", spot.t, configuration, what, branches=found)
