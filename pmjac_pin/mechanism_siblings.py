"""Siblings: the same machine with another tool, other motors or other parameters."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Self, TypeVar

from msgspec.structs import replace

from pmjac_pin.closing.assembly import build_parts
from pmjac_pin.errors import ArgumentError
from pmjac_pin.mechanism_value import MechanismValue
from pmjac_pin.model.pinocchio_model import checked_tool
from pmjac_pin.model.spec import MechanismSpec
from pmjac_pin.values.checks import as_names

MadeOnce = TypeVar("MadeOnce")


@dataclass(frozen=True, eq=False, repr=False)
class MechanismSiblings(MechanismValue):
    """A mechanism that makes others of itself, reading nothing again."""

    _made: dict[Hashable, Any] = field(default_factory=dict)

    def with_tool(
        self,
        tool: str | Sequence[str],
        *,
        rows: Iterable[str] | None = None,
        axes: str | None = None,
    ) -> Self:
        """Return the mechanism with another tool; no file is read again.

        What `load` would return with that tool: what depends on one, such as the ranks that its
        motions have in general, is found anew, once.

        Parameters
        ----------
        tool : str or three str
            A frame of `model`, or the three frames whose origins span the tool.
        rows, axes
            As `load` takes `tool_rows` and `tool_axes`; all rows of its twist count by default.

        Raises
        ------
        UnknownNameError
            No such frame.
        ArgumentError
            Neither one name nor three; no such rows or axes.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> bar = pj.load("four_bar").with_tool("rocker_tip", rows=["vx", "vy"])
        >>> bar.home.jacobian().Jv_eq.shape
        (3, 1)
        """
        spec = replace(self.spec, tool=checked_tool(tool)).with_tool_rows(rows, axes)
        return self._sibling(spec.tool, spec)

    def driven_by(self, joints: Iterable[str]) -> Self:
        """Return the mechanism with other joints as its motors: independent ones of its freedoms.

        J_eq, masses and forces are then in their coordinates: those of an ankle's pitch and roll,
        say, that rods drive.

        Parameters
        ----------
        joints : iterable of str
            The new motors, in the order of the columns of K and J; the others are passive.

        Raises
        ------
        UnknownNameError, ArgumentError
            No such joints, or none at all.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> bar = pj.load("four_bar")
        >>> by_rocker = bar.driven_by(["phi1"]).configuration(bar.home.q).jacobian()
        >>> crank_by_rocker = by_rocker.passive_rates[0, 0]
        >>> round(float(crank_by_rocker * bar.home.jacobian().passive_rates[0, 0]), 9)
        1.0
        """
        names = as_names(joints, "the joints that drive are a list of names")
        spec = replace(self.spec, actuated=names, passive=None)
        return self._sibling(names, spec)

    def with_parameters(self, values: Mapping[str, float] | None = None, /, **named: float) -> Self:
        """Return the mechanism with other values of its parameters, its file not read again.

        What `load` would return at these values, to the last bit, in a fraction of the time; from
        whichever mechanism it is asked for. Home is followed from the parameters' defaults to them,
        and ranks, scales and tolerance are found anew: they may be others.

        Parameters
        ----------
        values : mapping of str to float, optional
            By the names of `parameters`, m or rad.
        **named : float
            The same, where names are words. Those that are not named stay as they are here.

        Raises
        ------
        UnknownNameError
            No such parameter.
        ArgumentError
            A value outside its parameter's range.
        ModelFileError, ClosureError
            As in `load`: the home pose does not assemble with these.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> mechanism = pj.load("four_bar")
        >>> lengths = (1.0, 1.1, 1.2)
        >>> poses = [mechanism.with_parameters(l1=l1).close([1.0]) for l1 in lengths]
        >>> [round(float(pose.jacobian().Jv_eq[0, 0]), 3) for pose in poses]
        [-0.482, -0.542, -0.606]
        """
        if values is not None and not isinstance(values, Mapping):
            self.spec.parameter_values(values)  # says what is wanted
        given = {**(values or {}), **named}
        wanted = self.spec.parameter_values({**self.parameters, **given})
        if self.blueprint is None and given:
            raise ArgumentError(
                f"{self.name} was not read from a file, and so has no parameters that move it"
            )
        if self.blueprint is None or dict(wanted) == dict(self.parameters):
            return self
        return type(self)(
            self.blueprint.parts(wanted),
            notes=self.notes,
            unread=self.unread,
            blueprint=self.blueprint,
        )

    def _sibling(self, key: Hashable, spec: MechanismSpec) -> Self:
        """Return the machine as another specification has it; made once."""
        if spec == self.spec:
            return self
        return self.made_once(key, lambda: self._as_of(spec))

    def _as_of(self, spec: MechanismSpec) -> Self:
        parts = self._parts
        built = build_parts(parts.standing, spec, parts.values, parts.urdf, parts.home_q)
        blueprint = self.blueprint and self.blueprint.of(spec)
        return type(self)(built, notes=self.notes, unread=self.unread, blueprint=blueprint)

    def made_once(self, key: Hashable, make: Callable[[], MadeOnce]) -> MadeOnce:
        """Return what was made of the mechanism under a key; made now where it was not yet.

        It is kept as long as the mechanism is, so a key says nothing that there is no end of, such
        as a pose.
        """
        if key not in self._made:
            self._made[key] = make()
        kept: MadeOnce = self._made[key]
        return kept
