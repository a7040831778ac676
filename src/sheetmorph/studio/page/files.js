// Opening, dropping and saving: designs, drawings, scans.

import { $, ask, digits, make, toast } from "./dom.js";
import { on, order, tab } from "./wire.js";

const DRAWINGS = [".svg", ".dxf", ".3mf"];
const SCANS = [".stl", ".obj", ".ply"];
const MAX_DESIGN = 5e6;
let name = "design";
let dropped = ""; // what the file in question is called, for people

on("design", (head) => { name = head.name; });

/** Read a file as what its ending says. */
async function take(file) {
  const ending = file.name.slice(file.name.lastIndexOf(".")).toLowerCase();
  dropped = file.name;
  if (ending === ".toml") {
    if (file.size > MAX_DESIGN) return toast("This design is too large: 5 MB are allowed.");
    return order("open", { text: await file.text() });
  }
  if (DRAWINGS.includes(ending)) return (await upload("drawing", file)) && order("look");
  if (SCANS.includes(ending)) return (await upload("scan", file)) && askScan();
  return toast(`${file.name} is nothing that the studio reads: a design (.toml), a drawing (${DRAWINGS.join(", ")}) or a scan (${SCANS.join(", ")}).`);
}

async function upload(what, file) {
  const address = `upload/${tab()}/${what}?name=${encodeURIComponent(file.name)}`;
  try {
    const answer = await fetch(address, { method: "POST", body: file });
    if (answer.ok) return true;
    const told = await answer.json().catch(() => ({}));
    toast(`${file.name}: ${told.error ?? `refused (${answer.status})`}`);
  } catch {
    toast(`${file.name} did not reach the studio; is it still running?`);
  }
  return false;
}

$("open").onclick = () => $("picker").click();
$("picker").onchange = async () => {
  for (const file of $("picker").files) await take(file);
  $("picker").value = "";
};
let inside = 0;
const hasFiles = (event) => event.dataTransfer?.types.includes("Files");
addEventListener("dragenter", (event) => {
  if (!hasFiles(event)) return;
  inside += 1;
  $("drop").hidden = false;
});
addEventListener("dragleave", (event) => {
  if (!hasFiles(event)) return;
  inside = Math.max(0, inside - 1);
  $("drop").hidden = inside === 0;
});
addEventListener("dragover", (event) => event.preventDefault());
addEventListener("drop", async (event) => {
  event.preventDefault();
  inside = 0;
  $("drop").hidden = true;
  for (const file of event.dataTransfer.files) await take(file);
});

// Saving: into the file that the studio was started with, or as a download.

$("save").onclick = () => order("save");
on("text", (head) => {
  const link = make("a", { href: URL.createObjectURL(new Blob([head.text], { type: "application/toml" })), download: `${name}.toml` });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  toast(`${name}.toml goes to your downloads.`);
});
on("saved", (head) => toast(`Saved ${head.file}.`));
on("conflict", async (head) => {
  const text = `${head.file} was changed by someone else since it was read here. Saving replaces what it holds now.`;
  if (await ask("Replace the file?", [make("p", { textContent: text })], [["", "Keep it"], ["yes", "Replace", true]])) order("save", { force: true });
});

// A drawing: which of its layers is what.

on("drawing", async (head) => {
  const pick = (role, label, guess) => {
    const none = make("option", { value: "-", textContent: role === "slits" ? "none" : "keep the one of the design" });
    const all = role === "slits" ? [] : [make("option", { value: "", textContent: "the whole drawing" })];
    const names = head.names.map((entry) => make("option", { value: entry.name, textContent: `${entry.name} (${entry.kind})` }));
    const select = make("select", { id: `role-${role}` }, none, ...all, ...names);
    select.value = guess ?? "-";
    return make("label", { htmlFor: select.id }, label, select);
  };
  const guess = head.guess;
  const whole = !guess.sheet && !guess.pattern;
  const units = ["", "mm", "cm", "in", "px", "pt", "m"].map((unit) => make("option", { value: unit, textContent: unit || `as in the file (${head.unit})` }));
  const body = [
    picture(head.lines),
    pick("sheet", "Sheet", guess.sheet),
    pick("pattern", "Pattern", whole ? "" : guess.pattern),
    pick("slits", "Slits", guess.slits),
    make("label", { htmlFor: "role-unit" }, "Unit of its numbers", make("select", { id: "role-unit" }, ...units)),
    ...head.notes.map((text) => make("p", { className: "faint", textContent: text })),
  ];
  const done = await ask(`Use ${dropped}`, body, [["", "Cancel"], ["use", "Use it", true]]);
  if (!done) return;
  const role = (what) => ($(`role-${what}`).value === "-" ? null : $(`role-${what}`).value);
  order("use", { roles: { sheet: role("sheet"), pattern: role("pattern"), slits: role("slits"), unit: role("unit") || null } });
});

function picture(lines) {
  const points = lines.flat();
  const low = [0, 1].map((k) => points.reduce((least, p) => Math.min(least, p[k]), Infinity));
  const high = [0, 1].map((k) => points.reduce((most, p) => Math.max(most, p[k]), -Infinity));
  const size = [high[0] - low[0] || 1, high[1] - low[1] || 1];
  const canvas = make("canvas", { width: 460, height: 190, role: "img", "aria-label": `Drawing, ${digits(size[0])} × ${digits(size[1])} mm` });
  const pen = canvas.getContext("2d");
  const scale = Math.min(440 / size[0], 170 / size[1]);
  pen.strokeStyle = getComputedStyle(document.documentElement).getPropertyValue("--ink");
  for (const line of lines) {
    pen.beginPath();
    line.forEach(([x, y], k) => pen[k ? "lineTo" : "moveTo"](230 + (x - (low[0] + high[0]) / 2) * scale, 95 - (y - (low[1] + high[1]) / 2) * scale));
    pen.stroke();
  }
  return make("div", {}, canvas, make("p", { className: "faint", textContent: `${digits(size[0], 4)} × ${digits(size[1], 4)} mm` }));
}

// A scan: its unit, then its numbers and the distance map.

async function askScan() {
  const units = ["", "mm", "cm", "in", "m"].map((unit) => make("option", { value: unit, textContent: unit || "fit the size" }));
  const body = [
    make("p", { textContent: "The scan is laid over the present shape; then every later shape is measured against it." }),
    make("label", { htmlFor: "scan-unit" }, "Unit of the file", make("select", { id: "scan-unit" }, ...units)),
    make("label", { className: "tick" }, make("input", { type: "checkbox", id: "scan-mirror" }), "it may be mirrored"),
  ];
  if (!(await ask(`Compare with ${dropped}`, body, [["", "Cancel"], ["go", "Compare", true]]))) return;
  order("compare", { unit: $("scan-unit").value || null, mirror: $("scan-mirror").checked });
}
document.addEventListener("compare-again", askScan);
