// Moves a motor to and fro between its ends, or as far as its assembly mode goes.

import { element } from "./elements.js";

const CROSSING = 6;   // seconds from end to end
const LONGEST = 100;  // milliseconds that one step may stand for: nothing leaps after a pause

export class Play {
  #playing = false;
  #way = 1;
  #turned = NaN;  // where it turned last
  #last = 0;

  // `actions` has go(value) and free(), whether nothing waits to be sent.
  constructor(id, { name, lower, upper }, actions) {
    Object.assign(this, { name, lower, upper, actions, value: lower });
    this.button = element("button", { type: "button", id, class: "play" });
    this.button.addEventListener("click", () => (this.#playing ? this.rest() : this.#start()));
    this.#name();
  }

  // Where the motor is now, and on which side, 1 or -1, it cannot go on; 0 if it can.
  show(value, stop) {
    this.value = value;
    const end = this.#way > 0 ? value >= this.upper : value <= this.lower;
    if (!this.#playing || !(end || stop === this.#way)) return;
    if (Math.abs(value - this.#turned) <= 1e-6 * (this.upper - this.lower)) this.rest();
    this.#turned = value;
    this.#way = -this.#way;
  }

  rest() {
    this.#playing = false;
    this.#name();
  }

  #start() {
    this.#playing = true;
    this.#turned = NaN;
    this.#last = performance.now();
    this.#name();
    requestAnimationFrame((now) => this.#step(now));
  }

  #step(now) {
    if (!this.#playing) return;
    requestAnimationFrame((next) => this.#step(next));
    if (!this.actions.free()) return;  // Python has not seen the last step yet
    const by = (Math.min(Math.max(now - this.#last, 0), LONGEST) / 1000) * ((this.upper - this.lower) / CROSSING);
    this.#last = now;
    this.actions.go(Math.min(this.upper, Math.max(this.lower, this.value + this.#way * by)));
  }

  #name() {
    this.button.textContent = this.#playing ? "❚❚" : "▶";
    this.button.setAttribute("aria-label", `${this.#playing ? "Stop" : "Play"} ${this.name}`);
    this.button.setAttribute("aria-pressed", this.#playing);
  }
}
