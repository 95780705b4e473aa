"""What the page's list of assembly modes reads, its own JavaScript run by Node: no browser."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import pytest
from mechanisms import loaded
from test_same_machine import QUICKLY, THETA, rusr

import pmjac_pin as pj
from pmjac_pin.viewer.messages import Modes
from pmjac_pin.words.modes_report import make_modes_report
from pmjac_pin.words.modes_tables import count
from pmjac_pin.words.plain import encoded

PAGE = Path(pj.__file__).parent / "viewer" / "page"
NODE = shutil.which("node")

#: As much of a document as the list needs.
SCRIPT = """
class Made {
  dataset = {};
  children = [];
  attributes = {};
  textContent = "";
  setAttribute(name, value) { this.attributes[name] = String(value); this[name] = value; }
  removeAttribute(name) { delete this.attributes[name]; }
  append(...children) { this.children.push(...children); }
  replaceChildren(...children) { this.children = children; }
  querySelectorAll() { return this.children.flatMap((line) => line.children); }
}
const made = {};
globalThis.document = {
  createElement: () => new Made(),
  getElementById: (id) => (made[id] ??= new Made()),
};
const { showModes } = await import("./modes.js");
const { readFileSync } = await import("node:fs");
showModes(JSON.parse(readFileSync(0, "utf8")));
const buttons = made.modes.querySelectorAll("button");
console.log(JSON.stringify({
  text: made["modes-text"].textContent,
  cells: buttons.map((button) => button.children.map((cell) => cell.children.join(""))),
  labels: buttons.map((button) => button.attributes["aria-label"]),
  current: buttons.map((button) => button.attributes["aria-current"] === "true"),
}));
"""


def shown(directory, mechanism, values):
    """What the list shows of a mechanism's modes."""
    report = make_modes_report(
        mechanism, values, pj.assembly_modes(mechanism, values, rng=0, **QUICKLY)
    )
    told = tuple(mode.told() for mode in report.modes)
    message = Modes(status="found", text=count(report), current=1, modes=told)
    for script in PAGE.glob("*.js"):
        shutil.copy(script, directory)
    (directory / "package.json").write_text('{"type": "module"}')
    (directory / "show.js").write_text(SCRIPT)
    done = subprocess.run(
        [str(NODE), "show.js"],
        input=encoded(message),
        cwd=directory,
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    return json.loads(done.stdout)


@pytest.mark.skipif(NODE is None, reason="there is no Node")
def test_the_list_says_in_how_many_ways_a_mode_fits(tmp_path):
    page = shown(tmp_path, rusr("rocker_tip"), THETA)
    assert page["text"].startswith("2 assembly modes within")
    assert page["text"].endswith("; 8 poses, bodies turned over or not.")
    assert all(cells[-1].split(", ")[-1] == "4 ways" for cells in page["cells"])
    assert all(label.endswith("4 ways") for label in page["labels"])
    assert page["current"] == [True, False]


@pytest.mark.skipif(NODE is None, reason="there is no Node")
def test_one_way_is_not_worth_a_word(tmp_path):
    mechanism = loaded("four_bar")
    page = shown(tmp_path, mechanism, mechanism.home.actuated)
    assert [cells[0] for cells in page["cells"]] == ["1", "2"]
    assert not any("way" in text for text in [*page["labels"], page["text"]])
