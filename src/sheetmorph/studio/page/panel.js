// The side panel: a field for every key of the design.

import { $, make } from "./dom.js";
import { on, order } from "./wire.js";

const form = $("groups");
const open = new Map(); // which groups are unfolded
let shape = ""; // which fields there are, so that values alone are changed in place
let typing = null;

form.addEventListener("submit", (event) => event.preventDefault());
$("filter").addEventListener("input", filter);

on("design", (head) => {
  if (!head.panel) return;
  const now = JSON.stringify(head.panel.map((group) => [group.title, group.entries.map((entry) => [entry.key, entry.type])]));
  if (now !== shape) build(head.panel, head.plan);
  shape = now;
  for (const group of head.panel) for (const entry of group.entries) fillIn(entry);
  for (const row of form.querySelectorAll(".wrong")) right(row);
});
on("editing", (head) => {
  for (const [key, value] of Object.entries(head.values)) {
    const inputs = fieldsOf(key);
    const parts = Array.isArray(value) ? value : [value];
    inputs.forEach((input, k) => { input.value = Number.parseFloat(parts[k]); });
  }
});
on("problem", (head) => {
  if (!head.key || head.drag) return;
  const input = fieldsOf(head.key.replace(/\[(\d+)\]/g, ".$1"))[0];
  if (input) wrong(input.closest(".row"), head.text);
});

const fieldsOf = (key) => [...form.querySelectorAll(`[data-key="${CSS.escape(key)}"]`)];

function build(groups, plan) {
  form.replaceChildren(...groups.map((group, k) => {
    const title = make("summary", {}, group.title);
    if (group.shape !== undefined) {
      const remove = make("button", { type: "button", textContent: "remove", "aria-label": `Remove ${group.title}` });
      remove.onclick = (event) => {
        event.preventDefault();
        order("edit", { values: { [group.key]: null } });
      };
      title.append(remove);
    }
    const unfolded = open.get(group.title) ?? (k < 2 || group.key === "actuation");
    const details = make("details", { open: unfolded && !group.folded }, title, ...group.entries.map(row));
    details.addEventListener("toggle", () => open.set(group.title, details.open));
    return details;
  }));
  const last = [...form.children].findLast((element, k) => groups[k].key === "outline" || groups[k].shape !== undefined);
  const add = make("button", { type: "button", textContent: "Add a shape to the pattern…" });
  add.onclick = () => document.dispatchEvent(new CustomEvent("add-shape", { detail: plan }));
  last.after(make("div", { className: "more" }, add));
  filter();
}

function row(entry) {
  const id = `field-${entry.key}`;
  const title = [entry.help, entry.key, bounds(entry)].filter(Boolean).join(" · ");
  const label = make("label", { htmlFor: id, textContent: entry.label, title });
  const line = make("div", { className: "row", title, data: { key: "", name: `${entry.label} ${entry.key}`.toLowerCase() } }, label);
  delete line.dataset.key;
  if (entry.type === "choice" || entry.type === "flag") {
    const choices = entry.type === "flag" ? ["true", "false"] : entry.choices;
    const options = choices.map((text) => make("option", { value: text, textContent: { true: "yes", false: "no" }[text] ?? text.replaceAll("_", " ") }));
    if (entry.value === null) options.unshift(make("option", { value: "", textContent: "by itself" }));
    const select = make("select", { id, data: { key: entry.key, type: entry.type } }, ...options);
    select.onchange = () => commit(select, entry);
    line.classList.add("choice");
    line.append(select);
  } else {
    const count = entry.type === "pair" ? 2 : 1;
    if (count === 2) line.classList.add("wide");
    for (let k = 0; k < count; k++) {
      const input = make("input", {
        id: k ? `${id}-2` : id, type: "number", step: "any", placeholder: entry.value === null ? "auto" : "",
        "aria-label": count === 2 ? `${entry.label} ${"xy"[k]} in mm` : undefined, data: { key: entry.key, type: entry.type },
      });
      input.onchange = () => commit(input, entry);
      input.onkeydown = (event) => step(event, input, entry);
      input.onfocus = () => { typing = input; };
      input.onblur = () => { typing = null; };
      line.append(input);
    }
    line.append(make("span", { className: "unit", textContent: unitText(entry.unit) }));
  }
  return line;
}

const unitText = (unit) => ({ "kg/m^3": "kg/m³", "m/s^2": "m/s²", degC: "°C", deg: "°" })[unit] ?? unit ?? "";

function bounds(entry) {
  if (entry.low === undefined && entry.high === undefined) return "";
  return `${entry.low ?? ""} to ${entry.high ?? ""} ${unitText(entry.unit)}`.trim();
}

/** Arrow keys change a number by a hundredth of it, with Shift by a tenth. */
function step(event, input, entry) {
  const way = { ArrowUp: 1, ArrowDown: -1 }[event.key];
  if (!way || input.value === "") return;
  event.preventDefault();
  const value = Number(input.value);
  const size = entry.type === "whole" ? 1 : Math.max(10 ** (Math.floor(Math.log10(Math.abs(value) || 1)) - (event.shiftKey ? 0 : 1)), 1e-6);
  let next = value + way * size;
  if (entry.low !== undefined) next = Math.max(entry.low, next);
  if (entry.high !== undefined) next = Math.min(entry.high, next);
  input.value = Number(next.toPrecision(8));
  commit(input, entry);
}

/** Send what a field says. An empty one takes its key out of the design. */
function commit(input, entry) {
  const fields = fieldsOf(entry.key);
  const texts = fields.map((field) => field.value.trim());
  let value = null;
  if (texts.every((text) => text !== "")) {
    if (entry.type === "pair") value = texts.map((text) => `${text} ${entry.unit}`);
    else if (entry.type === "quantity") value = entry.unit ? `${texts[0]} ${entry.unit}` : Number(texts[0]);
    else if (entry.type === "flag") value = texts[0] === "true";
    else if (entry.type === "choice") value = texts[0];
    else value = Number(texts[0]);
  }
  right(input.closest(".row"));
  order("edit", { values: { [entry.key]: value } });
}

function fillIn(entry) {
  const fields = fieldsOf(entry.key);
  const parts = entry.type === "pair" ? entry.value : [entry.value];
  fields.forEach((field, k) => {
    if (field === typing && field.matches(":focus") && Number(field.value) === parts[k]) return;
    field.value = parts[k] === null ? "" : String(parts[k]);
  });
  const line = fields[0]?.closest(".row");
  if (line) line.dataset.given = entry.given === false ? "no" : "yes";
}

function wrong(line, text) {
  right(line);
  line.classList.add("wrong");
  line.append(make("span", { className: "why", textContent: text }));
  line.querySelectorAll("input, select").forEach((field) => field.setAttribute("aria-invalid", "true"));
  line.closest("details").open = true;
}

function right(line) {
  line.classList.remove("wrong");
  line.querySelector(".why")?.remove();
  line.querySelectorAll("[aria-invalid]").forEach((field) => field.removeAttribute("aria-invalid"));
}

function filter() {
  const words = $("filter").value.trim().toLowerCase();
  for (const line of form.querySelectorAll(".row")) line.hidden = Boolean(words) && !line.dataset.name.includes(words);
  for (const group of form.querySelectorAll("details")) {
    group.hidden = Boolean(words) && !group.querySelector(".row:not([hidden])");
    if (words && !group.hidden) group.open = true;
  }
}
