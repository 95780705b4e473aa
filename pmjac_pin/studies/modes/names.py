"""Names: which of the assembly modes have the name of a pose."""

from __future__ import annotations

from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.assembled_poses import assembled_poses
from pmjac_pin.studies.modes.assembly_modes import AssemblyModes
from pmjac_pin.studies.modes.recognition import Recognition


def pose_names(mechanism: Mechanism, modes: AssemblyModes) -> tuple[tuple[str, ...], ...]:
    """Return for each mode the names of the poses that it is."""
    recognition = Recognition(modes)
    names: list[list[str]] = [[] for _ in modes]
    for name, pose in assembled_poses(mechanism).items():
        index = recognition.index(pose)
        if index is not None:
            names[index].append(name)
    return tuple(map(tuple, names))
