// A slider and a box for each motor, and for each parameter.

import { shownIn } from "./angles.js";
import { $, broken, element } from "./elements.js";
import { decimalsOfRange, fixed, niceStep } from "./numbers.js";
import { Play } from "./play.js";

const DIRECTIONS = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 };

export class Sliders {
  #rows = [];

  // `kind` is "motor" or "parameter", `things` are those from Python; `actions` has target(index),
  // go(values), restore() and complain(text), and free() where they can be played.
  constructor(kind, things, actions) {
    this.kind = kind;
    this.actions = actions;
    this.#rows = things.map((thing, index) => this.#build(thing, index));
    $(`${kind}s`).replaceChildren(...this.#rows.map((row) => row.row));
  }

  // Nothing moves by itself any more.
  rest() {
    for (const { play } of this.#rows) play?.rest();
  }

  // Numbers say what is; a slider that is being dragged stands where it is wanted, but never
  // beyond a stop. `stops` has the side of each motor's stop, 1 or -1, or 0.
  show(values, wanted, stops) {
    this.#rows.forEach((row, index) => {
      const { slider, box, digits, motor } = row;
      row.play?.show(values[index], stops[index] ?? 0);
      row.stop = stops[index] ? { side: stops[index], at: values[index] } : null;
      slider.value = this.#within(row, wanted?.[index] ?? values[index]);
      const [size, unit] = shownIn(motor.unit);
      const text = fixed(values[index] / size, size === 1 ? digits : 2);
      slider.setAttribute("aria-valuetext", `${text} ${unit}`);
      this.#nameUnit(row, size, unit);
      if (box.dataset.dirty) return;
      const plain = text.replace("−", "-");
      if (box.value !== plain) box.value = plain;
      box.removeAttribute("aria-invalid");
    });
  }

  #build(motor, index) {
    const id = `${this.kind}-${index}`;
    const digits = decimalsOfRange(motor.upper - motor.lower);
    const label = element("label", { for: id, title: motor.meaning || motor.name }, ...broken(motor.name));
    const slider = element("input", { type: "range", id, min: motor.lower, max: motor.upper, step: "any" });
    const box = element("input", {
      type: "text", inputmode: "decimal", id: `${id}-value`, autocomplete: "off", spellcheck: "false",
    });
    const limits = element("div", { class: "limits", "aria-hidden": "true" });
    const unit = element("span", { class: "unit" });
    const play = this.actions.free
      ? new Play(`${id}-play`, motor, { go: (value) => this.#move(index, value), free: this.actions.free })
      : null;
    const row = element("div", { class: "motor" }, label, slider, box, unit, limits);
    if (play) row.prepend(play.button);
    const built = { row, slider, box, unit, limits, digits, motor, index, play, step: niceStep(motor.upper - motor.lower) };
    this.#listen(built);
    return built;
  }

  // The unit and the range, where they are not written yet.
  #nameUnit({ box, unit, limits, digits, motor }, size, shown) {
    if (unit.textContent === shown) return;
    unit.textContent = shown;
    const ends = (decimals) => [motor.lower, motor.upper].map((value) => fixed(value / size, decimals));
    const [lower, upper] = ends(size === 1 ? digits : 2);
    limits.title = motor.limited ? `limits ${lower} to ${upper}` : "no limits";
    limits.replaceChildren(...ends(size === 1 ? 2 : 0).map((text) => element("span", {}, text)));
    box.setAttribute("aria-label", `${motor.name}, exact value in ${shown}, ${limits.title}`);
  }

  #listen(row) {
    const { slider, box, index } = row;
    slider.addEventListener("input", () => {
      row.play?.rest();
      const value = slider.valueAsNumber;
      const possible = this.#within(row, value);
      if (possible === value) this.#move(index, value);
      else slider.value = possible;
    });
    slider.addEventListener("keydown", (event) => this.#arrow(event, row));
    box.addEventListener("keydown", (event) => {
      if (event.key === "Enter") this.#typed(row);
      else if (event.key === "Escape") { box.dataset.dirty = ""; this.actions.restore(); }
      else if (event.key === "ArrowUp" || event.key === "ArrowDown") { box.dataset.dirty = ""; this.#arrow(event, row); }
    });
    box.addEventListener("input", () => { box.dataset.dirty = "yes"; });
    box.addEventListener("blur", () => { if (box.dataset.dirty) this.#typed(row); });
  }

  #within({ stop }, value) {
    return stop && stop.side * (value - stop.at) > 0 ? stop.at : value;
  }

  #move(index, value) {
    // Other motors may be moved by another page just now.
    this.actions.go(this.#rows.map((row) => (row.index === index ? value : null)));
  }

  #arrow(event, { index, step, motor, play }) {
    const direction = DIRECTIONS[event.key];
    if (direction === undefined || event.altKey || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    play?.rest();
    const by = direction * step * (event.shiftKey ? 0.1 : 1);
    this.#move(index, Math.min(motor.upper, Math.max(motor.lower, this.actions.target(index) + by)));
  }

  #typed({ box, motor, index, play }) {
    if (!box.dataset.dirty) return;  // it shows fewer digits than the value has
    box.dataset.dirty = "";
    const text = box.value.trim().replace("−", "-").replace(",", ".");
    const value = text === "" ? NaN : Number(text) * shownIn(motor.unit)[0];
    play?.rest();
    if (Number.isFinite(value)) this.#move(index, value);
    else {
      box.setAttribute("aria-invalid", "true");
      this.actions.complain(`“${box.value}” is no number; ${motor.name} stays where it is.`);
    }
  }
}
