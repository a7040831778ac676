// The page: puts its parts together, keys, theme.

import { $, ask, make } from "./dom.js";
import "./export.js";
import "./files.js";
import "./gallery.js";
import "./panel.js";
import "./plan.js";
import "./status.js";
import "./scan.js";
import "./shapes.js";
import { play } from "./tools.js";
import { look, retheme } from "./view.js";
import { connect, on, order } from "./wire.js";

let file = null; // the name of the file that is saved to
let text = null; // the newest design, to go on with when the server was started anew

on("design", (head) => {
  if (head.panel) text = head.text;
  $("name").textContent = head.name;
  document.title = `${head.name} – sheetmorph studio`;
});
on("history", (head) => {
  $("undo").disabled = !head.undo;
  $("redo").disabled = !head.redo;
  mark(head.saved);
});
on("hello", (head) => {
  file = head.file;
  if (head.fresh && text) order("open", { text });
});

on("saved", () => mark(true));

function mark(saved) {
  $("file").textContent = file ? `${file}${saved ? "" : " · not saved"}` : "";
}

$("undo").onclick = () => order("undo");
$("redo").onclick = () => order("redo");

const stored = localStorage.getItem("theme");
const dark = matchMedia("(prefers-color-scheme: dark)");
function theme(name) {
  document.documentElement.dataset.theme = name;
  retheme();
}
theme(stored ?? (dark.matches ? "dark" : "light"));
dark.addEventListener("change", () => { if (!localStorage.getItem("theme")) theme(dark.matches ? "dark" : "light"); });
$("theme").onclick = () => {
  const next = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
  localStorage.setItem("theme", next);
  theme(next);
};

const KEYS = [
  ["Ctrl Z, Ctrl Shift Z", "undo, redo"], ["Ctrl S", "save"], ["Space", "play the actuation"],
  ["0, 1, 2", "view from the corner, from above, from the side"], ["D", "show h and d"], ["M", "measure between two points"],
  ["W", "show the mesh"], ["Tab, then arrows", "move a handle of the pattern; with Shift in larger, with Alt in smaller steps"],
  ["arrows, + and −", "turn and zoom the sheet, when it has the focus"], ["?", "this help"],
];
function help() {
  const rows = KEYS.map(([keys, what]) => make("tr", {}, make("td", {}, make("kbd", { textContent: keys })), make("td", { textContent: what })));
  ask("Keys", [make("table", { className: "keys" }, make("tbody", {}, ...rows))], [["", "Close", true]]);
}
$("help").onclick = help;

document.addEventListener("keydown", (event) => {
  const typing = event.target.matches("input:not([type=range]), select, textarea") || $("dialog").open;
  if (event.ctrlKey || event.metaKey) {
    const letter = event.key.toLowerCase();
    if (letter === "s") { event.preventDefault(); $("save").click(); }
    if (typing) return;
    if (letter === "z") { event.preventDefault(); order(event.shiftKey ? "redo" : "undo"); }
    if (letter === "y") { event.preventDefault(); order("redo"); }
    return;
  }
  if (typing || event.altKey) return;
  const act = {
    " ": () => { if (!event.target.matches("button, summary")) { event.preventDefault(); play(); } },
    0: () => look("home"), 1: () => look("top"), 2: () => look("side"), "?": help,
    d: () => $("sizes").click(), m: () => $("measure").click(), w: () => $("grid").click(),
  }[event.key];
  act?.();
});

connect();
