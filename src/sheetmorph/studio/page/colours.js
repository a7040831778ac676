// Colours of fields and of the sheet, and the legend.

import { $, digits, make } from "./dom.js";

// Points of two scales: one from dark to light, one with a pale middle. In between they are mixed.
const SEQUENTIAL = [[38, 20, 84], [34, 92, 138], [31, 151, 139], [122, 200, 92], [250, 230, 60]];
const DIVERGING = [[26, 78, 150], [116, 173, 212], [242, 240, 234], [240, 146, 100], [160, 28, 44]];

/** Red, green, blue of a share from 0 to 1, each 0 to 1 and linear as three.js wants it. */
export function colourOf(share, diverging, out, at) {
  const points = diverging ? DIVERGING : SEQUENTIAL;
  const place = Math.min(1, Math.max(0, share)) * (points.length - 1);
  const k = Math.min(points.length - 2, Math.floor(place));
  for (let c = 0; c < 3; c++) {
    const value = (points[k][c] + (place - k) * (points[k + 1][c] - points[k][c])) / 255;
    out[at + c] = linear(value);
  }
}

export const linear = (value) => (value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4);

/** A colour of the page as three linear numbers. */
export function themed(name) {
  const text = getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const number = parseInt(text.slice(1), 16);
  return [number >> 16, (number >> 8) & 255, number & 255].map((value) => linear(value / 255));
}

/** Draw the legend of a field, or of the parts of the sheet. */
export function legend(field) {
  const card = $("legend");
  card.hidden = false;
  if (!field) {
    const line = (name, text) => {
      const swatch = make("i");
      swatch.style.background = `var(${name})`;
      return make("li", {}, swatch, text);
    };
    card.replaceChildren(make("h3", { textContent: "Sheet" }), make("ul", {}, line("--film", "sheet"), line("--ribs", "pattern")));
    return;
  }
  const canvas = make("canvas", { width: 1, height: 128 });
  const pen = canvas.getContext("2d");
  const points = field.diverging ? DIVERGING : SEQUENTIAL;
  const fill = pen.createLinearGradient(0, 128, 0, 0);
  points.forEach((rgb, k) => fill.addColorStop(k / (points.length - 1), `rgb(${rgb})`));
  pen.fillStyle = fill;
  pen.fillRect(0, 0, 1, 128);
  const ticks = [1, 0.75, 0.5, 0.25, 0].map((share) => make("li", { textContent: digits(field.low + share * (field.high - field.low)) }));
  card.replaceChildren(
    make("h3", { textContent: `${field.label}${field.unit ? ` [${field.unit}]` : ""}` }),
    make("div", { className: "scale" }, canvas, make("ol", { "aria-label": "scale" }, ...ticks)),
  );
}
