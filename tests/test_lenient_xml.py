"""XML that parsers of robots read though it is not well-formed: read, or told why not."""

from __future__ import annotations

import pytest

import pmjac_pin as pj
from pmjac_pin.files.vocabulary import spelt
from pmjac_pin.files.xml_text import parse_xml


@pytest.mark.parametrize("blank", ["\n", " \n\t", "\r\n"])
def test_blank_lines_before_the_declaration(blank):
    assert parse_xml(f'{blank}<?xml version="1.0" encoding="utf-8"?>\n<robot/>').tag == "robot"
    with pytest.raises(pj.ModelFileError, match="line 4"):
        parse_xml('\n<?xml version="1.0"?>\n<robot>\n<</robot>')


@pytest.mark.parametrize("before", ["", "<?xml version='1.0'?>", "<!-- <a:b> --><?c?>\n"])
def test_prefixes_that_nobody_binds_are_bound_to_their_names(before):
    root = parse_xml(f'{before}<robot drake:k="1"><drake:mimic/><x:y xmlns:x="z"/></robot>')
    assert [spelt(child.tag) for child in root] == ["drake:mimic", "z:y"]
    assert [spelt(key) for key in root.attrib] == ["drake:k"]


@pytest.mark.parametrize("text", ["<a", "<drake:a", "", "<a:b></c>", "<a><:b/></a>", "<!-- <a:b/>"])
def test_what_is_no_xml_is_refused(text):
    with pytest.raises(pj.ModelFileError, match="not well-formed XML"):
        parse_xml(text)


@pytest.mark.parametrize(
    "comment",
    [
        "<!-- a bar -- on one hinge -->",
        "<!------- parts ------->",
        "<!--- <c/> --->",
        "<!-- a -- b --><!-- 'c\" -- -->",
        "<!-- -- \n\n -->",
    ],
)
@pytest.mark.parametrize("before", ["", '\n<?xml version="1.0"?>\n', "<?c -- <!-- ?>"])
def test_a_comment_ends_at_its_end_whatever_hyphens_it_holds(before, comment):
    """TinyXML, with which URDF, MJCF and SDFormat are read elsewhere, ends it at the first -->."""
    text = f"{before}{comment}<robot a='x > y'>{comment}<b/>{comment}text</robot>{comment}"
    root = parse_xml(text)
    assert (root.tag, root.attrib, [child.tag for child in root]) == (
        "robot",
        {"a": "x > y"},
        ["b"],
    )
    assert (root.text or "").strip() == ""
    assert root[0].tail.strip() == "text"


def test_nothing_but_comments_is_mended():
    """What looks like a comment in text or in an attribute is left alone."""
    root = parse_xml("<a><!-- -- --><b c='--&gt; &lt;!-- --'/><![CDATA[<!-- x -- y -->]]></a>")
    assert root[0].get("c") == "--> <!-- --"
    assert root[0].tail == "<!-- x -- y -->"


def test_lines_are_counted_as_they_stand():
    with pytest.raises(pj.ModelFileError, match="line 5"):
        parse_xml("<a>\n<!-- -- \n\n-->\n<</a>")


def test_hyphens_and_prefixes_together():
    root = parse_xml("\n<?xml version='1.0'?><a><!-- -- --><drake:mimic/><!-- -- --></a>")
    assert [spelt(child.tag) for child in root] == ["drake:mimic"]


@pytest.mark.parametrize(
    "text",
    [
        "<a><!-- -- </a>",
        "<a b='<!-- -- -->'/>",
        "<a b='<!-- -- '/><c d=' -->'/>",
        "<a><!-- -- --><b c=<!-- -- -->'1'/></a>",
        "<!-- -- --><!DOCTYPE a [<!ENTITY b '<!-- -- -->'>]><a>&b;</a>",
        "<!--" * 100_000,
        "<a '" * 100_000,
        '<a b="' * 99_999,
    ],
    ids=range(8),
)
def test_what_is_no_xml_for_anybody_is_refused_at_once(text):
    with pytest.raises(pj.ModelFileError, match=r"not well-formed XML|DOCTYPE"):
        parse_xml(text)


ROBOTS = {
    "urdf": "<robot name='r'><link name='a'/><link name='b'/><!-- x -- y --><joint name='j' "
    "type='continuous'><parent link='a'/><child link='b'/><axis xyz='0 0 1'/></joint></robot>",
    "xml": "<mujoco><worldbody><!-- x -- y --><body name='b'><joint name='j'/>"
    "<geom size='.1'/></body></worldbody></mujoco>",
    "sdf": "<sdf version='1.9'><model name='m'><link name='a'/><!-- x -- y --><link name='b'/>"
    "<joint name='j' type='revolute'><parent>a</parent><child>b</child>"
    "<axis><xyz>0 0 1</xyz></axis></joint></model></sdf>",
}


@pytest.mark.parametrize("suffix", ROBOTS)
def test_robots_with_such_comments_are_read(tmp_path, suffix):
    path = tmp_path / f"robot.{suffix}"
    path.write_text(ROBOTS[suffix])
    assert pj.load(path, tool="b").actuated == ("j",)
