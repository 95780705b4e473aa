"""Motors: what a slider has to know of each of them."""

from __future__ import annotations

import math

from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.joint_kinds import pitch_of
from pmjac_pin.viewer.messages import Slider

#: A motor without limits takes no value beyond this, m or rad.
WIDEST_SLIDER = 1e4
_ENDLESS = 1e12  # no machine has such a limit


def motors_of(mechanism: Mechanism) -> tuple[Slider, ...]:
    """Return the motors of one degree of freedom, in their order.

    One without limits gets a slider of a sensible range.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> motors_of(pj.load("three_rps"))[0]
    Slider(name='l1', unit='m', lower=0.1, upper=3.0, limited=True, meaning='')
    """
    model = mechanism.model
    motors = []
    for name, home in zip(mechanism.actuated, mechanism.home.actuated.tolist(), strict=True):
        if name not in mechanism.coordinates.names:
            continue  # of a joint of several degrees of freedom: no slider
        unit, (lower, upper) = mechanism.units[name], mechanism.limits(name)
        joint = model.joints[model.getJointId(name)]
        pitch = abs(pitch_of(joint))
        if joint.nq == 2:  # cosine and sine: it turns endlessly
            reach, middle = math.pi, 0.0
        elif unit == "rad" and not pitch:
            reach, middle = 2.0 * math.pi, 0.0
        else:
            slide, middle = 2.0 * mechanism.characteristic_length, home
            reach = min(slide / (pitch or 1.0), 0.5 * WIDEST_SLIDER)
        limited = max(-lower, upper) < _ENDLESS
        low = lower if lower > -_ENDLESS else middle - reach
        high = upper if upper < _ENDLESS else middle + reach
        motors.append(Slider(name, unit, low, max(high, low), limited))
    return tuple(motors)
