"""AssemblyModes: all closed poses found at given motor values, and what that rests on."""

from __future__ import annotations

from dataclasses import dataclass

from pmjac_pin.configuration import Configuration
from pmjac_pin.studies.modes.modes_found import ModesFound


@dataclass(frozen=True, eq=False, repr=False)
class AssemblyModes(ModesFound):
    """The assembly modes at given motor values: a sequence of Configurations, always sorted alike.

    Attributes
    ----------
    configurations : tuple of Configuration
        By the tool's height, then by x, y and its orientation.
    starts : int
        How many random starts were tried.
    evidence : Evidence
        What it rests on that these are all.
    shares : tuple of float
        The share of random starts that led to each.
    mirror_images : tuple of (int or None)
        For each mode, the index of the one that is its mirror image in the plane of the base.
    poses : tuple of tuple of Configuration
        For each mode all closed poses that are it, itself first: those where only bodies that look
        the same are turned over. Just itself when not given.
    """

    shares: tuple[float, ...]
    mirror_images: tuple[int | None, ...]
    poses: tuple[tuple[Configuration, ...], ...] = ()

    def __post_init__(self) -> None:
        if not self.poses:
            object.__setattr__(self, "poses", tuple((mode,) for mode in self.configurations))

    @property
    def ways(self) -> tuple[int, ...]:
        """In how many ways the bodies of each mode fit: more than one where some turn over."""
        return tuple(map(len, self.poses))
