"""Which C compiler there is: the one that CC names, the machine's, that of PyPI."""

from __future__ import annotations

import os
import shutil
import sys
from importlib.util import find_spec

import numpy as np
import pytest
from mechanisms import loaded
from test_batch import targets
from test_tape_kernel import everything

import pmjac_pin as pj
from pmjac_pin.algebra import compiled_programs
from pmjac_pin.algebra.c_compilers import NAMES, c_compilers
from pmjac_pin.algebra.compiled_programs import CompiledProgram
from pmjac_pin.algebra.tape_runner import run
from pmjac_pin.closing.path_kernel import many_paths_kernel

PATH = os.environ["PATH"]  # as it is before a test empties it
CC = shutil.which("cc")
needs_cc = pytest.mark.skipif(CC is None or many_paths_kernel() is None, reason="no C compiler")


@pytest.fixture(autouse=True)
def commands(tmp_path, monkeypatch):
    """The folder of all commands that a machine has: none."""
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path / "commands"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    compiled_programs._running.cache_clear()
    yield tmp_path / "commands"
    compiled_programs._running.cache_clear()


@pytest.fixture
def no_ziglang(monkeypatch):
    monkeypatch.setitem(sys.modules, "ziglang", None)


def install(folder, name, *lines):
    folder.mkdir(exist_ok=True)
    place = folder / name
    place.write_text("\n".join(["#!/bin/sh", *lines, ""]))
    place.chmod(0o755)
    return str(place)


STAND_IN = """
import os, sys
from pathlib import Path
with Path(__file__).with_name("calls").open("a") as calls:
    print(*sys.argv[1:], file=calls)
if sys.argv[1] == "version":
    print(Path(__file__).with_name("version").read_text())
else:
    assert sys.argv[1] == "cc"
    os.environ["PATH"] = {path!r}
    os.execv({cc!r}, ["cc", *(one for one in sys.argv[2:] if one != "-mcpu=baseline")])
"""


@pytest.fixture
def ziglang(tmp_path, monkeypatch):
    """The folder of a stand-in, for which the machine's compiler works; its `calls` are a file."""
    folder = tmp_path / "site" / "ziglang"
    folder.mkdir(parents=True)
    (folder / "__init__.py").touch()
    (folder / "__main__.py").write_text(STAND_IN.format(path=PATH, cc=CC))
    (folder / "version").write_text("0.0.1")
    monkeypatch.syspath_prepend(str(folder.parent))
    monkeypatch.setenv("PYTHONPATH", str(folder.parent))
    return folder


def kept(tmp_path):
    return {path.name for path in (tmp_path / "cache" / "pmjac_pin").iterdir()}


def test_who_is_asked_first(commands, ziglang, monkeypatch):
    zig = (sys.executable, "-P", "-m", "ziglang", "cc")
    assert [one.command for one in c_compilers()] == [zig]
    mine = [install(commands, name) for name in reversed(NAMES)][::-1]
    assert [one.command for one in c_compilers()] == [*((path,) for path in mine), zig]
    monkeypatch.setenv("CC", "gcc -O1 '-D A'")
    assert [one.command for one in c_compilers()] == [(mine[1], "-O1", "-D A")]
    monkeypatch.setenv("CC", " ")
    assert len(c_compilers()) == 4


@pytest.mark.parametrize("given", ["no-such-compiler -O1", "unclosed 'quote"])
def test_no_other_is_taken_for_the_one_that_is_named(commands, ziglang, given, monkeypatch):
    monkeypatch.setenv("CC", given)
    with pytest.raises(pj.MissingDependencyError, match="variable CC names, is none that runs"):
        CompiledProgram.of(everything())
    assert not (ziglang / "calls").exists()


@pytest.mark.usefixtures("no_ziglang")
def test_the_error_names_all_ways_to_a_compiler(tmp_path):
    with pytest.raises(pj.MissingDependencyError) as raised:
        CompiledProgram.of(everything())
    for way in ("apt install gcc", "pip install 'pmjac_pin[compiled]'", "ziglang", "variable CC"):
        assert way in str(raised.value)
    assert not (tmp_path / "cache").exists()


@needs_cc
def test_by_ziglang_where_no_other_runs(commands, ziglang, rng):
    install(commands, "cc", "exit 1")  # as on a Mac without its tools
    tape, values = everything(), rng.normal(size=(3, 200))
    np.testing.assert_array_equal(CompiledProgram.of(tape).run(values), run(tape, values))
    calls = (ziglang / "calls").read_text().splitlines()
    assert all("-march=native" in call for call in calls if call.startswith("cc"))
    assert "version" in calls


@needs_cc
def test_another_version_of_the_compiler_is_another_file(tmp_path, ziglang):
    CompiledProgram.of(everything())
    first = kept(tmp_path)
    assert len(first) == 1
    (ziglang / "version").write_text("0.0.2")
    compiled_programs._running.cache_clear()  # as in another process
    CompiledProgram.of(everything())
    assert len(kept(tmp_path)) == 2
    (ziglang / "version").write_text("0.0.1")
    compiled_programs._running.cache_clear()
    CompiledProgram.of(everything())
    assert len(kept(tmp_path)) == 2


@needs_cc
def test_kernels_are_built_by_ziglang_for_every_processor(tmp_path, ziglang, hatch_build):
    source = tmp_path / "source.c"
    source.write_text("int answer(void) { return 42; }\n")
    assert hatch_build.build(tmp_path / "kernel.so", source) == ""
    assert (tmp_path / "kernel.so").is_file()
    (call,) = (ziglang / "calls").read_text().splitlines()
    assert call.startswith("cc ")
    assert "-mcpu=baseline" in call


@pytest.mark.usefixtures("no_ziglang")
def test_the_build_says_that_there_is_no_compiler(tmp_path, hatch_build):
    (tmp_path / "source.c").touch()
    told = hatch_build.build(tmp_path / "kernel.so", tmp_path / "source.c")
    assert "no C compiler: none is called cc, gcc, clang" in told


@pytest.mark.slow
@pytest.mark.skipif(
    find_spec("ziglang") is None or many_paths_kernel() is None, reason="ziglang is not installed"
)
def test_ziglang_itself_compiles_to_the_last_bit(rng):
    tape = everything()
    (compiler,) = c_compilers()
    assert "ziglang" in compiler.command
    for size in (1e-3, 1.0, 1e4, np.inf):
        values = size * rng.normal(size=(3, 200))
        with np.errstate(invalid="ignore"):
            np.testing.assert_array_equal(CompiledProgram.of(tape).run(values), run(tape, values))
    mechanism = loaded("five_bar")
    many, compiled = pj.batch(mechanism), pj.batch(mechanism, compiled=True)
    values = targets(mechanism, 1000, 0.1, rng)
    found, expected = (one.close(values, enforce_limits=False) for one in (compiled, many))
    for key in ("q", "share", "status"):
        np.testing.assert_array_equal(getattr(found, key), getattr(expected, key))
