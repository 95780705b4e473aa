"""The rectangle of joint values that a transmission is asked for where nobody says one."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.transmissions.map_maker import transmission_map
from pmjac_pin.studies.transmissions.rectangle import Rectangle
from pmjac_pin.studies.transmissions.transmission import transmission

_POINTS = 33  # along each joint, of the map in which it is looked for
_SHARE = 0.9  # of what is found: where it ends is singular, as a rule


def widest_rectangle(
    mechanism: Mechanism, joints: Iterable[str], *, enforce_limits: bool | str = "all"
) -> dict[str, tuple[float, float]]:
    """Return joint values, about home, for which a transmission exists, as `over` of others.

    About nine tenths of the largest rectangle within all limits that a map of 33 points along each
    joint finds; angles without limits are looked at for half a turn to each side of home, slides
    for one length of the mechanism.

    Parameters
    ----------
    mechanism : Mechanism
    joints : iterable of str
    enforce_limits : bool or "all"
        As of `transmission_map`.

    Raises
    ------
    UnknownNameError, ArgumentError
        As `transmission_map`; it exists at no such rectangle.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> found = widest_rectangle(pj.load("ankle"), ["pitch", "roll"])
    >>> {name: (round(low, 1), round(high, 1)) for name, (low, high) in found.items()}
    {'pitch': (-0.5, 0.7), 'roll': (-0.4, 0.4)}
    """
    driven = transmission(mechanism, joints).by_joints
    coordinates, columns = driven.coordinates, driven.problem.partition.actuated
    reach = np.where(coordinates.rotational[columns], np.pi, driven.characteristic_length)
    home = driven.home.actuated
    lower = np.maximum(coordinates.lower[columns], home - reach)
    upper = np.minimum(coordinates.upper[columns], home + reach)
    ends = zip(lower.tolist(), upper.tolist(), strict=True)
    whole = Rectangle.of(dict(zip(driven.actuated, ends, strict=True)))
    over = dict(zip(whole.joints, zip(whole.lower, whole.upper, strict=True), strict=True))
    found = transmission_map(mechanism, over, _POINTS, enforce_limits=enforce_limits)
    return {name: _shrunk(*ends) for name, ends in found.covered().items()}


def _shrunk(lower: float, upper: float) -> tuple[float, float]:
    middle, half = 0.5 * (lower + upper), 0.5 * _SHARE * (upper - lower)
    digits = 2 - math.floor(math.log10(half))
    return round(middle - half, digits), round(middle + half, digits)
