"""Configuration: a value that certifies "kinematics computed, loops closed"."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from pmjac_pin.algebra.one_thread import one_thread_from
from pmjac_pin.closing.closed import Closed, closed_point
from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.closing.generic_ranks import on_branch_of
from pmjac_pin.closing.idle_motions import gained_and_idle
from pmjac_pin.closing.loaded_pose import LoadedPose
from pmjac_pin.closing.parts import Parts
from pmjac_pin.errors import ArgumentError, ClosureError
from pmjac_pin.kinematics.pinocchio import Snapshot
from pmjac_pin.model.limits import Violation, violations
from pmjac_pin.model.reference_frame import frame_name
from pmjac_pin.model.tool_rows import WORLD_AXES
from pmjac_pin.model.twist_frame import FrameName, change_frame
from pmjac_pin.pose_of_configuration import PoseOfConfiguration
from pmjac_pin.rates.allowed import AllowedJacobian, allowed_jacobian
from pmjac_pin.rates.elimination import eliminated
from pmjac_pin.rates.jacobian import EquivalentJacobian
from pmjac_pin.rates.known_jacobian import KnownJacobian
from pmjac_pin.rates.partition import LoopRates
from pmjac_pin.rates.singularity import Singularity, analyse_singularity
from pmjac_pin.rates.split import SplitJacobian
from pmjac_pin.values.arrays import Array, read_only
from pmjac_pin.values.found_once import found_once
from pmjac_pin.values.shown import Shown

if TYPE_CHECKING:
    from pmjac_pin.closing.one_pose import KnownPose
    from pmjac_pin.mechanism import Mechanism


@dataclass(frozen=True, eq=False, repr=False)
class Configuration(LoadedPose, Shown):
    """A pose of a mechanism whose loops are closed.

    Made by `Mechanism.close`, `Mechanism.home`, `Mechanism.pose` and `Mechanism.configuration`
    only; holding one is proof that the loops are closed to the tolerance.

    Attributes
    ----------
    mechanism : Mechanism
    q : ndarray, shape (nq,)
        Pinocchio's configuration vector, read-only.
    iterations : int
        Newton iterations that it took to close the loops, 0 for a given q.
    residual_norm : float
        Euclidean norm of the gaps of all loops, in m.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> configuration = pj.load("four_bar").close([1.0])
    >>> configuration
    Configuration(four_bar, theta1=1, residual_norm=...)
    >>> bool(configuration.residual_norm < 1e-12)
    True
    """

    mechanism: Mechanism = field(init=False)
    q: Array = field(init=False)
    iterations: int = field(init=False)
    residual_norm: float = field(init=False)

    if TYPE_CHECKING:
        _problem: ClosureProblem | None  # where a path led here

    def __init__(self) -> None:
        # It is a proof, so nobody can make one by hand, `dataclasses.replace` included.
        raise ArgumentError("a Configuration is made by Mechanism.close, .pose or .configuration")

    @classmethod
    def _certified(
        cls,
        mechanism: Mechanism,
        q: Array,
        iterations: int,
        gap: float,
        problem: ClosureProblem | None = None,
        **known: object,
    ) -> Configuration:
        """Make a configuration of a q whose loops were just seen closed, keeping what is known.

        That is on the branch with the problem's ranks, where one is given.
        """
        configuration = object.__new__(cls)
        configuration.__dict__.update(
            known,
            mechanism=mechanism,
            q=read_only(q),
            iterations=iterations,
            residual_norm=gap,
            _problem=problem,
        )
        return configuration

    @classmethod
    def _of_point(
        cls, mechanism: Mechanism, point: Closed, iterations: int, problem: ClosureProblem
    ) -> Configuration:
        """Make the configuration where a path ended, on the branch with the problem's ranks."""
        return cls._certified(mechanism, point.q, iterations, point.gap, problem, _point=point)

    @classmethod
    def _of_q(cls, mechanism: Mechanism, q: Array, iterations: int = 0) -> Configuration:
        """Make the configuration of a given q, or raise ClosureError when its loops are open."""
        parts = mechanism._parts
        if (known := mechanism.recorded.pose(q)) is not None:
            return cls._certified(mechanism, q, iterations, known.gap, _known=known)
        snapshot, problem = parts.kinematics.snapshot(q), parts.problem
        gap = problem.gap(snapshot.residual)
        if not gap <= problem.tolerance:
            message = (
                f"the loops of {mechanism.name!r} are open by {gap:.3g} m at this q (tolerance "
                f"{problem.tolerance:g} m); use close() to close them"
            )
            raise ClosureError(message, residual_norm=gap, q=q)
        return cls._certified(mechanism, q, iterations, gap, _known=None, _snapshot=snapshot)

    @property
    def actuated(self) -> Array:
        """Motor values θ, shape (n,), m or rad, in the order of `Mechanism.actuated`."""
        return self._values(self._parts.problem.partition.actuated)

    @property
    def passive(self) -> Array:
        """Passive values φ, shape (m_p,), m or rad, in the order of `Mechanism.passive`."""
        return self._values(self._parts.problem.partition.passive)

    @property
    def joint_values(self) -> Mapping[str, float | tuple[float, ...]]:
        """Every joint's value by its name, m or rad, motors first; a guess for `close`.

        A joint with several degrees of freedom has a tuple of them.
        """
        spec, coordinates = self._parts.spec, self._parts.coordinates
        others = (name for name in coordinates.names if name not in spec.actuated)
        names = spec.actuated + (spec.passive or tuple(others))
        return MappingProxyType(coordinates.joint_values(self.q, names))

    @property
    def limits_violated(self) -> Mapping[str, Violation]:
        """The joints beyond their limits, by name, motors first: `value`, `lower`, `upper`, `unit`.

        The loops close here, but the joints that the model describes cannot be here.
        An angle counts as it is, full turns and all.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> bar = pj.load("four_bar")
        >>> dict(bar.close([1.0]).limits_violated)
        {}
        >>> bar.close([6.5], enforce_limits=False).limits_violated["theta1"].words
        '6.5 rad is outside its limits [-6.28319, 6.28319] rad'
        """
        return violations(self._parts.coordinates, self.q, self.joint_values)

    @property
    def residual(self) -> Array:
        """η(q), shape (p,): m for a point loop, m² for a distance loop; world axes."""
        return read_only(self._snapshot.residual)

    def tool_pose(self, tool: str | Sequence[str] | None = None) -> pin.SE3:
        """Return the tool's pose in the world: a rotation and a translation in m.

        Parameters
        ----------
        tool : str or three str, optional
            Another frame than the mechanism's tool, or three that span one: as of `with_tool`.

        Raises
        ------
        NoToolError
            No frame is named as the tool.
        UnknownNameError, ArgumentError
            As `with_tool`.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> home = pj.load("four_bar").home
        >>> home.tool_pose("rocker_tip").translation.round(3).tolist()
        [2.469, 3.147, 0.0]
        """
        if tool is not None:
            return self.with_tool(tool).tool_pose()
        self._need_tool()
        return pin.SE3(self._snapshot.rotation, self._snapshot.position + self._parts.place)

    def with_tool(self, tool: str | Sequence[str]) -> Configuration:
        """Return this pose of the mechanism with another tool: a frame, or three that span it.

        `tool_pose()`, `jacobian()` and `singularity()` are its; see `Mechanism.with_tool`.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> home = pj.load("four_bar").home
        >>> home.with_tool("rocker_tip").singularity().kind
        'regular'
        """
        return self.mechanism.with_tool(tool).configuration(self.q)

    def jacobian(
        self,
        frame: str | pin.ReferenceFrame = WORLD_AXES,
        *,
        tool: str | Sequence[str] | None = None,
    ) -> EquivalentJacobian:
        """Return J_eq = J − J* K*⁻¹ K and the matrices that it is made of.

        Parameters
        ----------
        frame : {"LOCAL_WORLD_ALIGNED", "LOCAL", "WORLD"} or pin.ReferenceFrame
            Frame of the tool's twist, with Pinocchio's meaning.
        tool : str or three str, optional
            Another frame than the mechanism's tool, or three that span one: as of `with_tool`.

        Raises
        ------
        SingularError
            At a singularity, where no J_eq exists; `singularity` still answers there.
        ForbiddenRatesError
            The loops forbid some motor rates; `allowed_jacobian` answers for the others.
        IdleMotionError
            The tool feels a passive motion that no motor commands.
        NoToolError
            No frame is named as the tool.

        References
        ----------
        Ghosal, *Parallel Manipulator Jacobian Matrix*, equations (26) to (32).

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> pj.load("serial_2r").home.jacobian().Jw_eq[2].tolist()
        [1.0, 1.0]
        """
        if tool is not None:
            return self.with_tool(tool).jacobian(frame)
        known, home = self._known, self.mechanism._parts.problem
        problem = self._branch[0] if known is None else self.problem
        if not problem.partition.tool_rows.names:
            self._need_tool()
        name: FrameName = WORLD_AXES if frame is WORLD_AXES else frame_name(frame)
        pose = PoseOfConfiguration(self, name)
        find: Callable[[], EquivalentJacobian]
        if known is not None and problem is home:
            J_eq, find = known.J_eq(name), functools.partial(self._whole, pose)
        else:
            J_eq, find = self._eliminated(pose)
        return KnownJacobian.of(J_eq, name, problem.partition, pose, find)

    def allowed_jacobian(
        self,
        frame: str | pin.ReferenceFrame = "LOCAL_WORLD_ALIGNED",
        *,
        tool: str | Sequence[str] | None = None,
    ) -> AllowedJacobian:
        """Return J_eq on the motor rates that the loops allow, where motors are tied to each other.

        With more motors than freedoms `jacobian` is refused, since not all motor rates are
        possible. Those that are fit each other: some motors lead, and the others follow. Where the
        loops tie none, all lead, and `J_eq` is that of `jacobian`.

        Parameters
        ----------
        frame, tool
            As of `jacobian`.

        Raises
        ------
        SingularError, IdleMotionError
            As `jacobian`.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> tied = pj.load("four_bar", actuated=["theta1", "phi1"]).home.allowed_jacobian()
        >>> tied.leading, tied.motor_rates.round(4).tolist(), tied.Jw_eq[2].round(4).tolist()
        (('theta1',), [[1.0], [-0.0024]], [-0.3345])
        """
        if tool is not None:
            return self.with_tool(tool).allowed_jacobian(frame)
        self._need_tool()
        split = self.split_jacobian(frame)
        return allowed_jacobian(split, self.singularity, loops=self._loop_rates)

    def _eliminated(
        self, pose: PoseOfConfiguration
    ) -> tuple[Array, Callable[[], EquivalentJacobian]]:
        """Return J_eq by singular values, and what has all matrices; or say why there is none."""
        constraint, tool = self._jacobians(self._snapshot, pose.frame)
        problem, loops = self._branch
        partition = problem.partition
        with one_thread_from(partition.column_scale.size):
            rates, J_eq = eliminated(tool, partition, loops, self.singularity)
        J_eq = read_only(J_eq)
        matrices = constraint, tool, pose.frame, partition, rates, J_eq
        return J_eq, functools.partial(EquivalentJacobian, *matrices, pose=pose)

    def _whole(self, pose: PoseOfConfiguration) -> EquivalentJacobian:
        return self._eliminated(pose)[1]()

    def split_jacobian(
        self, frame: str | pin.ReferenceFrame = "LOCAL_WORLD_ALIGNED"
    ) -> SplitJacobian:
        """Return K, K*, J and J*, which exist at singular poses too; J and J* NaN without a tool.

        Parameters
        ----------
        frame : {"LOCAL_WORLD_ALIGNED", "LOCAL", "WORLD"} or pin.ReferenceFrame
            Frame of the tool's twist, with Pinocchio's meaning.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> pj.load("four_bar").home.split_jacobian().K_star.shape
        (2, 2)
        """
        name = frame_name(frame)
        constraint, tool = self._jacobians(self._snapshot, name)
        partition = self.problem.partition
        if self._parts.spec.tool.is_none:
            tool = np.full_like(tool, np.nan)
        return SplitJacobian(
            constraint, tool, name, partition, pose=PoseOfConfiguration(self, name)
        )

    def singularity(self) -> Singularity:
        """Return the ranks here, the kind of singularity and what moves freely.

        By singular values, and by the factorisation that `jacobian` takes, too, where no recorded
        program tells it that K* has its rank for certain.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> pj.load("four_bar").home.singularity().kind
        'regular'
        """
        return self._singularity

    @found_once
    def _singularity(self) -> Singularity:
        problem, snapshot = self.problem, self._snapshot
        rows = problem.partition.tool_rows
        with one_thread_from(self._parts.model.nv):
            return analyse_singularity(
                snapshot.constraint_jacobian,
                snapshot.judged_jacobian(rows),
                problem.partition,
                functools.partial(gained_and_idle, problem, self.q),
                loops=self._loop_rates,
                tool_pose=(snapshot.axes_of(rows), snapshot.position + self._parts.place),
                slopes=PoseOfConfiguration(self, rows.axes).slopes,
                find_margins=PoseOfConfiguration(self, rows.axes).margins,
            )

    def _need_tool(self) -> None:
        self.mechanism.need_tool()

    def _jacobians(self, snapshot: Snapshot, frame: FrameName) -> tuple[Array, Array]:
        """Return the constraint and the tool Jacobian of a snapshot, the latter in a frame."""
        constraint, tool = snapshot.constraint_jacobian, snapshot.tool_jacobian
        if frame == WORLD_AXES:
            return constraint, tool
        position = snapshot.position + self._parts.place
        return constraint, change_frame(tool, frame, snapshot.rotation, position)

    @found_once
    def _known(self) -> KnownPose | None:
        return self.mechanism.recorded.pose(self.q)

    def _motion_by_home(self, rates: Array) -> tuple[Array, Array, Array] | None:
        """Return what motor rates lead to by a program, None where nothing is certain."""
        recorded = None if self._known is None else self.mechanism.recorded.motion()
        return None if recorded is None else recorded.at(self.q, rates)

    @found_once
    def _point(self) -> Closed:
        return closed_point(self.problem, self.q)

    @property
    def problem(self) -> ClosureProblem:
        """The closure problem, with the generic ranks of the branch that this pose lies on."""
        if (told := self._problem) is not None:
            return told
        return self._parts.problem if self._known is not None else self._branch[0]

    @property
    def _loop_rates(self) -> LoopRates:
        return self._branch[1]

    @found_once
    def _branch(self) -> tuple[ClosureProblem, LoopRates]:
        """The problem of the branch that this pose lies on, and what the loops allow by it."""
        parts, jacobian = self._parts, self._snapshot.constraint_jacobian
        home, here = parts.problem, self._problem
        with one_thread_from(parts.model.nv):
            if here is None:
                loops = home.partition.loop_rates(jacobian)
                if self._known is None:
                    here = on_branch_of(home, parts.kinematics, self.q, loops)
                if here is None or here is home:
                    return home, loops
            return here, here.partition.loop_rates(jacobian)

    @found_once
    def _snapshot(self) -> Snapshot:
        return self._parts.kinematics.snapshot(self.q)

    @property
    def _parts(self) -> Parts:
        return self.mechanism._parts

    def _values(self, columns: NDArray[np.intp]) -> Array:
        return read_only(self._parts.coordinates.values(self.q)[columns])

    def __reduce__(self) -> tuple[Any, ...]:
        # What a pickle says is no proof: the loops are looked at again.
        return (_unpickled, (self.mechanism, np.array(self.q), self.iterations))

    def __repr__(self) -> str:
        motors = ", ".join(
            f"{name}={value:.6g}"
            for name, value in zip(self.mechanism.actuated[:3], self.actuated[:3], strict=True)
        ) + ", ..." * (self.actuated.size > 3)
        gap = f"residual_norm={self.residual_norm:.1e}"
        beyond = "".join(f", {name!r} beyond its limits" for name in self.limits_violated)
        return f"Configuration({self.mechanism.name}, {motors}, {gap}{beyond})"


def _unpickled(mechanism: Mechanism, q: Array, iterations: int) -> Configuration:
    return Configuration._of_q(mechanism, mechanism._checked(q), iterations)
