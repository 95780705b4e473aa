"""Tapes compiled by a C compiler, the machine's or that of PyPI, and kept in the user's cache.

A file there is named by what it computes, for which processor, and by which compiler. What is not
whole any longer is compiled anew.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import shlex
import subprocess
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Lock
from typing import NamedTuple

import numpy as np

from pmjac_pin.algebra import compiled_text as text
from pmjac_pin.algebra.c_compilers import NAMES, CCompiler, c_compilers, named_compiler
from pmjac_pin.algebra.c_kernels import COUNT, POINTER, address
from pmjac_pin.algebra.compiled_cache import cache_folder, keep, loaded_from, not_kept, whole
from pmjac_pin.algebra.tape import Tape
from pmjac_pin.errors import MissingDependencyError
from pmjac_pin.values.arrays import Array, aligned

# No function's error number is asked for, no exception is trapped, and no product is added to
# unrounded: numbers are the tape's to the last bit.
_OPTIONS = (
    "-std=gnu99", "-O2", "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=off",
    "-fPIC", "-shared", "-Wno-psabi",
)  # fmt: skip
_OF_PROCESSOR = (("-march=native",), ("-mcpu=native",), ())


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
        library.pmjac_kept.restype = library.pmjac_lanes.restype = COUNT
        rows = (POINTER, COUNT)
        library.pmjac_run_rows.argtypes = (COUNT, COUNT, *rows, *rows, POINTER)
        self._library, self._tape = library, tape
        self._lanes = int(library.pmjac_lanes())
        self.kept = int(library.pmjac_kept())
        self.stage = int(ctypes.cast(library.pmjac_run_stage, POINTER).value or 0)

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
        compiler = _compiler()
        folder = cache_folder()
        kept = folder / f"{_digest_name(tape, compiler)}.so"
        contents = whole(kept) or keep(_build(tape, compiler.command, folder), kept)
        return cls(loaded_from(contents, folder), tape)

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
            len(tape.stages) or 1,
            count,
            address(inputs),
            tape.inputs,
            address(found),
            tape.outputs,
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


class _Compiler(NamedTuple):
    """The command that compiles for this processor, and what it says of both."""

    command: tuple[str, ...]
    identity: bytes


def _compiler() -> _Compiler:
    """Return the first compiler that runs; raise MissingDependencyError where none does."""
    for candidate in c_compilers():
        try:
            return _running(candidate)
        except OSError:
            continue
    named = shlex.join(named_compiler())
    none = f"neither {', '.join(NAMES)} nor ziglang is one that runs"
    told = f"{named!r}, which the environment variable CC names, is none that runs"
    raise MissingDependencyError(
        f"programs are compiled by a C compiler, and {told if named else none}: install one "
        "(apt install gcc, dnf install gcc, xcode-select --install), take the one from PyPI "
        "(pip install 'pmjac_pin[compiled]', which is ziglang), or name one in the environment "
        "variable CC"
    )


@cache
def _running(candidate: CCompiler) -> _Compiler:
    """Return a compiler with the options that it understands; raise OSError where none runs."""
    for options in _OF_PROCESSOR:
        command = (*candidate.command, *_OPTIONS, *options)
        defined = _answer([*command, "-dM", "-E", "-x", "c", os.devnull])
        if not defined.returncode:
            version = _answer(candidate.version)
            return _Compiler(command, defined.stdout + version.stdout)
    raise OSError(defined.stderr)


def _answer(command: Sequence[str]) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run(command, capture_output=True, check=False)


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


def _build(tape: Tape, command: tuple[str, ...], folder: Path) -> bytes:
    """Return a compiled tape, from a folder within another that is gone then."""
    source = text.compiled_text(tape).encode()
    try:
        with TemporaryDirectory(prefix=".", dir=folder) as drafts:  # for no one else to look into
            draft = Path(drafts, "program.so")
            asked = [*command, "-x", "c", "-", "-o", str(draft), "-lm"]
            done = subprocess.run(asked, input=source, capture_output=True, check=False)
            if not done.returncode:
                return draft.read_bytes()
    except OSError as error:
        raise not_kept(folder, error) from None
    lines = done.stderr.decode(errors="replace").strip().splitlines()
    raise MissingDependencyError(
        f"{shlex.join(command)} cannot compile a program ({(lines or ['no reason'])[0]}): "
        "name another C compiler in the environment variable CC"
    )
