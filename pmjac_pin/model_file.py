"""Reading a model file: TOML to MechanismSpec, each error with the file and the key at fault."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import msgspec

from pmjac_pin.errors import ModelFileError, did_you_mean
from pmjac_pin.loop_spec import LOOP_KINDS
from pmjac_pin.parameter import Move, Parameter
from pmjac_pin.spec import MechanismSpec, Tool
from pmjac_pin.text_file import read_text

MAXIMAL_SIZE = 1 << 20  # bytes; the largest of our own model files has a few thousand

# Which table a path in one of msgspec's messages leads to: the last that fits.
_TABLES = (
    (r"", (MechanismSpec,)),
    (r"^loop\[", tuple(LOOP_KINDS.values())),
    (r"^tool", (Tool,)),
    (r"^parameters\[", (Parameter,)),
    (r"moves\[", (Move,)),
)
_WORDS = {
    "Object contains unknown field": "unknown key",
    "Object missing required field": "missing key",
    "`object": "`table",
    "| object": "| table",
    "Invalid enum value": "Invalid value",
    "$.": "",
    "`$`": "the file",
}


def read_model_file(path: Path) -> MechanismSpec:
    """Read and check a model file; without a name of its own it gets the file's stem.

    Raises
    ------
    ModelFileError
        The message starts with the file's path and names the key at fault.
    """
    text = read_text(path, MAXIMAL_SIZE)
    try:
        spec = msgspec.convert(tomllib.loads(text), MechanismSpec)
    except msgspec.ValidationError as error:
        raise ModelFileError(f"{path}: {_explained(error)}", path=str(path)) from None
    except (ValueError, RecursionError, OverflowError) as error:
        raise ModelFileError(f"{path}: not valid TOML: {error}", path=str(path)) from None
    if not spec.urdf:
        raise ModelFileError(f"{path}: missing key `urdf`", path=str(path))
    return spec if spec.name else msgspec.structs.replace(spec, name=path.stem)


def _explained(error: msgspec.ValidationError) -> str:
    """Turn msgspec's message into ours: TOML's words for things, and the near match."""
    message = str(error)
    for theirs, ours in _WORDS.items():
        message = message.replace(theirs, ours)
    if unknown := re.search(r"unknown key `([^`]*)`(?: - at `([^`]*)`)?", message):
        return message + did_you_mean(unknown[1], _keys(unknown[2] or ""))
    if kind := re.search(r"Invalid value '([^']*)' - at `loop\[\d+\]\.kind`", message):
        return message + did_you_mean(kind[1], LOOP_KINDS)
    return message


def _keys(path: str) -> list[str]:
    tables = next(tables for pattern, tables in reversed(_TABLES) if re.search(pattern, path))
    return sorted({key.encode_name for table in tables for key in msgspec.structs.fields(table)})
