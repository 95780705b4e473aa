"""A transmission as a C header: position, velocity and effort, both ways, without dependencies.

From the table by interpolation, then Newton's steps on the loop equations in straight-line code. A
pose that is not certain is none: its status says why, and its numbers are NaN.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np

from pmjac_pin.algebra.arrays import Numbers
from pmjac_pin.algebra.program_text import C_WORDS, c_function, function_name, in_comment
from pmjac_pin.studies.transmissions.c_table import ALGEBRA, INTERPOLATION
from pmjac_pin.studies.transmissions.c_templates import FILE_HEAD, POSES, filled
from pmjac_pin.studies.transmissions.fitted_polynomial import c_polynomial, fitted_polynomial
from pmjac_pin.studies.transmissions.newton_program import NewtonProgram
from pmjac_pin.studies.transmissions.sheet import Sheet
from pmjac_pin.studies.transmissions.transmission import Transmission
from pmjac_pin.values.arrays import Array, Index

_WIDTH = 96  # of a comment's lines
_MOST_SEEDS = 9  # along a joint
_OF_STEP = ("next", "size", "gap", "condition", "motion", "ratio")


@dataclass(frozen=True, eq=False)
class HeaderParts:
    """What a header is written of.

    Attributes
    ----------
    transmission : Transmission
    sheet : Sheet
    program : NewtonProgram
        The joints drive, the motors follow.
    alone : ndarray, shape (nq,)
        No other pose has each entry of q nearer to the sheet.
    motors : ndarray, shape (*grid, n)
        At the points of the sheet.
    """

    transmission: Transmission
    sheet: Sheet
    program: NewtonProgram
    alone: Array
    motors: Array

    @property
    def joint_columns(self) -> Index:
        """Columns of v."""
        return self.program.rates.partition.actuated

    @property
    def kept(self) -> Index:
        """Entries of q that the table holds: those that the joints do not say themselves."""
        coordinates = self.program.mechanism.coordinates
        own = [
            entry + k
            for column, entry in _entries(self, self.joint_columns)
            for k in range(1 + int(coordinates.wraps[column]))
        ]
        return np.setdiff1d(np.arange(self.sheet.data.shape[-1]), own)


def c_header(parts: HeaderParts, name: str | None, head: Iterable[str]) -> str:
    """Return the text of a header.

    Parameters
    ----------
    parts : HeaderParts
    name : str, optional
        What its names begin with; by default the mechanism's.
    head : iterable of str
        Lines of the comment above.

    Raises
    ------
    ArgumentError
        A name that C does not allow.
    """
    mechanism = parts.transmission.by_motors
    called = function_name(mechanism.name if name is None else name, C_WORDS, name is None)
    words = {"NAME": called.upper(), "name": called, **_numbers(parts), **_snippets(parts)}
    lines = [part for line in head for part in textwrap.wrap(in_comment(line), _WIDTH)]
    comment = "\n".join(["/*", *(f" * {line}" for line in lines)])
    sections = [
        comment,
        filled(FILE_HEAD, words),
        *_arrays(parts, called),
        filled(INTERPOLATION[len(parts.sheet.axes)], words),
        *_programs(parts.program, called),
        filled(ALGEBRA[len(parts.sheet.axes)], words),
        filled(POSES, words),
    ]
    return "\n".join(sections)


def _programs(program: NewtonProgram, name: str) -> Iterator[str]:
    """Yield Newton's steps at held joints and to wanted motors: the step, or rates as well."""
    for way, known in (("joints", program.step), ("motors", program.aimed)):
        for what, keys in (("near", _OF_STEP[:2]), ("step", _OF_STEP)):
            outputs = {key: known[key] for key in keys}
            declared = f"static inline void {name}_{what}_{way}"
            yield c_function(declared, program.recording, outputs)


def _numbers(parts: HeaderParts) -> dict[str, str]:
    """Return sizes and tolerances."""
    partition, transmission = parts.program.rates.partition, parts.transmission
    scale = partition.column_scale
    bare = np.outer(1.0 / scale[parts.program.followers], scale[parts.joint_columns])
    counts = {
        "n": len(transmission.joints),
        "nn": len(transmission.joints) ** 2,
        "nq": parts.sheet.data.shape[-1],
        "inputs": len(parts.program.recording.inputs),
        "seeds": len(_seeds(parts)),
    }
    sizes = {f"points{k}": str(axis.size) for k, axis in enumerate(parts.sheet.axes)}
    return {
        **{key: str(count) for key, count in counts.items()},
        **sizes,
        "steepest": _double(_steepest(parts.sheet)),
        "gap": _double(transmission.by_motors.problem.tolerance),
        "tolerance": _double(partition.rank_tolerance),
        "bare": ", ".join(map(_double, bare.ravel().tolist())),
    }


def _steepest(sheet: Sheet) -> float:
    """Return twice the largest slope of an entry at a point, summed over joints."""
    n = len(sheet.axes)
    flat = np.abs(sheet.data.reshape(-1, 2**n, sheet.data.shape[-1]))
    slopes: Array = flat[:, 1 : n + 1].sum(axis=1)
    return 2.0 * float(slopes.max())


def _snippets(parts: HeaderParts) -> dict[str, str]:
    """Return statements that go from values of joints to entries of q and back."""
    motors = _entries(parts, parts.program.followers)
    joints = _entries(parts, parts.joint_columns)
    wraps = parts.program.mechanism.coordinates.wraps
    return {
        "joints_to_q": _lines(_written(joints, wraps, "x")),
        "motors_to_q": _lines(_written(motors, wraps, "theta")),
        "q_to_joints": _lines(_read(joints, wraps, "x")),
        "q_to_now": _lines(_read(motors, wraps, "now")),
        "q_to_motors": _lines(_read(motors, wraps, "theta")),
        **_sums(parts),
        "guess": _lines(_guess(parts)),
        "apart": _lines(
            f"apart[{k}] = {_difference(f'theta[{k}]', f'now[{k}]', bool(wraps[column]))};"
            for k, (column, _) in enumerate(motors)
        ),
    }


def _sums(parts: HeaderParts) -> dict[str, str]:
    """Return the statements that sum up an interpolation, in straight-line code."""
    kept = parts.kept
    if len(parts.sheet.axes) == 1:
        terms = [("one[{0}]", place) for place in range(4)]
        places = [("near", "far")[place // 2] for place in range(4)]
        offsets = [place % 2 for place in range(4)]
        weights = [text.format(place) for text, place in terms]
        declared: list[str] = []
    else:
        pairs = list(product(range(4), repeat=2))
        places = [f"d{2 * (a // 2) + b // 2}" for a, b in pairs]
        offsets = [2 * (a % 2) + b % 2 for a, b in pairs]
        weights = [f"w{a}{b}" for a, b in pairs]
        declared = [f"const double w{a}{b} = one[{a}] * other[{b}];" for a, b in pairs]
    sums = (
        f"q[{entry}] = "
        + " + ".join(
            f"{weight} * {place}[{offset * kept.size + k}]"
            for weight, place, offset in zip(weights, places, offsets, strict=True)
        )
        + ";"
        for k, entry in enumerate(kept.tolist())
    )
    return {"weights": _lines(declared), "sums": _lines(sums)}


def _guess(parts: HeaderParts) -> Iterator[str]:
    """Yield statements of a polynomial from motor to joint values, fitted to the points."""
    n, wraps = len(parts.sheet.axes), parts.program.mechanism.coordinates.wraps
    motors = parts.motors.reshape(-1, n)
    joints = np.stack(np.meshgrid(*parts.sheet.axes, indexing="ij"), axis=-1).reshape(-1, n)
    middle = 0.5 * (motors.min(axis=0) + motors.max(axis=0))
    half = 0.5 * np.ptp(motors, axis=0)
    exponents, coefficients = fitted_polynomial((motors - middle) / half, joints)
    for k, column in enumerate(parts.program.followers.tolist()):
        away = _difference(f"theta[{k}]", _double(middle[k]), bool(wraps[column]))
        yield f"const double u{k} = ({away}) * {_double(1.0 / half[k])};"
        yield f"(void)u{k}; /* of a constant no compiler warns */"
    for j in range(n):
        known = {tuple(e): c for e, c in zip(exponents, coefficients[:, j].tolist(), strict=True)}
        yield f"x[{j}] = {c_polynomial(known, n)};"


def _written(entries: Iterable[tuple[int, int]], wraps: Numbers, values: str) -> Iterator[str]:
    for k, (column, entry) in enumerate(entries):
        if wraps[column]:
            yield f"q[{entry}] = cos({values}[{k}]);"
            yield f"q[{entry + 1}] = sin({values}[{k}]);"
        else:
            yield f"q[{entry}] = {values}[{k}];"


def _read(entries: Iterable[tuple[int, int]], wraps: Numbers, values: str) -> Iterator[str]:
    for k, (column, entry) in enumerate(entries):
        whole = f"atan2(q[{entry + 1}], q[{entry}])" if wraps[column] else f"q[{entry}]"
        yield f"{values}[{k}] = {whole};"


def _difference(one: str, other: str, wraps: bool) -> str:
    return f"remainder({one} - {other}, {_double(2.0 * np.pi)})" if wraps else f"{one} - {other}"


def _lines(statements: Iterable[str]) -> str:
    return "\n    ".join(statements)


def _entries(parts: HeaderParts, columns: Index) -> list[tuple[int, int]]:
    """Return columns of v and where q holds their values."""
    entry = parts.program.mechanism.coordinates.entry
    return [(column, entry(column)) for column in columns.tolist()]


def _arrays(parts: HeaderParts, name: str) -> Iterator[str]:
    """Yield the numbers of the table."""
    kept, n = parts.kept, len(parts.sheet.axes)
    for k, axis in enumerate(parts.sheet.axes):
        yield _array(f"{name}_axis{k}[{axis.size}]", axis)
    data = parts.sheet.data[..., kept].reshape(-1, 2**n * kept.size)
    yield _array(f"{name}_data[{data.shape[0]}][{data.shape[1]}]", data)
    seeds = _seeds(parts)
    yield _array(f"{name}_seeds[{len(seeds)}][{seeds.shape[1]}]", seeds)
    yield _array(f"{name}_alone[{parts.alone.size}]", parts.alone)


def _seeds(parts: HeaderParts) -> Array:
    """Return motor and joint values of some points, from which inverses are looked for."""
    chosen = [
        np.unique(np.linspace(0, axis.size - 1, min(axis.size, _MOST_SEEDS)).round().astype(int))
        for axis in parts.sheet.axes
    ]
    joints = np.meshgrid(
        *(axis[c] for axis, c in zip(parts.sheet.axes, chosen, strict=True)), indexing="ij"
    )
    both = np.concatenate([parts.motors[np.ix_(*chosen)], np.stack(joints, axis=-1)], axis=-1)
    return both.reshape(-1, both.shape[-1])


def _array(declared: str, numbers: Array) -> str:
    if numbers.ndim == 1:
        return f"static const double {declared} = {_braced(numbers)};\n"
    rows = ",\n".join(f"    {_braced(row)}" for row in numbers)
    return f"static const double {declared} = {{\n{rows}}};\n"


def _braced(row: Array) -> str:
    return "{" + ", ".join(map(_double, row.tolist())) + "}"


def _double(number: float) -> str:
    return repr(float(number) + 0.0)
