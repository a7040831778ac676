// The tools of the view: colour, layout, clipping, branch, sizes, distances, time, camera.

import { legend } from "./colours.js";
import { $, digits, make } from "./dom.js";
import { between, clip, look, pick, project, redraw, setMarks, setMoment, showMesh, shown } from "./view.js";
import { on, order } from "./wire.js";

const canvas = $("canvas");
let ends = []; // of the distance that is measured
let playing = 0;

const pressed = (id) => $(id).getAttribute("aria-pressed") === "true";
const press = (id, on) => $(id).setAttribute("aria-pressed", String(on));

/** Fields that the newest shape has, in the list. */
export function listFields() {
  const fields = Object.entries(shown.head.fields);
  const chosen = shown.field;
  const names = [["", "material"], ...fields.map(([name, field]) => [name, field.label])];
  $("field").replaceChildren(...names.map(([value, textContent]) => make("option", { value, textContent })));
  if (!shown.head.fields[chosen]) shown.field = "";
  $("field").value = shown.field;
  legend(shown.head.fields[shown.field]);
}

/** Colour by a field. */
export function choose(name) {
  shown.field = name;
  $("field").value = name;
  legend(shown.head?.fields[name]);
  redraw();
}

$("field").onchange = () => choose($("field").value);
$("layout").onchange = () => {
  shown.layout = $("layout").value;
  redraw();
  look("home");
};
function cut() {
  $("cut").hidden = !$("clip").value;
  clip($("clip").value, Number($("cut").value));
}
$("clip").onchange = cut;
$("cut").oninput = cut;
for (const way of ["up", "down"]) {
  $(way).onclick = () => order("edit", { values: { "perturbation.direction": way } });
}
on("design", (head) => {
  press("up", head.direction === "up");
  press("down", head.direction === "down");
});
for (const from of ["home", "top", "side"]) $(from).onclick = () => look(from);
$("grid").onclick = () => {
  press("grid", !pressed("grid"));
  showMesh(pressed("grid"));
};
$("sizes").onclick = () => {
  press("sizes", !pressed("sizes"));
  mark();
};
$("measure").onclick = () => {
  press("measure", !pressed("measure"));
  canvas.classList.toggle("aim", pressed("measure"));
  ends = [];
  mark();
};
let down = null;
canvas.addEventListener("pointerdown", (event) => { down = [event.clientX, event.clientY]; });
canvas.addEventListener("pointerup", (event) => {
  if (!pressed("measure") || !down || Math.hypot(event.clientX - down[0], event.clientY - down[1]) > 4) return;
  const point = pick(event);
  if (point) ends = ends.length === 1 ? [...ends, point] : [point];
  mark();
});

let notes = []; // [point, text] of the labels over the canvas

/** Draw the lines and labels of what is measured. */
function mark() {
  const lines = [];
  notes = [];
  if (pressed("sizes") && shown.head) {
    const size = sizes();
    lines.push(...size.width, ...size.height, ...size.rungs);
    notes.push([middle(size.width), `d = ${digits(size.d, 4)} mm`], [middle(size.height), `h = ${digits(size.h, 4)} mm`]);
  }
  if (ends.length === 2) {
    lines.push(...ends);
    const far = Math.hypot(...ends[0].map((value, k) => value - ends[1][k]));
    notes.push([middle(ends), `${digits(far, 4)} mm`]);
  } else if (ends.length === 1) notes.push([ends[0], "first point"]);
  setMarks(lines);
  label();
}

const middle = ([a, b]) => a.map((value, k) => (value + b[k]) / 2);

/** Height, and largest width in the plane with the points where it lies. */
function sizes() {
  const nodes = shown.nodes;
  let low = Infinity, high = -Infinity, best = -1, pair = [0, 0];
  for (let i = 2; i < nodes.length; i += 3) [low, high] = [Math.min(low, nodes[i]), Math.max(high, nodes[i])];
  const corners = hull(nodes);
  for (const p of corners) {
    for (const q of corners) {
      const far = (nodes[p] - nodes[q]) ** 2 + (nodes[p + 1] - nodes[q + 1]) ** 2;
      if (far > best) [best, pair] = [far, [p, q]];
    }
  }
  const [p, q] = pair;
  const start = [nodes[p], nodes[p + 1], low], end = [nodes[q], nodes[q + 1], low];
  const right = nodes[p] > nodes[q] ? start : end;
  const top = [right[0], right[1], high];
  return {
    d: Math.sqrt(best), h: high - low, width: [start, end], height: [right, top],
    rungs: [[start, [nodes[p], nodes[p + 1], nodes[p + 2]]], [end, [nodes[q], nodes[q + 1], nodes[q + 2]]]].flat(),
  };
}

/** Places in `nodes` of the corners of the convex hull seen from above (monotone chain). */
function hull(nodes) {
  const all = Array.from({ length: nodes.length / 3 }, (_, k) => 3 * k).sort((a, b) => nodes[a] - nodes[b] || nodes[a + 1] - nodes[b + 1]);
  const turn = (o, a, b) => (nodes[a] - nodes[o]) * (nodes[b + 1] - nodes[o + 1]) - (nodes[a + 1] - nodes[o + 1]) * (nodes[b] - nodes[o]);
  const half = (order) => {
    const chain = [];
    for (const p of order) {
      while (chain.length > 1 && turn(chain.at(-2), chain.at(-1), p) <= 0) chain.pop();
      chain.push(p);
    }
    return chain.slice(0, -1);
  };
  return [...half(all), ...half(all.reverse())];
}

function label() {
  $("labels").replaceChildren(...notes.map(([point, text]) => {
    const span = make("span", { textContent: text });
    const [x, y] = project(point);
    span.style.left = `${x}px`;
    span.style.top = `${y}px`;
    return span;
  }));
}
on("moment", () => { if (pressed("sizes")) mark(); });
on("drawn", () => { if (notes.length) label(); });

/** Where the slider is, in words. */
function tell() {
  if (!shown.head) return;
  const [k, share] = between();
  const states = shown.head.actuation;
  const now = (1 - share) * states[k] + share * states[Math.min(k + 1, states.length - 1)];
  const ratio = shown.head.ratio;
  const h = (1 - share) * ratio[k] + share * ratio[Math.min(k + 1, ratio.length - 1)];
  const time = shown.head.time;
  const t = time ? (1 - share) * time[k] + share * time[Math.min(k + 1, time.length - 1)] : 0;
  $("at").textContent = `${time ? `${digits(1e3 * t, 3)} ms` : `ε ${digits(100 * now, 3)} %`} · h/d ${digits(h, 3)}`;
  $("scrub").setAttribute("aria-valuetext", `free strain ${digits(100 * now, 3)} percent, h over d ${digits(h, 3)}`);
}

/** Go to a moment of the actuation. */
export function scrub(moment) {
  $("scrub").value = moment;
  setMoment(moment);
  tell();
}
$("scrub").oninput = () => {
  stop();
  scrub(Number($("scrub").value));
};

function stop() {
  cancelAnimationFrame(playing);
  playing = 0;
  $("play").textContent = "▶";
  $("play").setAttribute("aria-label", "Play the actuation");
}

/** Play the actuation from flat to final, or stop. */
export function play() {
  if (playing) return stop();
  $("play").textContent = "❚❚";
  $("play").setAttribute("aria-label", "Stop");
  const begin = performance.now();
  const from = shown.moment >= 1 ? 0 : shown.moment;
  const frame = (now) => {
    const moment = Math.min(1, from + (now - begin) / 3500);
    scrub(moment);
    if (moment < 1) playing = requestAnimationFrame(frame);
    else stop();
  };
  playing = requestAnimationFrame(frame);
  return undefined;
}
$("play").onclick = play;

on("scene", () => {
  listFields();
  tell();
  ends = [];
  mark();
  if ($("clip").value) cut();
});
