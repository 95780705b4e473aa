// A picture of what is shown, larger than its pane: with a title, the numbers and the colours' meaning.

import { shownIn } from "./angles.js";
import { element } from "./elements.js";
import { fixed } from "./numbers.js";

const WIDTH = 2400;             // pixels
const EDGE = WIDTH / 48;
const LINE = WIDTH / 50;        // from one line of text to the next
const FONT = `${WIDTH / 75}px system-ui, sans-serif`;
const TITLE = `600 ${WIDTH / 55}px system-ui, sans-serif`;
const DOT = WIDTH / 160;

// `capture` returns the scene as a PNG of a given width; `about` and `state` are Python's.
export async function snapshot(capture, about, state) {
  const scene = new Image();
  scene.src = capture(WIDTH);
  await scene.decode();
  const canvas = element("canvas", { width: WIDTH });
  const pen = canvas.getContext("2d");
  const words = broken(pen, sentences(about, state));
  const rows = legendRows(pen, about.legend);
  canvas.height = Math.round(scene.height + LINE * (words.length + rows.length + 1.5) + 3 * EDGE);
  pen.fillStyle = "#fff";
  pen.fillRect(0, 0, canvas.width, canvas.height);
  let y = EDGE + LINE;
  write(pen, TITLE, about.mechanism, EDGE, y);
  for (const line of words) write(pen, FONT, line, EDGE, (y += LINE));
  pen.drawImage(scene, 0, (y += EDGE / 2));
  y += scene.height + EDGE / 2;
  for (const row of rows) drawLegend(pen, row, (y += LINE));
  const blob = await new Promise((done) => { canvas.toBlob(done, "image/png"); });
  const href = URL.createObjectURL(blob);
  element("a", { href, download: fileName(about.mechanism) }).click();
  setTimeout(() => URL.revokeObjectURL(href), 60000);
}

function sentences({ motors, parameters }, state) {
  const said = (things, values) => things.map(({ name, unit }, k) => {
    const [size, shown] = shownIn(unit);
    return `${name} = ${fixed(values[k] / size, 4)} ${shown}`;
  });
  const pose = state.pose ? [`pose ${state.pose}`] : [];
  const lines = [[...pose, ...said(motors, state.values)], said(parameters, state.parameters)];
  return [...lines.map((parts) => parts.join(",  ")), state.readout.warning.text, state.readout.beyond].filter(Boolean);
}

// Lines that fit the picture, broken between words.
function broken(pen, lines) {
  pen.font = FONT;
  return lines.flatMap((line) => {
    const fitting = [""];
    for (const part of line.split("  ")) {
      const longer = `${fitting.at(-1)} ${part}`.trim();
      if (pen.measureText(longer).width > WIDTH - 2 * EDGE) fitting.push(part);
      else fitting[fitting.length - 1] = longer;
    }
    return fitting.filter(Boolean);
  });
}

// The legend's entries with where they begin, in as many rows as they need.
function legendRows(pen, legend) {
  pen.font = FONT;
  const rows = [];
  let x = WIDTH;
  for (const { text, colours } of legend) {
    const width = 3 * DOT * colours.length + pen.measureText(text).width + 4 * DOT;
    if (x + width > WIDTH - EDGE) {
      rows.push([]);
      x = EDGE;
    }
    rows.at(-1).push({ text, colours, x });
    x += width;
  }
  return rows;
}

function drawLegend(pen, row, y) {
  for (const { text, colours, x } of row) {
    colours.forEach((colour, k) => {
      pen.fillStyle = colour;
      pen.beginPath();
      pen.arc(x + DOT + 3 * DOT * k, y - 0.7 * DOT, DOT, 0, 2 * Math.PI);
      pen.fill();
    });
    write(pen, FONT, text, x + 3 * DOT * colours.length, y);
  }
}

function write(pen, font, text, x, y) {
  pen.font = font;
  pen.fillStyle = "#1b2733";
  pen.fillText(text, x, y);
}

function fileName(name) {
  const time = new Date(Date.now() - 60000 * new Date().getTimezoneOffset()).toISOString().slice(0, 19);
  return `${`${name}_${time.replace("T", "_").replaceAll(":", "-")}`.replace(/[^\w.-]+/g, "_")}.png`;
}
