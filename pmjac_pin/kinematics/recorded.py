"""The kinematics of a mechanism as a program: η, ∂η/∂v and the tool, over the entries of q."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from pmjac_pin.algebra.arrays import Numbers
from pmjac_pin.algebra.jets import Jet
from pmjac_pin.algebra.programs import PROGRAMS, Programs, objects, root, zeros
from pmjac_pin.algebra.rooted_programs import ROOTED_PROGRAMS
from pmjac_pin.algebra.terms import Term
from pmjac_pin.kinematics.dimensions import Dimensions, Placement
from pmjac_pin.kinematics.loops import Loops, by_twists
from pmjac_pin.kinematics.tool import spanned_jacobian, spanned_rotation
from pmjac_pin.kinematics.tree import Link, Poses, Tree
from pmjac_pin.kinematics.world_frames import FrameMotion, frame_motion, vectors_in_bodies
from pmjac_pin.model.coupling import Coupling
from pmjac_pin.model.frames import Frame, find_frame
from pmjac_pin.model.joint_kind import JointMotion
from pmjac_pin.model.spec import MechanismSpec
from pmjac_pin.values.arrays import Array


@dataclass(frozen=True, slots=True, eq=False)
class RecordedRows:
    """Terms over the entries of q; what is zero by structure is the double 0.

    Attributes
    ----------
    residual, rates : ndarray, shapes (p,) and (p, nv)
        η and ∂η/∂v, each loop seen from the last body that carries both frames; tilts and turns
        by polynomials.
    cosines : ndarray, shape (k,)
        Of the angles that tilts and turns leave: −1 where these vanish by mistake.
    """

    residual: Numbers
    rates: Numbers
    cosines: Numbers


@dataclass(frozen=True, slots=True, eq=False)
class RecordedKinematics(RecordedRows):
    """The same with the tool.

    Attributes
    ----------
    tool : ndarray, shape (6, nv)
        The tool's Jacobian in LOCAL_WORLD_ALIGNED.
    rotation, position : ndarray, shapes (3, 3) and (3,)
        Of the tool.
    spread : number
        The sine of the angle at the first of the three points that span a tool; 1 for a frame.
    turned : tuple of (slice, ndarray of shape (3, 3))
        The rows that are the components of a vector in a moving body's axes, and these axes.
    """

    tool: Numbers
    rotation: Numbers
    position: Numbers
    spread: Any
    turned: tuple[tuple[slice, Numbers], ...]

    def in_world(self) -> tuple[Numbers, Numbers]:
        """Return η and, where the loops are closed, ∂η/∂v in the world's axes."""
        residual, rates = self.residual.copy(), self.rates.copy()
        for rows, axes in self.turned:
            residual[rows], rates[rows] = axes @ residual[rows], axes @ rates[rows]
        return residual, rates


class Recorder:
    """Records the kinematics of a mechanism.

    Parameters
    ----------
    model : pin.Model
    spec : MechanismSpec
    values : mapping of str to float
        Of the parameters.
    place : ndarray, shape (3,)
        Where the model stands in the world, m.
    dimensions : Dimensions, optional
        In place of the model's and of `values`.

    Attributes
    ----------
    nq, nv : int
        Of the model.
    tree : Tree
    """

    __slots__ = ("_loops", "_model", "_names", "_place", "nq", "nv", "tree")

    def __init__(
        self,
        model: pin.Model,
        spec: MechanismSpec,
        values: Mapping[str, float],
        place: Array,
        dimensions: Dimensions | None = None,
    ) -> None:
        self._model, self._place = model, place
        if dimensions is None:
            self.tree = Tree(model)
        else:
            self.tree, values = Tree(model, Placement.of, dimensions), dimensions.values
        self._loops = Loops(model, self.tree, spec.loops, values)
        self._names = spec.tool.names
        self.nq, self.nv = model.nq, model.nv

    def loops_at(self, q: Sequence[Term]) -> RecordedRows:
        """Record the loops at entries of q, where nobody asks for the tool."""
        return self._loops_at(_poses_at(self._loops.tree, q), q)

    def at(self, q: Sequence[Term]) -> RecordedKinematics:
        """Record loops and tool at entries of q."""
        poses = _poses_at(self._loops.tree, q)
        loops = self._loops_at(poses, q)
        frames = [find_frame(self._model, name) for name in self._names]
        points = [frame_motion(poses, frame, self.nv, 1) for frame in frames]
        tool, spread = _spanned(points) if len(points) > 1 else (points[0], 1.0)
        turned = vectors_in_bodies(self._loops, poses)
        return RecordedKinematics(
            residual=loops.residual,
            rates=loops.rates,
            cosines=loops.cosines,
            tool=tool.jacobian[..., 0],
            rotation=tool.rotation[..., 0],
            position=tool.position[..., 0] + self._place,
            spread=spread,
            turned=tuple((rows, axes[..., 0]) for rows, axes in turned),
        )

    def _loops_at(self, poses: Poses, q: Sequence[Term]) -> RecordedRows:
        return RecordedRows(*_loop_rows(self._loops, poses, objects(q), self.nv))

    def motions(self, q: Sequence[Term], frames: Sequence[Frame]) -> list[FrameMotion]:
        """Record where frames are at entries of q, and how they move."""
        poses = _poses_at(self._loops.tree, q)
        return [frame_motion(poses, frame, self.nv, 1) for frame in frames]


def recorded_rows(loops: Loops, q: Sequence[Term], nv: int) -> tuple[Numbers, Numbers]:
    """Record η and ∂η/∂v over the entries of q, tilts and turns as Pinocchio measures them.

    Parameters
    ----------
    loops : Loops
    q : sequence of Term, length nq
    nv : int
    """
    poses = _poses_at(loops.tree, q, ROOTED_PROGRAMS)
    residual, rates, _ = _loop_rows(loops, poses, objects(q), nv)
    return residual, rates


def _poses_at(tree: Tree, q: Sequence[Term], programs: Programs = PROGRAMS) -> Poses:
    entries = programs.numbers(q)

    def motion(link: Link) -> JointMotion:
        return link.kind.motion(programs, entries[link.entries], link.edge.pitch)

    return Poses(tree, programs, motion)


def _loop_rows(loops: Loops, poses: Poses, q: Numbers, nv: int) -> tuple[Numbers, Numbers, Numbers]:
    residual, rates = zeros(loops.count), zeros(loops.count, nv)
    cosines: list[Any] = []
    for pair in loops.pairs:
        for (rows, _), block in zip(pair.blocks, by_twists(pair, poses), strict=True):
            residual[rows] = block.rows.value[:, 0, 0]
            _spread_rates(block.rows, rates[rows])
            if block.cosine is not None:
                cosines += block.cosine.value.ravel().tolist()
    for row, coupling in loops.couplings.items():
        residual[row], rates[row] = _coupled_gap(coupling, q), coupling.gradient.astype(object)
    return residual, rates, objects(cosines)


def _coupled_gap(coupling: Coupling, q: Numbers) -> Any:
    first, second = (_joint_value(coupling, q, column) for column in coupling.columns.tolist())
    return coupling.equation(first, second, _less_its_turns)


def _less_its_turns(angle: Any) -> Any:
    turns = angle * (1.0 / math.tau)
    return angle - math.tau * turns.recording.term("round", turns)


def _joint_value(coupling: Coupling, q: Numbers, column: int) -> Any:
    """Return the value of a joint of one freedom."""
    coordinates = coupling.coordinates
    start = coordinates.entry(column)
    if not coordinates.wraps[column]:
        return q[start]
    return q[start].recording.term("atan2", q[start + 1], q[start])


def _spanned(points: Sequence[FrameMotion]) -> tuple[FrameMotion, Any]:
    """Return the same of the frame that three points span, as `PointsTool` does, and the sine."""
    places = np.array([point.position[:, 0] for point in points], dtype=object)
    rates = np.array([point.jacobian[:3, :, 0] for point in points], dtype=object)
    side, apex = places[1] - places[0], places[2] - places[0]
    normal = PROGRAMS.cross(side, apex)
    rotation = spanned_rotation(places, root)
    jacobian = spanned_jacobian(places, rates, rotation)
    sine = root(normal @ normal) / (root(side @ side) * root(apex @ apex))
    found = (rotation, places.sum(axis=0) / 3.0, jacobian)
    return FrameMotion(*(one[..., None] for one in found)), sine


def _spread_rates(jet: Jet, rates: Numbers) -> None:
    """Write a jet's rates into all columns."""
    if jet.columns:
        rates[:, jet.columns] = jet.rates[..., 0]
