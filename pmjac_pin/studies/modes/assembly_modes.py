"""AssemblyModes: all closed poses found at given motor values, and what that rests on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import overload

from pmjac_pin.configuration import Configuration
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.values.shown import Shown


@dataclass(frozen=True, eq=False)
class AssemblyModes(Shown, Sequence[Configuration]):
    """The assembly modes at given motor values: a sequence of Configurations, always sorted alike.

    Attributes
    ----------
    configurations : tuple of Configuration
        By the tool's height, then by x, y and its orientation.
    shares : tuple of float
        The share of random starts that led to each.
    starts : int
        How many starts were tried.
    evidence : Evidence
        What it rests on that these are all.
    mirror_images : tuple of (int or None)
        For each mode, the index of the one that is its mirror image in the plane of the base.
    poses : tuple of tuple of Configuration
        For each mode all closed poses that are it, itself first: those where only bodies that look
        the same are turned over. Just itself when not given.
    """

    configurations: tuple[Configuration, ...]
    shares: tuple[float, ...]
    starts: int
    evidence: Evidence
    mirror_images: tuple[int | None, ...]
    poses: tuple[tuple[Configuration, ...], ...] = ()

    def __post_init__(self) -> None:
        if not self.poses:
            object.__setattr__(self, "poses", tuple((mode,) for mode in self.configurations))

    @property
    def ways(self) -> tuple[int, ...]:
        """In how many ways the bodies of each mode fit: more than one where some turn over."""
        return tuple(map(len, self.poses))

    @overload
    def __getitem__(self, index: int) -> Configuration: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[Configuration, ...]: ...
    def __getitem__(self, index: int | slice) -> Configuration | tuple[Configuration, ...]:
        return self.configurations[index]

    def __len__(self) -> int:
        return len(self.configurations)

    def __iter__(self) -> Iterator[Configuration]:
        return iter(self.configurations)

    def __repr__(self) -> str:
        return f"AssemblyModes({len(self)} modes, {self.evidence})"
