"""SameMachine: which closed poses differ only in bodies that are turned over unseen.

The axle of a delta's leg fits its hinges turned by half a turn as well. Its body is then in
another pose, and the machine is not: the tool, all points and all axes, as lines, are where they
were, so that J_eq is the same; and what is drawn looks the same.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.closing.parts import Parts
from pmjac_pin.configuration import Configuration
from pmjac_pin.kinematics.many import WorldPoses
from pmjac_pin.model.frames import Frame, find_frame
from pmjac_pin.model.loop_spec import JointLoop
from pmjac_pin.studies.modes.distinct import idle_motions
from pmjac_pin.studies.modes.drawings import Drawings
from pmjac_pin.studies.modes.search_problem import SearchProblem, search_problem, without_legs

Array = NDArray[np.float64]
_Seen = tuple[list[Array], Array, Array]  # places, turns of bodies, drawn pieces

_SAME = 1e-5  # of the characteristic length, and rad: as poses are told apart
_STEP = 1e-4  # of an idle motion, rad or lengths
_AT_REST = 1e-6  # what an idle motion of one changes, and does not count as moved


def same_machines(parts: Parts, found: Sequence[Configuration]) -> list[list[int]]:
    """Return the poses in groups that are the same machine, in each the nearest to home first.

    Parameters
    ----------
    parts : Parts
    found : sequence of Configuration
        Closed poses at the same motor values, each once.
    """
    if len(found) < 2:
        return [[index] for index in range(len(found))]
    looks = _Looks.of(parts, found)
    groups: list[list[int]] = []
    for index in looks.from_home():
        for group in groups:
            if looks.same(group[0], index):
                group.append(index)
                break
        else:
            groups.append([index])
    return groups


@dataclass(frozen=True, slots=True, eq=False)
class _Looks:
    """What is compared of each pose.

    Attributes
    ----------
    places : ndarray, shape (b, entries)
        Of the tool, of loops, and of the joints' motions, without dimension.
    turns : ndarray, shape (b, bodies, 3, 3)
        Of bodies that do not idle.
    home : ndarray, shape (bodies, 3, 3)
    drawn : ndarray, shape (b, pieces, entries)
    """

    places: Array
    turns: Array
    home: Array
    drawn: Array

    @classmethod
    def of(cls, parts: Parts, found: Sequence[Configuration]) -> _Looks:
        """Return the looks of closed poses; what idles at every pose is left out of them."""
        problem, _ = search_problem(parts, found[0].q)
        drawings = Drawings(parts, problem.model, problem.length)

        def seen(q: Array) -> _Seen:
            poses = problem.tree.poses(q)
            places = [*_tool(parts, problem, poses), *_loops(problem, poses)]
            places += _motions(parts, problem, poses)
            return places, poses.rotations.swapaxes(0, 1), drawings(poses)

        rows = np.array([without_legs(parts, problem, one.q) for one in found])
        home = without_legs(parts, problem, parts.home_q)[None]
        (places, turns, drawn), rest = seen(rows), _at_rest(problem, rows, seen)
        return cls(
            places=np.hstack(
                [place for place, rests in zip(places, rest[0], strict=True) if rests]
            ),
            turns=turns[:, rest[1]],
            home=seen(home)[1][0, rest[1]],
            drawn=drawn[:, rest[2]],
        )

    def from_home(self) -> list[int]:
        """Return the poses' order by how little their bodies are turned from home.

        Rounded, so that rounding errors do not decide between those that are equally near.
        """
        far = np.square(self.turns - self.home).sum(axis=(1, 2, 3))
        keys = np.column_stack([far, self.turns.reshape(len(far), -1)]).round(6) + 0.0
        return sorted(range(len(keys)), key=lambda index: tuple(keys[index]))

    def same(self, one: int, other: int) -> bool:
        """Tell whether two poses look the same, bodies being where they were or turned over.

        Half a turn is its own inverse, its matrix symmetric. A small turn's is not: beside a
        singularity, two modes that are about to meet stay two.
        """
        if np.abs(self.places[one] - self.places[other]).max() > _SAME:
            return False
        between = self.turns[one] @ self.turns[other].swapaxes(1, 2)
        if np.abs(between - between.swapaxes(1, 2)).max(initial=0.0) > _SAME:
            return False
        return _each_in(self.drawn[one], self.drawn[other])


def _each_in(pieces: Array, others: Array) -> bool:
    """Tell whether each drawn piece is one of others: two ends of a bar may change places."""
    return all(np.abs(others - piece).max(axis=1).min() <= _SAME for piece in pieces)


def _at_rest(
    problem: SearchProblem, rows: Array, seen: Callable[[Array], _Seen]
) -> tuple[NDArray[np.bool_], ...]:
    """Tell which places, bodies and drawn pieces no idle motion moves."""
    idle, row = idle_motions(problem, rows)
    count = idle.shape[1]
    steps = _STEP * problem.length * np.vstack([idle.T, -idle.T])
    places, *others = seen(problem.tree.moved(np.repeat(rows[row : row + 1], 2 * count, 0), steps))
    limit = 2.0 * _STEP * _AT_REST

    def moves(block: Array) -> NDArray[np.float64]:
        apart = np.abs(block[:count] - block[count:])
        return np.asarray(apart.max(axis=(0, *range(2, block.ndim)), initial=0.0))

    at_rest = [moves(block) <= limit for block in others]
    return np.array([moves(place).max() <= limit for place in places]), *at_rest


def _tool(parts: Parts, problem: SearchProblem, poses: WorldPoses) -> Iterator[Array]:
    tool = parts.spec.tool
    for name in tool.names:
        frame = find_frame(problem.model, name)
        yield _point(problem, poses, frame)
        if not tool.points:
            yield (poses.rotations[frame.joint] @ frame.placement.rotation).reshape(-1, 9)


def _loops(problem: SearchProblem, poses: WorldPoses) -> Iterator[Array]:
    """Yield the points that loops join, and their axes as lines."""
    for loop in problem.closures:
        if isinstance(loop, JointLoop):
            continue
        axes = getattr(loop, "axes", (getattr(loop, "axis", None),) * 2)
        for name, axis in zip(loop.frames, axes, strict=True):
            frame = find_frame(problem.model, name)
            yield _point(problem, poses, frame)
            if axis is not None:
                line = poses.rotations[frame.joint] @ frame.placement.rotation @ np.array(axis)
                yield (line[:, :, None] * line[:, None, :]).reshape(-1, 9)


def _motions(parts: Parts, problem: SearchProblem, poses: WorldPoses) -> Iterator[Array]:
    """Yield what motions each joint allows, as a projector: seen from either side it is one.

    Motors and geared joints have a sense, which counts.
    """
    geared = [
        name for loop in problem.closures if isinstance(loop, JointLoop) for name in loop.ends
    ]
    sensed = {*parts.spec.actuated, *geared}
    screws = np.concatenate([poses.linear / problem.length, poses.angular], axis=1)
    for joint in list(problem.model.joints)[1:]:
        columns = screws[:, :, joint.idx_v : joint.idx_v + joint.nv]
        if problem.model.names[joint.id] not in sensed:
            basis, _ = np.linalg.qr(columns)
            columns = basis @ basis.swapaxes(1, 2)
        yield columns.reshape(len(columns), columns.shape[1] * columns.shape[2])


def _point(problem: SearchProblem, poses: WorldPoses, frame: Frame) -> Array:
    place = poses.rotations[frame.joint] @ frame.placement.translation
    return np.asarray((poses.positions[frame.joint] + place) / problem.length)
