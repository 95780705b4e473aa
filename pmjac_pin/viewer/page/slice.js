// A map of two motors' values: what is reached, what is singular, where we are; a click goes there.

import { shownIn } from "./angles.js";
import { $ } from "./elements.js";
import { decimalsOfRange, fixed } from "./numbers.js";

const SVG = "http://www.w3.org/2000/svg";
const LEFT = 52, TOP = 8, SIZE = 320;  // of the map within its frame, 400 by 370
const STEPS = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const EMPTY = { status: "unknown", text: "", plane: [], lower: [], upper: [], cells: [], curves: [] };

let map = EMPTY;     // the newest that Python has told
let motors = [];     // all, as Python describes them
let values = [];     // where they are
let shown = "";      // what is drawn
let actions = null;  // send(command), and go(values) of the motors

export function listenToSlice(those) {
  actions = those;
  $("draw-slice").addEventListener("click", () => {
    if (map.status === "drawing") actions.send({ command: "stop slice" });
    else actions.send({ command: "draw slice", first: $("slice-first").value, second: $("slice-second").value });
  });
  $("slice-first").addEventListener("change", () => differ("slice-second", "slice-first"));
  $("slice-second").addEventListener("change", () => differ("slice-first", "slice-second"));
  $("slice-map").addEventListener("click", goToClick);
  $("slice-map").addEventListener("keydown", goByKey);
}

export function buildSlice(described) {
  const names = described.map(({ name }) => name);
  $("slice").hidden = names.length < 2;
  if (names.join() !== motors.map(({ name }) => name).join()) {
    for (const [id, first] of [["slice-first", 0], ["slice-second", 1]]) {
      $(id).replaceChildren(...names.map((name) => new Option(name, name, false, name === names[first])));
    }
    showSlice(EMPTY);  // another machine's is none of this one
  }
  motors = described;
}

export function showSlice(message) {
  map = message;
  $("slice").dataset.status = map.status;
  $("draw-slice").textContent = { drawing: "Stop", drawn: "Draw again", stale: "Draw again" }[map.status] ?? "Draw";
  if ($("slice-text").textContent !== map.text) $("slice-text").textContent = map.text;
  draw();
}

// Where the motors are now.
export function showPlace(now) {
  values = now;
  draw();
}

// Both must not be the same motor: the other one gives way.
function differ(other, chosen) {
  if ($(other).value !== $(chosen).value) return;
  $(other).value = motors.find(({ name }) => name !== $(chosen).value).name;
}

const indices = () => map.plane.map((name) => motors.findIndex((motor) => motor.name === name));

function go(place) {
  const [first, second] = indices();
  const wanted = motors.map(() => null);
  [wanted[first], wanted[second]] = place.map((value, k) => Math.min(map.upper[k], Math.max(map.lower[k], value)));
  actions.go(wanted);
}

function goToClick(event) {
  if (!map.plane.length || $("draw-slice").disabled) return;
  const box = $("slice-map").getBoundingClientRect();
  const x = ((event.clientX - box.left) / box.width) * 400;
  const y = ((event.clientY - box.top) / box.height) * 370;
  const share = [(x - LEFT) / SIZE, (TOP + SIZE - y) / SIZE];
  if (share.some((part) => part < 0 || part > 1)) return;
  go(share.map((part, k) => map.lower[k] + part * (map.upper[k] - map.lower[k])));
}

function goByKey(event) {
  const step = STEPS[event.key];
  if (!step || !map.plane.length || event.altKey || event.ctrlKey || event.metaKey) return;
  event.preventDefault();
  const by = event.shiftKey ? 0.1 : 1;
  go(indices().map((index, k) => values[index] + (step[k] * by * (map.upper[k] - map.lower[k])) / (map.cells.length - 1)));
}

const across = (value) => LEFT + (SIZE * (value - map.lower[0])) / (map.upper[0] - map.lower[0]);
const up = (value) => TOP + SIZE - (SIZE * (value - map.lower[1])) / (map.upper[1] - map.lower[1]);

function draw() {
  const svg = $("slice-map");
  svg.toggleAttribute("hidden", map.plane.length === 0);
  if (!map.plane.length) return;
  const units = map.plane.map((_, k) => shownIn(motors[indices()[k]].unit));
  const what = JSON.stringify([map.plane, map.lower, map.upper, map.cells, units, map.curves.length]);
  if (what !== shown) {
    shown = what;
    svg.replaceChildren(...ground(), ...map.curves.map(curve), ...axes(units), made("circle", { id: "slice-here", r: 5 }));
  }
  const place = indices().map((index) => values[index]);
  const inside = place.every((value, k) => value >= map.lower[k] - 1e-9 && value <= map.upper[k] + 1e-9);
  const here = $("slice-here");
  here.toggleAttribute("hidden", !inside);
  here.setAttribute("cx", across(place[0]).toFixed(2));
  here.setAttribute("cy", up(place[1]).toFixed(2));
  const told = place.map((value, k) => `${map.plane[k]} ${fixed(value / units[k][0], 3)} ${units[k][1]}`).join(", ");
  svg.setAttribute("aria-label", `Map of ${map.plane.join(" and ")}; now at ${told}${inside ? "" : ", outside it"}. Arrow keys move by a cell.`);
}

// The cells that are reached, a rectangle for each run of them along the second motor.
function ground() {
  const side = SIZE / (map.cells.length - 1);
  const runs = { 1: "", 2: "" };
  map.cells.forEach((row, i) => {
    for (const { 0: run, index } of row.matchAll(/1+|2+/g)) {
      const x = LEFT + (i - 0.5) * side, y = TOP + SIZE - (index + run.length - 0.5) * side;
      runs[run[0]] += `M${x.toFixed(2)} ${y.toFixed(2)}h${side.toFixed(2)}v${(run.length * side).toFixed(2)}h${(-side).toFixed(2)}z`;
    }
  });
  const clip = made("clipPath", { id: "slice-window" });
  clip.append(made("rect", { x: LEFT, y: TOP, width: SIZE, height: SIZE }));
  return [
    clip,
    made("path", { class: "reached", d: runs[1], "clip-path": "url(#slice-window)" }),
    made("path", { class: "strained", d: runs[2], "clip-path": "url(#slice-window)" }),
  ];
}

function curve({ kind, places }) {
  const points = places.map(([x, y]) => `${across(x).toFixed(2)},${up(y).toFixed(2)}`).join(" ");
  return made("polyline", { class: kind, points });
}

function axes(units) {
  const texts = [0, 0.5, 1].flatMap((share) => {
    const [x, y] = [0, 1].map((k) => number(k, share, units[k][0]));
    const anchor = ["start", "middle", "end"][2 * share];
    return [
      made("text", { x: LEFT + share * SIZE, y: TOP + SIZE + 14, "text-anchor": anchor }, x),
      made("text", { x: LEFT - 5, y: TOP + SIZE - share * (SIZE - 9), "text-anchor": "end" }, y),
    ];
  });
  const [first, second] = map.plane.map((name, k) => `${name} [${units[k][1]}]`);
  const middle = TOP + SIZE / 2;
  return [
    made("rect", { class: "frame", x: LEFT, y: TOP, width: SIZE, height: SIZE }),
    ...texts,
    made("text", { x: LEFT + SIZE / 2, y: TOP + SIZE + 32, "text-anchor": "middle", class: "name" }, first),
    made("text", { x: 12, y: middle, "text-anchor": "middle", class: "name", transform: `rotate(-90 12 ${middle})` }, second),
  ];
}

function number(k, share, size) {
  const width = (map.upper[k] - map.lower[k]) / size;
  return fixed(map.lower[k] / size + share * width, Math.min(3, decimalsOfRange(width) - 2));
}

function made(tag, attributes, text = "") {
  const one = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) one.setAttribute(name, value);
  one.textContent = text;
  return one;
}
