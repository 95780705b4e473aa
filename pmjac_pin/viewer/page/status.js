// The line under the picture: what has happened, and how near a singularity is, and which joints are beyond their limits.

import { $ } from "./elements.js";

const HINT = "Drag a slider, or type a value. Drag the picture, or use its arrow keys, to turn it.";

// Text is set only when it changes, so that a screen reader says it once.
export function say(kind, notice, warning = { level: "regular", text: "" }, beyond = "") {
  const quiet = !notice && !beyond && ["regular", "loss"].includes(warning.level);
  $("status").className = `status ${kind} ${warning.level}${beyond ? " beyond" : ""}`;
  const texts = { notice: quiet ? HINT : notice, warning: warning.text, beyond };
  for (const [id, text] of Object.entries(texts)) {
    if ($(id).textContent !== text) $(id).textContent = text;
  }
  // What has to be scrolled can be reached with the keyboard.
  const scrolls = $("status").scrollHeight > $("status").clientHeight;
  if (scrolls) $("status").setAttribute("tabindex", "0");
  else $("status").removeAttribute("tabindex");
}
