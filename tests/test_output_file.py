"""Users' files: written whole or left alone, whoever else writes, and whatever fails."""

from __future__ import annotations

import errno
import os
import signal
import stat
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.cli import main
from pmjac_pin.files import output_file
from pmjac_pin.files.output_file import check_place, write_file, write_files

NOBODY = 65534


@pytest.fixture
def umask():
    before = os.umask(0o027)
    yield 0o027
    os.umask(before)


def save_html(path):
    with pj.view(loaded("serial_2r").home, open_browser=False, port=0) as viewer:
        viewer.save_html(path)


def plot(path):
    figure = pytest.importorskip("matplotlib.figure").Figure()
    from pmjac_pin.pictures.figures import save_figure

    save_figure(figure, path)


#: Everything that writes a file, and the suffix it takes.
WRITERS = {
    "write_file": (lambda path: write_file(path, b"new"), ".txt"),
    "save_html": (save_html, ".html"),
    "plot": (plot, ".png"),
    "convert": (lambda path: pj.convert("serial_2r", path, force=True), ".toml"),
}
writers = pytest.mark.parametrize(("write", "suffix"), WRITERS.values(), ids=WRITERS)


def names(folder):
    return sorted(path.name for path in folder.iterdir())


# --- what is there -----------------------------------------------------------------------------


@writers
@pytest.mark.parametrize("mode", [0o600, 0o640, 0o755])
def test_a_file_keeps_its_mode(tmp_path, umask, write, suffix, mode):
    path = tmp_path / f"x{suffix}"
    path.write_text("old")
    path.chmod(mode)
    write(path)
    assert path.read_bytes() != b"old"
    assert stat.S_IMODE(path.stat().st_mode) == mode


@writers
def test_a_new_file_has_what_the_umask_leaves(tmp_path, umask, write, suffix):
    write(tmp_path / f"x{suffix}")
    assert {stat.S_IMODE(path.stat().st_mode) for path in tmp_path.iterdir()} == {0o666 & ~umask}


@pytest.mark.parametrize("link", [False, True])
def test_a_file_that_is_open_here_is_not_replaced(tmp_path, link):
    """As /dev/stdout is where output goes to a file: what it has said before would be lost."""
    with (tmp_path / "log").open("w+b") as log:
        log.write(b"before")
        path = Path(f"/proc/self/fd/{log.fileno()}")
        if link:
            (tmp_path / "link").symlink_to(path)
            path = tmp_path / "link"
        with pytest.raises(pj.OutputError, match="leads to a file that is open here"):
            write_file(path, b"after")
        log.seek(0)
        assert log.read() == b"before"


@writers
@pytest.mark.parametrize("kind", ["pipe", "device", "folder", "circle"])
def test_what_is_no_file_stays(tmp_path, write, suffix, kind):
    path = tmp_path / f"x{suffix}"
    match kind:
        case "pipe":
            os.mkfifo(path)
        case "device":
            path.symlink_to("/dev/null")
        case "folder":
            path.mkdir()
        case "circle":
            path.symlink_to(path)
    before = path.lstat().st_ino
    with pytest.raises(pj.OutputError, match=r"folder|is no regular file"):
        write(path)
    assert path.lstat().st_ino == before
    assert Path("/dev/null").is_char_device()
    assert path.name in names(tmp_path)
    assert not [name for name in names(tmp_path) if name.startswith(".")]


@writers
def test_links_are_followed(tmp_path, write, suffix):
    folder = tmp_path / "deep"
    folder.mkdir()
    for name in ("there", "not yet there"):
        target, link = folder / f"{name}{suffix}", tmp_path / f"to {name}{suffix}"
        link.symlink_to(target)
        if name == "there":
            target.write_text("old")
        write(link)
        assert link.is_symlink()
        assert target.read_bytes() != b"old"


@pytest.mark.skipif(os.name != "posix" or os.geteuid() != 0, reason="only root gives files away")
def test_a_file_keeps_its_owner(tmp_path):
    path = tmp_path / "x"
    path.write_text("old")
    os.chown(path, NOBODY, NOBODY)
    write_file(path, b"new")
    assert (path.stat().st_uid, path.stat().st_gid) == (NOBODY, NOBODY)


def test_a_file_that_must_not_be_written_to_stays(tmp_path, monkeypatch):
    path = tmp_path / "x"
    path.write_text("precious")
    path.chmod(0o444)
    # To root, as whom tests may run, everything is allowed.
    monkeypatch.setattr(os, "access", lambda path, _: bool(path.stat().st_mode & 0o200))
    with pytest.raises(pj.OutputError, match="must not be written to"):
        write_file(path, b"new")
    assert path.read_text() == "precious"


@writers
def test_a_home_folder(tmp_path, monkeypatch, write, suffix):
    monkeypatch.setenv("HOME", str(tmp_path))
    write(f"~/x{suffix}")
    assert f"x{suffix}" in names(tmp_path)
    with pytest.raises(pj.ArgumentError, match="home folder of 'nosuch' is not known"):
        write(f"~nosuch/x{suffix}")


def test_a_name_as_long_as_can_be(tmp_path):
    write_file(tmp_path / ("x" * 255), b"new")
    with pytest.raises(pj.OutputError, match="too long"):
        write_file(tmp_path / ("x" * 256), b"new")
    assert names(tmp_path) == ["x" * 255]


def test_nowhere(tmp_path):
    for path in (".", "..", "/", str(tmp_path)):
        with pytest.raises(pj.OutputError, match="is a folder; give the name of a file in it"):
            check_place(path)
    with pytest.raises(pj.ArgumentError, match="got an empty text"):
        check_place("")
    with pytest.raises(pj.OutputError, match="there is no folder"):
        check_place(tmp_path / "none" / "x")


# --- what fails --------------------------------------------------------------------------------


@writers
def test_a_disk_that_is_full_changes_nothing(tmp_path, monkeypatch, write, suffix):
    def full(_):
        raise OSError(errno.ENOSPC, "No space left on device")

    path = tmp_path / f"x{suffix}"
    path.write_text("precious")
    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(pj.OutputError, match=r"x\.\w+: No space left on device"):
        write(path)
    assert path.read_text() == "precious"
    assert names(tmp_path) == [path.name]


@pytest.mark.parametrize("old", [("a", "b"), ("a",), ("b",), ()])
@pytest.mark.parametrize("links", [True, False])
def test_of_several_files_all_are_written_or_none(tmp_path, monkeypatch, old, links):
    """Whatever rename fails, and whether or not the file system knows hard links."""
    places = {tmp_path / name: name.encode() for name in "ab"}
    for name in old:
        (tmp_path / name).write_text("precious")
    move, calls = type(tmp_path).replace, []

    def failing(self, target):
        calls.append(target.name)
        if target.name == "b" and self.suffix != ".old":
            raise OSError(errno.EIO, "Input/output error")
        return move(self, target)

    def no_links(*_):
        raise OSError(errno.EPERM, "Operation not permitted")

    with monkeypatch.context() as patched:
        patched.setattr(type(tmp_path), "replace", failing)
        if not links:
            patched.setattr(os, "link", no_links)
        with pytest.raises(pj.OutputError, match="b: Input/output error"):
            write_files(places)
    assert calls[:2] == ["a", "b"]
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == dict.fromkeys(
        old, "precious"
    )
    write_files(places)
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"a": "a", "b": "b"}


def test_convert_loses_no_urdf_when_the_model_file_cannot_be_put_in_its_place(
    tmp_path, monkeypatch
):
    target, urdf = tmp_path / "mine.toml", tmp_path / "mine.urdf"
    pj.convert("serial_2r", target)
    before = target.read_text(), urdf.read_text()
    move = type(tmp_path).replace

    def failing(self, place):
        if place == target:
            raise OSError(errno.EIO, "Input/output error")
        return move(self, place)

    monkeypatch.setattr(type(tmp_path), "replace", failing)
    with pytest.raises(pj.OutputError, match=r"mine\.toml: Input/output error"):
        pj.convert("four_bar", target, force=True)
    assert (target.read_text(), urdf.read_text()) == before
    assert names(tmp_path) == ["mine.toml", "mine.urdf"]


# --- who else writes ---------------------------------------------------------------------------


@pytest.mark.parametrize("links", [True, False])
def test_a_file_written_meanwhile_stays(tmp_path, monkeypatch, links):
    def meanwhile(_):
        (tmp_path / "b").write_text("precious")

    def no_links(*_):
        raise OSError(errno.EPERM, "Operation not permitted")

    monkeypatch.setattr(os, "fsync", meanwhile)
    if not links:
        monkeypatch.setattr(os, "link", no_links)
    with pytest.raises(pj.OutputError, match="b: exists already, since just now"):
        write_files({tmp_path / "a": b"a", tmp_path / "b": b"b"}, replace=False)
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"b": "precious"}


@pytest.mark.parametrize("links", [True, False])
def test_of_many_writers_one_succeeds(tmp_path, monkeypatch, links):
    """And both files are that one's."""

    def no_links(*_):
        raise OSError(errno.EPERM, "Operation not permitted")

    if not links:
        monkeypatch.setattr(os, "link", no_links)
    start = threading.Barrier(8)

    def write(number):
        content = f"{number}".encode()
        start.wait()
        try:
            write_files({tmp_path / "a": content, tmp_path / "b": content}, replace=False)
        except pj.OutputError:
            return None
        return content

    with ThreadPoolExecutor(8) as pool:
        written = [content for content in pool.map(write, range(8)) if content is not None]
    assert len(written) == 1
    assert [(tmp_path / name).read_bytes() for name in "ab"] == [written[0]] * 2
    assert names(tmp_path) == ["a", "b"]


def test_what_somebody_else_put_there_is_not_taken_back(tmp_path, monkeypatch):
    move, (first, second) = type(tmp_path).replace, (tmp_path / "a", tmp_path / "b")

    def failing(self, place):
        if place == second:
            first.unlink()
            first.write_text("precious")
            raise OSError(errno.EIO, "Input/output error")
        return move(self, place)

    monkeypatch.setattr(type(tmp_path), "replace", failing)
    with pytest.raises(pj.OutputError):
        write_files({first: b"a", second: b"b"})
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"a": "precious"}


# --- signals -----------------------------------------------------------------------------------

_KILLED = """
import os, signal, sys
from pmjac_pin.files import output_file
sync = os.fsync
def killed(descriptor):
    sync(descriptor)
    os.kill(os.getpid(), {signal})
os.fsync = killed
output_file.write_files({{name: b"new" for name in ("a", "b")}})
print("not reached")
"""


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_signals_leave_no_hidden_files(tmp_path, number):
    (tmp_path / "a").write_text("old")
    done = subprocess.run(
        [sys.executable, "-c", _KILLED.format(signal=int(number))],
        check=False,
        cwd=tmp_path,
        capture_output=True,
        timeout=60,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )
    assert b"not reached" not in done.stdout
    assert done.returncode == -number
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"a": "new", "b": "new"}


def test_ctrl_c_comes_once_all_is_written(tmp_path, monkeypatch):
    sync = os.fsync

    def interrupted(descriptor):
        sync(descriptor)
        signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(os, "fsync", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_file(tmp_path / "a", b"new")
    assert names(tmp_path) == ["a"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_in_another_thread_signals_are_left_alone(tmp_path):
    with ThreadPoolExecutor(1) as pool:
        pool.submit(write_file, tmp_path / "a", b"new").result()
    assert names(tmp_path) == ["a"]


# --- the command line --------------------------------------------------------------------------


def test_commands_ask_first_whether_they_may_write(tmp_path, monkeypatch, capsys):
    """A search may take minutes."""
    monkeypatch.setattr("pmjac_pin.cli.modes.Search.report", lambda *_: pytest.fail("searched"))
    assert main(["modes", "four_bar", "-o", str(tmp_path / "none" / "x.png")]) == 2
    assert "there is no folder" in capsys.readouterr().err
    assert main(["modes", "four_bar", "-o", str(tmp_path / "x.txt")]) == 2
    assert "its suffix must be one of" in capsys.readouterr().err


def test_an_output_without_a_name(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for command in ("convert", "plot", "modes"):
        assert main([command, "serial_2r", "-o", ""]) == 2
        assert capsys.readouterr().err.count("\n") == 1
    assert names(tmp_path) == []


def test_all_writing_is_done_in_one_place():
    """Nothing else of the package opens a file to write to it."""
    words = ("write_text(", "write_bytes(", "mkstemp", "TemporaryDirectory(")
    for path in Path(output_file.__file__).parent.rglob("*.py"):
        lines = [line.strip() for line in path.read_text(encoding="utf-8").splitlines()]
        code = [line for line in lines if not line.startswith(">>>")]
        assert not [line for line in code for word in words if word in line], path
