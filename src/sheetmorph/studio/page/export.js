// Exporting: everything that `run` and `fabricate` write, as files or as one zip.

import { $, ask, make, toast } from "./dom.js";
import { on, order, tab } from "./wire.js";

const PRINTERS = ["generic-0.4", "bambu-p1s", "prusa-mk4"];

$("export").onclick = async () => {
  const tick = (id, text) => make("label", { className: "tick" }, make("input", { type: "checkbox", id, checked: true }), text);
  const printers = PRINTERS.map((value) => make("option", { value, textContent: value }));
  const body = [
    tick("what-run", "The computed shape: states (HDF5), numbers (JSON), STL, series for ParaView, pictures, animation, report"),
    tick("what-parts", "The files to make it: 3MF and STL to print, DXF and SVG to cut, templates in true size, assembly sheet"),
    make("label", { htmlFor: "printer" }, "Printer", make("select", { id: "printer" }, ...printers)),
    make("label", { htmlFor: "kerf" }, "Kerf of the cutter [mm]", make("input", { id: "kerf", type: "number", min: 0, max: 5, step: 0.01, value: 0 })),
  ];
  if (!(await ask("Export", body, [["", "Cancel"], ["go", "Write the files", true]]))) return;
  const what = ["run", "parts"].filter((name) => $(`what-${name}`).checked);
  order("export", { what, printer: $("printer").value, kerf_mm: Number($("kerf").value) || 0 });
};

on("busy", (head) => {
  $("wait-what").textContent = `${head.what.charAt(0).toUpperCase()}${head.what.slice(1)}…`;
  $("wait-text").textContent = "";
  $("wait-bar").value = 0;
  $("wait").hidden = false;
});
on("helping", (head) => {
  $("wait-bar").value = head.fraction;
  $("wait-text").textContent = head.text;
});
for (const kind of ["idle", "lost"]) on(kind, () => { $("wait").hidden = true; });
$("wait-stop").onclick = () => order("stop");

on("exported", offer);

function offer(head) {
  const address = (name) => `out/${tab()}/${head.name}/${name.split("/").map(encodeURIComponent).join("/")}`;
  const link = (file) => make("a", { href: address(file.name), download: "", textContent: file.name });
  const zip = head.files.find((file) => file.name === head.zip);
  const rest = head.files.filter((file) => file !== zip);
  const size = (bytes) => (bytes > 1e6 ? `${(bytes / 1e6).toFixed(1)} MB` : `${Math.ceil(bytes / 1e3)} kB`);
  const all = make("a", { href: address(zip.name), download: head.zip, id: "zip" }, make("button", { type: "button", className: "primary", tabIndex: -1, textContent: `Everything as one zip (${size(zip.bytes)})` }));
  const items = rest.map((file) => make("li", {}, link(file), make("span", { className: "faint", textContent: ` ${size(file.bytes)}` })));
  const notes = head.notes.map((text) => make("p", { className: "faint", textContent: text }));
  ask(`${rest.length} files are ready`, [make("p", {}, all), make("ul", { className: "files" }, ...items), ...notes], [["", "Close"]]);
  if (!rest.length) toast("Nothing was written.");
}
