"""The cache of compiled programs: nobody else leads to it, and what was checked is loaded."""

from __future__ import annotations

import os
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from test_tape_kernel import everything

import pmjac_pin as pj
from pmjac_pin.algebra import compiled_programs
from pmjac_pin.algebra.compiled_cache import cache_folder, keep, whole
from pmjac_pin.algebra.compiled_programs import CompiledProgram
from pmjac_pin.algebra.tape_runner import run, tape_kernel

OTHER = os.geteuid() + 12345
needs_cc = pytest.mark.skipif(
    shutil.which("cc") is None or tape_kernel() is None, reason="no C compiler"
)


@pytest.fixture
def base(tmp_path, monkeypatch):
    """What XDG_CACHE_HOME names, the user's alone, and not there yet."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "base"))
    return tmp_path / "base"


@pytest.fixture
def give_away(monkeypatch):
    """Make a place another user's: in fact where that is allowed, else by what is told of it."""
    given, told = set(), Path.lstat

    def lstat(place):
        known = told(place)
        return os.stat_result([*known[:4], OTHER, *known[5:]]) if place in given else known

    monkeypatch.setattr(Path, "lstat", lstat)

    def give(place):
        if os.geteuid() == 0:
            os.lchown(place, OTHER, OTHER)
        given.add(place)

    return give


def folder(place, mode=0o700):
    place.mkdir(parents=True)
    place.chmod(mode)
    return place


def link(place, target):
    place.parent.mkdir(parents=True, exist_ok=True)
    place.symlink_to(target)
    return place


REFUSED = {
    "another user's folder": (
        lambda base, give: give(folder(base / "pmjac_pin")),
        "pmjac_pin: this folder is another user's",
    ),
    "in another user's folder": (
        lambda base, give: (folder(base / "pmjac_pin"), give(base)),
        "base: this folder is another user's",
    ),
    "in a folder that others write to": (
        lambda base, give: folder(base, 0o777),
        "base: others may write to this folder",
    ),
    "in a folder that the group writes to": (
        lambda base, give: folder(base, 0o770),
        "base: others may write to this folder",
    ),
    "sticky itself": (
        lambda base, give: folder(base / "pmjac_pin", 0o1777),
        "pmjac_pin: others may write to this folder",
    ),
    "another user's link": (
        lambda base, give: give(link(base / "pmjac_pin", folder(base / "mine"))),
        "pmjac_pin: this link is another user's",
    ),
    "another user's link in /tmp": (
        lambda base, give: give(link(folder(base, 0o1777) / "pmjac_pin", folder(base / "mine"))),
        "pmjac_pin: this link is another user's",
    ),
    "another user's link on the way": (
        lambda base, give: give(link(base, folder(base.with_name("mine")))),
        "base: this link is another user's",
    ),
    "by another user's link": (
        lambda base, give: (
            link(base / "pmjac_pin", base / "second"),
            give(link(base / "second", folder(base / "mine"))),
        ),
        "second: this link is another user's",
    ),
    "a link to where others write": (
        lambda base, give: link(base / "pmjac_pin", folder(base / "open", 0o777)),
        "open: others may write to this folder",
    ),
    "a link into where others write": (
        lambda base, give: (
            link(base / "pmjac_pin", Path("open", "mine")),
            (folder(base / "open" / "mine"), (base / "open").chmod(0o777)),
        ),
        "open: others may write to this folder",
    ),
}


@pytest.mark.parametrize("how", REFUSED)
def test_what_others_lead_to_is_refused(base, give_away, how):
    prepare, told = REFUSED[how]
    prepare(base, give_away)
    with pytest.raises(pj.OutputError, match=f"{told}, so no compiled program in it is run"):
        cache_folder()


ACCEPTED = {
    "nothing there": lambda base: None,
    "others may read": lambda base: folder(base / "pmjac_pin", 0o755),
    "a link of the user's": lambda base: link(base / "pmjac_pin", folder(base / "mine")),
    "a relative one": lambda base: link(base / "pmjac_pin", folder(base / "mine").name),
    "in a sticky folder": lambda base: folder(base, 0o1777),
}


@pytest.mark.parametrize("how", ACCEPTED)
def test_what_is_the_users_alone_is_used(base, how):
    ACCEPTED[how](base)
    assert cache_folder() == base / "pmjac_pin"
    assert (base / "pmjac_pin").is_dir()


def test_what_is_made_is_for_no_one_else(base, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(base / "deep" / "deeper"))
    before = os.umask(0)
    try:
        made = cache_folder()
    finally:
        os.umask(before)
    for place in (made, made.parent, made.parent.parent, base):
        assert place.stat().st_mode & 0o077 == 0


def test_the_home_folder_counts_and_what_it_is_in_does_not(tmp_path, monkeypatch):
    """As for the keys of OpenSSH: whoever can exchange a home folder has all that is in it."""
    home = folder(tmp_path / "homes" / "mine")
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setenv("HOME", str(home))
    home.parent.chmod(0o777)
    assert cache_folder() == home / ".cache" / "pmjac_pin"
    home.chmod(0o777)
    with pytest.raises(pj.OutputError, match="mine: others may write to this folder"):
        cache_folder()


def test_without_a_home(monkeypatch):
    def none():
        raise RuntimeError

    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(Path, "home", none)
    with pytest.raises(pj.OutputError, match="set XDG_CACHE_HOME"):
        cache_folder()


def test_what_is_kept_is_whole(base):
    place = cache_folder() / "kept.so"
    contents = keep(b"a program", place)
    assert whole(place) == contents
    place.write_bytes(contents[1:])
    assert whole(place) is None


@needs_cc
def test_what_was_checked_is_what_is_loaded(base, monkeypatch, rng):
    """Between the two, and afterwards, a file becomes another program, and nothing."""
    tape, values = everything(), rng.normal(size=(3, 100))
    expected = run(tape, values)
    CompiledProgram.of(replace(tape, constants=-tape.constants))
    (other,) = cache_folder().glob("*.so")
    other = other.read_bytes()
    program = CompiledProgram.of(tape)
    exchanged = []

    def checked(place):
        contents = whole(place)
        place.write_bytes(other)
        exchanged.append(place)
        return contents

    monkeypatch.setattr(compiled_programs, "whole", checked)
    again = CompiledProgram.of(tape)
    (place,) = exchanged
    place.write_bytes(b"")
    for one in (program, again):
        np.testing.assert_array_equal(one.run(values), expected)
