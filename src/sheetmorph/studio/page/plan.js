// The flat pattern: drawn in SVG, with handles that are dragged or moved by the arrow keys.

import { $, digits, draw } from "./dom.js";
import { emit, on, order } from "./wire.js";

const svg = $("plan");
const MARGIN = 1.16;
let plan = null;
let scale = 1; // pixels per mm
let held = null; // the handle that is being dragged
let waiting = false; // an order is on its way
let latest = null; // the values to send when it is back

on("design", (head) => {
  if (held && !head.commit) return drawShapes(head.plan);
  plan = head.plan;
  redraw();
});
for (const kind of ["settled", "problem", "scene"]) on(kind, () => sendLatest());
new ResizeObserver(() => redraw()).observe(svg);

const px = (point) => [point[0] * scale, -point[1] * scale];
const path = (rings) => rings.map((ring) => `M${ring.map((p) => px(p).map((v) => v.toFixed(2)).join(",")).join("L")}Z`).join("");

/** Draw all anew: shapes, scale and handles. */
export function redraw() {
  const { width, height } = svg.getBoundingClientRect();
  if (!plan || !width || !height) return;
  const [x0, y0, x1, y1] = plan.box;
  scale = Math.min(width / (x1 - x0), height / (y1 - y0)) / MARGIN;
  const [cx, cy] = px([(x0 + x1) / 2, (y0 + y1) / 2]);
  svg.setAttribute("viewBox", `${cx - width / 2} ${cy - height / 2} ${width} ${height}`);
  const focused = document.activeElement?.dataset?.key;
  svg.replaceChildren(draw("g", { id: "plan-shapes" }), ruler(cx, cy, width, height), draw("g", { id: "plan-handles" }));
  drawShapes(plan);
  $("plan-handles").append(...plan.handles.map(knob));
  if (focused) svg.querySelector(`[data-key="${CSS.escape(focused)}"]`)?.focus();
}

function drawShapes(now) {
  const shapes = $("plan-shapes");
  if (!shapes) return;
  const sheet = draw("path", { class: "plan-sheet", d: path(now.sheet), "fill-rule": "evenodd" });
  const parts = Object.values(now.parts).map((rings) => draw("path", { class: "plan-part", d: path(rings), "fill-rule": "evenodd" }));
  const slits = now.slits.map((line) => draw("path", { class: "plan-slit", d: path([line]).replace("Z", "") }));
  const boxes = now.supports.map(([x0, x1, y0, y1]) =>
    draw("path", { class: "plan-held", d: path([[[x0, y0], [x1, y0], [x1, y1], [x0, y1]]]) }));
  shapes.replaceChildren(sheet, ...parts, ...slits, ...boxes);
}

function ruler(cx, cy, width, height) {
  const wanted = 80 / scale;
  const power = 10 ** Math.floor(Math.log10(wanted));
  const length = [5, 2, 1].map((k) => k * power).find((value) => value <= wanted) ?? power;
  const [x, y] = [cx + width / 2 - 16 - length * scale, cy + height / 2 - 12];
  return draw("g", { "aria-hidden": "true" },
    draw("path", { class: "plan-scale", d: `M${x},${y - 4}v4h${length * scale}v-4` }),
    Object.assign(draw("text", { class: "plan-text", x: x + (length * scale) / 2, y: y - 7, "text-anchor": "middle" }), { textContent: `${digits(length)} mm` }));
}

function knob(handle) {
  const [x, y] = px(handle.at);
  const number = handle.rule !== "move";
  const group = draw("g", {
    class: `handle ${handle.rule}`, tabindex: "0", transform: `translate(${x},${y})`, "data-key": handle.key,
    role: number ? "slider" : "button", "aria-label": handle.label, ...(number ? { "aria-valuenow": handle.value.toFixed(2) } : {}),
  },
  draw("circle", { class: "hit", r: 13 }), draw("circle", { r: handle.rule === "move" ? 4.5 : 6 }), draw("text", handle.at[0] > (plan.box[0] + plan.box[2]) / 2 ? { x: -10, y: -12, "text-anchor": "end" } : { x: 10, y: -12 }));
  label(group, handle);
  group.addEventListener("pointerdown", (event) => grab(event, group, handle));
  group.addEventListener("keydown", (event) => nudge(event, group, handle));
  group.addEventListener("keyup", () => { if (held?.keys) release(); });
  group.addEventListener("blur", () => { if (held?.keys) release(); });
  return group;
}

function text(handle) {
  if (handle.rule === "move") return `${digits(handle.at[0], 4)}, ${digits(handle.at[1], 4)} mm`;
  return `${digits(handle.value, 4)} ${handle.unit === "deg" ? "°" : handle.unit}`;
}

function label(group, handle) {
  group.querySelector("text").textContent = `${handle.label} ${text(handle)}`;
  if (handle.rule === "move") group.setAttribute("aria-description", text(handle));
  else {
    group.setAttribute("aria-valuenow", handle.value.toFixed(2));
    group.setAttribute("aria-valuetext", text(handle));
  }
}

/** Put a handle where the pointer is, as far as its rule lets it. */
function place(handle, point) {
  if (handle.rule === "slide") {
    const [dx, dy] = handle.direction;
    const along = (point[0] - handle.origin[0]) * dx + (point[1] - handle.origin[1]) * dy;
    handle.value = Math.max(handle.least, along * handle.factor);
    const far = handle.value / handle.factor;
    handle.at = [handle.origin[0] + dx * far, handle.origin[1] + dy * far];
  } else if (handle.rule === "turn") {
    const radius = Math.hypot(handle.at[0] - handle.origin[0], handle.at[1] - handle.origin[1]);
    const angle = Math.atan2(point[1] - handle.origin[1], point[0] - handle.origin[0]);
    handle.value = ((((angle * 180) / Math.PI - handle.add + 540) % 360) + 360) % 360 - 180;
    handle.at = [handle.origin[0] + radius * Math.cos(angle), handle.origin[1] + radius * Math.sin(angle)];
  } else handle.at = point;
}

function values(handle) {
  const round = (value) => Number(value.toFixed(3));
  if (handle.rule !== "move") return { [handle.key]: `${round(handle.value)} ${handle.unit}` };
  const point = handle.at.map(round);
  return { [handle.key]: point.map((value) => `${value} mm`) };
}

function grab(event, group, handle) {
  if (event.button !== 0) return;
  event.preventDefault();
  group.focus();
  group.setPointerCapture(event.pointerId);
  held = { group, handle, keys: false, moved: false };
  group.classList.add("held");
  svg.classList.add("busy");
  group.onpointermove = (move) => {
    const matrix = svg.getScreenCTM().inverse();
    const at = new DOMPoint(move.clientX, move.clientY).matrixTransform(matrix);
    place(handle, [at.x / scale, -at.y / scale]);
    moved();
  };
  group.onpointerup = group.onpointercancel = () => release();
}

function nudge(event, group, handle) {
  const by = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
  if (!by) return;
  event.preventDefault();
  const step = event.shiftKey ? 5 : event.altKey ? 0.1 : 0.5;
  if (handle.rule === "move") handle.at = [handle.at[0] + step * by[0], handle.at[1] + step * by[1]];
  else {
    const more = (by[0] + by[1]) * step;
    if (handle.rule === "slide") {
      const [dx, dy] = handle.direction;
      const far = (handle.value + more) / handle.factor;
      place(handle, [handle.origin[0] + dx * far, handle.origin[1] + dy * far]);
    } else {
      const angle = ((handle.value + more + handle.add) * Math.PI) / 180;
      const radius = Math.hypot(handle.at[0] - handle.origin[0], handle.at[1] - handle.origin[1]);
      place(handle, [handle.origin[0] + radius * Math.cos(angle), handle.origin[1] + radius * Math.sin(angle)]);
    }
  }
  held = { group, handle, keys: true, moved: false };
  moved();
}

function moved() {
  held.moved = true;
  const [x, y] = px(held.handle.at);
  held.group.setAttribute("transform", `translate(${x},${y})`);
  label(held.group, held.handle);
  emit("editing", { values: values(held.handle) });
  latest = values(held.handle);
  if (!waiting) sendLatest();
}

function sendLatest() {
  waiting = false;
  if (!latest || !held) return;
  waiting = true;
  order("edit", { values: latest, drag: true });
  latest = null;
}

function release() {
  const { group, handle, moved: changed } = held;
  held = latest = null;
  waiting = false;
  group.classList.remove("held");
  svg.classList.remove("busy");
  group.onpointermove = group.onpointerup = group.onpointercancel = null;
  if (changed) order("edit", { values: values(handle) });
}
