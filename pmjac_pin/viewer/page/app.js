// The page of `pmjac view`: sends motor values, and shows what Python answers.

import { Connection } from "./connection.js";
import { $ } from "./elements.js";
import { listenToAngles } from "./angles.js";
import { buildLegend } from "./legend.js";
import { buildLoad, listenToLoad, showLoad } from "./load.js";
import { listenToModes, showModes } from "./modes.js";
import { listenToOptions, showOptions } from "./options.js";
import { adoptPicture, capture, frameOn, keepInView, resetView } from "./picture.js";
import { buildJacobian, copyJacobian, decimalsAt, showReadout } from "./readout.js";
import { buildSections, showSections } from "./sections.js";
import { buildReplay, restReplay, showReplay } from "./replay.js";
import { buildSlice, listenToSlice, showPlace, showSlice } from "./slice.js";
import { Sliders } from "./sliders.js";
import { snapshot } from "./snapshot.js";
import { say } from "./status.js";
import { buildTool, showTool } from "./tool.js";

let state = null;      // the newest that is shown
let about = null;      // what is the same at all poses
let decimals = null;
let motors = null;
let parameters = null;
let connection = null;

// What scripts and tests may look at.
window.pmjac = {
  updates: 0,  // answers that have been shown
  state: null,
  ready: false,
  idle: () => connection.idle,
};

function build(news) {
  about = news;
  document.title = `${about.mechanism} · pmjac`;
  $("name").textContent = about.mechanism;
  $("description").textContent = about.description;
  $("counted").textContent = about.counted;
  $("pose").replaceChildren(new Option("moved", ""), ...about.poses.map((name) => new Option(name, name)));
  $("pose").options[0].hidden = true;
  decimals = decimalsAt(about.home);
  motors = new Sliders("motor", about.motors, {
    target: (index) => connection.heading?.[index] ?? state.values[index],
    go: moveMotors,
    free: () => connection.moving === null,
    restore: showMotors,
    complain,
  });
  buildSlice(about.motors);
  buildParameters(about.parameters);
  buildReplay(about, {
    go: (values) => { motors.rest(); connection.send({ command: "moment", values }); },
    free: () => connection.replaying === null,
    restore: showMoment,
    complain,
  });
  buildLegend(about.legend);
  buildTool(about.passive);
  buildLoad(about.load, complain);
  buildJacobian(about.motors);
  buildSections();
}

// Those that are there already stay: one of them may be being dragged.
function buildParameters(declared) {
  $("design").hidden = declared.length === 0;
  const kind = JSON.stringify(declared);
  if (parameters?.declared === kind) return;
  parameters = new Sliders("parameter", declared, {
    target: (index) => connection.setting?.[index] ?? state.parameters[index],
    go: (values) => connection.send({ command: "set", values }),
    restore: showParameters,
    complain,
  });
  parameters.declared = kind;
}

function show() {
  const { readout, notice } = state;
  showMotors();
  showPlace(state.values);
  showParameters();
  showMoment();
  showTool(readout);
  showLoad(state.load);
  showReadout(readout, decimals);
  showSections(readout.sections, decimals.Jv);
  showOptions(state.drawn, connection.idle);
  $("pose").value = state.pose ?? "";
  say(notice.kind, notice.text, readout.warning, readout.beyond);
}

function moveMotors(values) {
  restReplay();
  connection.send({ command: "move", values });
}

function showMotors() {
  motors.show(state.values, connection.moving, state.notice.stops);
}

function showMoment() {
  showReplay(state.moment, connection.replaying);
}

function showParameters() {
  parameters.show(state.parameters, connection.setting, []);
}

const complain = (text) => say("error", text, state?.readout.warning, state?.readout.beyond);

const LOST = "The connection to Python has ended: the picture stays as it was. It goes on by itself when Python serves this page again.";
let focused = null;  // what had the focus when the connection was lost

function lost() {
  if (document.activeElement.id) focused = document.activeElement.id;
  motors?.rest();
  restReplay();
  complain(LOST);
  disable(true);
}

function disable(whether) {
  document.querySelectorAll("button:not(#reset):not(#snapshot), input, select").forEach((control) => { control.disabled = whether; });
}

function found(about) {
  motors?.rest();
  build(about);
  disable(false);
  if (focused && document.activeElement === document.body) $(focused)?.focus();
  focused = null;
}

function goTo(command) {
  motors.rest();
  restReplay();
  connection.send(command);
}

connection = new Connection({
  state(message, mine) {
    state = window.pmjac.state = message;
    if (message.about) found(message.about);
    if (message.framing) frameOn(message.framing);
    if (message.jump) keepInView(message.jump);
    show();
    if (mine) window.pmjac.updates += 1;
    window.pmjac.ready = true;
  },
  told: { modes: showModes, slice: showSlice },
  refused(text) {
    motors.rest();
    restReplay();
    complain(text);
    if (!connection.moving) showMotors();
    showParameters();
    showLoad(state.load);
  },
  lost,
});

$("home").addEventListener("click", () => goTo({ command: "home" }));
$("pose").addEventListener("change", () => goTo({ command: "pose", name: $("pose").value }));
$("reset").addEventListener("click", () => { resetView(); connection.send({ command: "frame" }); });
$("snapshot").addEventListener("click", () => { if (capture()) snapshot(capture(), about, state); });
listenToModes((command) => (command.command === "mode" ? goTo(command) : connection.send(command)));
listenToSlice({ send: (command) => connection.send(command), go: (values) => { motors.rest(); moveMotors(values); } });
listenToLoad(connection);
listenToOptions((command) => connection.send(command));
listenToAngles(show);
$("frame").addEventListener("change", show);
$("copy").addEventListener("click", () => copyJacobian(state.readout));
adoptPicture();
