"""crocoddyl plans motions of trees in contact; it is asked for models that close loops."""

from __future__ import annotations

from collections.abc import Mapping

import crocoddyl as cd
from compared.known import none


def answers() -> Mapping[str, str]:
    """Return what it says, by question."""
    return {
        "close": none(cd, "close"),
        "beyond": "–",
        "rate": "–",
        "singular": none(cd, "singular"),
        "modes": none(cd, "modes"),
        "mobility": none(cd, "mobility"),
        "simulate": f"no loops; {cd.ContactModel6D.__name__}",
    }
