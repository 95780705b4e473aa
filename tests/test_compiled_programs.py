"""Programs that the machine's C compiler compiled: the same numbers, from a cache that is safe."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from humanoid import humanoid
from mechanisms import CATALOGUE, loaded, mostly_slow
from test_batch import targets
from test_tape_kernel import everything

import pmjac_pin as pj
from pmjac_pin.algebra import compiled_programs
from pmjac_pin.algebra.compiled_programs import CompiledProgram, CompiledPrograms
from pmjac_pin.algebra.compiled_text import compiled_text
from pmjac_pin.algebra.tape_runner import run, tape_kernel
from pmjac_pin.closing.path_kernel import many_paths_kernel

pytestmark = pytest.mark.skipif(
    shutil.which("cc") is None or many_paths_kernel() is None, reason="no C compiler"
)


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "pmjac_pin"


def numbers(count, rng, size=1.0):
    return size * rng.normal(size=(3, count))


@pytest.mark.parametrize("count", [0, 1, 63, 64, 65, 1000])
def test_every_instruction_to_the_last_bit(cache, count, rng):
    assert tape_kernel() is not None
    tape = everything()
    program = CompiledProgram.of(tape)
    for size in (1e-3, 1.0, 1e4, 1e7, np.inf, np.nan):
        values = numbers(count, rng, size)
        values[:, 1::3] = numbers(len(values[0, 1::3]), rng)  # beside them, others
        with np.errstate(invalid="ignore"):
            np.testing.assert_array_equal(program.run(values), run(tape, values))


def cases():
    for name in [*CATALOGUE, "humanoid"]:
        yield pytest.param(name, marks=[] if name == "four_bar" else [pytest.mark.slow])


@pytest.mark.parametrize("name", list(cases()))
def test_many_poses_to_the_last_bit(cache, name, rng):
    """Short paths and long ones, with what is told of each pose."""
    mechanism = humanoid() if name == "humanoid" else loaded(name)
    many, compiled = pj.batch(mechanism), pj.batch(mechanism, compiled=True)
    assert (many.runs_on, compiled.runs_on) == ("kernel", "compiled programs")
    for count, share in ((150, 0.03), (8, 0.3)):
        values = targets(mechanism, count, share, rng)
        found, expected = (one.close(values, enforce_limits=False) for one in (compiled, many))
        for key in ("q", "share", "status"):
            np.testing.assert_array_equal(getattr(found, key), getattr(expected, key))
        assert (expected.share > 0.0).any()
        for told, known in (
            (compiled.jacobian(expected.q, "LOCAL"), many.jacobian(expected.q, "LOCAL")),
            (compiled.measures(expected.q), many.measures(expected.q)),
        ):
            for key, array in vars(known).items():
                np.testing.assert_array_equal(getattr(told, key), array)


def test_threads_change_no_bit_of_compiled_programs(cache, rng):
    mechanism = loaded("four_bar")
    many = pj.batch(mechanism, compiled=True)
    values = targets(mechanism, 9000, 0.1, rng)
    alone, together = (many.close(values, enforce_limits=False, threads=n) for n in (1, 3))
    np.testing.assert_array_equal(alone.q, together.q)


def built(cache):
    found = [path for path in cache.iterdir() if path.suffix == ".so"]
    assert len(list(cache.iterdir())) == len(found)  # no drafts are left
    return found


def rewrite(path, contents):
    """As another file in its place: what runs already is not touched."""
    path.unlink()
    path.write_bytes(contents)


def flip(path):
    """One bit in the middle."""
    contents = bytearray(path.read_bytes())
    contents[len(contents) // 2] ^= 1
    rewrite(path, contents)


def replace_by_link(path):
    target = path.with_name("elsewhere")
    target.write_bytes(path.read_bytes())
    path.unlink()
    path.symlink_to(target)


SPOILT = {
    "a bit": flip,
    "cut": lambda path: rewrite(path, path.read_bytes()[:-100]),
    "empty": lambda path: rewrite(path, b""),
    "others may write": lambda path: path.chmod(0o666),
    "link": replace_by_link,
}


@pytest.mark.parametrize("how", SPOILT)
def test_what_is_whole_is_loaded_and_what_is_not_is_compiled_anew(cache, how, rng, monkeypatch):
    compiled, build = [], compiled_programs._build

    def counted(*given):
        compiled.append(1)
        return build(*given)

    monkeypatch.setattr(compiled_programs, "_build", counted)
    tape, values = everything(), numbers(100, rng)
    expected = CompiledProgram.of(tape).run(values)
    (path,) = built(cache)
    assert path.parent.stat().st_mode & 0o077 == 0
    CompiledProgram.of(tape)
    assert len(compiled) == 1
    SPOILT[how](path)
    found = CompiledProgram.of(tape).run(values)
    assert len(compiled) == 2
    np.testing.assert_array_equal(found, expected)
    assert path.is_file()
    assert not path.is_symlink()
    assert path.stat().st_mode & 0o022 == 0
    CompiledProgram.of(tape)
    assert len(compiled) == 2


def test_whatever_files_a_user_lets_others_write(cache, monkeypatch):
    before = os.umask(0)
    try:
        CompiledProgram.of(everything())
    finally:
        os.umask(before)
    monkeypatch.setattr(compiled_programs, "_build", None)
    CompiledProgram.of(everything())


def test_another_program_is_another_file(cache):
    tape = everything()
    CompiledProgram.of(tape)
    constants = tape.constants.copy()
    constants[0] += 1.0
    CompiledProgram.of(type(tape)(tape.code, constants, tape.slots, tape.inputs, tape.outputs))
    assert len(built(cache)) == 2


def test_a_folder_that_others_write_to_is_refused(cache):
    cache.mkdir()
    cache.chmod(0o777)
    with pytest.raises(pj.OutputError, match="others may write to this folder"):
        CompiledProgram.of(everything())
    assert not list(cache.iterdir())


def test_a_folder_that_cannot_be_made(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    with pytest.raises(pj.OutputError, match="set XDG_CACHE_HOME"):
        CompiledProgram.of(everything())


def test_without_a_compiler(cache, monkeypatch, tmp_path):
    monkeypatch.setenv("CC", str(tmp_path / "nothing"))
    with pytest.raises(pj.MissingDependencyError, match="install one"):
        pj.batch(loaded("four_bar"), compiled=True)
    assert not cache.exists()


def test_a_compiler_that_fails_says_why(cache, monkeypatch, tmp_path):
    failing = tmp_path / "failing"
    lines = ["#!/bin/sh", 'case "$*" in *-dM*) exit 0;; esac', 'echo "no space" >&2', "exit 1", ""]
    failing.write_text("\n".join(lines))
    failing.chmod(0o755)
    monkeypatch.setenv("CC", str(failing))
    with pytest.raises(pj.MissingDependencyError, match="no space"):
        CompiledProgram.of(everything())
    assert not built(cache)


def test_without_a_kernel(cache, monkeypatch):
    monkeypatch.setattr("pmjac_pin.batches.closing.many_paths_kernel", lambda: None)
    with pytest.raises(pj.MissingDependencyError, match="install a C compiler"):
        pj.batch(loaded("four_bar"), compiled=True)


_PROCESS = """
import numpy as np
from test_tape_kernel import everything
from pmjac_pin.algebra.compiled_programs import CompiledProgram, CompiledPrograms
from pmjac_pin.algebra.compiled_text import compiled_text
print(CompiledProgram.of(everything()).run(np.full((3, 70), 0.5)).sum().hex())
"""


def test_several_processes_at_once(cache):
    path = os.pathsep.join([str(Path(__file__).parent), *filter(None, sys.path)])
    started = [
        subprocess.Popen(
            [sys.executable, "-c", _PROCESS],
            stdout=subprocess.PIPE,
            text=True,
            env={**os.environ, "PYTHONPATH": path},
        )
        for _ in range(3)
    ]
    told = {process.communicate()[0] for process in started}
    assert [process.returncode for process in started] == [0, 0, 0]
    assert len(told) == 1
    assert len(built(cache)) == 1


STRICT = ("cc", "-std=c99", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-x", "c", "-")


@pytest.mark.parametrize("name", mostly_slow(CATALOGUE))
def test_texts_are_c99_without_a_warning(name, monkeypatch):
    tapes = [everything()]
    monkeypatch.setattr(CompiledPrograms, "of", lambda _, tape: tapes.append(tape))
    mechanism = loaded(name)
    pj.batch(mechanism, compiled=True).jacobian(mechanism.home.q[None])
    assert len(tapes) == 5  # three of a path, one of rates
    for tape in tapes:
        told = subprocess.run(
            STRICT, input=compiled_text(tape), capture_output=True, text=True, check=False
        )
        assert (told.returncode, told.stderr) == (0, "")
