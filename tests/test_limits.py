"""Inputs without end or measure are refused before they cost time or memory."""

from __future__ import annotations

import os
import re
import tomllib
import tracemalloc
from pathlib import Path

import looped
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.files import model_file
from pmjac_pin.files.bounded_toml import MAXIMAL_PARTS, bounded_table
from pmjac_pin.files.bounded_xml import MAXIMAL_ATTRIBUTES, MAXIMAL_ELEMENTS, MAXIMAL_NESTING
from pmjac_pin.files.catalog import find_model_file, find_urdf
from pmjac_pin.files.mjcf import file as mjcf_file
from pmjac_pin.files.mjcf import guards as mjcf_guards
from pmjac_pin.files.sdf import reader as sdf
from pmjac_pin.files.urdf import checks as urdf_checks
from pmjac_pin.files.urdf import closure_yaml, joint_tree
from pmjac_pin.files.urdf import robot as urdf
from pmjac_pin.files.xml_text import parse_xml
from pmjac_pin.model.loop_spec import MAXIMAL_LOOPS
from pmjac_pin.model.spec import MAXIMAL_ENTRIES
from pmjac_pin.model.table import LONGEST_NAME
from pmjac_pin.values.checks import LARGEST, SMALLEST

FOUR_BAR = find_model_file("four_bar").read_text(encoding="utf-8")
FOUR_BAR_URDF = find_urdf("four_bar.urdf", find_model_file("four_bar"))
LOOP = '[[loop]]\nkind = "point"\nframes = ["coupler_tip", "rocker_tip"]\n'
MEMORY = 30_000_000  # bytes that refusing may take, besides the text itself


def refusal(call, *arguments, **keywords):
    with pytest.raises(pj.PmjacError) as caught:
        call(*arguments, **keywords)
    assert len(str(caught.value)) < 700
    return str(caught.value)


def cheap_refusal(call, *arguments, memory=MEMORY):
    tracemalloc.start()
    try:
        message = refusal(call, *arguments)
        assert tracemalloc.get_traced_memory()[1] < memory
    finally:
        tracemalloc.stop()
    return message


# --- TOML --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "key",
    [
        "a" + ".a" * 20_000 + " = 1",
        "[" + "a." * 20_000 + "a]",
        "x = {a" + " . 'b'" * 5_000 + " = 1}",
        '"a.b"' + '."c"' * MAXIMAL_PARTS + " = 1",
    ],
)
def test_keys_with_many_dots(key):
    """40 kB of them took 1.5 GB."""
    message = cheap_refusal(bounded_table, f"# one\n{key}\n")
    assert " in line 2 has " in message
    assert message.endswith(f" parts; at most {MAXIMAL_PARTS} are read")


DOTS = "a" + ".a" * 20_000


@pytest.mark.parametrize(
    "text",
    [
        f'x = "{DOTS}"',
        f"x = '{DOTS}'",
        f'x = """\n{DOTS}"""',
        f"x = '''\n{DOTS}\n'''",
        f"x = 1 # {DOTS}",
        f'"{DOTS}" = 1',
        'x = "a\\"b" # ' + DOTS,
        ".".join("abcdefghijklmnop") + " = 1",
    ],
)
def test_dots_elsewhere_are_no_keys(text):
    assert bounded_table(text) == tomllib.loads(text)


@given(st.text(alphabet="\"'\\\n#=.[]{}, ab1", max_size=60))
@settings(max_examples=500, deadline=None, derandomize=True)
def test_short_texts_are_read_as_tomllib_reads_them(text):
    try:
        expected = tomllib.loads(text)
    except ValueError:
        with pytest.raises(pj.ModelFileError):
            bounded_table(text)
    else:
        assert text.count(".") >= MAXIMAL_PARTS or bounded_table(text) == expected


@pytest.mark.parametrize("text", ["a = " + "[" * 100_000, "a = " + "{a = " * 100_000])
def test_deep_tables(text):
    assert cheap_refusal(bounded_table, text) == "not valid TOML: nested too deep to be read"


@pytest.mark.parametrize("text", ['a = """' + '\\"""' * 50_000, '"' * 200_000, "'''\\" * 50_000])
def test_quotes_without_end_take_no_time(text):
    assert "not valid TOML" in cheap_refusal(bounded_table, text)


@pytest.mark.parametrize(
    ("what", "entry", "most"),
    [
        ("loops", LOOP, MAXIMAL_LOOPS),
        ("poses", "[poses.p{k}]\ntheta1 = 1.0\n", MAXIMAL_ENTRIES),
        (
            "parameters",
            '[parameters.p{k}]\ndefault = 1.0\nunit = "m"\nmeaning = "x"\n',
            MAXIMAL_ENTRIES,
        ),
    ],
)
def test_many_entries(tmp_path, what, entry, most):
    """5,000 loops took 98 s and 5.3 GB."""
    path = tmp_path / "many.toml"
    path.write_text(FOUR_BAR + "".join(entry.replace("{k}", f"{k}") for k in range(most + 10)))
    assert f"{what} are too many; at most {most} are read" in cheap_refusal(pj.load, path)


def test_many_loops_from_pinocchio():
    mechanism = loaded("four_bar")
    loops = [pj.PointLoop(frames=("coupler_tip", "rocker_tip"))] * (MAXIMAL_LOOPS + 1)
    message = refusal(
        pj.Mechanism.from_pinocchio, mechanism.model, loops, ["theta1"], "coupler_midpoint"
    )
    assert message == f"{MAXIMAL_LOOPS + 1} loops are too many; at most {MAXIMAL_LOOPS} are read"


def test_as_many_loops_as_are_read(tmp_path):
    path = tmp_path / "many.toml"
    path.write_text(FOUR_BAR + LOOP * (MAXIMAL_LOOPS - 1))
    (tmp_path / "four_bar.urdf").write_bytes(FOUR_BAR_URDF.read_bytes())
    assert len(pj.load(path).spec.loops) == MAXIMAL_LOOPS


# --- XML ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<a>" * 1_000_000, f"elements are nested more than {MAXIMAL_NESTING} deep"),
        ("<r>" + "<a/>" * (MAXIMAL_ELEMENTS + 1), "elements are too many to be read"),
        ("<r " + " ".join(f"a{k}='>'" for k in range(200_000)) + "/>", "attributes"),
        ("<r>&" + "x" * 1_000_000 + ";</r>", "not well-formed XML: undefined entity"),
        ("<r>" + "x" * 1_000_000, "not well-formed XML: no element found"),
    ],
)
def test_xml_without_end(text, message):
    """20 MB of unclosed elements took 1 GB and more."""
    assert message in cheap_refusal(parse_xml, text, memory=70_000_000)


def test_what_xml_may_be():
    deep = "<a>" * MAXIMAL_NESTING + "</a>" * MAXIMAL_NESTING
    assert parse_xml(deep).tag == "a"
    many = " ".join(f'a{k}="x = 1"' for k in range(MAXIMAL_ATTRIBUTES))
    assert len(parse_xml(f"<r {many}/>").attrib) == MAXIMAL_ATTRIBUTES
    assert len(parse_xml("<r>" + "<a/>" * (MAXIMAL_ELEMENTS - 1) + "</r>")) == MAXIMAL_ELEMENTS - 1
    vertices = " ".join(["0.123456"] * 300_000)
    assert parse_xml(f'<mesh vertex="{vertices}"/>').get("vertex") == vertices
    words = '<!-- width="1" -->' + 'width="1" ' * 10
    assert parse_xml(f"<r>{words}</r>").tag == "r"


# --- YAML --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("closed_loop: " + "[" * 60_000, "not valid YAML: nested too deep to be read"),
        ("- " * 30_000, "not valid YAML: nested too deep to be read"),
        ("closed_loop: &a [*a, *a]", "not valid YAML: found unconstructable recursive node"),
        ("closed_loop: []\n" + " " * 64_000, "bytes are too many"),
        (
            "a: &a [x, x]\n"
            + "".join(
                f"{b}: &{b} [*{a}, *{a}, *{a}, *{a}, *{a}]\n"
                for a, b in zip("abcdefghijklmno", "bcdefghijklmnop", strict=True)
            )
            + "closed_loop: *p",
            "closed_loop[0]",
        ),
    ],
)
def test_yaml_without_end(tmp_path, text, message):
    (tmp_path / "robot.urdf").write_text(looped.two_parents())
    (tmp_path / "robot.yaml").write_text(text)
    assert message in refusal(pj.load, tmp_path / "robot.urdf", actuated=["theta1"], tool="pin")


# --- files that are none -----------------------------------------------------------------------


@pytest.mark.parametrize("name", ["x.toml", "x.urdf", "x.xml", "x.sdf"])
@pytest.mark.parametrize("kind", ["pipe", "zero", "tty", "kernel"])
def test_files_that_would_not_end(tmp_path, name, kind):
    """As a model file, as its URDF, and beside a URDF."""
    path = tmp_path / name
    if kind == "pipe":
        os.mkfifo(path)
    else:
        path.symlink_to({"zero": "/dev/zero", "tty": "/dev/ptmx", "kernel": "/proc/kmsg"}[kind])
    message = "the file is empty" if kind == "kernel" else "is no regular file"
    assert message in refusal(pj.load, path, actuated=["a"], tool="b")


def test_a_urdf_that_would_not_end(tmp_path):
    os.mkfifo(tmp_path / "pipe.urdf")
    path = tmp_path / "x.toml"
    path.write_text(FOUR_BAR.replace("four_bar.urdf", "pipe.urdf"))
    assert "pipe.urdf' does not exist" in refusal(pj.load, path)
    (tmp_path / "kernel.urdf").symlink_to("/proc/kmsg")
    path.write_text(FOUR_BAR.replace("four_bar.urdf", "kernel.urdf"))
    assert "kernel.urdf: the file is empty" in refusal(pj.load, path)


def test_a_pipe_put_there_meanwhile_is_not_waited_for(tmp_path, monkeypatch):
    """Between looking at a file and opening it, another may have come."""
    path = tmp_path / "x.toml"
    path.write_text("x = 1")
    before = path.stat()
    path.unlink()
    os.mkfifo(path)
    monkeypatch.setattr(type(path), "stat", lambda *_, **__: before)
    assert "is no regular file" in refusal(pj.load, path)


# --- the page about it -------------------------------------------------------------------------


def test_the_page_states_each_limit():
    page = (Path(__file__).parent.parent / "docs" / "input_limits.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| ([^|]+) \| ([^|]+) \| ([^|]+) \|", page, re.MULTILINE)
    stated = {f"{what.strip()} {of.strip()}": value.strip() for what, of, value in rows}
    expected = {
        "size of a model file": "1 MiB",
        "size of a URDF or SDF": f"{urdf.MAXIMAL_URDF:,} bytes",
        "size of an MJCF, with all that it includes": f"{mjcf_file.MAXIMAL_MJCF:,} bytes",
        "size of the YAML of an extended URDF": f"{closure_yaml.MAXIMAL_YAML:,} bytes",
        "files included in an MJCF, or attached": f"{mjcf_file.MAXIMAL_INCLUDES}",
        "elements of an MJCF that are read, copies by `replicate` and `attach` counted": (
            f"{mjcf_guards.MAXIMAL_MJCF_ELEMENTS:,}"
        ),
        "default classes of an MJCF": f"{mjcf_guards.MAXIMAL_CLASSES:,}",
        "parts of a dotted TOML key": f"{MAXIMAL_PARTS}",
        "nesting of XML elements": f"{MAXIMAL_NESTING}",
        "elements of an XML file": f"{MAXIMAL_ELEMENTS:,}",
        "attributes of an XML element": f"{MAXIMAL_ATTRIBUTES:,}",
        "links of a machine": f"{urdf_checks.MAXIMAL_LINKS:,}",
        "joints of a machine, with those that close loops": f"{urdf_checks.MAXIMAL_JOINTS:,}",
        "joints in a row of the tree": f"{joint_tree.MAXIMAL_DEPTH}",
        "degrees of freedom of the tree": f"{urdf_checks.MAXIMAL_VELOCITIES}",
        "loops of a machine, in a model file or from Pinocchio, too": f"{MAXIMAL_LOOPS}",
        "poses, parameters of a model file": f"{MAXIMAL_ENTRIES:,} each",
        "characters of a name": f"{LONGEST_NAME}",
        "magnitude of a number, m, rad, kg, kg m²": "1e9",
        "length, ratio of a rod; of a gear": "1e-9 to 1e9",
    }
    assert {key: stated.get(key) for key in expected} == expected
    assert (model_file.MAXIMAL_MODEL_FILE, sdf.MAXIMAL_SDF) == (1 << 20, urdf.MAXIMAL_URDF)
    assert urdf_checks.MAXIMAL_NAME == LONGEST_NAME
    assert (LARGEST, SMALLEST) == (1e9, 1e-9)
