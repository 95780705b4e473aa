"""The keys of what the commands write as JSON, held against a list: scripts rely on them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pmjac_pin.cli import main

KEYS = json.loads((Path(__file__).parent / "json_keys.json").read_text(encoding="utf-8"))


def keys(data, place=""):
    """Return the places of what is no object and no array; all entries of an array are one."""
    if isinstance(data, dict) and data:
        return {key for name, one in data.items() for key in keys(one, f"{place}.{name}")}
    if isinstance(data, list) and data:
        return {key for one in data for key in keys(one, f"{place}[]")}
    return {place}


@pytest.mark.parametrize("command", KEYS)
def test_commands_write_the_same_keys(command, capsys):
    main([*command.split(), "--json"])
    assert sorted(keys(json.loads(capsys.readouterr().out))) == KEYS[command]
