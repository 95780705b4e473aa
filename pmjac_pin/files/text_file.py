"""Reading a text file that a user named: one clear error for all that can go wrong."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pmjac_pin.errors import ArgumentError, ModelFileError
from pmjac_pin.files.user_path import shown_path

# A pipe that nobody writes to, or a device, would not come back from being opened.
_WITHOUT_WAITING = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0)


def read_text(path: Path, maximal_size: int) -> str:
    """Read a UTF-8 text file of at most `maximal_size` bytes; nothing else is opened.

    Raises
    ------
    ModelFileError
        Missing, unreadable, a directory, a device, empty, too large or not UTF-8.
    """
    try:
        text = _contents(path, maximal_size).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise _refused(path, f"not UTF-8 text (byte {error.start})") from None
    except OSError as error:
        raise _refused(path, error.strerror or str(error)) from None
    if not text.strip():
        raise _refused(path, "the file is empty")
    return text


def _contents(path: Path, maximal_size: int) -> bytes:
    """Return a regular file's bytes; what is at its path may change, so that it is asked twice."""
    _check_status(path, path.stat(), maximal_size)
    with open(
        path, "rb", opener=lambda name, flags: os.open(name, flags | _WITHOUT_WAITING)
    ) as file:
        _check_status(path, os.fstat(file.fileno()), maximal_size)
        contents = file.read(maximal_size + 1) or b""
    if len(contents) > maximal_size:
        raise _too_large(path, len(contents), maximal_size)
    return contents


def _check_status(path: Path, status: os.stat_result, maximal_size: int) -> None:
    if stat.S_ISDIR(status.st_mode):
        raise _refused(path, "is a directory, not a file")
    if not stat.S_ISREG(status.st_mode):
        raise _refused(path, "is no regular file but a device or a pipe")
    if status.st_size > maximal_size:
        raise _too_large(path, status.st_size, maximal_size)
    if not status.st_size:  # as of the kernel's own, such as /proc/kmsg, which may have no end
        raise _refused(path, "the file is empty")


def _too_large(path: Path, size: int, maximal_size: int) -> ModelFileError:
    return _refused(path, f"{size} bytes are too many; at most {maximal_size} are read")


def _refused(path: Path, why: str) -> ModelFileError:
    return ModelFileError(f"{shown_path(path)}: {why}", path=str(path))


@contextmanager
def at_file(path: str) -> Iterator[None]:
    """Put the file's path before the message of an error that does not have it yet."""
    try:
        yield
    except (ModelFileError, ArgumentError) as error:
        if isinstance(error, ModelFileError) and error.path:
            raise
        raise ModelFileError(f"{shown_path(path)}: {error}", path=path) from None
