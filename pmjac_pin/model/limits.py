"""Limits: the joints of a pose that are beyond theirs, and the words for it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
import pinocchio as pin

from pmjac_pin.errors import ArgumentError, LimitError
from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.model.joint_kinds import kind_of
from pmjac_pin.values.arrays import Array, Mask
from pmjac_pin.values.checks import LARGEST

#: What an error says of the switch that lets a file's poses be beyond their limits.
SWITCH = "; enforce_limits=False takes it all the same"
_FLAGS = (bool, np.bool_)
_AN_ANGLE = 3.0 * math.pi  # rad: larger ones are turns, or degrees


@dataclass(frozen=True, slots=True)
class Violation:
    """A joint beyond its limits.

    Attributes
    ----------
    value, lower, upper : float
    unit : {"m", "rad"}
    """

    value: float
    lower: float
    upper: float
    unit: str

    @classmethod
    def of(cls, coordinates: JointCoordinates, name: str, value: float) -> Violation:
        """Return that of a joint by its value."""
        [column] = coordinates.columns([name])
        unit = "rad" if coordinates.rotational[column] else "m"
        return cls(value, *coordinates.limits(name), unit)

    @property
    def words(self) -> str:
        """The value and the limits, with as many digits as tell them apart."""
        for digits in range(6, 18):
            value, lower, upper = (
                f"{number:.{digits}g}" for number in (self.value, self.lower, self.upper)
            )
            if not float(lower) <= float(value) <= float(upper):
                break
        return (
            f"{value} {self.unit} is outside its limits [{lower}, {upper}] {self.unit}{self._hint}"
        )

    @property
    def _hint(self) -> str:
        """What a number that is large for an angle would be in degrees, where that is within."""
        radians = math.radians(self.value)
        if (
            self.unit == "m"
            or abs(self.value) <= _AN_ANGLE
            or not self.lower <= radians <= self.upper
        ):
            return ""
        return f" ({self.value:g}° would be {radians:.6g} rad)"


def violations(
    coordinates: JointCoordinates, q: Array, names: Iterable[str]
) -> Mapping[str, Violation]:
    """Return those of these joints that are beyond their limits, by name.

    Joints with one degree of freedom and one entry in q have limits. Values up to 1e-9 m or rad
    beyond them count as within.
    """
    values, columns = coordinates.values(q), np.arange(coordinates.lower.size)
    outside = set(coordinates.outside(values, columns))
    found = {}
    for name in names:
        if name in outside:
            value = float(values[coordinates.columns([name])[0]])
            found[name] = Violation.of(coordinates, name, value)
    return MappingProxyType(found)


def beyond_limits(coordinates: JointCoordinates, q: Array) -> Mask:
    """Tell which of many q, (..., nq), have joints beyond their limits: any of `violations`."""
    limited = np.flatnonzero(np.isfinite(coordinates.lower) | np.isfinite(coordinates.upper))
    beyond = coordinates.beyond(coordinates.values_of(q, limited), limited)
    return np.asarray(beyond.any(axis=-1))


def limit_error(what: str, found: Mapping[str, Violation], advice: str = "") -> LimitError:
    """Build the error of joints beyond their limits; the message starts with `what`."""
    name, first = next(iter(found.items()))
    told = "; ".join(f"{other!r} = {violation.words}" for other, violation in found.items())
    return LimitError(
        f"{what}{told}{advice}",
        joint=name,
        value=first.value,
        lower=first.lower,
        upper=first.upper,
        unit=first.unit,
    )


def stated_limits(lower: Array, upper: Array) -> Array:
    """Return the rates or efforts (nv,) that a model allows both ways, infinite where it has none.

    Files without a limit write 0, or what is as good as infinite; Pinocchio writes the lower limits
    of rates without their sign.

    Examples
    --------
    >>> stated_limits(np.array([-2.0, 4.0, 0.0, -1e300]), np.array([3.0, 4.0, 0.0, 1e300])).tolist()
    [2.0, 4.0, inf, inf]
    """
    both = np.minimum(np.abs(lower), np.abs(upper))
    return np.where((both > 0.0) & (both < LARGEST), both, np.inf)


def unread_limits(model: pin.Model) -> Iterator[str]:
    """Yield what is to be said of limits in a model that nothing looks at: of several freedoms."""
    for name, joint in zip(model.names[1:], list(model.joints)[1:], strict=True):
        kind = kind_of(joint)
        if joint.nq == 1:
            continue
        slides = joint.nq if kind is None else len(kind.along)  # others are of a turn's numbers
        entries = slice(joint.idx_q, joint.idx_q + slides)
        ends = np.append(model.lowerPositionLimit[entries], model.upperPositionLimit[entries])
        if (np.abs(ends) < LARGEST).any():
            one = "joints with one degree of freedom have limits"
            yield f"the limits of joint {name!r} are left out: only {one}"


def enforced(given: object) -> str:
    """Return whose limits to enforce: those of "all" joints, of the "motors", or of "none".

    Raises
    ------
    ArgumentError
        Not True, False or "all".
    """
    if isinstance(given, _FLAGS):
        return "motors" if given else "none"
    if isinstance(given, str) and given == "all":
        return given
    wanted = "True (of the motors), False (of none) or 'all'"
    raise ArgumentError(f"enforce_limits must be {wanted}, got {given!r:.100}")
