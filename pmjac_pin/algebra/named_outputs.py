"""Outputs of a program by their names, as arrays."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pmjac_pin.algebra.arrays import Numbers
from pmjac_pin.algebra.tape import Tape
from pmjac_pin.algebra.tape_runner import run
from pmjac_pin.algebra.terms import Recording
from pmjac_pin.values.arrays import Array


def named_outputs(
    recording: Recording, outputs: Mapping[str, Numbers], rows: Array
) -> dict[str, Array]:
    """Return recorded arrays as (b, *shape), at rows of inputs (b, inputs)."""
    terms = [term for array in outputs.values() for term in array.ravel()]
    values = run(Tape.of(recording, terms), rows.T).T
    ends = np.cumsum([array.size for array in outputs.values()])
    parts = np.split(values, ends[:-1], axis=1)
    return {
        name: part.reshape(len(rows), *array.shape)
        for (name, array), part in zip(outputs.items(), parts, strict=True)
    }
