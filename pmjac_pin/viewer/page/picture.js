// The picture: meshcat's viewer in its frame, and what it looks at.

import { $ } from "./elements.js";

let framing = null;  // the newest, for a stage that is not there yet

const stage = () => $("scene").contentWindow?.stage ?? null;

export function adoptPicture() {
  $("scene").addEventListener("load", () => { if (framing) stage()?.frameOn(framing); });
}

export function frameOn(news) {
  framing = news;
  stage()?.frameOn(news);
}

// What is shown now, after a jump, may lie outside.
export function keepInView(news) {
  framing = news;
  stage()?.keepInView(news);
}

export const resetView = () => stage()?.reset();

// The scene as it is seen, as wide as wished; null where the browser cannot draw.
export const capture = () => stage() && ((width) => stage().capture(width));
