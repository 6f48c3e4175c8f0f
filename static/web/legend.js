/** What the colours mean. */

import { classMark, gradient } from "./colors.js";
import { element } from "./page.js";

const POLYGONS = {
  circle: "",
  diamond: "polygon(50% 0, 100% 50%, 50% 100%, 0 50%)",
  triangle: "polygon(50% 0, 100% 90%, 0 90%)",
  square: "polygon(8% 8%, 92% 8%, 92% 92%, 8% 92%)",
  pentagon: "polygon(50% 0, 98% 38%, 80% 95%, 20% 95%, 2% 38%)",
};

/**
 * One entry a class; the pointer on one lights it up on the board.
 * @param {HTMLElement} parent
 * @param {string[]} classes of the points
 * @param {(name: string | null) => void} light
 */
export function classLegend(parent, classes, light) {
  const order = [...new Set(classes)].sort();
  if (parent.dataset.legend === order.join("\n")) return;
  parent.dataset.legend = order.join("\n");
  const entries = order.map((name, k) => {
    const { color, shape } = classMark(k);
    const swatch = element("i", { class: "rb-swatch" });
    swatch.style.background = color;
    if (shape === "circle") swatch.style.borderRadius = "50%";
    else swatch.style.clipPath = POLYGONS[shape];
    const entry = element("span", { class: "rb-entry" }, [swatch, new Text(name || "no class")]);
    entry.addEventListener("pointerenter", () => light(name));
    entry.addEventListener("pointerleave", () => light(null));
    return entry;
  });
  parent.replaceChildren(element("div", { class: "rb-entries" }, entries));
}

/**
 * A scale with a word at either end.
 * @param {HTMLElement} parent
 * @param {import("./colors.js").Scale} scale
 * @param {string} low
 * @param {string} high
 */
export function scaleLegend(parent, scale, low, high) {
  if (parent.dataset.legend === scale) return;
  parent.dataset.legend = scale;
  const bar = element("span", { class: "rb-scale" });
  bar.style.background = gradient(scale);
  parent.replaceChildren(
    element("div", { class: "rb-scales" }, [
      element("b", { text: scale }),
      element("span", { text: low }),
      bar,
      element("span", { text: high }),
    ]),
  );
}
