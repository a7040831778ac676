// The card of the scan: how well the shape fits it.

import { $, digits, make } from "./dom.js";
import { choose } from "./tools.js";
import { render, setScan, shown } from "./view.js";
import { on, order } from "./wire.js";

let head = null;
let asked = false;

on("scan", (told) => {
  head = told;
  asked = true;
});

on("scene", (now, arrays) => {
  const field = now.fields.scan;
  setScan(field ? arrays : null, field?.high ?? 1);
  if (!field) {
    if (!now.preview) $("scan").hidden = true;
    return;
  }
  if (asked) choose("scan");
  asked = false;
  card(arrays, now.numbers);
});

function card(arrays, numbers) {
  const distance = arrays["scan.distance"];
  const rms = Math.sqrt(distance.reduce((sum, d) => sum + d * d, 0) / distance.length);
  const rows = [
    ["now: r.m.s. distance", `${digits(rms)} mm`],
    ["now: largest", `${digits(distance.reduce((a, b) => Math.max(a, b), 0))} mm`],
    ["h/d of shape, scan", `${digits(numbers.aspect_ratio)}, ${digits(head?.numbers.aspect_ratio.scan)}`],
    ["SSIM when compared", digits(head?.numbers.ssim)],
    ["SSIM of a flat sheet", digits(head?.numbers.ssim_flat)],
  ];
  const show = make("input", { type: "checkbox", checked: true, id: "scan-show" });
  show.onchange = () => {
    setScan(show.checked ? shown.arrays : null, shown.head.fields.scan.high);
    render();
  };
  const again = make("button", { type: "button", textContent: "Align again…" });
  again.onclick = () => document.dispatchEvent(new CustomEvent("compare-again"));
  const away = make("button", { type: "button", textContent: "Remove" });
  away.onclick = () => {
    order("forget scan");
    choose("");
  };
  const title = make("h3", { textContent: "Scan" });
  const list = make("dl", {}, ...rows.flatMap(([label, text]) => [make("dt", { textContent: label }), make("dd", { textContent: text })]));
  const notes = (head?.notes ?? []).join(" ");
  $("scan").replaceChildren(title, list, make("label", { title: notes }, show, " show it"), " ", again, " ", away);
  $("scan").hidden = false;
}
