"""Where compiled programs are kept, and what of it is loaded: what nobody else can have written.

A file is written beside its place and renamed, and ends with a digest of what is before it. What
is loaded is a copy of the bytes that were checked, so that nothing depends on what becomes of the
file in the meantime.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import secrets
import stat
from collections.abc import Iterator
from pathlib import Path

from pmjac_pin.errors import OutputError

_DIGEST = 32  # bytes at the end of a file: of what is before
_OTHERS = stat.S_IWGRP | stat.S_IWOTH


def cache_folder() -> Path:
    """Return where compiled programs are kept: made where it is not there, the user's alone.

    All that leads to it from the home folder on, or from the root where it is elsewhere, is asked
    for what OpenSSH asks of the way to a user's keys: folders and links are the user's or the
    superuser's, and others cannot exchange what is in a folder.

    Raises
    ------
    OutputError
    """
    base = Path(os.environ.get("XDG_CACHE_HOME", ""))
    try:
        home = Path.home()
        folder = (base if base.is_absolute() else home / ".cache") / "pmjac_pin"
    except RuntimeError:
        told = "compiled programs are kept in the home folder, and there is none: "
        raise OutputError(f"{told}set XDG_CACHE_HOME to a folder that can be written") from None
    try:
        for place in (*reversed(folder.parents), folder):
            place.mkdir(mode=0o700, exist_ok=True)
        risks = [_risk(place) for place in _leading_to(folder, home)]
        if not _only_ours(folder.stat()):
            risks.append(f"{folder}: others may write to this folder")
    except OSError as error:
        told = f"{folder}: compiled programs cannot be kept there ({error.strerror}); "
        raise OutputError(f"{told}set XDG_CACHE_HOME to a folder that can be written") from None
    for risk in filter(None, risks):
        told = f"{risk}, so no compiled program in it is run; make it yours alone (chown, "
        raise OutputError(f"{told}chmod go-w), or set XDG_CACHE_HOME to a folder that is")
    return folder


def whole(kept: Path) -> bytes | None:
    """Return what a file holds where it is as it was kept, by this user; else None."""
    try:
        opened = os.open(kept, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0))
    except OSError:
        return None
    with os.fdopen(opened, "rb") as file:
        if not _only_ours(os.fstat(opened)):
            return None
        contents = file.read()
    return contents if contents == _with_digest(contents[:-_DIGEST]) else None


def keep(program: bytes, kept: Path) -> bytes:
    """Keep a compiled program; return what `whole` will; raise OutputError where it cannot be."""
    contents = _with_digest(program)
    draft = _draft(kept.parent)
    try:
        _put(draft, contents)
        draft.replace(kept)
    except OSError as error:
        raise not_kept(kept.parent, error) from None
    finally:
        draft.unlink(missing_ok=True)
    return contents


def loaded_from(contents: bytes, folder: Path) -> ctypes.CDLL:
    """Load a library from its bytes, by way of a folder that is the user's alone.

    Its file has a name that no other has had, by which the loader would take it for that one, and
    is gone when it is loaded: who writes to the kept one does not write to what runs.
    """
    draft = _draft(folder)
    try:
        _put(draft, contents)
        return ctypes.CDLL(str(draft))
    except OSError as error:
        raise not_kept(folder, error) from None
    finally:
        draft.unlink(missing_ok=True)


def not_kept(folder: Path, error: OSError) -> OutputError:
    """Return the error for a program that cannot be written, or not be loaded."""
    told = f"{folder}: a compiled program cannot be kept there ({error.strerror or error}); "
    return OutputError(f"{told}set XDG_CACHE_HOME to a folder that can be written and run from")


def _leading_to(folder: Path, home: Path) -> Iterator[Path]:
    """Yield the folders and links that a path goes through, to where these lead, and its end."""
    for place in (*reversed(folder.parents), folder):
        if place in home.parents:  # who can exchange the home folder needs no cache
            continue
        yield place
        if place.is_symlink():
            yield from _leading_to(place.parent / place.readlink(), home)


def _risk(place: Path) -> str:
    """Return how others may exchange a folder or link, or what is in it; "" where they cannot."""
    known, user = place.lstat(), _user()
    if user is None:
        return ""
    link = stat.S_ISLNK(known.st_mode)
    if known.st_uid not in (0, user):
        return f"{place}: this {'link' if link else 'folder'} is another user's"
    # Of a sticky folder, such as /tmp, others cannot exchange what is not theirs.
    if link or known.st_mode & stat.S_ISVTX or not known.st_mode & _OTHERS:
        return ""
    return f"{place}: others may write to this folder"


def _user() -> int | None:
    """Return who runs this, None on a system that does not tell."""
    asked = getattr(os, "geteuid", None)
    return None if asked is None else int(asked())


def _only_ours(known: os.stat_result) -> bool:
    user = _user()
    return user is None or (known.st_uid == user and not known.st_mode & _OTHERS)


def _with_digest(program: bytes) -> bytes:
    return program + hashlib.sha256(program).digest()


def _draft(folder: Path) -> Path:
    return folder / f".{secrets.token_hex(16)}.so"


def _put(draft: Path, contents: bytes) -> None:
    """Write a file that is new and, whatever the user's umask is, the user's alone."""
    with os.fdopen(os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o700), "wb") as file:
        draft.chmod(0o700)
        file.write(contents)
