// What is drawn: which ellipsoids, how large, and whether motors are named.

import { $ } from "./elements.js";

const BOXES = ["linear", "angular", "force", "names", "velocity_polytope", "force_polytope"];

export function listenToOptions(send) {
  const choose = () => {
    const chosen = Object.fromEntries(BOXES.map((name) => [name, $(name).checked]));
    send({ command: "options", ...chosen, scale: 10 ** $("scale").valueAsNumber });
  };
  for (const name of BOXES) $(name).addEventListener("change", choose);
  $("scale").addEventListener("input", () => { showScale(10 ** $("scale").valueAsNumber); choose(); });
}

// `settled`: no choice of ours is on its way that this would undo.
export function showOptions(drawn, settled) {
  $("no-polytopes").textContent = [...new Set(Object.values(drawn.no_polytopes))].join(" ");
  if (!settled) return;
  for (const name of BOXES) $(name).checked = drawn[name];
  $("scale").value = Math.log10(drawn.scale);
  showScale(drawn.scale);
}

function showScale(scale) {
  $("scale-value").textContent = `× ${scale.toFixed(2)}`;
  $("scale").setAttribute("aria-valuetext", `times ${scale.toFixed(2)}`);
}
