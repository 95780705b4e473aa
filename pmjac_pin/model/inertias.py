"""Which bodies of a model have no mass."""

from __future__ import annotations

import pinocchio as pin


def massless(model: pin.Model) -> tuple[str, ...]:
    """Return the joints whose bodies have no mass.

    Examples
    --------
    >>> massless(pin.buildSampleModelManipulator())
    ()
    """
    pairs = zip(list(model.names)[1:], list(model.inertias)[1:], strict=True)
    return tuple(name for name, inertia in pairs if not inertia.mass > 0.0)
