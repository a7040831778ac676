// Other shapes of the same sheet: searched on demand, looked at one by one.

import { $, digits, make, toast } from "./dom.js";
import { choose, scrub } from "./tools.js";
import { look, shown, swapFinal } from "./view.js";
import { on, order } from "./wire.js";

$("shapes").onclick = () => order("shapes");

on("shapes", (head, arrays) => {
  const [count, nodes] = arrays.shapes.shape;
  if (3 * nodes !== shown.nodes.length) {
    toast("The design has changed meanwhile; look for its shapes again.");
    return;
  }
  const rows = head.shapes.map((shape, k) => {
    const text = `h/d ${digits(shape.aspect_ratio)}, ${digits(shape.energy_mJ)} mJ, ${shape.stable ? "stable" : "unstable"}`;
    const button = make("button", { type: "button", textContent: `${shape.number}: ${text}`, "aria-pressed": "false" });
    button.onclick = () => show(button, arrays.shapes.subarray(3 * nodes * k, 3 * nodes * (k + 1)));
    return make("li", {}, button);
  });
  const back = make("button", { type: "button", textContent: "Back to the run", "aria-pressed": "true" });
  back.onclick = () => show(back, null);
  const title = `${count} ${count === 1 ? "shape" : "shapes"} at full actuation`;
  $("others").replaceChildren(make("h3", { textContent: title }), make("ul", {}, ...rows, make("li", {}, back)));
  $("others").hidden = false;
});

function show(button, points) {
  for (const other of $("others").querySelectorAll("button")) other.setAttribute("aria-pressed", String(other === button));
  if (points) choose("");
  swapFinal(points);
  scrub(1);
  look("home");
}

on("scene", () => { $("others").hidden = true; });
