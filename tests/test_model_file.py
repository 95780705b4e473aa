"""Model files: what is wrong is said in one line with the file, the key and what would be right."""

from __future__ import annotations

import math
import os
import re
import shutil
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.files.catalog import find_model_file
from pmjac_pin.files.model_file import read_model_file

ROOT = Path(__file__).resolve().parent.parent

MODEL = find_model_file("four_bar").read_text()
URDF = (find_model_file("four_bar").parent.parent / "urdf" / "four_bar.urdf").read_text()


@pytest.fixture
def files(tmp_path):
    """A user's own model file and URDF, far from the library."""

    def write(model=MODEL, urdf=URDF):
        (tmp_path / "four_bar.urdf").write_text(urdf)
        path = tmp_path / "mine.toml"
        path.write_text(model)
        return path

    return write


def changed(text, old, new):
    assert text.count(old) >= 1
    return text.replace(old, new, 1)


def test_a_users_own_file(files):
    mechanism = pj.load(files())
    assert mechanism.name == "mine"
    np.testing.assert_array_equal(
        mechanism.home.jacobian().J_eq, loaded("four_bar").home.jacobian().J_eq
    )
    assert pj.load(str(files())) == mechanism


MODEL_ERRORS = {
    "missing urdf": (
        ('urdf = "four_bar.urdf"', 'urdf = "four_baar.urdf"'),
        "{path}: the URDF 'four_baar.urdf' does not exist: neither {folder}/four_baar.urdf nor "
        "{parent}/urdf/four_baar.urdf",
    ),
    "no urdf": (('urdf = "four_bar.urdf"\n', ""), "{path}: missing key `urdf`"),
    "malformed TOML": (
        ("actuated = [", "actuated = [["),
        "{path}: not valid TOML: Unclosed array (at line 4, column 1)",
    ),
    "unknown key": (
        ("actuated =", "actuatd ="),
        "{path}: unknown key `actuatd`; did you mean 'actuated'?",
    ),
    "unknown nested key": (
        ("minimum = 0.001", "minimun = 0.001"),
        "{path}: unknown key `minimun` - at `parameters[...]`; did you mean 'minimum'?",
    ),
    "unknown kind of loop": (
        ('kind = "point"', 'kind = "poimt"'),
        "{path}: Invalid value 'poimt' - at `loop[0].kind`; did you mean 'point'",
    ),
    "a key of one other kind of loop": (
        ('kind = "point"', 'kind = "point"\naxes = [[1, 0, 0], [0, 1, 0]]'),
        "{path}: unknown key `axes` - at `loop[0]`: a key of universal loops; this one is point "
        "and has frames",
    ),
    "a key of other kinds of loop": (
        ('kind = "point"', 'kind = "universal"\naxis = [0, 0, 1]'),
        "{path}: unknown key `axis` - at `loop[0]`: a key of other kinds of loop; this one is "
        "universal and has axes, frames",
    ),
    "a misspelt key of a loop": (
        ('kind = "point"', 'kind = "revolute"\naxes_ = [0, 0, 1]'),
        "{path}: unknown key `axes_` - at `loop[0]`; did you mean 'axis'",
    ),
    "unknown frame in a loop": (
        ("coupler_tip", "coupler_tipp"),
        "{path}: unknown frame 'coupler_tipp'; did you mean 'coupler_tip'",
    ),
    "unknown tool": (
        ("coupler_midpoint", "couplermidpoint"),
        "{path}: unknown frame 'couplermidpoint'; did you mean 'coupler_midpoint'",
    ),
    "unknown motor": (
        ('["theta1"]', '["theta2"]'),
        "{path}: unknown joint 'theta2'; did you mean 'theta1'?",
    ),
    "unknown passive joint": (
        ('["phi1", "phi2"]', '["phi1", "phi22"]'),
        "{path}: unknown joint 'phi22'; did you mean 'phi2' or 'phi1'?",
    ),
    "unknown joint in a pose": (
        ("phi2 = ", "psi2 = "),
        "{path}: unknown joint 'psi2'; did you mean 'phi2'",
    ),
    "unknown joint in a move": (
        ('{ joint = "phi1"', '{ joint = "phi11"'),
        "{path}: unknown joint 'phi11'; did you mean 'phi1'",
    ),
    "a joint listed twice": (
        ('["phi1", "phi2"]', '["phi1", "phi1"]'),
        "{path}: joint 'phi1' is listed twice in `passive`",
    ),
    "a motor that is also passive": (
        ('["phi1", "phi2"]', '["phi1", "phi2", "theta1"]'),
        "{path}: joint 'theta1' is listed as actuated and as passive",
    ),
    "a joint forgotten": (
        ('["phi1", "phi2"]', '["phi1"]'),
        "{path}: joint 'phi2' moves and is neither actuated nor passive",
    ),
    "no motors": (
        ('["theta1"]', "[]"),
        "{path}: `actuated` is empty: name at least one motor joint",
    ),
    "no home": (
        ("[poses.home]", "[poses.hom]"),
        "{path}: `poses.home` is missing; there are: hom; give joint values",
    ),
    "a pose of the wrong type": (
        ("theta1 = 0.9", 'theta1 = "0.9"'),
        "{path}: Expected `float | array`, got `str` - at `poses[...][...]`",
    ),
    "NaN in a pose": (
        ("theta1 = 0.9", "theta1 = nan"),
        "{path}: `poses` holds nan; a finite number is wanted",
    ),
    "a loop between a frame and itself": (
        ('"rocker_tip"', '"coupler_tip"'),
        "{path}: a loop joins two different frames, got 'coupler_tip' twice - at `loop[0]`",
    ),
    "a tool of both kinds": (
        ("[tool]", '[tool]\npoints = ["crank", "coupler", "rocker"]'),
        "{path}: a tool is either `frame = NAME` or `points = [NAME, NAME, NAME]` - at `tool`",
    ),
    "a tool that is a name": (
        ('[tool]\nframe = "coupler_midpoint"', 'tool = "coupler_midpoint"'),
        '{path}: Expected `table`, got `str` - at `tool`; write tool.frame = "coupler_midpoint"',
    ),
    "a default out of range": (
        ("default = 4.0", "default = 0.0"),
        "{path}: parameter 'default' = 0 m is not within [0.001, 1e+06] - at `parameters[...]`",
    ),
}


@pytest.mark.parametrize("case", MODEL_ERRORS)
def test_bad_model_files(files, tmp_path, case):
    change, message = MODEL_ERRORS[case]
    path = files(changed(MODEL, *change))
    with pytest.raises(pj.ModelFileError) as caught:
        pj.load(path)
    expected = message.format(path=path, folder=tmp_path, parent=tmp_path.parent)
    assert str(caught.value).startswith(expected)
    assert "\n" not in str(caught.value)
    assert caught.value.path == str(path)


def test_a_home_pose_that_does_not_assemble(files):
    urdf = changed(URDF, 'xyz="4 0 0"', 'xyz="40 0 0"')
    with pytest.raises(pj.ClosureError) as caught:
        pj.load(files(urdf=urdf))
    # Stretched out, crank, coupler and rocker reach 7.5 m of 40 m.
    assert str(caught.value) == (
        "mine: the pose 'home' does not assemble: the loops stay open by 32.5 m, the least from "
        "several starts, most at 'coupler_tip-rocker_tip x'; give joint values nearer to a closed "
        "pose, or other lengths"
    )
    assert caught.value.residual_norm == pytest.approx(32.5)


def test_home_assembles_from_near_it_with_its_motors_where_they_are(files):
    model = changed(MODEL, "phi1 = 2.0236", "phi1 = 1.2")
    home = pj.load(files(model)).home
    assert home.actuated[0] == 0.9
    np.testing.assert_allclose(home.q, loaded("four_bar").home.q, atol=1e-12)


def test_home_moves_its_motors_only_as_far_as_it_takes():
    moved = pj.load("four_bar", parameters={"l0": 7.2}).home
    assert moved.residual_norm < 1e-12
    assert 0.05 < abs(moved.actuated[0] - 0.9) < 0.9


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "the file is empty"),
        (b"  \n\t\n", "the file is empty"),
        (b"\xff\xfe\x00", "not UTF-8 text (byte 0)"),
        (b"a = " + b"[" * 100_000, "not valid TOML: "),
        (b"a = 1" + b"0" * 5000, "not valid TOML: "),
        (np.random.default_rng(0).bytes(10_000_000), "10000000 bytes are too many; at most"),
        (b"= " * 400_000, "not valid TOML: "),
    ],
)
def test_files_of_nonsense(tmp_path, content, message):
    path = tmp_path / "noise.toml"
    path.write_bytes(content)
    with pytest.raises(pj.ModelFileError) as caught:
        pj.load(path)
    assert str(caught.value).startswith(f"{path}: {message}")


def test_missing_file_and_directory(tmp_path):
    with pytest.raises(pj.ModelFileError, match="No such file or directory"):
        pj.load(tmp_path / "none.toml")
    with pytest.raises(pj.ModelFileError, match="there is no URDF in this folder"):
        pj.load(tmp_path)


def test_a_link_with_two_parents(files):
    urdf = changed(
        URDF,
        '<joint name="coupler_end"',
        '<joint name="extra" type="fixed"><parent link="crank"/><child link="rocker"/></joint>'
        '<joint name="coupler_end"',
    )
    with pytest.raises(pj.ModelFileError, match="rocker") as caught:
        pj.load(files(urdf=urdf))
    assert "phi1" in str(caught.value)
    assert "extra" in str(caught.value)


class TestParameters:
    @pytest.mark.parametrize(
        ("parameters", "kind", "message"),
        [
            ({"l9": 1.0}, pj.UnknownNameError, "unknown parameter 'l9'; there are: l0, l1, l2, l3"),
            ({"l1": 0.0}, pj.ArgumentError, "parameter 'l1' = 0 m is not within [0.001, 1e+06]"),
            ({"l1": math.nan}, pj.ArgumentError, "parameter 'l1' = nan m is not within"),
            ({"l1": math.inf}, pj.ArgumentError, "parameter 'l1' = inf m is not within"),
            ({"l1": "1"}, pj.ArgumentError, "parameter 'l1' must be a number in m, got '1'"),
            ({"l1": True}, pj.ArgumentError, "parameter 'l1' must be a number in m, got True"),
            ({"l1": 10**400}, pj.ArgumentError, "parameter 'l1' = inf m is not within"),
        ],
    )
    def test_bad_values(self, parameters, kind, message):
        with pytest.raises(kind) as caught:
            pj.load("four_bar", parameters=parameters)
        assert str(caught.value).startswith(message)

    def test_numpy_numbers_are_numbers(self):
        mechanism = pj.load("four_bar", parameters={"l1": np.float32(1.5), "l2": np.int64(3)})
        assert dict(mechanism.parameters) == {"l0": 4.0, "l1": 1.5, "l2": 3.0, "l3": 3.5}

    @pytest.mark.parametrize("name", ["four_bar", "serial_2r", "three_rps", "three_rps_ss"])
    def test_each_parameter_moves_something_or_sets_a_length(self, name):
        default = loaded(name)
        for parameter, value in default.parameters.items():
            changed = pj.load(name, parameters={parameter: 1.07 * value})
            difference = (
                np.abs(
                    changed.home.jacobian().constraint_jacobian
                    - default.home.jacobian().constraint_jacobian
                ).max(initial=0)
                + np.abs(changed.home.jacobian().J_eq - default.home.jacobian().J_eq).max()
            )
            assert difference > 1e-3


WORDS = (
    "urdf actuated passive tool loop poses parameters home frame frames kind length default unit "
    "moves theta1 xyz é"
)
keys = st.sampled_from([*WORDS.split(), ""])
scalars = st.one_of(
    st.text(max_size=8),
    st.integers(),
    st.floats(),
    st.booleans(),
    st.sampled_from(["point", "home"]),
)
values = st.recursive(
    scalars,
    lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(keys, inner, max_size=4)),
    max_leaves=12,
)


def as_toml(value):
    match value:
        case bool():
            return str(value).lower()
        case float():
            return repr(value)
        case int():
            return str(value)
        case str():
            escaped = "".join(f"\\U{ord(c):08x}" for c in value if not 0xD800 <= ord(c) < 0xE000)
            return f'"{escaped}"'
        case list():
            return "[" + ", ".join(map(as_toml, value)) + "]"
        case dict():
            items = (f"{as_toml(key)} = {as_toml(item)}" for key, item in value.items())
            return "{ " + ", ".join(items) + " }"


FUZZ = settings(
    max_examples=250,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)


def read_or_refuse(folder: Path, content: bytes):
    path = folder / "fuzz.toml"
    path.write_bytes(content)
    try:
        read_model_file(path)
    except pj.ModelFileError as error:
        assert str(error).startswith(f"{path}: ")
        assert "\n" not in str(error).replace(str(path), "")


@pytest.mark.slow
@FUZZ
@given(st.dictionaries(keys, values, max_size=6))
def test_fuzz_tables(tmp_path, table):
    text = "\n".join(f"{as_toml(key)} = {as_toml(value)}" for key, value in table.items())
    read_or_refuse(tmp_path, text.encode())


@FUZZ
@given(st.binary(max_size=300))
def test_fuzz_bytes(tmp_path, content):
    read_or_refuse(tmp_path, content)


@FUZZ
@given(st.data())
def test_fuzz_a_good_file_gone_wrong(tmp_path, data):
    lines = MODEL.splitlines()
    for _ in range(data.draw(st.integers(1, 3))):
        where = data.draw(st.integers(0, len(lines) - 1))
        match data.draw(st.integers(0, 3)):
            case 0:
                del lines[where]
            case 1:
                lines.insert(where, data.draw(st.sampled_from(lines)))
            case 2:
                lines[where] = lines[where][: data.draw(st.integers(0, 30))]
            case 3:
                key = lines[where].split("=")[0]
                lines[where] = f"{key} = {as_toml(data.draw(values))}"
    (tmp_path / "four_bar.urdf").write_text(URDF)
    path = tmp_path / "fuzz.toml"
    path.write_text("\n".join(lines))
    try:
        pj.load(path)
    except (pj.ModelFileError, pj.ClosureError) as error:
        assert "\n" not in str(error)


@pytest.mark.parametrize("name", ["device.toml", "pipe.toml"])
def test_what_is_no_regular_file_is_not_opened(tmp_path, name):
    path = tmp_path / name
    if name == "device.toml":
        path.symlink_to("/dev/zero")
    else:
        os.mkfifo(path)
    with pytest.raises(pj.ModelFileError, match="is no regular file"):
        pj.load(path)


# --- what to write where there is no home pose ---------------------------------------------------


def without_poses(text):
    """A model file up to its poses: those of the catalogue come after what is needed."""
    return text[: text.index("[poses.home]")]


@pytest.mark.parametrize("name", ["four_bar", "three_rps", "watt_six_bar"])
@pytest.mark.parametrize("header", ["", "[poses]\n"])
def test_the_line_that_gives_a_home_pose_is_told(tmp_path, name, header):
    """It is TOML, has every joint, and where it says it does the file is whole."""
    text = without_poses((ROOT / "models" / f"{name}.toml").read_text())
    path = tmp_path / "mine.toml"
    path.write_text(text + header)
    shutil.copy(ROOT / "urdf" / f"{name}.urdf", tmp_path)
    with pytest.raises(
        pj.ModelFileError, match="give joint values near which the loops close"
    ) as no:
        pj.load(path)
    (line,) = re.findall(r"such as `(.*)`", str(no.value))
    place = re.search("above the first .table.|under .poses.", str(no.value))[0]
    top, _, tables = text.partition("\n[")
    assert bool(header) == place.startswith("under")
    path.write_text(f"{text}{header}{line}\n" if header else f"{top}\n{line}\n[{tables}")
    joints = tomllib.loads(path.read_text())["poses"]["home"]
    known = loaded(name)
    assert list(joints)[: len(known.actuated)] == list(known.actuated)
    assert {*joints} == {*known.coordinates.names}
    try:
        assert pj.load(path).actuated == known.actuated
    except pj.ClosureError as error:  # zeros may be far from any closed pose
        assert "does not assemble" in str(error)


def test_home_values_to_write_are_within_limits_and_skip_locked_joints(tmp_path):
    (tmp_path / "arm.urdf").write_text(
        """<robot name="arm"><link name="a"/><link name="b"/><link name="c"/><link name="d"/>
        <joint name="lift 1" type="prismatic"><parent link="a"/><child link="b"/>
        <limit lower="0.2" upper="0.6" effort="1" velocity="1"/></joint>
        <joint name="ball" type="spherical"><parent link="b"/><child link="c"/></joint>
        <joint name="held" type="continuous"><parent link="c"/><child link="d"/></joint></robot>"""
    )
    path = tmp_path / "arm.toml"
    path.write_text(
        'urdf = "arm.urdf"\nactuated = ["lift 1", "ball"]\ntool.frame = "d"\nlocked.held = 0.1\n'
    )
    wanted = re.escape('`poses.home = {"lift 1" = 0.4, ball = [0.0, 0.0, 0.0]}`')
    with pytest.raises(pj.ModelFileError, match=wanted):
        pj.load(path)
