"""The equivalent Jacobian of the pose that is shown: drawn and written of one computation."""

from __future__ import annotations

import functools

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import NoJacobianError
from pmjac_pin.rates.jacobian import EquivalentJacobian


@functools.lru_cache(maxsize=1)
def equivalent(configuration: Configuration) -> tuple[EquivalentJacobian | None, str | None]:
    """Return J_eq, or why there is none; that of the last configuration is kept."""
    try:
        return configuration.jacobian(), None
    except NoJacobianError as error:
        return None, str(error)
