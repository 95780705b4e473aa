"""Which C compilers there may be: the one that a user names, the machine's, that of PyPI.

It imports the standard library alone: what builds the package runs it, too, from its file.
"""

from __future__ import annotations

import os
import shlex
import shutil
import sys
from importlib.util import find_spec
from typing import NamedTuple

#: What a machine's C compiler is called.
NAMES = ("cc", "gcc", "clang")


class CCompiler(NamedTuple):
    """How a C compiler is called, whether it is there or not.

    Attributes
    ----------
    command : tuple of str
    version : tuple of str
        The command by which it tells its version.
    portable : tuple of str
        What it has to be told to compile for every processor of the machine's kind.
    """

    command: tuple[str, ...]
    version: tuple[str, ...]
    portable: tuple[str, ...] = ()


def c_compilers() -> list[CCompiler]:
    """Return what the environment variable CC names; where it is empty, all that are found."""
    if given := named_compiler():
        return [_compiler(*given)]
    found = [_compiler(path) for name in NAMES if (path := shutil.which(name))]
    if sys.executable and find_spec("ziglang"):
        zig = (sys.executable, "-P", "-m", "ziglang")  # -P: from no folder that happens to be here
        found.append(CCompiler((*zig, "cc"), (*zig, "version"), ("-mcpu=baseline",)))
    return found


def named_compiler() -> list[str]:
    """Return the command in the environment variable CC, nothing where it is empty."""
    given = os.environ.get("CC", "")
    try:
        return shlex.split(given)
    except ValueError:  # a quotation mark too many: no command is called so
        return [given]


def _compiler(name: str, *options: str) -> CCompiler:
    command = (shutil.which(name) or name, *options)
    return CCompiler(command, (*command, "--version"))
