"""Mechanisms whose programs are recorded at their first call, or never."""

from __future__ import annotations

import pmjac_pin as pj


def recorded(mechanism: pj.Mechanism) -> pj.Mechanism:
    """Let the next call record what single poses need."""
    for earned in (mechanism._recorded._pose, mechanism._recorded._path):
        earned._left = 1
    return mechanism


def unrecorded(mechanism: pj.Mechanism) -> pj.Mechanism:
    """Let no call record anything."""
    for earned in (mechanism._recorded._pose, mechanism._recorded._path):
        earned._left = 1 << 60
    return mechanism
