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


def test_hyphens_in_comments_are_told():
    hint = "two hyphens side by side stand within a comment"
    with pytest.raises(pj.ModelFileError, match=hint):
        parse_xml("<mujoco>\n  <!-- a bar -- on one hinge -->\n</mujoco>")
    with pytest.raises(pj.ModelFileError) as caught:
        parse_xml("<mujoco><!-- fine --><</mujoco>")
    assert hint not in str(caught.value)
