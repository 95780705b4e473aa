"""SingularityFree: a proof that no singularity is within a distance of motors from a pose."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from pmjac_pin.algebra.balls import OUTWARDS, precise
from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError
from pmjac_pin.rates.partition import Partition
from pmjac_pin.studies.certificates.certificate import others_of
from pmjac_pin.studies.certificates.equations import LoopEquations
from pmjac_pin.studies.certificates.tool_rates import ToolRates
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.singularities.ball_bounds import BallBounds
from pmjac_pin.studies.singularities.free_cells import FreeCells
from pmjac_pin.studies.singularities.series_ball import SeriesBall
from pmjac_pin.studies.singularities.singular_equations import FREED, Freed
from pmjac_pin.values.arrays import Index
from pmjac_pin.values.checks import as_count, check_kind, check_one_of

_HALF_A_CELL = 0.5  # of what one step proves: half the width of cells


@dataclass(frozen=True, slots=True)
class SingularityFree:
    """How far motors may move from a pose, each for itself, with K* proven regular.

    True where some distance is proven.

    Attributes
    ----------
    radius : float
        Each motor may move by this, in `unit`, either way; 0 where nothing is proven.
    unit : "m" or "rad"
        m where all motors slide; else rad, a slide by `characteristic_length` counting as 1 rad.
    passive_radius : float
        How far passive joints are from the pose at most, rad, slides by `characteristic_length`.
    rank : int
        Of K*, which it has there.
    kind : "gain" or "loss"
        What does not happen there: no gain, or neither.
    failed : str
        Why nothing is proven; empty where something is.
    left_out : tuple of str
        Rows of the loop equations that depend on the others at the pose: nothing is asked of them.
    held : tuple of str
        Passive degrees of freedom that the loops leave free: held where they are.
    cells : int
        How many steps were tried.
    tool_rank : int
        In how many ways the tool moves there, on the judged rows; 0 where that was not asked.
    """

    radius: float
    unit: Literal["m", "rad"]
    passive_radius: float
    rank: int
    kind: Freed = "gain"
    failed: str = ""
    left_out: tuple[str, ...] = ()
    held: tuple[str, ...] = ()
    cells: int = 1
    tool_rank: int = 0

    def __bool__(self) -> bool:
        return not self.failed

    @property
    def evidence(self) -> Evidence:
        """What is proven."""
        if self.failed:
            return Evidence("nothing", self.failed)
        if not self.rank and self.kind == "gain":
            return Evidence("proof", "no loop ties a passive joint: K* has no rank to lose")
        parts = [
            f"while each motor is within {self.radius:.3g} {self.unit} of the pose, there is "
            f"exactly one pose that closes the loops and is led to from there, within "
            f"{self.passive_radius:.3g} rad of it, and K* has rank {self.rank}"
        ]
        if self.kind == "loss":
            parts.append(f"the tool moves in {self.tool_rank} ways on the judged rows")
        if self.held:
            parts.append(f"with {', '.join(self.held)} held")
        if self.left_out:
            parts.append(f"by all rows but {len(self.left_out)} that depend on them at the pose")
        return Evidence("proof", "; ".join(parts))


def singularity_free(
    configuration: Configuration,
    *,
    kind: Freed = "gain",
    most_cells: int = 1,
    order: Literal[1, 2] = 1,
) -> SingularityFree:
    """Return how far motors may move from a pose with no singularity met: a proof.

    By interval arithmetic in one step, or with the motors' values about the pose covered by many
    cells, so that it is some fraction of the distance to the nearest singularity, which
    `nearest_singularity` estimates from above: a tenth, say, in one step, and much more with
    hundreds of cells and two or three motors.

    Parameters
    ----------
    configuration : Configuration
    kind : {"gain", "loss"}
        No gain: K* keeps its rank, nothing comes free with the motors locked. No loss: nor does
        the tool lose a motion, on the judged rows.
    most_cells : int
        How many steps may be tried, 1 or more; some 30 ms each.
    order : {1, 2}
        Of the polynomials along which the one step about the pose goes: with 2 it goes further,
        where machines have no gears, and takes up to seconds.

    Returns
    -------
    SingularityFree
        False where nothing is proven; `failed` then says why.

    Raises
    ------
    ArgumentError
        No such kind, number or order.
    NoToolError
        No loss, and no frame is named as the tool.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> home = pj.load("five_bar").home
    >>> nearest = pj.nearest_singularity(home, kind="gain", rng=0)
    >>> proven = pj.singularity_free(home)
    >>> 0.03 < proven.radius < nearest.distance
    True
    """
    check_kind(configuration, Configuration)
    check_one_of(kind, "kind", FREED)
    check_one_of(order, "order", (1, 2))
    most_cells = as_count(most_cells, "most_cells")
    mechanism, partition = configuration.mechanism, configuration.problem.partition
    slides = all(unit == "m" for unit in partition.units_of(partition.actuated))
    unit: Literal["m", "rad"] = "m" if slides else "rad"
    if kind == "loss":
        mechanism.need_tool()
    elif not partition.passive_rank:
        return SingularityFree(np.inf, unit, 0.0, 0)
    try:
        with precise(), np.errstate(over="ignore", invalid="ignore"):
            found = _proven_ball(configuration, kind, most_cells, order)
    except ArgumentError as error:
        return SingularityFree(0.0, unit, 0.0, partition.passive_rank, kind, str(error))
    left_out, held = map(others_of, (len(mechanism.rows), partition.passive.size), found.kept)
    return SingularityFree(
        radius=found.radius * (partition.length if slides else 1.0) / OUTWARDS,
        unit=unit,
        passive_radius=found.passive,
        rank=partition.passive_rank,
        kind=kind,
        tool_rank=partition.tool_rank if kind == "loss" else 0,
        failed=found.failed,
        left_out=tuple(mechanism.rows[k] for k in left_out.tolist()),
        held=tuple(partition.passive_names[k] for k in held.tolist()),
        cells=found.cells,
    )


class _ProvenBall(NamedTuple):
    """What is proven of the motors within a distance, and by which rows and columns of K*."""

    radius: float
    passive: float
    kept: tuple[Index, Index]
    failed: str
    cells: int


def _proven_ball(
    configuration: Configuration, kind: Freed, most_cells: int, order: int
) -> _ProvenBall:
    """Return the largest ball that one step proves, a series, or cells as large as one step's."""
    mechanism, partition = configuration.mechanism, configuration.problem.partition
    columns = [*partition.passive.tolist(), *partition.actuated.tolist()]
    model, loops = mechanism.kinematics.model, mechanism.spec.loops
    equations = LoopEquations(model, loops, mechanism.parameters, columns)
    tool = ToolRates(mechanism, equations.unknowns) if kind == "loss" else None
    bounds = BallBounds(equations, configuration, tool=tool)
    found = bounds.largest()
    first, groups = found[0], equations.unknowns.groups[:, : partition.passive.size]
    if first and order > 1 and _in_series(equations, partition):
        series = SeriesBall(configuration, bounds.kept, groups, tool)
        found = max(found, series.largest(first))
    cells = FreeCells(equations, configuration, bounds, most_cells, tool)
    if first and most_cells > 1 and _one_by_one(equations, bounds, partition):
        found = max(found, cells.grown(_HALF_A_CELL * first))
    return _ProvenBall(*found, bounds.kept, bounds.failed, cells.tried)


def _in_series(equations: LoopEquations, partition: Partition) -> bool:
    """Tell whether motors' values are numbers of one freedom each, and no gears tie joints."""
    return not equations.geared and _single_motors(equations, partition)


def _single_motors(equations: LoopEquations, partition: Partition) -> bool:
    motors = equations.unknowns.groups[:, partition.passive.size :]
    return bool(motors.sum(axis=1).max() <= 1.0)


def _one_by_one(equations: LoopEquations, bounds: BallBounds, partition: Partition) -> bool:
    """Tell whether each motor is a freedom of its own and nothing idles: else one step is all."""
    single = _single_motors(equations, partition)
    return single and bounds.kept[1].size == partition.passive.size
