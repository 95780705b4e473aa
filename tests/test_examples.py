"""The scripts in examples run as a user runs them, and say what they found without a warning."""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = sorted((Path(__file__).parent.parent / "examples").glob("*.py"))


@pytest.mark.slow
@pytest.mark.parametrize("script", EXAMPLES, ids=lambda script: script.stem)
def test_an_example_runs(script, tmp_path):
    environment = {**os.environ, "MPLBACKEND": "Agg", "PYTHONIOENCODING": "utf-8"}
    command = [sys.executable, "-W", "error", script]
    done = subprocess.run(
        command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert not done.stderr
    assert done.stdout.count("\n") >= 3
    assert not re.search(r"\b(nan|inf|None|Traceback|Warning)\b|-0\.0*\b(?![0-9.])", done.stdout)
    assert not list(tmp_path.iterdir())  # what it writes, it writes elsewhere, and removes


@pytest.mark.parametrize("script", EXAMPLES, ids=lambda script: script.stem)
def test_an_example_reads_as_a_page(script):
    text = script.read_text(encoding="utf-8")
    title, rule, blank, *_ = (ast.get_docstring(ast.parse(text)) or "").splitlines()
    assert set(rule) == {"="}
    assert len(rule) >= len(title)
    assert not blank
    assert "# %%\n" in text
    assert "assert " in text
