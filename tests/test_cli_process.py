"""The command line as a process of its own: pipes, encodings, interrupts."""

from __future__ import annotations

import os
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parent.parent
COLORS = ("NO_COLOR", "FORCE_COLOR", "TTY_COMPATIBLE")
ENVIRONMENT = {key: value for key, value in os.environ.items() if key not in COLORS}
ENVIRONMENT["PYTHONPATH"] = str(ROOT)


def process(*argv, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **environment):
    """Run as a process of its own, from an unrelated folder."""
    return subprocess.run(
        [sys.executable, "-m", "pmjac_pin", *argv],
        stdout=stdout,
        stderr=stderr,
        env={**ENVIRONMENT, **environment},
        cwd=os.sep,
        check=False,
    )


def test_as_a_module():
    done = process("report", "three_rps_ss", "--from", "lecture_b")
    assert (done.returncode, done.stderr) == (0, b"")
    assert b"2.3429" in done.stdout
    assert b"\x1b" not in done.stdout
    done = process("report", "nope")
    assert (done.returncode, done.stdout) == (2, b"")
    assert done.stderr.startswith(b"pmjac: unknown mechanism 'nope'")


@pytest.mark.slow
@pytest.mark.parametrize(
    "environment",
    [{"LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0"}, {"PYTHONIOENCODING": "ascii"}],
)
def test_without_unicode(environment):
    done = process("report", "three_rps_ss", **environment)
    assert (done.returncode, done.stderr) == (0, b"")
    assert done.stdout.isascii()
    assert b"K* = d eta/d phi" in done.stdout


def test_a_reader_that_leaves_early():
    arguments = [sys.executable, "-m", "pmjac_pin", "report", "three_rps"]
    child = subprocess.Popen(
        arguments,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=ENVIRONMENT,
    )
    child.stdout.close()
    with child.stderr:
        assert child.stderr.read() == b""
    assert child.wait() == 0


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
def test_an_output_that_is_full():
    with Path("/dev/full").open("wb") as full:
        done = process("report", "serial_2r", stdout=full)
    assert (done.returncode, done.stderr) == (2, b"pmjac: No space left on device\n")


def test_an_output_that_is_closed():
    command = shlex.join([sys.executable, "-m", "pmjac_pin", "report", "serial_2r"])
    done = subprocess.run(
        ["sh", "-c", f"{command} >&-"],
        capture_output=True,
        env=ENVIRONMENT,
        cwd=os.sep,
        check=False,
    )
    message = b"pmjac: standard output: Bad file descriptor\n"
    assert (done.returncode, done.stderr) == (2, message)


def test_ctrl_c_in_a_process():
    # The child says when it is past its imports, and then waits to be interrupted.
    code = (
        "import sys, time, pmjac_pin.cli as cli, pmjac_pin.cli.options as options\n"
        "options.load = lambda *a, **k: (print('ready', flush=True), time.sleep(60))\n"
        "sys.exit(cli.main(['report', 'four_bar']))\n"
    )
    child = subprocess.Popen(
        [sys.executable, "-c", code],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=ENVIRONMENT,
    )
    with child.stdout, child.stderr:
        assert child.stdout.readline() == b"ready\n"
        time.sleep(0.1)
        child.send_signal(signal.SIGINT)
        assert child.stderr.read() == b""
    assert child.wait() == 130


WHEN = np.random.default_rng(0).uniform(0.005, 1.5, 28)  # seconds after `main` is there


@pytest.mark.parametrize(
    "when",
    [*WHEN[:4], *(pytest.param(when, marks=pytest.mark.slow) for when in WHEN[4:])],
)
def test_ctrl_c_at_any_time(when):
    """While it imports, works, writes and ends: nothing on stderr, and no other status."""
    code = (
        "import sys; from pmjac_pin.cli import main; print('ready', flush=True);"
        "sys.argv[1:] = ['report', 'four_bar']; sys.exit(main())"
    )
    child = subprocess.Popen(
        [sys.executable, "-c", code],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=ENVIRONMENT,
    )
    with child.stdout, child.stderr:
        assert child.stdout.readline() == b"ready\n"
        time.sleep(when)
        child.send_signal(signal.SIGINT)
        out = child.stdout.read()
        assert child.stderr.read() == b""
    assert child.wait() in ((130,) if not out else (0, 130))


def test_what_ctrl_c_does_not_concern_stays_so():
    """As in the background of a script, which shells start with it ignored."""
    code = "import signal; print(signal.getsignal(signal.SIGINT) == signal.SIG_IGN)"
    ignoring = (
        "import signal, sys; signal.signal(signal.SIGINT, signal.SIG_IGN);"
        "sys.argv[1:] = ['report', 'nope']; from pmjac_pin.cli import main; main();" + code
    )
    done = subprocess.run(
        [sys.executable, "-c", ignoring], capture_output=True, env=ENVIRONMENT, check=False
    )
    assert done.stdout == b"True\n"


def test_the_entry_point_imports_nothing_heavy():
    code = (
        "import sys; before = set(sys.modules); from pmjac_pin.cli import main;"
        "print(*sorted(set(sys.modules) - before))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, env=ENVIRONMENT, check=True
    )
    new = {name for name in done.stdout.split() if not name.startswith(b"importlib")}
    ours = {b"pmjac_pin", b"pmjac_pin.cli", b"pmjac_pin.cli.exit_status", b"pmjac_pin.cli.process"}
    assert new <= ours | {b"signal", b"enum", b"types", b"operator", b"functools", b"warnings"}


@pytest.mark.parametrize("columns", ["0", "-3", "1000000000"])
def test_any_width_shows_all(columns):
    done = process("report", "serial_2r", COLUMNS=columns)
    assert (done.returncode, done.stderr) == (0, b"")
    words = b"".join(done.stdout.split())
    assert b"serial_2r,posehome" in words
    assert len(words) > 1000
    assert len(done.stdout) < 50_000


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
def test_an_error_output_that_is_full():
    with Path("/dev/full").open("wb") as full:
        done = process("report", "nope", stderr=full)
        assert (done.returncode, done.stdout) == (2, b"")
        assert process("report", "serial_2r", stdout=full, stderr=full).returncode == 2


def test_an_error_output_that_nobody_reads():
    reader, writer = os.pipe()
    os.close(reader)
    with os.fdopen(writer, "wb") as nobody:
        assert process("report", "nope", stderr=nobody).returncode == 2


def test_matplotlib_is_imported_only_to_draw():
    code = (
        "import sys, pmjac_pin.cli as cli; cli.main(['report', 'serial_2r']); "
        "sys.exit('matplotlib' in sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, env=ENVIRONMENT, check=False
    )
    assert done.returncode == 0
