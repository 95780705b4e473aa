// The picture: meshcat's viewer in its frame, the first view and the snapshot.

import { $, element } from "./elements.js";

let framing = null;
let touched = false;  // whether the user has turned it

const viewer = () => $("scene").contentWindow?.viewer ?? null;

// Calls `missing` where the browser cannot draw.
export function adoptPicture(missing) {
  const adopt = () => {
    if (!viewer()) return missing();
    const pane = viewer().dom_element;
    for (const event of ["pointerdown", "wheel"]) pane.addEventListener(event, () => { touched = true; }, { passive: true });
    $("scene").contentWindow.addEventListener("resize", () => { if (!touched) fit(); });
    return fit();
  };
  if ($("scene").contentDocument?.readyState === "complete" && viewer()) adopt();
  else $("scene").addEventListener("load", adopt, { once: true });
}

export function frameOn(news) {
  framing = news;
  if (!touched) fit();
}

export function resetView() {
  touched = false;
  fit();
}

export function snapshot(name) {
  if (!viewer()) return;
  element("a", { href: viewer().capture_image(), download: `${name.replace(/[^\w.-]+/g, "_")}.png` }).click();
}

function fit() {
  const { contentWindow: inner, clientWidth, clientHeight } = $("scene");
  if (viewer() && framing) inner.fitView(viewer(), framing, clientWidth, clientHeight);
}
