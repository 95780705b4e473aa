"""What a program computes, as it is and as text in three languages, is what the library says."""

from __future__ import annotations

import ctypes
import shutil
import subprocess

import numpy as np
import pytest
from mechanisms import CATALOGUE, PARAMETRISED, loaded, mostly_slow

import pmjac_pin as pj

OPTIONS = ("-Wall", "-Wextra", "-Werror", "-pedantic", "-std=c99", "-O1", "-shared", "-fPIC")
FRAMES = ("LOCAL_WORLD_ALIGNED", "LOCAL", "WORLD")
DIFFERENT = ("five_bar", "three_rps_ss", "delta", "agile_eye")


def poses(mechanism, rng):
    """Home, and a few closed poses around it."""
    slides = [mechanism.units[motor] == "m" for motor in mechanism.actuated]
    size = 0.03 * np.where(slides, mechanism.characteristic_length, 1.0)
    targets = mechanism.home.actuated + size * rng.uniform(-1, 1, (3, size.size))
    return [mechanism.home, *(mechanism.close(one, enforce_limits=False) for one in targets)]


def check(found, configuration, frame="LOCAL_WORLD_ALIGNED"):
    """Compare with what the single pose says."""
    jacobian = configuration.jacobian(frame)
    partition, whole = jacobian.partition, jacobian.constraint_jacobian
    length = max(configuration.mechanism.characteristic_length, 1.0)
    for name, expected in (
        ("eta", configuration.residual),
        ("K", whole[:, partition.actuated]),
        ("K_star", whole[:, partition.passive]),
        ("J_eq", jacobian.J_eq),
    ):
        np.testing.assert_allclose(found[name], expected, atol=1e-9 * length, rtol=1e-9)
    if not partition.passive_rank:
        assert "sigma" not in found
        return
    for doubt in ("forbidden", "felt"):
        assert abs(found.get(doubt, np.zeros(1))[0]) < 1e-9 * length
    scaled = partition.scaled(whole)[:, partition.passive]
    sizes = np.linalg.svd(scaled, compute_uv=False)[: partition.passive_rank]
    assert 0.0 < found["sigma"][0] <= sizes.min() * (1 + 1e-9)


def in_c(recorded, folder):
    """Compile a function and return it as one of q."""
    source, library = folder / "program.c", folder / "program.so"
    source.write_text(recorded.c("written"))
    subprocess.run(["cc", *OPTIONS, str(source), "-o", str(library), "-lm"], check=True)
    function = ctypes.CDLL(str(library)).written

    def at(*given):
        found = {key: np.full(array.shape, np.nan) for key, array in recorded.outputs.items()}
        arrays = [*map(np.ascontiguousarray, given), *(one for one in found.values() if one.size)]
        function(*(array.ctypes.data_as(ctypes.c_void_p) for array in arrays))
        return found

    return at


def in_python(text):
    names = {}
    exec(compile(text, "written", "exec"), names)
    return names["written"]


@pytest.mark.parametrize("name", mostly_slow(CATALOGUE))
def test_of_every_mechanism(name, rng):
    mechanism = loaded(name)
    recorded, many = pj.program(mechanism), poses(mechanism, rng)
    assert len(recorded.inputs) == mechanism.nq
    together = recorded([pose.q for pose in many])
    written = in_python(recorded.numpy("written"))(np.array([pose.q for pose in many]))
    for k, configuration in enumerate(many):
        check({key: array[k] for key, array in together.items()}, configuration)
        check({key: array[k] for key, array in written.items()}, configuration)


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler here")
@pytest.mark.parametrize("name", mostly_slow(CATALOGUE))
def test_in_c(name, rng, tmp_path):
    mechanism = loaded(name)
    function = in_c(pj.program(mechanism), tmp_path)
    for configuration in poses(mechanism, rng):
        check(function(configuration.q), configuration)


@pytest.mark.slow
@pytest.mark.parametrize("name", DIFFERENT)
def test_in_jax(name, rng):
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    mechanism = loaded(name)
    function = jax.jit(in_python(pj.program(mechanism).jax("written")))
    for configuration in poses(mechanism, rng):
        check(function(configuration.q), configuration)


@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.parametrize("name", DIFFERENT)
def test_in_every_frame(name, frame, rng):
    mechanism = loaded(name)
    recorded = pj.program(mechanism, frame)
    for configuration in poses(mechanism, rng):
        check(recorded(configuration.q), configuration, frame)


def designs(mechanism, rng):
    """A few machines of lengths within 3 % that have a Jacobian, and these lengths."""
    for _ in range(3):
        values = {
            name: value + 0.03 * (abs(value) or 0.1) * rng.uniform(-1.0, 1.0)
            for name, value in mechanism.parameters.items()
        }
        machine = mechanism.with_parameters(values)
        try:
            machine.home.jacobian()
        except pj.NoJacobianError:  # a spatial loop of four hinges moves with special lengths alone
            continue
        yield machine, np.array(list(values.values()))


@pytest.mark.parametrize("name", mostly_slow(PARAMETRISED))
def test_of_every_mechanism_with_parameters(name, rng, tmp_path):
    mechanism = loaded(name)
    recorded = pj.program(mechanism, parameters=mechanism.parameters)
    assert recorded.parameters == tuple(mechanism.parameters)
    written = in_python(recorded.numpy("written"))
    functions = [recorded, lambda *given: written(*map(np.asarray, given))]
    if shutil.which("cc") is not None:
        functions.append(in_c(recorded, tmp_path))
    for machine, values in designs(mechanism, rng):
        for configuration in poses(machine, rng):
            for function in functions:
                found = dict(function(configuration.q, values))
                if "sigma" in found:  # by the scales of one of the machines: it bounds no other's
                    found["sigma"] = 1e-9 * found["sigma"]
                check(found, configuration)


def test_parameters_that_are_not_named_stay(rng):
    mechanism = loaded("four_bar").with_parameters(l2=3.2)
    recorded = pj.program(mechanism, parameters=["l3", "l1"])
    poses, lengths = np.tile(mechanism.home.q, (4, 1)), rng.uniform(0.9, 1.1, (3, 1, 2)) * [3.5, 1]
    found = recorded(poses, lengths)
    assert found["eta"].shape == (3, 4, 3)
    written = in_python(recorded.numpy("written"))(poses, lengths)
    np.testing.assert_allclose(found["eta"], written["eta"], atol=1e-14)
    own = recorded(mechanism.home.q)
    np.testing.assert_allclose(own["J_eq"], mechanism.home.jacobian().J_eq, atol=1e-13)
    # Of the residual by hand: the crank's and the coupler's tip against the rocker's.
    angles, (l3, l1) = dict(zip(recorded.inputs, mechanism.home.q, strict=True)), lengths[1, 0]
    coupler = np.exp(1j * (angles["theta1"] + angles["phi2"]))
    gap = l1 * np.exp(1j * angles["theta1"]) + 3.2 * coupler - 4.0
    gap -= l3 * np.exp(1j * angles["phi1"])
    np.testing.assert_allclose(found["eta"][1, 2], [gap.real, gap.imag, 0.0], atol=1e-13)


def test_parameters_that_there_are_none_of():
    mechanism = loaded("four_bar")
    with pytest.raises(pj.UnknownNameError, match="did you mean 'l1'"):
        pj.program(mechanism, parameters=["l11"])
    with pytest.raises(pj.ArgumentError, match="one twice"):
        pj.program(mechanism, parameters=["l1", "l1"])
    with pytest.raises(pj.ArgumentError, match="a list of names"):
        pj.program(mechanism, parameters="l1")
    recorded = pj.program(mechanism, parameters=["l1", "l2"])
    with pytest.raises(pj.ArgumentError, match=r"parameters of shape \(\.\.\., 2\) expected"):
        recorded(mechanism.home.q, [1.0])
    with pytest.raises(pj.ArgumentError, match="as many designs as poses expected, or one"):
        recorded(np.tile(mechanism.home.q, (4, 1)), np.ones((3, 2)))


def test_where_there_is_no_jacobian():
    over = pj.load("five_bar", actuated=["theta1", "theta2", "phi1"])
    with pytest.raises(pj.ForbiddenRatesError):
        pj.program(over)
    with pytest.raises(pj.ArgumentError, match="frame must be"):
        pj.program(loaded("four_bar"), "base")


@pytest.mark.parametrize("name", ["1st", "a b", "", 3, "\u00e9"])
def test_names_that_no_function_has(name):
    recorded = pj.program(loaded("four_bar"))
    for write in (recorded.c, recorded.numpy, recorded.jax):
        with pytest.raises(pj.ArgumentError, match="a function's name is letters, digits and _"):
            write(name)


def test_names_that_are_words():
    recorded = pj.program(loaded("four_bar"))
    with pytest.raises(pj.ArgumentError, match="'double' is a word of the language"):
        recorded.c("double")
    with pytest.raises(pj.ArgumentError, match="'lambda' is a word of the language"):
        recorded.numpy("lambda")


@pytest.mark.parametrize("shape", [(), (2,), (5, 2)])
def test_poses_of_another_shape(shape):
    with pytest.raises(pj.ArgumentError, match=r"q of shape \(\.\.\., 3\) expected"):
        pj.program(loaded("four_bar"))(np.zeros(shape))
