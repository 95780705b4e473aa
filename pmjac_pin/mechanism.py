"""Mechanism: Pinocchio model, loops, actuated/passive split and tool, closed at any pose."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING

import pinocchio as pin
from numpy.typing import ArrayLike

from pmjac_pin import direct_kinematics
from pmjac_pin.closing.arms import arms_of, without_arms
from pmjac_pin.closing.assembly import build_parts
from pmjac_pin.closing.motor_values import Motors
from pmjac_pin.closing.pose_assembly import assemble_pose
from pmjac_pin.closing.recorded_mechanism import RecordedMechanism
from pmjac_pin.closing.step_guard import StepGuard
from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError, unknown_name
from pmjac_pin.mechanism_siblings import MechanismSiblings
from pmjac_pin.model.limits import unread_limits
from pmjac_pin.model.loop_spec import Loop
from pmjac_pin.model.pinocchio_model import Constraint, RobotWrapper, own_model
from pmjac_pin.model.spec import JointValue
from pmjac_pin.model.unit_turns import with_unit_turns
from pmjac_pin.values.arrays import Array, read_only
from pmjac_pin.values.checks import as_numbers
from pmjac_pin.values.shown import Shown

if TYPE_CHECKING:
    from pmjac_pin.closing.idle_way import IdleWay
    from pmjac_pin.kinematics.slopes import SlopesAlongMotions


@dataclass(frozen=True, eq=False, repr=False)
class Mechanism(MechanismSiblings, Shown):
    """A mechanism with closed loops: made by `load` or `Mechanism.from_pinocchio`.

    A value: it can be shared between threads, copied, and pickled to other processes. In a notebook
    it shows itself: its degrees of freedom with their limits, its parameters, loops and poses.

    Attributes
    ----------
    notes : tuple of str
        One sentence for each decision that the reader of a file of another format took, after
        those of `unread`.
    unread : tuple of str
        One sentence for each kind of thing in the file that nobody reads, and that might tie
        bodies together.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> mechanism = pj.load("three_rps")
    >>> mechanism
    Mechanism(three_rps, actuated=(l1, l2, l3), 9 passive, 3 loops, mobility 3)
    """

    _poses: dict[str, Configuration] = field(default_factory=dict)

    @classmethod
    def from_pinocchio(
        cls,
        model: pin.Model | RobotWrapper,
        loops: Iterable[Loop | Constraint],
        actuated: Iterable[str],
        tool: str | Sequence[str] | None = None,
        *,
        passive: Iterable[str] | None = None,
        home: ArrayLike | Mapping[str, JointValue] | None = None,
        name: str = "",
        tool_rows: Iterable[str] | None = None,
        tool_axes: str | None = None,
        tolerance: float | None = None,
        enforce_limits: bool = True,
    ) -> Mechanism:
        """Make a mechanism of a Pinocchio model that you already hold.

        Parameters
        ----------
        model : pin.Model or RobotWrapper
            The cut tree; copied. Limits of joints with one degree of freedom are kept; `notes` name
            others.
        loops : iterable of PointLoop, RevoluteLoop, ...
            Or Pinocchio's own constraint models: point anchors and frame anchors, alone or in a
            ``pin.ConstraintModel``, and ``pin.RigidConstraintModel``.
        actuated : iterable of str
            Motor joints, in the order of the columns of K and J.
        tool : str or three str, optional
            A frame, or the three frames whose origins span the tool. Without one there is no J_eq,
            until `with_tool` or `jacobian(tool=...)` names it.
        passive : iterable of str, optional
            The other joints in the order of the columns of K* and J*; Pinocchio's when None.
        home : array_like (nq,) or mapping of str to float, optional
            Joint values near which the loops are assembled; neutral when None.
        name : str, optional
            The model's own when empty.
        tool_rows : iterable of str, optional
            The rows of the tool's twist that count where ranks are judged, of "vx", "vy", "vz",
            "wx", "wy" and "wz"; all when None. J_eq always has all six.
        tool_axes : {"LOCAL_WORLD_ALIGNED", "LOCAL"}, optional
            The axes of these rows: the world's (when None), or the tool's own.
        tolerance : float, optional
            The gap in m up to which the loops count as closed, where the model's numbers are
            rounded; 1e-12 of the characteristic length when None.
        enforce_limits : bool, optional
            Whether home keeps within the joints' limits.

        Raises
        ------
        UnknownNameError, ArgumentError, ClosureError

        Examples
        --------
        >>> import pinocchio as pin, pmjac_pin as pj
        >>> arm = pin.buildSampleModelManipulator()
        >>> pj.Mechanism.from_pinocchio(arm, [], arm.names[1:], "effector_body", name="arm")
        Mechanism(arm, actuated=(shoulder1_joint, ...), 0 passive, 0 loops, mobility 6)
        """
        own, spec = own_model(
            model,
            loops,
            actuated,
            tool,
            passive=passive,
            home=home,
            name=name,
            tool_rows=tool_rows,
            tool_axes=tool_axes,
            tolerance=tolerance,
            enforce_limits=enforce_limits,
        )
        return cls(build_parts(own, spec, {}), notes=tuple(unread_limits(own)))

    @property
    def home(self) -> Configuration:
        """The pose "home", its loops closed."""
        return self.pose("home")

    def pose(self, name: str) -> Configuration:
        """Return a named pose, its loops closed.

        The motors keep the pose's values where a closed pose is found with them at rest: from
        the pose's own passive values or, where these leave the loops wide open, from 24
        seeded starts further and further around them, on whichever assembly mode that leads
        to (with other parameters, the one that was meant may not exist). That none is found is
        no proof that there is none (`assembly_modes` tells more). Then the motors move as
        little as it takes. `moved` says how far all joints are from the values given.

        Raises
        ------
        UnknownNameError
            No such pose.
        ClosureError
            The loops do not close near it, or not within the joints' limits.
        """
        if isinstance(name, str) and (known := self._poses.get(name)) is not None:
            return known
        if not isinstance(name, str) or name not in self._parts.spec.poses:
            raise unknown_name("pose", name, self.poses)
        parts, q = self._parts, self._parts.home_q
        if name != "home":
            start = parts.coordinates.q(self.spec.poses[name], parts.home_q)
            q = assemble_pose(parts, start, name)
        return self._poses.setdefault(name, Configuration._of_q(self, q))

    def moved(self, pose: str = "home") -> Mapping[str, float]:
        """Return how far each degree of freedom had to move to close a pose's loops.

        Parameters
        ----------
        pose : str
            A name of `poses`.

        Returns
        -------
        mapping of str to float
            By the names of `actuated` and `passive`: the closed pose less the values that the
            model file gives, m or rad.

        Raises
        ------
        UnknownNameError, ClosureError
            As `pose`.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> moved = pj.load("four_bar", {"l1": 1.2}).moved()
        >>> {name: round(value, 3) for name, value in moved.items()}
        {'theta1': 0.0, 'phi1': -0.064, 'phi2': -0.034}
        """
        parts, closed = self._parts, self.pose(pose)
        given = parts.coordinates.q(self.spec.poses[pose], parts.home_q if pose != "home" else None)
        change = pin.difference(parts.model, given, closed.q)
        columns = parts.problem.partition.columns
        return MappingProxyType({name: float(change[k]) for name, k in columns.items()})

    close = direct_kinematics.close

    def loop_equations(self, q: ArrayLike) -> tuple[Array, Array]:
        """Return the loop equations and their derivative at any q, closed or not.

        Parameters
        ----------
        q : array_like, shape (nq,)
            Pinocchio's configuration vector.

        Returns
        -------
        residual : ndarray, shape (p,)
            η(q), m, rad or m² (`row_units`), in world axes.
        jacobian : ndarray, shape (p, nv)
            ∂η/∂v, exact on and off closure, its columns in Pinocchio's order.

        Raises
        ------
        ArgumentError
            Not nq finite numbers, or a quaternion or (cos, sin) that is not of unit length.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> mechanism = pj.load("four_bar")
        >>> residual, jacobian = mechanism.loop_equations([0.0, 0.0, 0.0])
        >>> residual.round(3).tolist(), jacobian.shape
        ([-3.5, 0.0, 0.0], (3, 3))
        """
        residual, jacobian = self._parts.kinematics.loop_equations(self._checked(q))
        return read_only(residual), read_only(jacobian)

    def configuration(self, q: ArrayLike) -> Configuration:
        """Return the configuration at this q.

        Parameters
        ----------
        q : array_like, shape (nq,)
            Pinocchio's configuration vector.

        Raises
        ------
        ClosureError
            The loops are open there.
        ArgumentError
            Not nq finite numbers, or a quaternion or (cos, sin) that is not of unit length.
        """
        return Configuration._of_q(self, self._checked(q))

    @cached_property
    def recorded(self) -> RecordedMechanism:
        """Programs of the mechanism, recorded when they are needed: for many poses, and for one."""
        recordings = None if self.blueprint is None else self.blueprint.recordings
        return RecordedMechanism(self._parts, recordings)

    @cached_property
    def motors(self) -> Motors:
        """Limits of the motors, and where q holds their values."""
        return Motors(self._parts.spec, self._parts.coordinates)

    @cached_property
    def slopes(self) -> SlopesAlongMotions | None:
        """How Jacobians change along motions; None where joints are not in the table of joints."""
        # Second derivatives are imported with the first of them.
        from pmjac_pin.kinematics.slopes import SlopesAlongMotions  # noqa: PLC0415

        parts = self._parts
        try:
            return SlopesAlongMotions(parts.model, parts.spec, parts.values, parts.place)
        except ArgumentError:
            return None

    @cached_property
    def step_guard(self) -> StepGuard:
        """What tells whether K* stays regular along a step."""
        parts = self._parts
        try:
            arms = arms_of(parts.model, parts.spec.loops, parts.values)
        except ArgumentError:
            arms = without_arms(parts.model, len(parts.kinematics.loops.row_names))
        return StepGuard(parts.model, arms)

    @cached_property
    def idle_way(self) -> IdleWay | None:
        """What knows where idle motions are at the ends of paths; None of unknown joints."""
        from pmjac_pin.closing.idle_way import IdleWay  # noqa: PLC0415

        try:
            return IdleWay(self._parts.model)
        except ArgumentError:
            return None

    def _checked(self, q: ArrayLike) -> Array:
        values, parts = as_numbers(q, "q"), self._parts
        if values.shape != parts.home_q.shape:
            raise ArgumentError(f"q has nq = {self.nq} entries, got shape {values.shape}")
        return with_unit_turns(parts.model, values)
