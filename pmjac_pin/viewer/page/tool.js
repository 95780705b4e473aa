// Where the tool is, and the values of the passive joints.

import { shownIn } from "./angles.js";
import { $, broken, element } from "./elements.js";
import { fixed } from "./numbers.js";

const DECIMALS = { m: 4, rad: 4, "°": 2 };
let units = [];

export function buildTool(passive) {
  units = passive.map((joint) => joint.unit);
  $("passive").replaceChildren(...passive.map((joint) => element(
    "tr", {}, element("th", { scope: "row", title: joint.name }, ...broken(joint.name)),
    element("td", {}, element("span", { class: "numbers" })), element("td", { class: "unit" }),
  )));
  $("passive-values").hidden = passive.length === 0;
}

export function showTool({ tool_position: position, tool_turn: turn, passive }) {
  write($("tool-position"), position, "m");
  write($("tool-turn"), turn, "rad");
  [...$("passive").rows].forEach((row, index) => write(row, [passive[index]], units[index]));
}

function write(row, values, unit) {
  const [size, shown] = shownIn(unit);
  const texts = values.map((value) => fixed(value / size, DECIMALS[shown]));
  row.cells[1].firstChild.replaceChildren(...texts.flatMap((text) => [" ", element("span", {}, text)]));
  row.cells[2].textContent = shown;
}
