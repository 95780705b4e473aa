"""Table: what all tables of a model file have in common."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Annotated, Any

import msgspec
from msgspec.structs import asdict, force_setattr

from pmjac_pin.errors import ArgumentError
from pmjac_pin.values.checks import LARGEST

LONGEST_NAME = 200  # characters

Vector = tuple[float, float, float]
NonEmpty = Annotated[str, msgspec.Meta(min_length=1)]
Name = Annotated[str, msgspec.Meta(min_length=1, max_length=LONGEST_NAME)]


class TomlTable(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A TOML table: immutable, every key known, every number of a size to compute with."""

    def __post_init__(self) -> None:
        for key, value in asdict(self).items():
            _refuse_extreme(key, value)
            if isinstance(value, dict):
                force_setattr(self, key, _frozen(value))


def _frozen(value: dict[str, Any]) -> Mapping[str, Any]:
    return MappingProxyType(
        {key: _frozen(item) if isinstance(item, dict) else item for key, item in value.items()}
    )


def _numbers_within(value: Any) -> Iterator[float]:
    if isinstance(value, float):
        yield value
    elif isinstance(value, dict | tuple):
        for item in value.values() if isinstance(value, dict) else value:
            yield from _numbers_within(item)


def _refuse_extreme(key: str, value: Any) -> None:
    for number in _numbers_within(value):
        if not math.isfinite(number):
            raise ArgumentError(f"`{key}` holds {number}; a finite number is wanted")
        if abs(number) > LARGEST:
            limit = f"of magnitude {LARGEST:g} or less"
            raise ArgumentError(f"`{key}` holds {number:g}; numbers {limit} are read")
