// The picture: meshcat's viewer in its frame, the first view and the snapshot.

import { $, element } from "./elements.js";

let framing = null;  // the newest, for a stage that is not there yet

const stage = () => $("scene").contentWindow?.stage ?? null;

export function adoptPicture() {
  $("scene").addEventListener("load", () => { if (framing) stage()?.frameOn(framing); });
}

export function frameOn(news) {
  framing = news;
  stage()?.frameOn(news);
}

export const resetView = () => stage()?.reset();

export function snapshot(name) {
  if (!stage()) return;
  const time = new Date(Date.now() - 60000 * new Date().getTimezoneOffset()).toISOString().slice(0, 19);
  const file = `${name}_${time.replace("T", "_").replaceAll(":", "-")}`.replace(/[^\w.-]+/g, "_");
  element("a", { href: stage().viewer.capture_image(), download: `${file}.png` }).click();
}
