// Which colour in the picture is what.

import { $, element } from "./elements.js";

export function buildLegend(keys) {
  $("legend").replaceChildren(...keys.map(({ text, colours }) => {
    const dots = colours.map((colour) => element("span", { class: "dot", style: `background: ${colour}` }));
    return element("li", {}, ...dots, text);
  }));
}
