"""Machine: what a check looks at, whether its home pose assembles or not."""

from __future__ import annotations

from typing import TypeAlias

from pmjac_pin.closing.parts import Parts
from pmjac_pin.mechanism import Mechanism

#: A mechanism, or what `unassembled` makes of the same model and spec.
CheckedMachine: TypeAlias = Mechanism | Parts
