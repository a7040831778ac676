// Presets with pictures, and shapes to add to the pattern.

import { $, ask, make } from "./dom.js";
import { on, order } from "./wire.js";

const WORDS = {
  bowl: ["Bowl", "A disc with a six-armed star, design A of the paper"],
  canoe: ["Canoe", "A rectangle with two joined stars, design B"],
  petals: ["Petals", "A square with a diagonal cross, design C"],
  kirigami: ["Kirigami", "A disc with random polygons; another seed, another pattern"],
  blank: ["Blank", "A free square with a stiff cross, to start from"],
};
let presets = [];

on("hello", (head) => { presets = head.presets; });

$("presets").onclick = async () => {
  const cards = presets.map((name) => {
    const [title, text] = WORDS[name] ?? [name, ""];
    return make("button", { type: "submit", value: name },
      make("img", { src: `page/preset-${name}.png`, alt: "", loading: "lazy" }), make("span", {}, make("strong", { textContent: title }), text));
  });
  const name = await ask("Presets", [make("div", { className: "cards" }, ...cards)], [["", "Cancel"]]);
  if (name) order("preset", { name });
};

// A new shape is sized by the sheet; what it is called in the design file stands beside it.
const SHAPES = {
  star: (r) => ({ arms: 5, arm_length: mm(0.7 * r), half_width: mm(0.09 * r) }),
  cross: (r) => ({ arms: 4, arm_length: mm(0.6 * r), half_width: mm(0.09 * r) }),
  bar: (r) => ({ start: [mm(-0.6 * r), mm(0)], end: [mm(0.6 * r), mm(0)], half_width: mm(0.09 * r) }),
  disc: (r) => ({ radius: mm(0.3 * r) }),
  ring: (r) => ({ radius: mm(0.7 * r), width: mm(0.15 * r) }),
  rings: (r) => ({ count: 2, spacing: mm(0.36 * r), width: mm(0.12 * r), spokes: 6 }),
  lotus: (r) => ({ petals: 6, disc_radius: mm(0.2 * r), radius: mm(0.7 * r), petal_half_width: mm(0.11 * r) }),
  spiral: (r) => ({ turns: 2.5, pitch: mm(0.28 * r), half_width: mm(0.07 * r), inner_radius: mm(0.15 * r) }),
  rectangle: (r) => ({ width: mm(0.8 * r), height: mm(0.3 * r) }),
  ellipse: (r) => ({ half_width: mm(0.5 * r), half_height: mm(0.25 * r) }),
  regular_polygon: (r) => ({ sides: 6, radius: mm(0.4 * r) }),
  stripes: (r) => ({ spacing: mm(0.3 * r), half_width: mm(0.06 * r), margin: mm(0.08 * r) }),
  grid: (r) => ({ spacing: mm(0.36 * r), half_width: mm(0.06 * r), margin: mm(0.08 * r) }),
  honeycomb: (r) => ({ cell_size: mm(0.36 * r), wall_width: mm(0.1 * r), margin: mm(0.08 * r) }),
};
const mm = (value) => `${Number(value.toPrecision(3))} mm`;

document.addEventListener("add-shape", async (event) => {
  const [x0, y0, x1, y1] = event.detail.box;
  const radius = Math.min(x1 - x0, y1 - y0) / 2;
  const middle = [(x0 + x1) / 2, (y0 + y1) / 2];
  const kinds = Object.keys(SHAPES).map((kind) => make("button", { type: "submit", value: kind, textContent: kind.replaceAll("_", " ") }));
  const kind = await ask("Add a shape", [make("p", { className: "faint", textContent: "It is joined to the pattern. All kinds and keys: patterns.md of the documentation." }), make("div", { className: "kinds" }, ...kinds)], [["", "Cancel"]]);
  if (!kind) return;
  const shape = { kind, ...SHAPES[kind](radius), clip: true };
  if (!["bar", "stripes", "grid", "honeycomb"].includes(kind) && (middle[0] || middle[1])) shape.centre = middle.map(mm);
  if (kind === "bar") for (const end of ["start", "end"]) shape[end] = shape[end].map((text, k) => mm(parseFloat(text) + middle[k]));
  order("add", { shape });
});
