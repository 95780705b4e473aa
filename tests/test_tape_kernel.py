"""The kernel computes what NumPy does, to rounding, whatever the instruction and the numbers."""

from __future__ import annotations

import importlib.util
import shutil
from pathlib import Path

import numpy as np
import pytest

import pmjac_pin as pj
from pmjac_pin.algebra import numpy_tape
from pmjac_pin.algebra.programs import Recording, largest, root, with_sign
from pmjac_pin.algebra.tape import INSTRUCTIONS, Tape
from pmjac_pin.algebra.tape_runner import loaded, run_in

ROOT = Path(__file__).resolve().parent.parent
SOURCE = ROOT / "pmjac_pin" / "algebra" / "tape_kernel.c"


@pytest.fixture(scope="module")
def hatch_build():
    pytest.importorskip("hatchling")
    spec = importlib.util.spec_from_file_location("hatch_build", ROOT / "hatch_build.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def build(hatch_build):
    return hatch_build.build


@pytest.fixture(scope="module")
def kernel(build, tmp_path_factory):
    if shutil.which("cc") is None:
        pytest.skip("no C compiler")
    built = tmp_path_factory.mktemp("kernel") / "kernel.so"
    assert build(built, SOURCE) == ""
    library = loaded(built, SOURCE)
    assert library is not None
    return library


def everything():
    """A program that has every instruction."""
    recording = Recording(3)
    x, y, z = recording.inputs
    term = recording.term
    outputs = [
        *(x * y + z, y * z - x, y - x * z, x + y, x - y, x * x, x / y, -x),
        *(term("sin", x), term("cos", x), root(abs(x)), largest(x, y), with_sign(x, y)),
        *(term("atan2", x, y), term("round", x), 2.5),
    ]
    return Tape.of(recording, outputs)


@pytest.mark.parametrize("count", [0, 1, 31, 32, 33, 1000])
@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3, 1e4, 1e7])
def test_every_instruction(kernel, count, size, rng):
    tape = everything()
    assert set(tape.code[:, 0].tolist()) == set(range(len(INSTRUCTIONS)))
    values = size * rng.normal(size=(3, count))
    expected = numpy_tape.run(tape, values)
    found = run_in(kernel, tape, values)
    # A product may be rounded before something is added to it, or not.
    np.testing.assert_allclose(found[:8], expected[:8], rtol=1e-15, atol=1e-15 * size**2)
    np.testing.assert_allclose(found[8:10], expected[8:10], rtol=0.0, atol=5e-16)
    np.testing.assert_allclose(found[10:], expected[10:], rtol=1e-15)


def test_what_is_no_number_stays_none(kernel):
    recording = Recording(2)
    x, y = recording.inputs
    sine = recording.term("sin", x)
    tape = Tape.of(recording, [x + y, largest(x, y), root(x), sine])
    values = np.array([[np.nan, 1.0, -1.0, np.inf], [1.0, np.nan, 1.0, 1.0]])
    expected, found = numpy_tape.run(tape, values), run_in(kernel, tape, values)
    np.testing.assert_array_equal(np.isnan(found), np.isnan(expected))


@pytest.mark.parametrize("name", ["five_bar", "three_rps", "agile_eye", "stewart_gough"])
def test_of_mechanisms(kernel, name, rng):
    many = pj.batch(pj.load(name))
    walker, nq = many._walker, many.mechanism.nq
    motors = len(many.mechanism.actuated)
    values = np.concatenate([many.mechanism.home.q, np.full(motors, 0.1)])[:, None]
    values = np.repeat(values, 100, axis=1)
    values[:nq] += 1e-6 * rng.normal(size=(nq, 100))
    expected = numpy_tape.run(walker.point, values)
    found = run_in(kernel, walker.point, values)
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12)


def test_what_was_built_from_another_source_is_not_loaded(kernel, build, tmp_path):
    other = tmp_path / "other.c"
    other.write_text(SOURCE.read_text() + "\n/* changed */\n")
    built = tmp_path / "kernel.so"
    assert build(built, SOURCE) == ""
    assert loaded(built, other) is None
    assert loaded(tmp_path / "none.so", SOURCE) is None
    (tmp_path / "broken.so").write_bytes(built.read_bytes()[:500])
    assert loaded(tmp_path / "broken.so", SOURCE) is None


def test_without_a_compiler_it_is_said(build, tmp_path, monkeypatch):
    monkeypatch.setenv("CC", str(tmp_path / "nothing"))
    assert "nothing" in build(tmp_path / "kernel.so", SOURCE)
    assert not list(tmp_path.iterdir())


def test_kernels_compile_without_warnings(hatch_build, tmp_path, monkeypatch):
    if shutil.which("cc") is None:
        pytest.skip("no C compiler")
    monkeypatch.setenv("CC", "cc -Wall -Wextra -Werror -O0")
    for built, sources in hatch_build.KERNELS.items():
        target = tmp_path / Path(built).name
        paths = [ROOT / "pmjac_pin" / source for source in sources]
        assert hatch_build.build(target, *paths) == ""
        assert loaded(target, *paths) is not None
