// The page of `pmjac view`: sends motor values, one message in flight, and shows the answers.
"use strict";

const $ = (id) => document.getElementById(id);
const SVG = "http://www.w3.org/2000/svg";
const ROWS = [["v", "x", "m/s"], ["v", "y", "m/s"], ["v", "z", "m/s"], ["ω", "x", "rad/s"], ["ω", "y", "rad/s"], ["ω", "z", "rad/s"]];
const HINT = "Drag a slider, or type a value. Drag the picture to turn it.";

let socket = null;
let about = null;      // what never changes: motors, poses, the size of the picture
let state = null;      // the newest that is shown
let nextId = 1;
let inFlight = null;   // the number of the command that is not answered yet
let wanted = null;     // motor values that wait until it is
let waiting = [];      // other commands that do
let motors = [];       // the elements of each motor
let decimals = {};     // fixed for each kind of number, so that numbers do not jump
let limit = 0;         // half the width of the section plots, m/s

window.pmjac = {
  updates: 0,  // answers that have been shown
  state: null,
  ready: false,
  idle: () => inFlight === null && wanted === null && waiting.length === 0,
};

// ---------------------------------------------------------------- numbers

const minus = (text) => text.replace("-", "−");

function fixed(value, digits) {
  if (value === null || !Number.isFinite(value)) return "—";
  const size = Math.abs(value);
  if (size >= 1e5) return minus(value.toExponential(2));
  const surplus = size >= 100 ? Math.floor(Math.log10(size)) - 1 : 0;  // as wide as the others
  const text = value.toFixed(Math.max(1, digits - surplus));
  return minus(Number(text) === 0 ? (0).toFixed(digits) : text);
}

function relative(value) {  // numbers that may fall towards zero
  if (value === null) return "—";
  return minus(value >= 1e-3 || value === 0 ? value.toFixed(4) : value.toExponential(2));
}

// Four significant digits of the largest number at home, and as many decimals for all.
function decimalsFor(values) {
  const largest = Math.max(0, ...values.map(Math.abs));
  if (largest === 0) return 4;
  return Math.min(9, Math.max(2, 3 - Math.floor(Math.log10(largest)) + (largest < 1 ? 0 : 1)));
}

const motorDecimals = (motor) => Math.min(9, Math.max(4, 4 - Math.floor(Math.log10(motor.upper - motor.lower || 1))));

function niceStep(range) {  // of an arrow key: about a two-hundredth
  const raw = range / 200 || 1e-3;
  const power = 10 ** Math.floor(Math.log10(raw));
  return power * [1, 2, 5, 10].find((factor) => factor * power >= 0.999 * raw);
}

// ---------------------------------------------------------------- conversation

function connect() {
  socket = new WebSocket(`ws://${location.host}/control`);
  socket.onmessage = (event) => receive(JSON.parse(event.data));
  socket.onclose = lost;
}

function lost() {
  say("error", "The connection to Python has ended: the picture stays as it was.");
  inFlight = null;
  document.querySelectorAll("button:not(#reset):not(#snapshot), input, select").forEach((element) => { element.disabled = true; });
}

function send(command) {
  if (socket.readyState !== WebSocket.OPEN) return;
  if (command.command === "move") wanted = command;
  else waiting.push(command);
  pump();
}

function pump() {
  if (inFlight !== null) return;
  const command = waiting.shift() ?? wanted;
  if (!command) return;
  if (command === wanted) wanted = null;
  inFlight = command.id = nextId++;
  socket.send(JSON.stringify(command));
}

function receive(message) {
  const mine = message.id !== null && message.id === inFlight;
  if (mine) inFlight = null;
  if (message.type === "error") {
    say("error", message.message);
    if (!wanted) showMotors();
  } else {
    if (message.about) build(message.about);
    // An answer to an older message of ours, or to another page, while we are moving on.
    state = window.pmjac.state = message;
    show();
    if (mine) window.pmjac.updates += 1;
  }
  pump();
  document.dispatchEvent(new CustomEvent("pmjac-update", { detail: message }));
}

// ---------------------------------------------------------------- building, once

function build(news) {
  about = news;
  const home = about.home;
  document.title = `${about.mechanism} · pmjac`;
  $("name").textContent = about.mechanism;
  $("description").textContent = about.description;
  const rows = home.J_eq ?? [];
  decimals = { linear: decimalsFor(rows.slice(0, 3).flat()), angular: decimalsFor(rows.slice(3).flat()) };
  decimals.Jv = decimalsFor(home.Jv_singular_values ?? []);
  decimals.Jw = decimalsFor(home.Jw_singular_values ?? []);
  $("pose").replaceChildren(new Option("moved", ""), ...about.poses.map((name) => new Option(name, name)));
  $("pose").options[0].hidden = true;
  motors = about.motors.map(buildMotor);
  $("motors").replaceChildren(...motors.map((motor) => motor.row));
  buildJacobian();
  $("sections").replaceChildren(...["zy", "zx", "xy"].map(buildSection));
  window.pmjac.ready = true;
  fitView();
}

function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

function buildMotor(motor, index) {
  const id = `motor-${index}`;
  const digits = motorDecimals(motor);
  const step = niceStep(motor.upper - motor.lower);
  const range = motor.limited ? `limits ${fixed(motor.lower, digits)} to ${fixed(motor.upper, digits)}` : "no limits";
  const label = element("label", { for: id, title: motor.name }, ...broken(motor.name));
  const slider = element("input", { type: "range", id, min: motor.lower, max: motor.upper, step: "any" });
  const box = element("input", {
    type: "text", inputmode: "decimal", id: `${id}-value`, autocomplete: "off", spellcheck: "false",
    "aria-label": `${motor.name}, exact value in ${motor.unit}, ${range}`,
  });
  const end = (value) => element("span", {}, fixed(value, 2));
  const limits = element("div", { class: "limits", title: range, "aria-hidden": "true" }, end(motor.lower), end(motor.upper));
  const row = element("div", { class: "motor" }, label, slider, box, element("span", { class: "unit" }, motor.unit), limits);

  slider.addEventListener("input", () => move(index, slider.valueAsNumber));
  slider.addEventListener("keydown", (event) => arrow(event, index, step));
  box.addEventListener("keydown", (event) => {
    if (event.key === "Enter") typed(index);
    else if (event.key === "Escape") { box.dataset.dirty = ""; showMotors(); }
    else if (event.key === "ArrowUp" || event.key === "ArrowDown") { box.dataset.dirty = ""; arrow(event, index, step); }
  });
  box.addEventListener("input", () => { box.dataset.dirty = "yes"; });
  box.addEventListener("blur", () => { if (box.dataset.dirty) typed(index); });
  return { row, slider, box, digits, motor };
}

function arrow(event, index, step) {
  const direction = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
  if (direction === undefined || event.altKey || event.ctrlKey || event.metaKey) return;
  event.preventDefault();
  const { lower, upper } = about.motors[index];
  const from = (wanted?.values ?? state.values)[index];
  const by = direction * step * (event.shiftKey ? 0.1 : 1);
  move(index, Math.min(upper, Math.max(lower, from + by)));
}

function typed(index) {
  const { box, motor } = motors[index];
  box.dataset.dirty = "";
  const text = box.value.trim().replace("−", "-").replace(",", ".");
  const value = text === "" ? NaN : Number(text);
  if (!Number.isFinite(value)) {
    box.setAttribute("aria-invalid", "true");
    say("error", `“${box.value}” is no number; ${motor.name} stays where it is.`);
    return;
  }
  move(index, value);
}

function move(index, value) {
  const values = [...(wanted?.values ?? state.values)];
  values[index] = value;
  send({ command: "move", values });
}

function buildJacobian() {
  const head = element("tr", {}, element("td", {}));
  for (const motor of about.motors) {
    head.append(element("th", { scope: "col", title: motor.name }, ...broken(motor.name), element("span", { class: "unit" }, `per ${motor.unit}/s`)));
  }
  const body = element("tbody");
  for (const [letter, axis, unit] of ROWS) {
    const name = element("th", { scope: "row" }, element("i", {}, letter), element("sub", {}, axis), " ", element("span", { class: "unit" }, unit));
    body.append(element("tr", {}, name, ...about.motors.map(() => element("td"))));
  }
  $("jacobian").replaceChildren(element("thead", {}, head), body);
}

// Long names may be broken after an underscore.
const broken = (name) => name.split("_").flatMap((part, k) => (k ? ["_", element("wbr"), part] : [part]));

function drawn(tag, attributes, text) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  if (text !== undefined) made.textContent = text;
  return made;
}

function buildSection(plane) {
  const svg = drawn("svg", { viewBox: "0 0 120 120", role: "img", id: `section-${plane}` });
  svg.append(
    drawn("path", { class: "grid", d: "M10 35H110M10 85H110M35 10V110M85 10V110M10 10H110V110H10Z" }),
    drawn("path", { class: "axis", d: "M10 60H110M60 10V110" }),
    letter(110, 118, "end", plane[0]),
    letter(10, 7.5, "start", plane[1]),
    drawn("text", { class: "limit", x: 10, y: 118 }, ""),
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

// ---------------------------------------------------------------- showing, at every answer

function show() {
  showMotors();
  showReadout();
  showJacobian();
  showSections();
  const { drawn: options } = state;
  for (const name of ["linear", "angular", "force"]) $(name).checked = options[name];
  if (document.activeElement !== $("scale") || inFlight === null) showScale(options.scale);
  $("pose").value = state.pose ?? "";
  const level = state.readout.warning.level;
  say(state.notice.kind || level, state.notice.text, state.readout.warning.text);
}

function showMotors() {
  const values = wanted?.values ?? state.values;
  motors.forEach(({ slider, box, digits, motor }, index) => {
    slider.value = values[index];
    const text = fixed(state.values[index], digits);
    slider.setAttribute("aria-valuetext", `${text} ${motor.unit}`);
    if (box.dataset.dirty) return;
    const plain = text.replace("−", "-");
    if (box.value !== plain) box.value = plain;
    box.removeAttribute("aria-invalid");
  });
}

function put(id, texts) {
  const place = $(id);
  if (place.children.length !== texts.length) {
    // With blanks between them: they are read aloud, too.
    place.replaceChildren(...texts.flatMap(() => [" ", element("span")]));
  }
  texts.forEach((text, index) => { place.children[index].textContent = text; });
}

function showReadout() {
  const { readout } = state;
  put("sigma-v", (readout.Jv_singular_values ?? [null]).map((value) => fixed(value, decimals.Jv)));
  put("sigma-w", (readout.Jw_singular_values ?? [null]).map((value) => fixed(value, decimals.Jw)));
  put("smallest", [readout.loops ? relative(readout.smallest) : "no loops"]);
  put("condition", [readout.loops ? (readout.condition === null ? "∞" : fixed(readout.condition, 1)) : "no loops"]);
  put("residual", [minus(readout.residual.toExponential(1))]);
  $("refusal").textContent = readout.refusal ? "There is no equivalent Jacobian at this pose." : "";
  $("refusal").title = readout.refusal ?? "";
}

function showJacobian() {
  const rows = state.readout.J_eq;
  const body = $("jacobian").tBodies[0];
  for (let i = 0; i < 6; i += 1) {
    const digits = i < 3 ? decimals.linear : decimals.angular;
    for (let j = 0; j < motors.length; j += 1) {
      body.rows[i].cells[j + 1].textContent = fixed(rows ? rows[i][j] : null, digits);
    }
  }
}

function showSections() {
  const sections = state.readout.sections;
  const largest = sections ? Math.max(...sections.map((section) => section.radii[0])) : 0;
  // Larger at once, smaller only when much is left over: the plots do not flicker in size.
  if (largest > limit || largest < limit / 3) limit = niceLimit(largest);
  for (const plane of ["zy", "zx", "xy"]) {
    const section = sections?.find((candidate) => candidate.plane === plane);
    const svg = $(`section-${plane}`);
    const radii = section ? section.radii.map((value) => fixed(value, decimals.Jv)).join(" × ") : "—";
    svg.querySelector("polygon").setAttribute("points", section ? outline(section) : "");
    svg.querySelector(".limit").textContent = limit ? `± ${Number(limit.toPrecision(2))}` : "";
    svg.setAttribute("aria-label", `Section in the ${plane} plane, radii ${radii} m/s`);
    $(`radii-${plane}`).textContent = radii;
  }
}

function niceLimit(value) {
  if (!(value > 0)) return limit;
  const power = 10 ** Math.floor(Math.log10(value));
  return power * [1, 1.5, 2, 3, 5, 7.5, 10].find((factor) => factor * power >= 1.02 * value) || value;
}

function outline({ radii, axes }) {
  const points = [];
  for (let k = 0; k < 72; k += 1) {
    const a = radii[0] * Math.cos((k * Math.PI) / 36);
    const b = radii[1] * Math.sin((k * Math.PI) / 36);
    const x = 60 + (50 / limit) * (a * axes[0][0] + b * axes[1][0]);
    const y = 60 - (50 / limit) * (a * axes[0][1] + b * axes[1][1]);
    points.push(`${x.toFixed(2)},${y.toFixed(2)}`);
  }
  return points.join(" ");
}

function showScale(scale) {
  $("scale").value = Math.log10(scale);
  $("scale-value").textContent = `× ${scale.toFixed(2)}`;
  $("scale").setAttribute("aria-valuetext", `times ${scale.toFixed(2)}`);
}

// Text is set only when it changes, so that a screen reader says it once.
function say(kind, notice, warning = "") {
  const quiet = !notice && !warning;
  const level = state?.readout.warning.level ?? "regular";
  $("status").className = `status ${kind} ${level}`;
  const texts = { notice: quiet ? HINT : notice, warning };
  for (const [id, text] of Object.entries(texts)) {
    if ($(id).textContent !== text) $(id).textContent = text;
  }
}

// ---------------------------------------------------------------- the picture

let touched = false;  // whether the user has turned it

function picture() {
  return $("scene").contentWindow?.viewer ?? null;
}

function adopt() {
  const viewer = picture();
  if (!viewer) {
    say("error", "This browser cannot draw in three dimensions (no WebGL); all else works.");
    return;
  }
  viewer.dom_element.addEventListener("pointerdown", () => { touched = true; });
  viewer.dom_element.addEventListener("wheel", () => { touched = true; }, { passive: true });
  $("scene").contentWindow.addEventListener("resize", () => { if (!touched) fitView(); });
  fitView();
}

function fitView() {
  const { contentWindow: inner, clientWidth, clientHeight } = $("scene");
  if (picture() && about) inner.fitView(picture(), about.framing, clientWidth, clientHeight);
}

function snapshot() {
  const viewer = picture();
  if (!viewer) return;
  const link = element("a", { href: viewer.capture_image(), download: `${about.mechanism.replace(/[^\w.-]+/g, "_")}.png` });
  link.click();
}

// ---------------------------------------------------------------- beginning

function options() {
  const chosen = Object.fromEntries(["linear", "angular", "force"].map((name) => [name, $(name).checked]));
  send({ command: "options", ...chosen, scale: 10 ** $("scale").valueAsNumber });
}

$("home").addEventListener("click", () => send({ command: "home" }));
$("reset").addEventListener("click", () => { touched = false; fitView(); });
$("snapshot").addEventListener("click", snapshot);
$("pose").addEventListener("change", () => send({ command: "pose", name: $("pose").value }));
for (const name of ["linear", "angular", "force"]) $(name).addEventListener("change", options);
$("scale").addEventListener("input", () => {
  showScale(10 ** $("scale").valueAsNumber);
  waiting = waiting.filter((command) => command.command !== "options");
  options();
});

if ($("scene").contentDocument?.readyState === "complete" && picture()) adopt();
else $("scene").addEventListener("load", adopt, { once: true });
connect();
