"""Paths that a user gave: the one place where they are expanded and looked at."""

from __future__ import annotations

import os
import re
from pathlib import Path

from pmjac_pin.errors import ArgumentError, quoted, shortened

_LONGEST_PATH = 400  # characters of one in a message
_MOST_LINKS = 40  # one after another, as Linux follows them


def user_path(given: object) -> Path:
    """Return the path that somebody gave, with ``~`` and ``~name`` expanded.

    Raises
    ------
    ArgumentError
        No path; characters that no file's name can have; a user that does not exist.
    """
    if not isinstance(given, str | os.PathLike) or isinstance(os.fspath(given), bytes):
        raise ArgumentError(f"a path is wanted, got {quoted(given)}")
    path = Path(given)
    try:
        possible = b"\0" not in os.fsencode(path)
    except UnicodeEncodeError:  # lone surrogates
        possible = False
    if not possible:
        raise ArgumentError(f"{quoted(str(path))}: no file can have such a name")
    try:
        return path.expanduser()
    except RuntimeError:
        user = quoted(path.parts[0][1:]) if len(path.parts[0]) > 1 else "yours"
        raise ArgumentError(
            f"{shown_path(path)}: the home folder of {user} is not known; write './~...' for a file"
        ) from None


def output_path(given: object) -> Path:
    """Return the path of a file that is to be written.

    Raises
    ------
    ArgumentError
        As `user_path`; an empty text, which `Path` takes for the working folder.
    """
    if isinstance(given, str) and not given:
        raise ArgumentError("the path of a file is wanted, got an empty text")
    return user_path(given)


def shown_path(path: str | os.PathLike[str]) -> str:
    """Return how messages call a file: by its path, shortened."""
    return shortened(os.fspath(path), _LONGEST_PATH)


def readable(name: str) -> str:
    """Return a file's name as text that can be written: its bytes need be no UTF-8."""
    return os.fsencode(name).decode(errors="replace")


def is_file(path: Path) -> bool:
    """Tell whether there is a file; there is none of a name that is too long."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def is_folder(path: Path) -> bool:
    """Tell whether there is a folder; there is none of a name that is too long."""
    try:
        return path.is_dir()
    except (OSError, ValueError):
        return False


def followed_link(path: Path) -> Path:
    """Return where a link leads; another path as it is."""
    return real(path) if os.path.islink(path) else path  # noqa: PTH114 - True or False for any name


def real(path: Path) -> Path:
    """Return where links lead, as far as they lead somewhere."""
    return Path(os.path.realpath(path))


def is_open_file(path: Path) -> bool:
    """Tell whether a path leads to a file by one of a process's handles, as /dev/stdout does."""
    for _ in range(_MOST_LINKS):
        if re.fullmatch(r"/proc/[^/]+/(task/[^/]+/)?fd", os.path.realpath(path.parent)):
            return True
        if not path.is_symlink():
            return False
        path = path.parent / path.readlink()
    return False
