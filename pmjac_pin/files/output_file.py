"""Writing the files that a user asked for: complete and in their places, or all as it was before.

Each is written beside its place under a hidden name and then renamed, which happens at once.
Links are followed, and a file that is there keeps its owner and its mode.
"""

from __future__ import annotations

import contextlib
import os
import secrets
import shutil
import signal
import stat
import threading
from collections.abc import Iterator, Mapping
from pathlib import Path

from pmjac_pin.errors import OutputError
from pmjac_pin.files.user_path import is_file, is_open_file, output_path, real, shown_path

_SIGNALS = tuple(
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
)


def check_place(path: str | os.PathLike[str]) -> None:
    """Refuse early where nothing could be written.

    Raises
    ------
    ArgumentError
        No path.
    OutputError
        No such folder, a folder, a device, a pipe, or a file that must not be written.
    """
    _Place(path)


def check_new(path: str | os.PathLike[str], replace: bool) -> None:
    """Refuse early what `check_place` does, and a file that exists and is not to be replaced.

    Raises
    ------
    ArgumentError, OutputError
    """
    place = output_path(path)
    check_place(place)
    if is_file(place) and not replace:
        raise OutputError(f"{shown_path(place)}: exists already; --force replaces it")


def write_file(path: str | os.PathLike[str], contents: bytes) -> None:
    """Write one file; see `write_files`."""
    write_files({path: contents})


def write_files(
    contents: Mapping[Path, bytes] | Mapping[str | os.PathLike[str], bytes],
    *,
    replace: bool = True,
) -> None:
    """Write files: all of them, or none.

    Parameters
    ----------
    contents : mapping of paths to bytes
    replace : bool
        Whether files that exist are replaced. Where not, and one appears meanwhile, it stays:
        of two that write the same file only one succeeds.

    Raises
    ------
    ArgumentError, OutputError
        As `check_place`; no space, or a file that exists. Then nothing has changed.
    """
    places = [_Place(path) for path in contents]
    with _signals_wait():
        try:
            for place, content in zip(places, contents.values(), strict=True):
                place.write(content)
            for place in places:
                place.put(replace=replace, keep=len(places) > 1)
        except BaseException:
            for place in reversed(places):
                place.take_back()
            raise
        finally:
            for place in places:
                place.clear()


class _Place:
    """A file to be written: what is there now, and the draft beside it."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self._given = output_path(path)
        self._target = real(self._given)
        with self._told():
            self._found = self._check()
        self._draft = self._target.with_name(f".pmjac-{secrets.token_hex(8)}")
        self._old = self._draft.with_suffix(".old")
        self._ours: os.stat_result | None = None  # what is in the place, once it is ours

    def _check(self) -> os.stat_result | None:
        """Return what is in the place: a file that may be replaced, or nothing."""
        if self._target.is_dir():
            raise self._refused("is a folder; give the name of a file in it")
        if not self._target.parent.is_dir():
            raise self._refused(f"there is no folder {shown_path(self._target.parent)}")
        try:
            found = self._target.lstat()
        except FileNotFoundError:
            return None
        if not stat.S_ISREG(found.st_mode):
            what = "a link in a circle" if stat.S_ISLNK(found.st_mode) else "a device or a pipe"
            raise self._refused(f"is no regular file but {what}; it is not replaced")
        if is_open_file(self._given):
            raise self._refused("leads to a file that is open here; it is not replaced")
        if not os.access(self._target, os.W_OK):
            raise self._refused("the file that is there must not be written to")
        return found

    def write(self, contents: bytes) -> None:
        """Write the draft, with the owner and the rights of the file that it is to replace."""
        new = os.O_WRONLY | os.O_CREAT | os.O_EXCL
        # What is new gets the usual rights, those that the process's umask leaves.
        mode = 0o666 if self._found is None else 0o600
        with (
            self._told(),
            open(self._draft, "xb", opener=lambda path, _: os.open(path, new, mode)) as file,
        ):
            file.write(contents)
            file.flush()
            os.fsync(file.fileno())
            if self._found is not None:
                with contextlib.suppress(PermissionError, AttributeError):  # only root may
                    os.chown(self._draft, self._found.st_uid, self._found.st_gid)
                self._draft.chmod(stat.S_IMODE(self._found.st_mode))

    def put(self, *, replace: bool, keep: bool) -> None:
        """Put the draft in its place; keep what was there for `take_back`."""
        with self._told():
            ours = self._draft.stat()
            if not replace:
                self._take_free_place()
            else:
                if keep and self._target.exists():
                    self._keep()
                self._draft.replace(self._target)
            self._ours = ours

    def _take_free_place(self) -> None:
        try:
            os.link(self._draft, self._target)
        except FileExistsError:
            raise
        except OSError:  # no hard links here: take the name, then fill it
            os.close(os.open(self._target, os.O_WRONLY | os.O_CREAT | os.O_EXCL))
            self._ours = self._target.stat()
            self._draft.replace(self._target)

    def _keep(self) -> None:
        try:
            os.link(self._target, self._old)
        except OSError:
            shutil.copy2(self._target, self._old)

    def take_back(self) -> None:
        """Restore what was there before `put`, unless somebody else has written it since."""
        with contextlib.suppress(OSError):
            if self._ours is None or _identity_of(self._ours) != _identity_of(self._target.lstat()):
                return
            if self._old.exists():
                self._old.replace(self._target)
            else:
                self._target.unlink()

    def clear(self) -> None:
        """Leave nothing beside the file."""
        for path in (self._draft, self._old):
            with contextlib.suppress(OSError):
                path.unlink(missing_ok=True)

    @contextlib.contextmanager
    def _told(self) -> Iterator[None]:
        """Name the file that was asked for, and not the draft."""
        try:
            yield
        except OutputError:
            raise
        except FileExistsError as error:
            raise self._refused("exists already, since just now; it is not replaced") from error
        except OSError as error:
            raise self._refused(error.strerror or str(error)) from error

    def _refused(self, why: str) -> OutputError:
        return OutputError(f"{shown_path(self._given)}: {why}")


def _identity_of(status: os.stat_result) -> tuple[int, ...]:
    """Return what tells one file from another: the numbers of removed ones are used again."""
    return (status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns)


@contextlib.contextmanager
def _signals_wait() -> Iterator[None]:
    """Let signals that would end the process wait until no draft is left; it is milliseconds."""
    if threading.current_thread() is not threading.main_thread():
        yield  # only the main thread may handle signals
        return
    arrived: list[int] = []
    known = [number for number in _SIGNALS if signal.getsignal(number) is not None]
    before = {
        number: signal.signal(number, lambda number, _: arrived.append(number)) for number in known
    }
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        for number in arrived:
            signal.raise_signal(number)
