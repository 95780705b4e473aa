"""Reading a text file that a user named: one clear error for all that can go wrong."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pmjac_pin.errors import ArgumentError, ModelFileError


def read_text(path: Path, maximal_size: int) -> str:
    """Read a UTF-8 text file of at most `maximal_size` bytes.

    Raises
    ------
    ModelFileError
        Missing, unreadable, a directory, a device, empty, too large or not UTF-8.
    """
    try:
        if path.is_dir():
            raise ModelFileError(f"{path}: is a directory, not a file", path=str(path))
        if path.exists() and not path.is_file():
            message = f"{path}: is no regular file but a device or a pipe"
            raise ModelFileError(message, path=str(path))
        if (size := path.stat().st_size) > maximal_size:
            message = f"{path}: {size} bytes are too many; at most {maximal_size} are read"
            raise ModelFileError(message, path=str(path))
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        message = f"{path}: not UTF-8 text (byte {error.start})"
        raise ModelFileError(message, path=str(path)) from None
    except OSError as error:
        raise ModelFileError(f"{path}: {error.strerror}", path=str(path)) from None
    if not text.strip():
        raise ModelFileError(f"{path}: the file is empty", path=str(path))
    return text


@contextmanager
def at_file(path: str) -> Iterator[None]:
    """Put the file's path before the message of an error that does not have it yet."""
    try:
        yield
    except (ModelFileError, ArgumentError) as error:
        if isinstance(error, ModelFileError) and error.path:
            raise
        raise ModelFileError(f"{path}: {error}", path=path) from None
