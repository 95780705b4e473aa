"""Names: which of the mechanism's named poses a mode is."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import PmjacError
from pmjac_pin.modes.distinct import Signatures
from pmjac_pin.modes.many_poses import ManyPoses

if TYPE_CHECKING:
    from pmjac_pin.mechanism import Mechanism

_SAME_MOTORS = 1e-9  # m or rad


def pose_names(mechanism: Mechanism, modes: Sequence[Configuration]) -> tuple[tuple[str, ...], ...]:
    """Return for each mode the names of the poses with its motor values and its bodies' places."""
    names: list[list[str]] = [[] for _ in modes]
    if not modes:
        return ()
    motors = modes[0].actuated
    signatures = Signatures.of(mechanism._parts, ManyPoses(mechanism._parts.model))
    found = signatures(np.array([mode.q for mode in modes]))
    for name, pose in _assembled(mechanism):
        if np.abs(pose.actuated - motors).max(initial=0.0) <= _SAME_MOTORS:
            for index in np.flatnonzero(signatures.same(found, signatures(pose.q[None])[0])):
                names[index].append(name)
    return tuple(map(tuple, names))


def _assembled(mechanism: Mechanism) -> Iterator[tuple[str, Configuration]]:
    """Yield the named poses; other parameters may leave some that do not close."""
    for name in mechanism.poses:
        try:
            yield name, mechanism.pose(name)
        except PmjacError:
            continue
