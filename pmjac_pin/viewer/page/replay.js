// A trajectory: a slider of its parameter that plays, and what happens on it.

import { $, element } from "./elements.js";
import { Sliders } from "./sliders.js";

let slider = null;
let moment = null;  // where it was last

// `actions` are those of Sliders: go([t]), free(), restore() and complain(text).
export function buildReplay(about, actions) {
  $("replay").hidden = about.replay === null;
  slider = moment = null;
  $("happenings").replaceChildren();
  if (about.replay === null) return;
  moment = about.replay.lower;
  slider = new Sliders("moment", [about.replay], { ...actions, target: () => moment });
  $("happenings").replaceChildren(...about.happenings.map((one) => happening(one, actions)));
}

export function showReplay(now, wanted) {
  moment = now ?? moment;
  slider?.show([moment], wanted, []);
}

export function restReplay() {
  slider?.rest();
}

function happening({ t, kind, what }, { go }) {
  const button = element("button", { type: "button" }, `t = ${Number(t.toPrecision(6))}`);
  button.addEventListener("click", () => { restReplay(); go([t]); });
  return element("li", { title: what }, button, ` ${kind}: ${what}`);
}
