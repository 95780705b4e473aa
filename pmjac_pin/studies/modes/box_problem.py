"""BoxProblem: the direct kinematics of a mechanism as equations over boxes of passive values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.modes.box_domain import NoBoxesError, box_domain
from pmjac_pin.studies.modes.box_equations import BoxEquations
from pmjac_pin.studies.modes.floating_body import placed
from pmjac_pin.studies.modes.interval_loops import IntervalLoops
from pmjac_pin.studies.modes.interval_tree import IntervalTree
from pmjac_pin.studies.modes.recorded_loops import RecordedLoops
from pmjac_pin.studies.modes.rows_over_boxes import Floating, rows_over_boxes
from pmjac_pin.values.arrays import Array, Mask


@dataclass(frozen=True, slots=True, eq=False)
class BoxProblem:
    """The loop equations at given motor values, over boxes of k unknowns.

    Attributes
    ----------
    names : tuple of str
        The unknowns: passive joints of one degree of freedom.
    loops : BoxEquations
    domain : Intervals, shape (k,)
        All values that the unknowns can have; for angles without limits, one full turn.
    endless : ndarray of bool, shape (k,)
        Whose values are the same after a full turn.
    scale : ndarray, shape (k,)
        1 rad, or the mechanism's characteristic length in m.
    floating : tuple of Floating
    """

    names: tuple[str, ...]
    loops: BoxEquations
    domain: Intervals
    endless: Mask
    scale: Array
    floating: tuple[Floating, ...]


def box_problem(mechanism: Mechanism, motors: Mapping[str, float], limits: bool) -> BoxProblem:
    """Return the equations of a mechanism at these motor values.

    Parameters
    ----------
    mechanism : Mechanism
    motors : mapping of str to float
        Each motor joint's value, m or rad.
    limits : bool
        Keep within the passive joints' limits.

    Raises
    ------
    NoBoxesError
        Geared joints; passive joints of several degrees of freedom that are not held at points;
        slides without a bound; passive joints that the motors leave free.
    """
    rows = rows_over_boxes(mechanism)
    tree = IntervalTree(rows.tree, rows.names, motors)
    domain, endless = box_domain(mechanism, motors, rows.unknowns, rows.blocks, limits)
    slides = np.array([not edge.kind.turns for edge in rows.unknowns], dtype=bool)
    loops = IntervalLoops(tree, rows.blocks)
    return BoxProblem(
        names=rows.names,
        loops=loops if rows.program is None else RecordedLoops(rows.program, loops),
        domain=domain,
        endless=endless,
        scale=np.where(slides, mechanism.problem.partition.length, 1.0),
        floating=rows.floating,
    )


def given_values(mechanism: Mechanism, values: Array) -> Mapping[str, float]:
    """Return the motors' values by name.

    Raises
    ------
    NoBoxesError
        A motor joint of several degrees of freedom.
    """
    model = mechanism.kinematics.model
    for name in mechanism.spec.actuated:
        joint = model.joints[model.getJointId(name)]
        if joint.nv != 1:
            raise NoBoxesError(f"motor {name!r} has {joint.nv} degrees of freedom")
    return dict(zip(mechanism.spec.actuated, values.tolist(), strict=True))


def start(mechanism: Mechanism, problem: BoxProblem, q: Array, values: Array) -> Array:
    """Return q with the unknowns at these values, and floating bodies where they are held."""
    columns = mechanism.coordinates.columns(problem.names)
    q = mechanism.coordinates.with_values(q, columns, values)
    model, data = mechanism.kinematics.model, mechanism.kinematics.placed(q)
    for floating in problem.floating:
        edge = floating.edge
        frames = [data.oMi[hold.other.joint] * hold.other.placement for hold in floating.holds]
        if floating.plane is not None:
            frames.append(data.oMi[floating.plane.joint] * floating.plane.placement)
        entries = edge.entries(data.oMi[edge.parent], placed(edge, floating.holds, frames))
        joint = model.joints[model.getJointId(edge.name)]
        q[joint.idx_q : joint.idx_q + joint.nq] = entries
    return q
