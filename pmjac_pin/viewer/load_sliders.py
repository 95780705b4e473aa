"""How far the sliders of a load go."""

from __future__ import annotations

import math

import numpy as np

from pmjac_pin.errors import PmjacError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.rates.motor_limits import stated_effort_limits
from pmjac_pin.values.arrays import Array
from pmjac_pin.viewer.load import DOWN, LARGEST_LOAD, gravity_of
from pmjac_pin.viewer.messages import Slider

_SLIDERS_BEYOND = (
    1.5  # times what brings the first motor to its limit at home: as far as sliders go
)
_USUAL = 100.0  # kg or N, where no motor has a limit


def load_sliders(mechanism: Mechanism) -> tuple[Slider, ...]:
    """Return the sliders of mass, size, azimuth and elevation.

    They go as far as the motors hold at home, and half as far again.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> [slider.upper for slider in load_sliders(pj.load("three_rps"))][:2]
    [50.0, 500.0]
    """
    gravity = gravity_of(mechanism)
    pull = float(np.linalg.norm(gravity))
    heaviest = _strongest(mechanism, gravity / pull) / pull if pull else math.inf
    strongest = min(_strongest(mechanism, way) for way in np.eye(3))
    return (
        Slider("mass", "kg", 0.0, _slider_end(heaviest), False, "hung at the tool"),
        Slider("size", "N", 0.0, _slider_end(strongest), False, "of the force"),
        Slider("azimuth", "rad", -math.pi, math.pi, True, "from the world's x towards its y"),
        Slider("elevation", "rad", DOWN, -DOWN, True, "from the world's x-y plane towards its z"),
    )


def _strongest(mechanism: Mechanism, way: Array) -> float:
    """Return the force along a direction, N, that is beyond what the motors hold at home.

    It is infinite where no motor feels it, or none has a limit.
    """
    try:
        found = mechanism.home.statics([*way, 0.0, 0.0, 0.0], gravity=False).efforts
    except PmjacError:
        return math.inf
    share = float(
        np.abs(found / stated_effort_limits(mechanism.problem.partition)).max(initial=0.0)
    )
    return _SLIDERS_BEYOND / share if share > 1.0 / LARGEST_LOAD else math.inf


def _slider_end(load: float) -> float:
    return _next_round(load if load < LARGEST_LOAD else _USUAL)


def _next_round(value: float) -> float:
    """Return the next of 1, 2, 5, 10, ..."""
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in (1.0, 2.0, 5.0, 10.0) if step * power >= 0.999 * value)
