"""A mechanism's equations as a program of its own: straight-line text to take away."""

from __future__ import annotations

import keyword
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from pmjac_pin.algebra.arrays import Numbers
from pmjac_pin.algebra.named_outputs import named_outputs
from pmjac_pin.algebra.program_text import C_WORDS, c_text, function_name, python_text
from pmjac_pin.algebra.terms import Recording, Term
from pmjac_pin.closing.recorded_rates import RecordedRates
from pmjac_pin.errors import ArgumentError, quoted, unknown_name
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.coordinates import entry_names
from pmjac_pin.model.reference_frame import frame_name
from pmjac_pin.model.twist_frame import FrameName
from pmjac_pin.model.unit_turns import UnitRows
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import as_names, as_numbers, check_kind


def program(
    mechanism: Mechanism,
    frame: str | pin.ReferenceFrame = "LOCAL_WORLD_ALIGNED",
    parameters: Iterable[str] = (),
) -> Program:
    """Record η, K, K* and J_eq = J − J* K*⁻¹ K as functions of q, and of parameters.

    Parameters
    ----------
    mechanism : Mechanism
    frame : {"LOCAL_WORLD_ALIGNED", "LOCAL", "WORLD"} or pin.ReferenceFrame
        Of J_eq.
    parameters : iterable of str
        Of the mechanism: a second argument. Those that are not named are numbers of the program.

    Raises
    ------
    NoJacobianError
        There is no J_eq at home: what is recorded takes the same steps at every pose, and which
        these are is chosen there.
    ArgumentError
        No such frame; a joint that is not in the table of joints; no names of parameters, or some
        that change loops otherwise than placements and the lengths of rods.
    UnknownNameError
        No such parameter.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> five_bar = pj.load("five_bar")
    >>> recorded = pj.program(five_bar)
    >>> recorded.inputs
    ('theta1', 'phi1', 'theta2', 'phi2')
    >>> text = recorded.c()
    >>> print(text[text.index("void") : text.index("{") + 1])
    void five_bar(
        const double q[4],
        double eta[3],
        double K[6],
        double K_star[6],
        double J_eq[12],
        double sigma[1])
    {
    >>> recorded(five_bar.home.q)["J_eq"].shape
    (6, 2)

    Of all designs at once:

    >>> designs = pj.program(five_bar, parameters=["l1", "l2"])
    >>> longer = five_bar.with_parameters(l1=1.1)
    >>> found = designs(longer.home.q, [longer.parameters[name] for name in designs.parameters])
    >>> bool(abs(found["J_eq"] - longer.home.jacobian().J_eq).max() < 1e-12)
    True
    """
    check_kind(mechanism, Mechanism)
    name, names = frame_name(frame), _parameter_names(mechanism, parameters)
    mechanism.home.jacobian()
    recording = Recording(mechanism.nq + len(names))
    rates = _recorded_rates(
        mechanism, dict(zip(names, recording.inputs[mechanism.nq :], strict=True))
    )
    kinematics = rates.recorder.at(recording.inputs[: mechanism.nq])
    (eta, by_v), found = kinematics.in_world(), rates.equivalent(kinematics, name)
    partition = rates.partition
    outputs = {
        "eta": eta,
        "K": by_v[:, partition.actuated],
        "K_star": by_v[:, partition.passive],
        "J_eq": found.J_eq,
    }
    if partition.passive_rank:
        outputs["sigma"] = np.array([1.0 / found.inverse], dtype=object)
    for doubt, number in (("forbidden", found.forbidden), ("felt", found.felt)):
        if isinstance(number, Term):  # else 0 at every pose
            outputs[doubt] = np.array([number], dtype=object)
    return Program(mechanism, name, recording, MappingProxyType(outputs), names)


def _parameter_names(mechanism: Mechanism, given: Iterable[str]) -> tuple[str, ...]:
    names = tuple(as_names(given, "`parameters` are a list of names"))
    known = tuple(mechanism.parameters)
    for name in names:
        if name not in known:
            raise unknown_name("parameter", name, known)
    if len(set(names)) < len(names):
        raise ArgumentError(f"`parameters` names one twice: {quoted(names)}")
    return names


def _recorded_rates(mechanism: Mechanism, values: Mapping[str, Term]) -> RecordedRates:
    if not values or mechanism.blueprint is None:
        return mechanism.recorded.rates
    return mechanism.recorded.rates_at(mechanism.blueprint, values)


@dataclass(frozen=True, eq=False, repr=False)
class Program:
    """The equations of a mechanism, recorded.

    Straight-line: nothing is decided at a pose. So whether J_eq exists there is for the caller
    to ask: the loops have to be closed (η = 0), `sigma` has to be larger than 1e-6 or so, and
    `forbidden` and `felt`, where there are any, have to be 0 but for rounding.

    Attributes
    ----------
    mechanism : Mechanism
    frame : str
        Of J_eq.
    recording : Recording
    outputs : mapping of str to ndarray
        Recorded numbers, in SI units: `eta` (p,), `K` (p, n) and `K_star` (p, m_p) on all rows,
        world axes as in `configuration.residual`, the latter two where η = 0; `J_eq` (6, n),
        linear rows first; `sigma` (1,), at most the smallest singular value of K* without
        dimension, and 0 where K* is singular; an open chain has none. Where rows are
        redundant, `forbidden` (1,): what K* cannot follow of K; where motions idle, `felt` (1,):
        what they do to the tool. Without dimension by the scales of `mechanism`, whatever the
        parameters are.
    parameters : tuple of str
        The entries of the second argument, where there is one.
    """

    mechanism: Mechanism
    frame: FrameName
    recording: Recording
    outputs: Mapping[str, Numbers]
    parameters: tuple[str, ...] = ()

    @property
    def inputs(self) -> tuple[str, ...]:
        """The entries of q, by their joints."""
        return entry_names(self.mechanism.model)

    @property
    def arguments(self) -> dict[str, int]:
        """How many entries each argument has: `q`, and `parameters` where there are any."""
        more = {"parameters": len(self.parameters)} if self.parameters else {}
        return {"q": self.mechanism.nq, **more}

    @property
    def own_parameters(self) -> list[float]:
        """The values that `parameters` have in the mechanism, m or rad."""
        return [self.mechanism.parameters[name] for name in self.parameters]

    def __call__(self, q: ArrayLike, parameters: ArrayLike | None = None) -> dict[str, Array]:
        """Return what the program computes.

        Parameters
        ----------
        q : array_like, shape (..., nq)
        parameters : array_like, shape (..., k), optional
            Values of `parameters`, m or rad, one design or one for each pose; those of `mechanism`
            when None.

        Returns
        -------
        dict of str to ndarray
            By the names of `outputs`, of shapes (..., *shape).

        Raises
        ------
        ArgumentError
            Other shapes.
        """
        if parameters is None:
            parameters = self.own_parameters
        poses = _checked_rows("q", q, self.mechanism.nq)
        designs = _checked_rows("parameters", parameters, len(self.parameters))
        try:
            leading = np.broadcast_shapes(poses.shape[:-1], designs.shape[:-1])
        except ValueError:
            told = f"q {poses.shape} and parameters {designs.shape}"
            raise ArgumentError(f"as many designs as poses expected, or one; got {told}") from None
        model, count = self.mechanism.kinematics.model, math.prod(leading)
        poses, designs = (
            np.broadcast_to(one, (*leading, one.shape[-1])).reshape(count, one.shape[-1])
            for one in (poses, designs)
        )
        rows = np.hstack([UnitRows(model).of(poses), designs])
        found = named_outputs(self.recording, self.outputs, rows)
        return {name: x.reshape(*leading, *x.shape[1:]) for name, x in found.items()}

    def c(self, name: str | None = None) -> str:
        """Return a function in C99: ``void name(const double q[nq], double eta[p], ...)``.

        Matrices are written row by row. Where there are parameters, ``const double parameters[k]``
        is the second argument.

        Parameters
        ----------
        name : str, optional
            Of the function; by default the mechanism's.

        Raises
        ------
        ArgumentError
            A name that C does not allow.
        """
        called, outputs = self._named(name, C_WORDS), self.outputs
        return c_text(called, self.recording, outputs, self._head(), self.arguments)

    def numpy(self, name: str | None = None) -> str:
        """Return a Python function on NumPy: q (..., nq) ↦ dict of arrays (..., *shape).

        Where there are parameters, (..., k), they are its second argument.
        """
        return self._python(name, "numpy")

    def jax(self, name: str | None = None) -> str:
        """Return the same on JAX, to be compiled, mapped and differentiated there.

        In double precision where ``jax.config.update("jax_enable_x64", True)`` was called.
        """
        return self._python(name, "jax.numpy")

    def __repr__(self) -> str:
        shapes = ", ".join(f"{name} {array.shape}" for name, array in self.outputs.items())
        given = ", ".join(f"{name} ({count},)" for name, count in self.arguments.items())
        return f"Program({self.mechanism.name}: {given} -> {shapes})"

    def _python(self, name: str | None, numpy: str) -> str:
        called = self._named(name, frozenset(keyword.kwlist))
        arguments, outputs = self.arguments, self.outputs
        return python_text(
            called, self.recording, outputs, self._head(), numpy, arguments=arguments
        )

    def _named(self, name: str | None, taken: frozenset[str]) -> str:
        """Return the name of the function."""
        return function_name(self.mechanism.name if name is None else name, taken, name is None)

    def _head(self) -> Iterable[str]:
        motors = ", ".join(self.mechanism.actuated)
        yield f"{self.mechanism.name}: eta, K, K_star, J_eq (frame {self.frame}) and sigma."
        yield f"q: {', '.join(self.inputs)}"
        if self.parameters:
            yield f"parameters: {', '.join(self.parameters)}"
        yield f"Motors, the columns of K and J_eq: {motors}"
        yield f"The columns of K_star: {', '.join(self.mechanism.passive) or 'none'}"
        yield f"Rows of eta, K and K_star: {', '.join(self.mechanism.rows) or 'none'}"
        yield "Units are m and rad; matrices are row by row."
        yield "J_eq exists where eta = 0 and sigma > 0: no more than the smallest singular value"
        yield "of K_star without dimension; and where forbidden and felt are 0, if there are any."


def _checked_rows(name: str, given: ArrayLike, count: int) -> Array:
    rows = as_numbers(given, name)
    if not rows.ndim or rows.shape[-1] != count:
        raise ArgumentError(f"{name} of shape (..., {count}) expected, got {rows.shape}")
    return rows
