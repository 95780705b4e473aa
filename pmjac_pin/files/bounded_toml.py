"""TOML whose reading takes no more time and memory than its length lets one expect."""

from __future__ import annotations

import re
import tomllib
from typing import Any

from pmjac_pin.errors import ModelFileError, quoted, shortened

MAXIMAL_PARTS = 16  # of a dotted key: tomllib's time grows with their square

# Comments and long strings are passed over, so that the dots in them do not count. What is not
# closed goes on to the end of the text. Nothing is tried twice: no repetition gives back.
_PART = r"""(?:[\w-]++|"(?:[^"\\\n]|\\.)*+"|'[^'\n]*+')"""
_TOKEN = re.compile(
    rf"""\#[^\n]*+
    | \"\"\"(?:[^\\]|\\.)*?(?:\"\"\"|\Z)
    | '''.*?(?:'''|\Z)
    | (?P<key>{_PART}(?:[ \t]*+\.[ \t]*+{_PART})*+)""",
    re.VERBOSE | re.DOTALL,
)


_LONGEST_MESSAGE = 400  # characters of one of msgspec's messages
_OUR_WORDS = {
    "Object contains unknown field": "unknown key",
    "Object missing required field": "missing key",
    "`object": "`table",
    "| object": "| table",
    "Invalid enum value": "Invalid value",
    "$.": "",
    "`$`": "the file",
}


def bounded_table(text: str) -> dict[str, Any]:
    """Parse TOML.

    Raises
    ------
    ModelFileError
        No TOML, a key of too many parts, or tables too deep in each other.
    """
    for token in _TOKEN.finditer(text):
        if (token["key"] or "").count(".") < MAXIMAL_PARTS:
            continue
        if (parts := len(re.findall(_PART, token["key"]))) > MAXIMAL_PARTS:
            line = text.count("\n", 0, token.start()) + 1
            at = f"{quoted(token['key'])} in line {line} has {parts} parts"
            raise ModelFileError(f"the key {at}; at most {MAXIMAL_PARTS} are read")
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ModelFileError("not valid TOML: nested too deep to be read") from None
    except (ValueError, OverflowError) as error:
        raise ModelFileError(f"not valid TOML: {shortened(str(error))}") from None


def in_words_of_toml(message: str) -> str:
    """Return one of msgspec's messages in TOML's words for things.

    Examples
    --------
    >>> in_words_of_toml("Object missing required field `frames` - at `$.loop[0]`")
    'missing key `frames` - at `loop[0]`'
    """
    for theirs, ours in _OUR_WORDS.items():
        message = message.replace(theirs, ours)
    return shortened(message, _LONGEST_MESSAGE)
