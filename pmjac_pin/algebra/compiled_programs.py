"""Tapes compiled by the machine's C compiler, and kept in the user's cache.

A file there is named by what it computes, for which processor, and by which compiler; it is
written beside its place and renamed, so that several processes may do so at once. What is not
whole any longer is compiled anew, and what others could have written is not loaded.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import secrets
import shlex
import stat
import subprocess
from functools import cache
from pathlib import Path
from threading import Lock
from typing import NamedTuple

import numpy as np

from pmjac_pin.algebra import compiled_text as text
from pmjac_pin.algebra.c_kernels import address
from pmjac_pin.algebra.tape import Tape
from pmjac_pin.errors import MissingDependencyError, OutputError
from pmjac_pin.values.arrays import Array, aligned

# No function's error number is asked for, no exception is trapped, and no product is added to
# unrounded: numbers are the tape's to the last bit.
_OPTIONS = (
    "-std=gnu99", "-O2", "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=off",
    "-fPIC", "-shared", "-Wno-psabi",
)  # fmt: skip
_OF_PROCESSOR = (("-march=native",), ("-mcpu=native",), ())
_DIGEST = 32  # bytes at the end of a file: of what is before


class CompiledProgram:
    """A tape that is compiled.

    Attributes
    ----------
    stage : int
        The address of what runs one stage (`pmjac_run_stage` of `compiled.h`).
    kept : int
        How many numbers of each lane it keeps between stages.
    """

    def __init__(self, library: ctypes.CDLL, tape: Tape) -> None:
        library.pmjac_kept.restype = library.pmjac_lanes.restype = ctypes.c_int64
        self._library, self._tape = library, tape
        self._lanes = int(library.pmjac_lanes())
        self.kept = int(library.pmjac_kept())
        self.stage = int(ctypes.cast(library.pmjac_run_stage, ctypes.c_void_p).value or 0)

    @classmethod
    def of(cls, tape: Tape) -> CompiledProgram:
        """Compile a tape, or load what was compiled before.

        Raises
        ------
        MissingDependencyError
            No compiler, or one that fails.
        OutputError
            A cache that cannot be written, or that others can write to.
        """
        compiler = _compiler(os.environ.get("CC", "cc"))
        built = cache_folder() / f"{_digest_name(tape, compiler)}.so"
        if not _is_whole(built):
            _build(built, tape, compiler.command)
        return cls(ctypes.CDLL(str(built)), tape)

    def run(self, inputs: Array) -> Array:
        """Return the outputs, shape (outputs, N), of inputs of shape (inputs, N)."""
        count = inputs.shape[1]
        whole = count - count % self._lanes
        if whole == count:
            return self._run(np.ascontiguousarray(inputs, dtype=float))
        rest = np.repeat(inputs[:, -1:], self._lanes, axis=1)
        rest[:, : count - whole] = inputs[:, whole:]
        found = np.empty((self._tape.outputs, count))
        found[:, :whole] = self._run(np.ascontiguousarray(inputs[:, :whole], dtype=float))
        found[:, whole:] = self._run(rest)[:, : count - whole]
        return found

    def _run(self, inputs: Array) -> Array:
        """Run sets of inputs that fill lanes."""
        tape, count = self._tape, inputs.shape[1]
        found = np.empty((tape.outputs, count))
        work = aligned(self.kept + tape.inputs + tape.outputs, self._lanes)
        self._library.pmjac_run_rows(
            ctypes.c_int64(len(tape.stages) or 1),
            ctypes.c_int64(count),
            address(inputs),
            ctypes.c_int64(tape.inputs),
            address(found),
            ctypes.c_int64(tape.outputs),
            address(work),
        )
        return found


class CompiledPrograms:
    """Tapes, each compiled or loaded when it is asked for first."""

    def __init__(self) -> None:
        self._known: dict[int, CompiledProgram] = {}
        self._lock = Lock()

    def of(self, tape: Tape) -> CompiledProgram:
        """Return the program of a tape; raises as `CompiledProgram.of` does."""
        with self._lock:  # a program has its tape, so no other comes to have the same id
            if id(tape) not in self._known:
                self._known[id(tape)] = CompiledProgram.of(tape)
            return self._known[id(tape)]


def cache_folder() -> Path:
    """Return where compiled programs are kept: made where it is not there, the user's alone.

    Raises
    ------
    OutputError
    """
    base = Path(os.environ.get("XDG_CACHE_HOME", ""))
    folder = (base if base.is_absolute() else Path.home() / ".cache") / "pmjac_pin"
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        known = folder.stat()
    except OSError as error:
        told = f"{folder}: compiled programs cannot be kept there ({error.strerror}); "
        raise OutputError(f"{told}set XDG_CACHE_HOME to a folder that can be written") from None
    if not _only_ours(known):
        told = f"{folder}: others may write to this folder, so nothing in it is run; "
        raise OutputError(f"{told}make it yours alone (chmod 700), or set XDG_CACHE_HOME")
    return folder


class _Compiler(NamedTuple):
    """The command that compiles for this processor, and what it says of both."""

    command: tuple[str, ...]
    identity: bytes


@cache
def _compiler(given: str) -> _Compiler:
    """Return the compiler that a user names; raise MissingDependencyError where it does not run."""
    for options in _OF_PROCESSOR:
        command = (*shlex.split(given), *_OPTIONS, *options)
        asked = [*command, "-dM", "-E", "-x", "c", os.devnull]
        try:
            done = subprocess.run(asked, capture_output=True, check=False)
        except OSError:
            break
        if not done.returncode:
            return _Compiler(command, done.stdout)
    raise MissingDependencyError(
        f"programs are compiled by a C compiler, and {given!r} is none that runs: install one "
        "(apt install gcc, dnf install gcc, xcode-select --install), or name one in the "
        "environment variable CC"
    )


def _digest_name(tape: Tape, compiler: _Compiler) -> str:
    """Return the digest of all that a compiled program depends on."""
    digest = hashlib.sha256()
    numbers = np.array([tape.slots, tape.inputs, tape.outputs, *tape.stages])
    parts = [source.read_bytes() for source in (Path(text.__file__), text.HEAD)]
    parts += [repr(compiler.command).encode(), compiler.identity, numbers.tobytes()]
    parts += [tape.code.tobytes(), tape.constants.tobytes()]
    for part in parts:
        digest.update(len(part).to_bytes(8, "little") + part)
    return digest.hexdigest()


def _is_whole(built: Path) -> bool:
    """Tell whether a file is what was compiled, by this user."""
    try:
        opened = os.open(built, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0))
    except OSError:
        return False
    with os.fdopen(opened, "rb") as file:
        if not _only_ours(os.fstat(opened)):
            return False
        contents = file.read()
    return hashlib.sha256(contents[:-_DIGEST]).digest() == contents[-_DIGEST:]


def _only_ours(known: os.stat_result) -> bool:
    user = getattr(os, "geteuid", None)  # not on every system
    others = stat.S_IWGRP | stat.S_IWOTH
    return user is None or (known.st_uid == user() and not known.st_mode & others)


def _build(built: Path, tape: Tape, command: tuple[str, ...]) -> None:
    draft = built.with_name(f".{secrets.token_hex(8)}.so")
    asked = [*command, "-x", "c", "-", "-o", str(draft), "-lm"]
    source = text.compiled_text(tape).encode()
    try:
        done = subprocess.run(asked, input=source, capture_output=True, check=False)
        if done.returncode:
            lines = done.stderr.decode(errors="replace").strip().splitlines()
            raise MissingDependencyError(
                f"{shlex.join(command)} cannot compile a program ({(lines or ['no reason'])[0]}): "
                "name another C compiler in the environment variable CC"
            )
        with draft.open("ab") as file:
            contents = draft.read_bytes()
            file.write(hashlib.sha256(contents).digest())
        draft.chmod(0o700)  # whatever the user's umask is
        draft.replace(built)
    except OSError as error:
        told = f"{built.parent}: a compiled program cannot be kept there ({error.strerror})"
        raise OutputError(told) from None
    finally:
        draft.unlink(missing_ok=True)
