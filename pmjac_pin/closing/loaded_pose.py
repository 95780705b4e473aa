"""What moves and loads a closed pose: accelerations, equations of motion, statics."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.closing.motor_values import MotorValues, motor_rates
from pmjac_pin.closing.parts import Parts
from pmjac_pin.closing.wrenches import Wrenches, held_wrenches
from pmjac_pin.model.inertias import massless
from pmjac_pin.model.reference_frame import frame_name
from pmjac_pin.model.springs import Springs, spring_efforts
from pmjac_pin.rates.dynamics import Dynamics, check_inertia, without_idle
from pmjac_pin.rates.elimination import refuse_singular
from pmjac_pin.rates.motion import Motion
from pmjac_pin.rates.partition import LoopRates
from pmjac_pin.rates.statics import Statics, balanced
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import as_flag

if TYPE_CHECKING:
    from pmjac_pin.rates.jacobian import EquivalentJacobian
    from pmjac_pin.rates.singularity import Singularity


class LoadedPose:
    """A closed pose, moved and loaded: what a `Configuration` knows of forces."""

    if TYPE_CHECKING:
        q: Array

        @property
        def _loop_rates(self) -> LoopRates: ...

        @property
        def problem(self) -> ClosureProblem: ...  # noqa: D102

        @property
        def _parts(self) -> Parts: ...

        def jacobian(self, frame: str | pin.ReferenceFrame = ...) -> EquivalentJacobian: ...  # noqa: D102

        def singularity(self) -> Singularity: ...  # noqa: D102

        def _need_tool(self) -> None: ...

        def _motion_by_home(self, rates: Array) -> tuple[Array, Array, Array] | None: ...

    def motion(
        self,
        rates: MotorValues,
        accelerations: MotorValues | None = None,
        frame: str | pin.ReferenceFrame = "LOCAL_WORLD_ALIGNED",
    ) -> Motion:
        """Return all that follows from motor rates and accelerations.

        Parameters
        ----------
        rates, accelerations : array_like, shape (n,), or mapping of str to float
            θ̇ and θ̈ (0 when None), m or rad per s and s².
        frame : {"LOCAL_WORLD_ALIGNED", "LOCAL", "WORLD"} or pin.ReferenceFrame
            Of the tool's twist and of its rate.

        Raises
        ------
        SingularError, ForbiddenRatesError, IdleMotionError
            As `jacobian`.
        UnknownNameError, ArgumentError
            Other rates than one for each motor.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> pj.load("slider_crank").home.motion([10.0]).acceleration.shape
        (6,)
        """
        given = [self._motor_rates(each) for each in (rates, accelerations)]
        motion = Motion(self.jacobian(frame), *given)
        known = self._motion_by_home(motion.rates)
        if known is None or motion.jacobian.frame != "LOCAL_WORLD_ALIGNED":
            return motion
        return motion.known(*known)

    def dynamics(
        self, rates: MotorValues | None = None, *, springs: Springs | None = None
    ) -> Dynamics:
        """Return the equations of motion in motor coordinates, M θ̈ + h = τ + J_eqᵀ w.

        Parameters
        ----------
        rates : array_like, shape (n,), or mapping of str to float, optional
            θ̇, m/s or rad/s; at rest when None.
        springs : mapping of str to (float, float), optional
            As of `statics`: `bias` has them.

        Raises
        ------
        SingularError, ForbiddenRatesError, IdleMotionError
            As `jacobian`.
        NoInertiaError
            Some motion of the motors moves no mass.
        UnknownNameError, ArgumentError
            Rates or springs that do not fit.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> pj.load("ur5").home.dynamics().mass_matrix.shape
        (6, 6)
        """
        tree, partition = self._parts.kinematics, self.problem.partition
        motion = self.motion(self._motor_rates(rates))
        (G, idle), still = motion.ways, 0.0 * motion.v
        forces = [tree.efforts(self.q, still, still), tree.efforts(self.q, motion.v, motion.bias)]
        if springs is not None:
            forces[1] += self._held_springs(springs)
        whole, on_tree = tree.mass_matrix(self.q), np.array(forces).T
        mass, driven = G.T @ whole @ G, G.T @ on_tree
        if idle.size:
            mass, driven = without_idle(whole, on_tree, G, idle, partition)
        check_inertia(mass, partition.motor_scale, partial(massless, tree.model))
        gravity, bias = driven.T
        energy = 0.5 * float(motion.v @ whole @ motion.v)
        return Dynamics(motion, 0.5 * (mass + mass.T), gravity, bias, energy)

    def statics(
        self,
        wrench: Wrenches | None = None,
        *,
        frame: str | pin.ReferenceFrame = "LOCAL_WORLD_ALIGNED",
        gravity: bool = True,
        springs: Springs | None = None,
    ) -> Statics:
        """Return the motor efforts, and the forces in the loops, that balance a load at rest.

        Parameters
        ----------
        wrench : array_like, shape (6,), or mapping of str or three str to such, optional
            That acts on the tool, or on each of these frames: a force in N, and a moment in N m.
            On three frames that span one it is forces at their origins that do the same work.
        frame : {"LOCAL_WORLD_ALIGNED", "LOCAL", "WORLD"} or pin.ReferenceFrame
            Of the wrenches: about the tool's origin by the world's axes or by its own, or about the
            world's origin.
        gravity : bool
            Whether the bodies' weight acts.
        springs : mapping of str to (float, float), optional
            Of joints of one degree of freedom: stiffness in N/m or N m/rad, and the value in m or
            rad where it is at rest; of a joint that turns without end, which is the shorter way
            from there. None are read from files.

        Raises
        ------
        SingularError
            As `jacobian`; at poses where loops forbid some motor rates there is an answer still.
        NoEquilibriumError
            The load drives what idles.
        NoToolError
            A wrench on the tool, and no frame is named as one.
        UnknownNameError, ArgumentError
            No such joint, frame or tool, or values that are none.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> home = pj.load("four_bar").home
        >>> home.statics([0, -10.0, 0, 0, 0, 0]).efforts.round(3).tolist()
        [3.126]
        >>> pushed = {"rocker_tip": [9.0, 0, 0, 0, 0, 0], "coupler_tip": [-9.0, 0, 0, 0, 0, 0]}
        >>> bool(abs(home.statics(pushed).efforts).max() < 1e-12)  # where one loop holds them
        True
        """
        refuse_singular(self._loop_rates, self.problem.partition, self.singularity)
        model, name = self._parts.kinematics.model, frame_name(frame)
        loads = [self._held_springs({} if springs is None else springs)]
        if as_flag(gravity, "gravity"):
            loads.append(self._parts.kinematics.efforts(self.q, *np.zeros((2, model.nv))))
        if wrench is not None:
            if not isinstance(wrench, Mapping):
                self._need_tool()
            loads += held_wrenches(self._parts, self.q, wrench, name)
        return balanced(np.array(loads), self._loop_rates, self.problem.partition)

    def _held_springs(self, springs: Springs) -> Array:
        return spring_efforts(self._parts.coordinates, self.q, springs)

    def _motor_rates(self, given: MotorValues | None) -> Array:
        if given is None:
            return np.zeros(self.problem.partition.actuated.size)
        return motor_rates(self._parts.spec, self._parts.coordinates, given)
