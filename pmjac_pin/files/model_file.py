"""Reading a model file: TOML to MechanismSpec, each error with the file and the key at fault."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import msgspec

from pmjac_pin.errors import ModelFileError, did_you_mean, shortened
from pmjac_pin.files.bounded_toml import bounded_table, in_words_of_toml
from pmjac_pin.files.home_lines import home_line
from pmjac_pin.files.text_file import at_file, read_text
from pmjac_pin.files.user_path import readable
from pmjac_pin.model.loop_spec import LOOP_KINDS
from pmjac_pin.model.parameter import Move, Parameter
from pmjac_pin.model.spec import MechanismSpec, converted
from pmjac_pin.model.tool_spec import Tool

MAXIMAL_MODEL_FILE = 1 << 20  # bytes; the largest of our own model files has a few thousand

# Which table a path in one of msgspec's messages leads to: the last that fits.
_TABLES = (
    (r"", MechanismSpec),
    (r"^tool", Tool),
    (r"^parameters\[", Parameter),
    (r"moves\[", Move),
)


def read_model_file(path: Path) -> MechanismSpec:
    """Read and check a model file; without a name of its own it gets the file's stem.

    Raises
    ------
    ModelFileError
        The message starts with the file's path and names the key at fault.
    """
    return parse_model_file(read_text(path, MAXIMAL_MODEL_FILE), path)


def parse_model_file(text: str, path: Path) -> MechanismSpec:
    """Check a model file's text; the path is for messages, and for the name.

    Raises
    ------
    ModelFileError
        As `read_model_file`.
    """
    with at_file(str(path)):
        spec = _spec(text, path)
    return spec if spec.name else msgspec.structs.replace(spec, name=readable(path.stem))


def _spec(text: str, path: Path) -> MechanismSpec:
    given = bounded_table(text)
    try:
        spec = converted(given)
    except msgspec.ValidationError as error:
        raise ModelFileError(_model_fault(error, given, path)) from None
    except OverflowError as error:
        raise ModelFileError(f"a whole number is too large: {error}") from None
    if not spec.urdf:
        raise ModelFileError("missing key `urdf`")
    return spec


def _model_fault(error: msgspec.ValidationError, given: dict[str, Any], path: Path) -> str:
    """Turn msgspec's message into ours: TOML's words for things, and the near match."""
    message = in_words_of_toml(str(error))
    return message + (_home(message, given, path) or _hint(message, given))


def _home(message: str, given: dict[str, Any], path: Path) -> str:
    """Return what to write where there is no home pose, "" where that is not what is wrong."""
    untold, unnamed = "missing key `poses`", "`poses.home` is missing"
    if not message.startswith((untold, unnamed)) or not given.get("urdf"):
        return ""
    line = home_line(given, path)
    written = f"`{line}` under [poses]"
    if message.startswith(untold):
        written = f"`poses.{line}` above the first [table]"
    return f"; give joint values near which the loops close, m or rad: such as {written}"


def _hint(message: str, given: dict[str, Any]) -> str:
    if isinstance(frame := given.get("tool"), str) and message.endswith("at `tool`"):
        return f"; write tool.frame = {json.dumps(shortened(frame))}"
    if unknown := re.search(r"unknown key `([^`]*)`(?: - at `([^`]*)`)?", message):
        key, place = unknown[1], unknown[2] or ""
        if loop := re.fullmatch(r"loop\[(\d+)\]", place):
            return _of_another_kind(key, given["loop"][int(loop[1])]["kind"])
        return did_you_mean(key, _keys(place))
    if kind := re.search(r"Invalid value '([^']*)' - at `loop\[\d+\]\.kind`", message):
        return did_you_mean(kind[1], LOOP_KINDS)
    return ""


def _of_another_kind(key: str, kind: str) -> str:
    """Say which kinds of loop know a key that this kind does not, and what this kind knows."""
    others = [other for other, table in LOOP_KINDS.items() if key in _fields(table)]
    own = _fields(LOOP_KINDS[kind])
    if not others:
        return did_you_mean(key, own)
    known = f"{others[0]} loops" if len(others) == 1 else "other kinds of loop"
    return f": a key of {known}; this one is {kind} and has {', '.join(own)}"


def _keys(path: str) -> list[str]:
    return _fields(next(table for pattern, table in reversed(_TABLES) if re.search(pattern, path)))


def _fields(table: type) -> list[str]:
    return sorted(field.encode_name for field in msgspec.structs.fields(table))
