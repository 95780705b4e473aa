// The numbers: singular values, condition, residual and the table of J_eq.

import { $, broken, element } from "./elements.js";
import { decimalsFor, fixed, minus, relative } from "./numbers.js";

const ROWS = [["v", "x", "m/s"], ["v", "y", "m/s"], ["v", "z", "m/s"], ["ω", "x", "rad/s"], ["ω", "y", "rad/s"], ["ω", "z", "rad/s"]];

// Fixed for each kind of number, so that numbers do not jump.
export function decimalsAt(home) {
  const rows = home.J_eq?.LOCAL_WORLD_ALIGNED ?? [];
  return {
    linear: decimalsFor(rows.slice(0, 3).flat()),
    angular: decimalsFor(rows.slice(3).flat()),
    Jv: decimalsFor(home.Jv_singular_values ?? []),
    Jw: decimalsFor(home.Jw_singular_values ?? []),
  };
}

export function buildJacobian(motors) {
  const head = element("tr", {}, element("td", {}));
  for (const motor of motors) {
    head.append(element("th", { scope: "col", title: motor.name }, ...broken(motor.name), element("span", { class: "unit" }, `per ${motor.unit}/s`)));
  }
  const body = element("tbody");
  for (const [letter, axis, unit] of ROWS) {
    const name = element("th", { scope: "row" }, element("i", {}, letter), element("sub", {}, axis), " ", element("span", { class: "unit" }, unit));
    body.append(element("tr", {}, name, ...motors.map(() => element("td"))));
  }
  $("jacobian").replaceChildren(element("thead", {}, head), body);
  $("jacobian").classList.toggle("many", motors.length > 4);
}

export function showReadout(readout, decimals) {
  put("sigma-v", (readout.Jv_singular_values ?? [null]).map((value) => fixed(value, decimals.Jv)));
  put("sigma-w", (readout.Jw_singular_values ?? [null]).map((value) => fixed(value, decimals.Jw)));
  put("smallest", [readout.loops ? relative(readout.smallest) : "no loops"]);
  put("condition", [readout.loops ? (readout.condition === null ? "∞" : fixed(readout.condition, 1)) : "no loops"]);
  put("tool-motions", [`${readout.tool_rank} of ${readout.generic_tool_rank}`]);
  [$("judged").textContent, $("judged").title] = readout.judged;
  put("residual", [minus(readout.residual.toExponential(1))]);
  $("refusal").textContent = readout.refusal ? "There is no equivalent Jacobian at this pose." : "";
  $("refusal").title = readout.refusal ?? "";
  showJacobian(inFrame(readout), decimals);
}

const inFrame = (readout) => readout.J_eq?.[$("frame").value] ?? null;

// All digits, as a line that Python reads.
export async function copyJacobian(readout) {
  const rows = inFrame(readout);
  const text = rows ? `np.array([${rows.map((row) => `[${row.join(", ")}]`).join(", ")}])` : "";
  let said = "No J_eq";
  if (text) said = await navigator.clipboard.writeText(text).then(() => "Copied", () => "Not allowed");
  $("copy").textContent = said;
  setTimeout(() => { $("copy").textContent = "Copy"; }, 1500);
}

function put(id, texts) {
  const place = $(id);
  if (place.children.length !== texts.length) {
    // With blanks between them: they are read aloud, too.
    place.replaceChildren(...texts.flatMap(() => [" ", element("span")]));
  }
  texts.forEach((text, index) => { place.children[index].textContent = text; });
}

function showJacobian(rows, decimals) {
  [...$("jacobian").tBodies[0].rows].forEach((row, i) => {
    const digits = i < 3 ? decimals.linear : decimals.angular;
    [...row.cells].slice(1).forEach((cell, j) => {
      cell.textContent = fixed(rows ? rows[i][j] : null, digits);
    });
  });
}
