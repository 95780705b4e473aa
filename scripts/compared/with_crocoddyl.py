"""crocoddyl plans motions of trees in contact; it is asked for models that close loops."""

from __future__ import annotations

from collections.abc import Mapping

import crocoddyl
from compared.known import none


def answers() -> Mapping[str, str]:
    """Return what it says, by question."""
    return {
        "close": none(crocoddyl, "close"),
        "beyond": "–",
        "rate": "–",
        "singular": none(crocoddyl, "singular"),
        "modes": none(crocoddyl, "modes"),
        "mobility": none(crocoddyl, "mobility"),
        "simulate": f"no loops; {crocoddyl.ContactModel6D.__name__}",
    }
