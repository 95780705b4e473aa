// What hangs at the tool or pushes it, and the motor efforts that balance it, against their limits.

import { $, broken, element } from "./elements.js";
import { decimalsFor, fixed } from "./numbers.js";
import { Sliders } from "./sliders.js";

const FIELDS = { weight: ["mass"], force: ["size", "azimuth", "elevation"] };
const WIDEST = 1.25;  // limits, that a bar can show

let sliders = {};
let shown = null;     // the newest that Python has told
let wanted = null;    // what it has still to be told
let connection = null;

export function listenToLoad(to) {
  connection = to;
  $("load-kind").addEventListener("change", () => change({ kind: $("load-kind").value }));
}

// `things` are the sliders of mass, size, azimuth and elevation.
export function buildLoad(things, complain) {
  const kind = JSON.stringify(things);
  if (sliders.kind === kind) return;  // one of them may be being dragged
  const named = Object.fromEntries(things.map((thing) => [thing.name, thing]));
  sliders = { kind };
  for (const [what, names] of Object.entries(FIELDS)) {
    sliders[what] = new Sliders(what, names.map((name) => named[name]), {
      target: (index) => (wanted ?? shown)[names[index]],
      go: (values) => change(Object.fromEntries(values.flatMap((value, k) => (value === null ? [] : [[names[k], value]])))),
      restore: () => showLoad(shown),
      complain,
    });
  }
}

function change(some) {
  const { kind, mass, size, azimuth, elevation } = { ...(wanted ?? shown), ...some };
  wanted = { kind, mass, size, azimuth, elevation };
  connection.send({ command: "load", ...wanted });
  showKind(kind);
}

export function showLoad(load) {
  shown = load;
  if (connection.idle) wanted = null;
  const { kind } = wanted ?? load;
  showKind(kind);
  for (const [what, names] of Object.entries(FIELDS)) {
    sliders[what].show(names.map((name) => load[name]), wanted && names.map((name) => wanted[name]), []);
  }
  showEfforts(load.efforts, load.beyond);
  $("load-note").textContent = load.refusal || load.note;
  $("load-note").title = load.reason;
  $("load-note").classList.toggle("refused", load.refusal !== "");
}

function showKind(kind) {
  $("load-kind").value = kind;
  for (const what of Object.keys(FIELDS)) $(`${what}s`).hidden = what !== kind;
}

function showEfforts(efforts, beyond) {
  const names = [...$("efforts").children].map((row) => row.title);
  if (names.join() !== efforts.map((one) => one.name).join()) $("efforts").replaceChildren(...efforts.map(buildRow));
  const largest = Math.max(0, ...efforts.filter((one) => one.limit === null).map((one) => Math.abs(one.value)));
  [...$("efforts").children].forEach((row, index) => showRow(row, efforts[index], beyond[index], largest));
}

function buildRow({ name, unit }) {
  const bar = element("div", { class: "bar-of-effort", role: "meter", "aria-label": `Effort of ${name}` }, element("span", { class: "fill" }));
  return element(
    "div", { class: "effort", title: name }, element("span", { class: "name" }, ...broken(name)), bar,
    element("span", { class: "value" }), element("span", { class: "unit" }, unit), element("span", { class: "of-limit" }),
  );
}

// Of motors without a limit the bars are shares of the largest effort among them.
function showRow(row, effort, beyond, largest) {
  const [, bar, value, , share] = row.children;
  const whole = effort.limit ?? largest;
  const end = Math.max(-WIDEST, Math.min(WIDEST, whole > 0 ? (effort.value ?? 0) / whole : 0));
  const fill = bar.firstChild;
  fill.style.left = `${50 + (50 * Math.min(end, 0)) / WIDEST}%`;
  fill.style.width = `${(50 * Math.abs(end)) / WIDEST}%`;
  row.classList.toggle("beyond", beyond);
  row.classList.toggle("unlimited", effort.limit === null);
  value.textContent = fixed(effort.value, digitsOf(effort));
  share.textContent = words(effort);
  const said = effort.value === null ? "none" : `${value.textContent} ${effort.unit}`;
  const told = { valuemin: -whole, valuemax: whole, valuenow: effort.value ?? 0, valuetext: `${said}, ${share.textContent}${beyond ? ", beyond the limit" : ""}` };
  for (const [name, text] of Object.entries(told)) bar.setAttribute(`aria-${name}`, text);
}

// As many as the limit has use for, so that they do not change from pose to pose.
const digitsOf = (effort) => (effort.limit === null ? 3 : Math.min(4, decimalsFor([effort.limit])));

function words({ value, limit }) {
  if (limit === null) return "no limit stated";
  const share = value === null ? "" : `${(100 * Math.abs(value / limit)).toFixed(0)} % `;
  return `${share}of ${Number(limit.toPrecision(4))}`;
}
