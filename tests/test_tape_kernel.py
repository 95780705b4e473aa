"""The kernel computes what NumPy does, to rounding, whatever the instruction and the numbers."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

import pmjac_pin as pj
from pmjac_pin.algebra import numpy_tape
from pmjac_pin.algebra.c_kernels import loaded
from pmjac_pin.algebra.programs import largest, root, with_sign
from pmjac_pin.algebra.singular_values import VALUES_TAKE, singular_values, values_in
from pmjac_pin.algebra.tape import INSTRUCTIONS, Tape
from pmjac_pin.algebra.tape_runner import TAPE_TAKES, run_in
from pmjac_pin.algebra.terms import Recording

ROOT = Path(__file__).resolve().parent.parent
ALGEBRA = ROOT / "pmjac_pin" / "algebra"
SOURCES = (ALGEBRA / "tape_kernel.c", ALGEBRA / "lanes.h")


@pytest.fixture(scope="module")
def build(hatch_build):
    return hatch_build.build


@pytest.fixture(scope="module")
def kernel(build, tmp_path_factory):
    if shutil.which("cc") is None:
        pytest.skip("no C compiler")
    built = tmp_path_factory.mktemp("kernel") / "kernel.so"
    assert build(built, *SOURCES) == ""
    library = loaded(built, *SOURCES, pmjac_run_tape=TAPE_TAKES)
    assert library is not None
    return library


@pytest.fixture(scope="module")
def values_kernel(build, tmp_path_factory):
    if shutil.which("cc") is None:
        pytest.skip("no C compiler")
    sources = (ALGEBRA / "singular_values.c", ALGEBRA / "lanes.h")
    built = tmp_path_factory.mktemp("values") / "kernel.so"
    assert build(built, *sources) == ""
    return loaded(built, *sources, pmjac_singular_values=VALUES_TAKE)


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


def sums(begins, products):
    """Products that are added to something one after the other, or taken from it."""
    recording = Recording(4)
    x, y, z, w = recording.inputs
    outputs = []
    for sign in (1.0, -1.0):
        total = {"a product": z * w, "a sum": z * w + x, "a difference": z * w - y, "": w}[begins]
        for k in range(products):
            total = total + sign * ((x + float(k)) * (y - float(k)))
        outputs.append(total)
    return Tape.of(recording, outputs)


def test_processors_of_one_kind_have_the_same_bits(kernel, hatch_build, monkeypatch, tmp_path, rng):
    """What is built without versions for newer processors has the instructions of the oldest."""
    monkeypatch.setattr(hatch_build, "OPTIONS", (*hatch_build.OPTIONS, "-DFOR_EACH_PROCESSOR="))
    assert hatch_build.build(tmp_path / "old.so", *SOURCES) == ""
    old = loaded(tmp_path / "old.so", *SOURCES, pmjac_run_tape=TAPE_TAKES)
    for tape in (everything(), *(sums(begins, 8) for begins in ("a product", "a sum", ""))):
        values = 10.0 * rng.normal(size=(tape.inputs, 200))
        np.testing.assert_array_equal(run_in(old, tape, values), run_in(kernel, tape, values))


@pytest.mark.parametrize("products", range(9))
@pytest.mark.parametrize("begins", ["a product", "a sum", "a difference", ""])
def test_sums_of_products(kernel, begins, products, rng):
    tape, inputs = sums(begins, products), rng.normal(size=(4, 130))
    found, expected = run_in(kernel, tape, inputs), numpy_tape.run(tape, inputs)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-14 * (1.0 + products**3))


@pytest.mark.parametrize("factors", [(3, 1), (1, 3), (3, 3)])
@pytest.mark.parametrize("name", ["muladd", "submul"])
def test_a_sum_may_be_a_factor_of_what_is_added_to_it(kernel, name, factors, rng):
    number = {name: k for k, name in enumerate(INSTRUCTIONS)}
    rows = [("load", 1, 0), ("load", 2, 1), ("load", 3, 2), (name, 3, 1, 2, 3)]
    rows += [(name, 3, *factors, 3), (name, 3, 1, 2, 3), ("store", 0, 3)]
    code = [[number[first], *more, *(0,) * (4 - len(more))] for first, *more in rows]
    tape = Tape(np.array(code, dtype=np.int32), np.zeros(1), slots=4, inputs=3, outputs=1)
    inputs = rng.normal(size=(3, 70))
    found, expected = run_in(kernel, tape, inputs), numpy_tape.run(tape, inputs)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-12)


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
    walker, nq = many._closing.walker, many.mechanism.nq
    others = walker.arrival.inputs - nq
    values = np.concatenate([many.mechanism.home.q, np.linspace(0.0, 0.1, others)])[:, None]
    values = np.repeat(values, 100, axis=1)
    values[:nq] += 1e-6 * rng.normal(size=(nq, 100))
    expected = numpy_tape.run(walker.arrival, values)
    found = run_in(kernel, walker.arrival, values)
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12)


SHAPES = [(1, 1), (3, 1), (3, 2), (3, 3), (3, 6), (9, 9), (18, 18), (10, 4), (5, 9), (40, 37)]


@pytest.mark.parametrize("count", [0, 1, 15, 16, 17, 300])
@pytest.mark.parametrize("shape", SHAPES)
def test_singular_values(values_kernel, shape, count, rng):
    """Nearly dependent, alike, tiny and vanishing rows and columns among them."""
    matrices = rng.normal(size=(*shape, count))
    matrices[:, :, ::7] *= 1e-12
    matrices[0, :, 1::5] = matrices[-1, :, 1::5]
    matrices[:, -1, ::5] = matrices[:, 0, ::5]
    matrices[0, :, ::11] = matrices[-1, :, ::11] + 1e-9 * matrices[0, :, ::11]
    matrices[:, 0, ::13] = 0.0
    matrices[:, :, 3:4] = 0.0
    expected = np.linalg.svd(matrices.transpose(2, 0, 1), compute_uv=False).T
    found = values_in(values_kernel, matrices, range(min(shape)))
    assert found.shape == expected.shape
    off = np.abs(found - expected)
    assert (off <= 3e-15 * max(shape) * expected[:1]).all()


@pytest.mark.parametrize("shape", [(3, 4), (18, 18)])
def test_singular_values_at_some_places(values_kernel, shape, rng):
    matrices = rng.normal(size=(*shape, 20))
    every = values_in(values_kernel, matrices, range(min(shape)))
    some = values_in(values_kernel, matrices, (2, 0))
    np.testing.assert_array_equal(some, every[[2, 0]])
    np.testing.assert_allclose(singular_values(matrices, (2, 0)), some, rtol=1e-12)


@pytest.mark.parametrize("apart", [0.0, 1e-14, 1e-10, 1e-6, 1e-3, 1e-2])
def test_singular_values_that_are_near_each_other(values_kernel, apart, rng):
    """Where Newton's method is slow; and what is beside them is not touched by that."""
    count, size = 64, 9
    left, right = (np.linalg.qr(rng.normal(size=(count, size, size)))[0] for _ in range(2))
    values = np.sort(rng.uniform(0.1, 1.0, (count, size)))[:, ::-1]
    values[::3] = 1.0 - apart * np.arange(size)
    values[1::3, -2:] = [1e-7 * (1.0 + apart), 1e-7]
    matrices = ((left * values[:, None]) @ right).transpose(1, 2, 0)
    expected = np.linalg.svd(matrices.transpose(2, 0, 1), compute_uv=False).T
    found = values_in(values_kernel, matrices, range(size))
    assert (np.abs(found - expected) <= 3e-15 * size * expected[:1]).all()
    for k in range(0, count, 5):
        alone = values_in(values_kernel, matrices[:, :, k : k + 1], range(size))
        np.testing.assert_array_equal(found[:, k], alone[:, 0])


@pytest.mark.parametrize("size", [1e-305, 1e-200, 1e-100, 1e-30, 1e30, 1e100, 1e305])
@pytest.mark.parametrize("vectors", [3, 9])
def test_singular_values_of_any_size(values_kernel, vectors, size, rng):
    matrices = size * rng.normal(size=(vectors, 9, 20))
    expected = np.linalg.svd(matrices.transpose(2, 0, 1), compute_uv=False).T
    found = values_in(values_kernel, matrices, range(vectors))
    np.testing.assert_allclose(found, expected, atol=3e-14 * expected[0].max(), rtol=0.0)


def test_small_singular_values_of_few_are_exact_beside_their_columns(values_kernel, rng):
    """Which those of LAPACK are not: columns of unlike size, otherwise well apart."""
    scale = 10.0 ** -np.arange(0.0, 20.0, 5.0)
    turned = np.linalg.qr(rng.normal(size=(4, 4)))[0]
    found = values_in(values_kernel, (scale[:, None] * turned)[:, :, None], range(4))
    np.testing.assert_allclose(found[:, 0], scale, rtol=1e-14)


@pytest.mark.parametrize("by_kernel", [True, False])
def test_singular_values_of_what_is_no_number(by_kernel, monkeypatch):
    if not by_kernel:
        monkeypatch.setattr("pmjac_pin.algebra.singular_values.values_kernel", lambda: None)
    matrices = np.ones((2, 3, 3))
    matrices[0, 0, 1], matrices[1, 2, 2] = np.nan, np.inf
    found = singular_values(matrices)
    np.testing.assert_allclose(found[:, 0], [6.0**0.5, 0.0], atol=1e-15)
    assert np.isnan(found[:, 1:]).all()


def test_what_was_built_from_another_source_is_not_loaded(kernel, build, tmp_path):
    other = tmp_path / "other.c"
    other.write_text(SOURCES[0].read_text() + "\n/* changed */\n")
    built = tmp_path / "kernel.so"
    assert build(built, *SOURCES) == ""
    with pytest.warns(RuntimeWarning, match="built from other sources"):
        assert loaded(built, other, SOURCES[1]) is None
    assert loaded(tmp_path / "none.so", *SOURCES) is None
    (tmp_path / "broken.so").write_bytes(built.read_bytes()[:500])
    assert loaded(tmp_path / "broken.so", *SOURCES) is None


def test_without_a_compiler_it_is_said(build, tmp_path, monkeypatch):
    monkeypatch.setenv("CC", str(tmp_path / "nothing"))
    assert "nothing" in build(tmp_path / "kernel.so", *SOURCES)
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_kernels_compile_without_warnings(hatch_build, tmp_path, monkeypatch):
    if shutil.which("cc") is None:
        pytest.skip("no C compiler")
    monkeypatch.setenv("CC", "cc -Wall -Wextra -Werror -O0")
    for built, sources in hatch_build.KERNELS.items():
        target = tmp_path / Path(built).name
        paths = [ROOT / "pmjac_pin" / source for source in sources]
        assert hatch_build.build(target, *paths) == ""
        assert loaded(target, *paths) is not None
