"""What is recorded of a mechanism: once, when it is needed, for many poses and for single ones.

To record programs takes as long as some hundreds of calls without them. Many poses have them at
once, and single ones of the same mechanism with them; otherwise only when so many calls have been
made that recording would have been paid for, so that nobody who asks for a few waits for it. How
many is counted, not timed: the same calls give the same bits.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Generic, TypeVar

from pmjac_pin.closing.motor_values import Motors
from pmjac_pin.closing.parts import Parts
from pmjac_pin.errors import ArgumentError
from pmjac_pin.model.twist_frame import FrameName
from pmjac_pin.values.arrays import Array

if TYPE_CHECKING:
    from pmjac_pin.algebra.recordings import Recordings
    from pmjac_pin.algebra.tape import Tape
    from pmjac_pin.algebra.terms import Term
    from pmjac_pin.closing.arms import Arms
    from pmjac_pin.closing.blueprint import Blueprint
    from pmjac_pin.closing.design_homes import DesignsOfFile
    from pmjac_pin.closing.one_path import Ahead, OnePath
    from pmjac_pin.closing.one_pose import KnownPose, OnePose
    from pmjac_pin.closing.recorded_dimensions import RecordedDimensions
    from pmjac_pin.closing.recorded_motion import RecordedMotion
    from pmjac_pin.closing.recorded_rates import RecordedRates
    from pmjac_pin.closing.recorded_slopes import RecordedSlopes

Made = TypeVar("Made")

_CALLS = 3  # for each entry of the Jacobians of loops and tool: what it takes to record
_CALLS_OF_SLOPES = 20  # which take longer without a program


class Earned(Generic[Made]):
    """Something that is made when it has been asked for often enough, or is wanted anyway."""

    __slots__ = ("_left", "_made", "_make", "_wanted")

    def __init__(
        self, calls: int, make: Callable[[], Made | None], wanted: Callable[[], bool]
    ) -> None:
        self._left, self._make, self._wanted = calls, make, wanted
        self._made: Made | None = None

    def __call__(self) -> Made | None:
        """Return it, None before it is made, or where it cannot be made."""
        if self._left > 0:
            self._left = 0 if self._wanted() else self._left - 1
            if not self._left:
                self._made = self._make()
        return self._made


class RecordedMechanism:
    """Programs of one mechanism.

    Parameters
    ----------
    parts : Parts
    recordings : Recordings, optional
        Of machines of other dimensions.

    Raises
    ------
    ArgumentError
        By what records: a joint that is not in the table of joints.
    """

    def __init__(self, parts: Parts, recordings: Recordings | None = None) -> None:
        self._parts, self._recordings = parts, recordings
        self._jacobians: dict[FrameName, Tape] = {}
        partition = parts.problem.partition
        calls = _CALLS * (partition.row_scale.size + 6) * partition.column_scale.size
        self._pose = Earned(calls, self._one_pose, self._serves_many)
        self._path = Earned(calls, self._one_path, self._serves_many)
        self._slopes = Earned(_CALLS_OF_SLOPES, self._recorded_slopes, lambda: False)
        self._motion = Earned(_CALLS_OF_SLOPES, self._recorded_motion, lambda: False)

    def pose(self, q: Array) -> KnownPose | None:
        """Return what is certain of a pose without singular values, None where nothing is."""
        one_pose = self._pose()
        return None if one_pose is None else one_pose.at(q)

    def sizes(self, q: Array, frame: FrameName) -> Array | None:
        """Return `TwistMap.sizes` at a q that `pose` knows, None where nothing tells them."""
        one_pose = self._pose()
        return None if one_pose is None else one_pose.sizes(q, frame)

    def slopes(self) -> RecordedSlopes | None:
        """Return what says how Jacobians change along motions, None where nothing is recorded."""
        return self._slopes()

    def motion(self) -> RecordedMotion | None:
        """Return what says what motor rates lead to at poses that are known."""
        return self._motion()

    def path(self, q: Array, values: Array) -> Ahead | None:
        """Return how far a straight path from a closed q is certain, None where it is not at all.

        Parameters
        ----------
        q : ndarray, shape (nq,)
            On a branch with home's ranks.
        values : ndarray, shape (n,)
            Of the motors, at its end.
        """
        one_path = self._path()
        ahead = None if one_path is None else one_path.follow(q, values)
        return ahead if ahead is None or ahead.share else None

    @cached_property
    def rates(self) -> RecordedRates:
        """What programs are recorded of, the columns kept that are best at home."""
        # What records is imported with the first program: a load and a few calls need none of it.
        from pmjac_pin.closing.recorded_rates import RecordedRates  # noqa: PLC0415
        from pmjac_pin.kinematics.recorded import Recorder  # noqa: PLC0415

        parts = self._parts
        recorder = Recorder(parts.model, parts.spec, parts.values, parts.place)
        return RecordedRates.at(recorder, parts.problem, parts.home_q, self._recordings)

    def dimensions(self, blueprint: Blueprint) -> RecordedDimensions:
        """Return where joints and frames are, as functions of the parameters."""
        from pmjac_pin.closing.recorded_dimensions import RecordedDimensions  # noqa: PLC0415

        return RecordedDimensions(self._parts, blueprint)

    def rates_at(self, blueprint: Blueprint, values: Mapping[str, Term]) -> RecordedRates:
        """Return `rates` of dimensions that are recorded; columns and scales are those of `rates`.

        Parameters
        ----------
        blueprint : Blueprint
            Of the machine.
        values : mapping of str to Term
            Of some of its parameters; the others stay as they are.

        Raises
        ------
        ArgumentError
            A machine, or a parameter, whose changes cannot be recorded.
        """
        from pmjac_pin.kinematics.recorded import Recorder  # noqa: PLC0415

        parts = self._parts
        dimensions = self.dimensions(blueprint).at({**parts.values, **values})
        recorder = Recorder(parts.model, parts.spec, parts.values, parts.place, dimensions)
        return replace(self.rates, recorder=recorder)

    @property
    def walks(self) -> bool:
        """Whether programs know how motors go: their values add up."""
        parts = self._parts
        return not parts.coordinates.curved[parts.problem.partition.actuated].any()

    @cached_property
    def walking(self) -> tuple[Tape, Tape, Tape]:
        """What a `Walker` of many paths takes: moves, arrivals and legs."""
        from pmjac_pin.closing.recorded_step import leg_tape  # noqa: PLC0415

        rates = self.rates
        return rates.move_tape(), rates.arrival_tape(), leg_tape(rates, self._arms)

    @cached_property
    def _arms(self) -> Arms:
        from pmjac_pin.closing.arms import arms_of  # noqa: PLC0415

        parts = self._parts
        return arms_of(parts.model, parts.spec.loops, parts.values)

    @cached_property
    def idling(self) -> tuple[Tape, Tape, Tape] | None:
        """What `ManyIdlePaths` takes; None where nothing idles."""
        if not self.rates.idle:
            return None
        from pmjac_pin.closing.recorded_idle_way import (  # noqa: PLC0415
            cover_tape,
            idle_tape,
            return_tape,
        )

        idle = idle_tape(self.rates)
        return idle, return_tape(self.rates, idle), cover_tape(self.rates, self._arms, idle)

    @cached_property
    def ellipsoids(self) -> Tape:
        """`RecordedRates.ellipsoids_tape`."""
        return self.rates.ellipsoids_tape()

    @cached_property
    def measures(self) -> Tape:
        """`RecordedRates.measures_tape`."""
        return self.rates.measures_tape()

    def jacobian(self, frame: FrameName) -> Tape:
        """Return `RecordedRates.jacobian_tape`."""
        if frame not in self._jacobians:
            self._jacobians[frame] = self.rates.jacobian_tape(frame)
        return self._jacobians[frame]

    def designs(self, blueprint: Blueprint, swept: Iterable[str]) -> DesignsOfFile | None:
        """Return designs that differ in some parameters; None for machines that are not served."""
        from pmjac_pin.closing.design_homes import DesignsOfFile  # noqa: PLC0415

        try:
            return DesignsOfFile(self._parts, blueprint, swept) if self.walks else None
        except ArgumentError:
            return None

    def _serves_many(self) -> bool:
        return "walking" in self.__dict__

    def _one_pose(self) -> OnePose | None:
        from pmjac_pin.closing.one_pose import OnePose  # noqa: PLC0415
        from pmjac_pin.closing.path_kernel import path_kernel  # noqa: PLC0415

        if (library := path_kernel()) is None or not self._determined:
            return None
        try:
            tape = self.rates.pose_tape()
        except ArgumentError:
            return None
        return OnePose(library, tape, self._parts.problem, self._parts.model)

    def _one_path(self) -> OnePath | None:
        from pmjac_pin.closing.one_path import OnePath  # noqa: PLC0415
        from pmjac_pin.closing.path_kernel import path_kernel  # noqa: PLC0415

        if (library := path_kernel()) is None or not self._determined:
            return None
        if not self.walks:
            return None
        try:
            tapes = self.walking
        except ArgumentError:
            return None
        parts, coordinates = self._parts, self._parts.coordinates
        motors = Motors(parts.spec, coordinates)
        return OnePath(library, tapes, parts.problem, coordinates, motors)

    def _recorded_slopes(self) -> RecordedSlopes | None:
        from pmjac_pin.closing.path_kernel import path_kernel  # noqa: PLC0415
        from pmjac_pin.closing.recorded_slopes import RecordedSlopes  # noqa: PLC0415

        if (library := path_kernel()) is None:
            return None
        try:
            tape = self.rates.slopes_tape()
        except ArgumentError:
            return None
        partition = self._parts.problem.partition
        rows, nv = partition.row_scale.size, partition.column_scale.size
        return RecordedSlopes(library, tape, rows, nv)

    def _recorded_motion(self) -> RecordedMotion | None:
        from pmjac_pin.closing.path_kernel import path_kernel  # noqa: PLC0415
        from pmjac_pin.closing.recorded_motion import RecordedMotion, motion_tape  # noqa: PLC0415

        if (library := path_kernel()) is None:
            return None
        partition = self._parts.problem.partition
        sizes = partition.column_scale.size, partition.actuated.size
        return RecordedMotion(library, motion_tape(self.rates), *sizes)

    @property
    def _determined(self) -> bool:
        """Whether motors move as they like, and all passive joints with them.

        Elsewhere ranks decide which motors lead and which motions idle.
        """
        partition = self._parts.problem.partition
        ranks = {partition.passive.size, partition.passive_rank, partition.constraint_rank}
        # Another branch may have more rank, of the tool too: then each pose is looked at.
        return len(ranks) == 1 and partition.tool_full and not partition.isolated
