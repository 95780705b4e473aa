"""Names: which of the assembly modes a pose is, and which of them have the name of one."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import PmjacError
from pmjac_pin.modes.assembly_modes import AssemblyModes
from pmjac_pin.modes.distinct import Signatures
from pmjac_pin.modes.many_poses import ManyPoses

if TYPE_CHECKING:
    from pmjac_pin.mechanism import Mechanism

SAME_MOTORS = 1e-9
"""Motor values nearer than this, in m or rad, are the same."""


class Recognition:
    """Knows the assembly modes at given motor values by the places of their bodies."""

    def __init__(self, mechanism: Mechanism, modes: AssemblyModes) -> None:
        self._motors = [mode.actuated for mode in modes]
        self._signatures = Signatures.of(mechanism._parts, ManyPoses(mechanism._parts.model))
        q = np.array([mode.q for mode in modes]).reshape(-1, mechanism.nq)
        self._known = self._signatures(q)

    def index(self, configuration: Configuration) -> int | None:
        """Return which of the modes this is, None where it is none of them."""
        if not self._motors:
            return None
        apart = np.abs(configuration.actuated - self._motors[0]).max(initial=0.0)
        if apart > SAME_MOTORS:
            return None
        mine = self._signatures(configuration.q[None])[0]
        same = np.flatnonzero(self._signatures.same(self._known, mine))
        return int(same[0]) if same.size else None


def pose_names(mechanism: Mechanism, modes: AssemblyModes) -> tuple[tuple[str, ...], ...]:
    """Return for each mode the names of the poses that it is."""
    recognition = Recognition(mechanism, modes)
    names: list[list[str]] = [[] for _ in modes]
    for name, pose in _assembled_poses(mechanism):
        index = recognition.index(pose)
        if index is not None:
            names[index].append(name)
    return tuple(map(tuple, names))


def _assembled_poses(mechanism: Mechanism) -> Iterator[tuple[str, Configuration]]:
    """Yield the named poses; other parameters may leave some that do not close."""
    for name in mechanism.poses:
        try:
            yield name, mechanism.pose(name)
        except PmjacError:
            continue
