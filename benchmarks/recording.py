"""Mechanisms whose programs are recorded at their first call, or never."""

from __future__ import annotations

import pmjac_pin as pj


def recorded(mechanism: pj.Mechanism) -> pj.Mechanism:
    """Let the next call record what single poses need."""
    known = mechanism.recorded
    for earned in (known._pose, known._path, known._slopes, known._motion):
        earned._left = 1
    return mechanism


def unrecorded(mechanism: pj.Mechanism) -> pj.Mechanism:
    """Let no call record anything."""
    known = mechanism.recorded
    for earned in (known._pose, known._path, known._slopes, known._motion):
        earned._left = 1 << 60
    return mechanism
