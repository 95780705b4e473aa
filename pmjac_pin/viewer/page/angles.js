// Angles in radians, as Python has them, or in degrees.

import { $ } from "./elements.js";

const DEGREE = Math.PI / 180;

// What a number in `unit` is divided by to be shown, and the unit that is then written.
export function shownIn(unit) {
  return unit === "rad" && $("degrees").checked ? [DEGREE, "°"] : [1, unit];
}

export function listenToAngles(change) {
  $("degrees").addEventListener("change", change);
}
