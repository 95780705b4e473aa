"""ModesFound: closed poses that a study found, as a sequence, and what it rests on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import overload

from pmjac_pin.configuration import Configuration
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.values.shown import Shown


@dataclass(frozen=True, eq=False, repr=False)
class ModesFound(Shown, Sequence[Configuration]):
    """Closed poses of a machine, always sorted alike: a sequence of Configurations.

    Attributes
    ----------
    configurations : tuple of Configuration
    starts : int
        How many random starts were tried.
    evidence : Evidence
        What it rests on that these are all.
    """

    configurations: tuple[Configuration, ...]
    starts: int
    evidence: Evidence

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
        return f"{type(self).__name__}({len(self)} modes, {self.evidence})"
