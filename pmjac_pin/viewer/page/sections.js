// The lecture's three sections of the velocity ellipsoid, as SVG.

import { $, element } from "./elements.js";
import { fixed } from "./numbers.js";

const SVG = "http://www.w3.org/2000/svg";
const PLANES = ["zy", "zx", "xy"];

let limit = 0;  // half the width of the plots, m/s

export function buildSections() {
  $("sections").replaceChildren(...PLANES.map(build));
}

export function showSections(sections, digits) {
  const largest = sections ? Math.max(...sections.map((section) => section.radii[0])) : 0;
  // Larger at once, smaller only when much is left over: the plots do not flicker in size.
  if (largest > limit || largest < limit / 3) limit = niceLimit(largest);
  for (const plane of PLANES) show(plane, sections?.find((section) => section.plane === plane), digits);
}

function show(plane, section, digits) {
  const svg = $(`section-${plane}`);
  const radii = section ? section.radii.map((value) => fixed(value, digits)).join(" × ") : "—";
  svg.querySelector("polygon").setAttribute("points", section ? outline(section) : "");
  svg.querySelector(".limit").textContent = limit ? `± ${Number(limit.toPrecision(2))}` : "";
  svg.setAttribute("aria-label", `Section in the ${plane} plane, radii ${radii} m/s`);
  $(`radii-${plane}`).textContent = radii;
}

function niceLimit(value) {
  if (!(value > 0)) return limit;
  const power = 10 ** Math.floor(Math.log10(value));
  return power * [1, 1.5, 2, 3, 5, 7.5, 10].find((factor) => factor * power >= 1.02 * value) || value;
}

function outline({ radii, axes }) {
  const scale = limit ? 50 / limit : 0;  // no limit while no section is more than a point
  const points = [];
  for (let k = 0; k < 72; k += 1) {
    const a = radii[0] * Math.cos((k * Math.PI) / 36);
    const b = radii[1] * Math.sin((k * Math.PI) / 36);
    const x = 60 + scale * (a * axes[0][0] + b * axes[1][0]);
    const y = 60 - scale * (a * axes[0][1] + b * axes[1][1]);
    points.push(`${x.toFixed(2)},${y.toFixed(2)}`);
  }
  return points.join(" ");
}

function build(plane) {
  const svg = drawn("svg", { viewBox: "0 0 120 120", role: "img", id: `section-${plane}` });
  svg.append(
    drawn("path", { class: "grid", d: "M10 35H110M10 85H110M35 10V110M85 10V110M10 10H110V110H10Z" }),
    drawn("path", { class: "axis", d: "M10 60H110M60 10V110" }),
    letter(110, 118, "end", plane[0]),
    letter(10, 7.5, "start", plane[1]),
    drawn("text", { class: "limit", x: 10, y: 118 }),
    drawn("polygon", { class: "outline", points: "" }),
  );
  const [across, up] = plane.toUpperCase();
  const title = element("div", { class: "plane" }, `${across}–${up} plane`);
  return element("figure", {}, title, svg, element("figcaption", { id: `radii-${plane}` }));
}

function letter(x, y, anchor, axis) {
  const text = drawn("text", { x, y, "text-anchor": anchor }, "v");
  text.append(drawn("tspan", { dy: 2, "font-size": 7 }, axis));
  return text;
}

function drawn(tag, attributes, text = "") {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.textContent = text;
  return made;
}
