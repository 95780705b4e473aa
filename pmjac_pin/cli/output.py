"""What a command returns, to be written once all of it is known."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Annotated, TypeAlias

from cyclopts import Parameter

from pmjac_pin.words.blocks import Block

#: Text as it is, plain data to be JSON, or blocks to be drawn.
Output: TypeAlias = str | Mapping[str, object] | Iterable[Block] | None
Json: TypeAlias = Annotated[bool, Parameter(help="Write JSON: all digits, SI units.")]


@dataclass(frozen=True, slots=True)
class Verdict:
    """An output together with the exit status."""

    output: Output
    status: int
