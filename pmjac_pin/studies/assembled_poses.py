"""The named poses of a mechanism that do close."""

from __future__ import annotations

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import PmjacError
from pmjac_pin.mechanism import Mechanism


def assembled_poses(mechanism: Mechanism) -> dict[str, Configuration]:
    """Return the named poses by their names; other parameters may leave some that do not close.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> list(assembled_poses(pj.load("four_bar")))
    ['home']
    """
    poses = {}
    for name in mechanism.poses:
        try:
            poses[name] = mechanism.pose(name)
        except PmjacError:
            continue
    return poses
