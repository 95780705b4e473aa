// The assembly modes at the current motor values: found on demand, and a list to go to one of them.

import { $, element } from "./elements.js";
import { minus, relative } from "./numbers.js";

const SIGNS = { 1: ["> 0", "positive"], "-1": ["< 0", "negative"], 0: ["= 0", "zero"] };
const STEPS = { ArrowDown: 1, ArrowUp: -1 };

export function listenToModes(send) {
  $("find-modes").addEventListener("click", () => {
    send({ command: $("modes").dataset.status === "searching" ? "stop search" : "find modes" });
  });
  $("modes").addEventListener("click", (event) => {
    const chosen = event.target.closest("button");
    if (chosen) send({ command: "mode", number: Number(chosen.value) });
  });
  $("modes").addEventListener("keydown", (event) => {
    const buttons = [...$("modes").querySelectorAll("button")];
    const next = { Home: 0, End: buttons.length - 1 }[event.key] ?? buttons.indexOf(event.target) + STEPS[event.key];
    if (!buttons[next]) return;
    event.preventDefault();
    buttons[next].focus();
  });
}

export function showModes({ status, text, current, modes }) {
  const list = $("modes");
  list.dataset.status = status;
  $("find-modes").textContent = { searching: "Stop", found: "Find again" }[status] ?? "Find";
  if ($("modes-text").textContent !== text) $("modes-text").textContent = text;
  const what = JSON.stringify(modes);
  if (list.dataset.what !== what) {
    list.dataset.what = what;
    list.replaceChildren(...modes.map(line));
    $("modes-head").hidden = modes.length === 0;
  }
  for (const button of list.querySelectorAll("button")) {
    if (Number(button.value) === current) button.setAttribute("aria-current", "true");
    else button.removeAttribute("aria-current");
  }
}

function line(mode) {
  const smallest = mode.smallest === null ? "" : relative(mode.smallest);
  const [sign, spoken] = SIGNS[mode.sign] ?? ["", ""];
  const residual = minus(mode.residual_norm.toExponential(0));
  const mirror = mode.mirror_image ?? "";
  const names = [
    ...mode.poses,
    ...(mode.kind === "regular" ? [] : ["singular"]),
    ...(mode.ways > 1 ? [`${mode.ways} ways`] : []),
  ].join(", ");
  const label = [
    `Mode ${mode.number}`,
    smallest && `smallest singular value of K* ${smallest}`,
    spoken && `determinant of K* ${spoken}`,
    `loop residual ${residual} metres`,
    mirror && `mirror image of mode ${mirror}`,
    names,
  ].filter(Boolean).join(", ");
  const cells = [mode.number, smallest, sign, residual, mirror && `⇅ ${mirror}`, names];
  const button = element(
    "button", { type: "button", value: mode.number, "aria-label": label },
    ...cells.map((text) => element("span", {}, String(text))),
  );
  return element("li", {}, button);
}
