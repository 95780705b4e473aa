"""Margins: how far a pose is from singular ones, in metres and radians, as designers measure it.

A joint's are of statics. With the motors locked (a gain) the loops hold a unit torque about a
passive joint by a force f and a moment m between its two bodies:

    arm = 1 / |f|,        angle = asin(1 / |m|),        transmission = asin(1 / (|f| r)),

the last of a link with one other joint, at r from the axis, which f passes through: the angle
there between force and link, 90° less the pressure angle. What locked joints hold together is one
link. By the same numbers play of δ metres in the joint turns it by up to δ / arm.

With the tool locked and the other motors free (a loss) they are those of a motor. A tool's are of
screws: with T the tool's twist by one motor and W the wrench on the tool that this motor alone
bears, |W ∘ T| at unit force and unit turn is a distance in m, and the sine of an angle where either
has no axis.

Ball, *A Treatise on the Theory of Screws*, 1900 (the virtual coefficient, here twice his); Wang, Wu
and Liu, *Performance evaluation of parallel manipulators: motion/force transmissibility and its
index*, Mechanism and Machine Theory 45, 2010, divide it by a largest one instead.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Literal, NamedTuple

from pmjac_pin.rates.screw import Screw
from pmjac_pin.values.ties import LIKE


class Least(NamedTuple):
    """The smallest of some margins: whose it is, and its value."""

    name: str
    value: float


@dataclass(frozen=True, slots=True)
class JointMargin:
    """At what arm and at what angles a joint is held: all three 0 where it is not.

    Attributes
    ----------
    arm : float
        m: a torque of 1 N m about the joint is held by a force of 1/arm between its bodies.
        Infinite where no force is needed, and of slides.
    angle : float
        rad, up to π/2. Of a joint that turns, between its axis and the plane across the moment
        that holds it; of a slide, between it and the plane across the force that holds it.
    transmission : float
        rad, up to π/2: the transmission angle, the smaller one where both bodies have one; NaN
        where none has: joined to several others, or held by a moment as well.
    """

    arm: float
    angle: float
    transmission: float = math.nan


@dataclass(frozen=True, slots=True, eq=False)
class ToolMargin:
    """How much of a motor's wrench does work on the twist that the motor commands.

    Attributes
    ----------
    value : float
        0 where the tool can move with this motor locked as well.
    unit : {"m", "rad"}
        m where force and turn have axes: |(p_W + p_T) cos α − d sin α| of their pitches, of the
        angle α and the distance d between them. rad, up to π/2, where either has none.
    twist : Screw
        Of the tool on the judged rows, with the other motors locked.
    wrench : Screw
        On the judged rows, that the loops bear with this motor alone locked.
    """

    value: float
    unit: Literal["m", "rad"]
    twist: Screw
    wrench: Screw


@dataclass(frozen=True, slots=True, eq=False)
class Margins:
    """The margins of a pose, none of which depends on frame, place, cut or unit of length.

    Attributes
    ----------
    gain : mapping of str to JointMargin
        Of passive joints with all motors locked, those that turn about one axis or any way or
        slide along one. A joint that is cut has none, nor has one that idles at every pose.
    loss : mapping of str to JointMargin
        Of motors, with the judged rows of the tool locked and the other motors free. None of a
        motor that moves generically then, as of redundant ones.
    tool : mapping of str to ToolMargin
        Of motors, where loops are closed and all judged rows of the tool move generically.
    """

    gain: Mapping[str, JointMargin] = field(default_factory=lambda: MappingProxyType({}))
    loss: Mapping[str, JointMargin] = field(default_factory=lambda: MappingProxyType({}))
    tool: Mapping[str, ToolMargin] = field(default_factory=lambda: MappingProxyType({}))

    @property
    def smallest_arm(self) -> Least | None:
        """The smallest in m of all that are finite, None where none is."""
        tool = ((name, one.value) for name, one in self.tool.items() if one.unit == "m")
        return _least([*tool, *((name, one.arm) for name, one in self._joints())])

    @property
    def smallest_angle(self) -> Least | None:
        """The smallest in rad, transmission angles included, None where there is none."""
        tool = ((name, one.value) for name, one in self.tool.items() if one.unit == "rad")
        angles = ((name, one.angle) for name, one in self._joints())
        transmissions = ((name, one.transmission) for name, one in self._joints())
        return _least([*tool, *angles, *transmissions])

    def _joints(self) -> list[tuple[str, JointMargin]]:
        return [*self.gain.items(), *self.loss.items()]


def _least(named: Iterable[tuple[str, float]]) -> Least | None:
    """Return the first of those that are the smallest but for rounding, None where none is."""
    known = [Least(*one) for one in named if math.isfinite(one[1])]
    least = min((one.value for one in known), default=math.inf)
    return next((Least(one.name, least) for one in known if LIKE * one.value <= least), None)
