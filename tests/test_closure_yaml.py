"""The YAML file of an extended URDF: types, sizes, and what YAML can hide."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import pmjac_pin as pj
from pmjac_pin.files.urdf.closure_yaml import ClosureFile, read_closure_yaml


@pytest.fixture
def read(tmp_path):
    def read(text):
        path = tmp_path / "robot.yaml"
        path.write_text(text)
        return read_closure_yaml(path)

    return read


def everything(read, text):
    found, _ = read(text)
    return found.kinds(), found.replacements(), found.floats()


def test_all_keys(read):
    text = (
        "closed_loop: [['a', \"b\"], [c, d]]\ntype: [3D, 6d]\nname_mot: [m1, m2]\n"
        "joint_name: [j]\njoint_type: [ujoint_xy]\nfree_flyer: True\nauthor: [someone]\n"
    )
    found, unused = read(text)
    assert found.closed_loop == (("a", "b"), ("c", "d"))
    assert found.kinds() == ("point", "frame")
    assert found.name_mot == ("m1", "m2")
    assert found.replacements() == {"j": "UJOINT_XY"}
    assert found.floats()
    assert unused == ("author",)


def test_only_the_loops_or_the_motors(read):
    assert read("name_mot: [m]") == (ClosureFile(name_mot=("m",)), ())
    assert read("closed_loop: [[a, b]]")[0].kinds() == ("frame",)


def test_names_that_yaml_would_take_for_something_else(read):
    """No, 012, 1e3 and a date are names here."""
    assert read("name_mot: [no, 012, 1e3, 2001-01-01, ~]")[0].name_mot == (
        "no",
        "012",
        "1e3",
        "2001-01-01",
        "~",
    )


BOMB = "a: &a [x, x]\n" + "".join(
    f"{chr(98 + k)}: &{chr(98 + k)} [{', '.join([f'*{chr(97 + k)}'] * 9)}]\n" for k in range(12)
)
BAD = {
    "nothing of it": ("x: 1", "expected, since it lies beside one; it has: x"),
    "a list": ("[a, b]", "it has: no table"),
    "a word": ("hello", "it has: no table"),
    "pairs": ("closed_loop: [[a, b, c]]", "Expected `array` of length 2, got 3"),
    "text": ("closed_loop: a", "Expected `array`, got `str` - at `closed_loop`"),
    "numbers of types": (
        "closed_loop: [[a, b]]\ntype: []",
        "`closed_loop` has 1 entries and `type`",
    ),
    "type": ("closed_loop: [[a, b]]\ntype: [5d]", "`type` is '5d'; 3D and 6D are read"),
    "joints": ("name_mot: [a]\njoint_name: [a]", "`joint_name` has 1 entries and `joint_type` 0"),
    "twice": (
        "name_mot: [a]\njoint_name: [a, a]\njoint_type: [FIXED, FIXED]",
        "`joint_name` lists a joint twice",
    ),
    "flyer": ("name_mot: [a]\nfree_flyer: maybe", "`free_flyer` is 'maybe', neither true nor"),
    "misspelt": ("closed_loop: [[a, b]]\ntypes: [3d]", "unknown key 'types'; did you mean 'type'?"),
    "unclosed": ("closed_loop: [[a, b]", "not valid YAML: expected ',' or ']', but got"),
    "tab": ("closed_loop:\n\t- a", "not valid YAML: found character '\\t' that cannot start"),
    "code": (
        "name_mot: !!python/object/apply:os.getcwd []\nclosed_loop: !!int x",
        "Expected `array`",
    ),
    "deep": ("name_mot: " + "[" * 5000, "not valid YAML: "),
    "aliases": (BOMB + "name_mot: *m\n", "Expected `str`, got `array`"),
    "itself": ("closed_loop: &a [*a]", "unconstructable recursive node"),
    "escapes": ('name_mot: ["\\UFFFFFFFF"]', "not valid YAML: "),
    "merges": ("name_mot: {<<: [{a: 1}]}", "Expected `array`, got `object` - at `name_mot`"),
}


@pytest.mark.parametrize(("text", "message"), BAD.values(), ids=BAD)
def test_what_is_refused(read, text, message):
    with pytest.raises(pj.ModelFileError) as caught:
        everything(read, text)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_large_file(read):
    with pytest.raises(pj.ModelFileError, match="bytes are too many; at most 64000 are read"):
        read(" " * 300_000)


@pytest.mark.slow
@settings(
    max_examples=500,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(st.text(st.sampled_from("closed_loop: name_mot[],&*!-|>'\"\n\t {}?#%@\\x0é"), max_size=80))
def test_fuzz(read, text):
    try:
        everything(read, text)
    except pj.ModelFileError as error:
        assert "\n" not in str(error)
