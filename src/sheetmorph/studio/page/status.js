// Numbers that are always on show, the state of the computation, and the log of messages.

import { $, digits, make, toast } from "./dom.js";
import { shown } from "./view.js";
import { on } from "./wire.js";

const chip = $("state");
let warnings = [];
let notes = [];
let problem = "";

function state(text, kind = "") {
  chip.textContent = text;
  chip.className = `chip ${kind}`;
}

on("lost", (head) => state(head.reason || "no connection; trying again", "bad"));
on("hello", () => state("starting the solver", "working"));
on("design", (head) => {
  notes = head.notes;
  problem = "";
  state("solving", "working");
});
on("progress", (head) => {
  if (head.fraction < 1) state(`${head.text} · ${Math.round(100 * head.fraction)} %`, "working");
});
on("scene", (head) => {
  numbers(head.numbers, head.preview);
  if (head.preview) state("preview", "working");
  else {
    warnings = [];
    const n = head.numbers;
    if (n.status !== "completed") {
      warnings.unshift(`The shape was followed to ${Math.round(100 * n.reached)} % of the actuation only (${n.detail || n.status.replaceAll("_", " ")}): ${n.remedy}.`);
    } else if (!n.stable) warnings.unshift(`The shape is an equilibrium, but not a stable one: ${n.remedy}.`);
  }
  log();
});
on("checked", (head) => {
  warnings.push(...head.warnings);
  log();
});
let solved = 0;
on("settled", (head) => {
  if (!head.drag) chip.dataset.solved = ++solved; // how many changes have been answered
  if (problem) state("not solved: see the message", "bad");
  else if (!head.drag) state(shown.head?.numbers.status === "completed" ? "solved" : "stopped early", shown.head?.numbers.status === "completed" ? "" : "bad");
});
on("problem", (head) => {
  if (head.about === "design") problem = head.text;
  else toast(head.text);
  if (head.about === "design" && !head.drag && !head.key) toast(head.text); // one with a key stands at its field
  log(head.about === "design" ? "" : head.text);
});

/** Write the numbers into the footer. */
function numbers(n, preview) {
  const stable = n.status !== "completed" ? ["stopped early", "bad"] : n.stable ? ["stable", "good"] : ["unstable", "bad"];
  const cells = [
    ["h/d", `${preview ? "≈ " : ""}${digits(n.aspect_ratio, 3)}`, "lead"],
    ["height h", `${digits(n.height_mm, 3)} mm`],
    ["width d", `${digits(n.width_mm, 4)} mm`],
    ["mass", `${digits(n.mass_g, 3)} g`],
    ["energy", energy(n.energy_mJ)],
    ["equilibrium", ...stable],
    ["solved in", `${n.seconds.toFixed(2)} s`],
    ["nodes", `${n.nodes}${preview ? " (preview)" : ""}`],
  ];
  $("numbers").replaceChildren(...cells.map(([label, text, kind]) =>
    make("div", { className: kind ?? "" }, make("dt", { textContent: label }), make("dd", { textContent: text }))));
}

function energy(value) {
  return Math.abs(value) < 0.1 ? `${digits(1e3 * value, 3)} µJ` : `${digits(value, 3)} mJ`;
}

const past = [];

function log(extra = "") {
  if (extra && past[0] !== extra) past.unshift(extra);
  past.length = Math.min(past.length, 30);
  const now = [
    ...(problem ? [["problem", problem]] : []),
    ...warnings.map((text) => ["warning", sentence(text)]),
    ...notes.map((text) => ["note", sentence(text)]),
    ...past.map((text) => ["problem", text]),
  ];
  const lines = now.map(([kind, text]) => make("li", { className: kind, textContent: text }));
  $("lines").replaceChildren(...(lines.length ? lines : [make("li", { textContent: "Nothing to report." })]));
  const open = (problem ? 1 : 0) + warnings.length + notes.length;
  $("count").textContent = now.length ? (open ? `${open} ${open === 1 ? "message" : "messages"}: ${now[0][1]}` : `Earlier: ${now[0][1]}`) : "Nothing to report";
  $("log").firstElementChild.classList.toggle("some", open > 0);
}

/** Say something in the log. */
export function note(text) {
  log(text);
}

function sentence(text) {
  const begun = text.charAt(0).toUpperCase() + text.slice(1);
  return /[.!?]$/.test(begun) ? begun : `${begun}.`;
}
