// The viewer of the studio in a cell of a notebook: one finished result, no server.

import { legend } from "./colours.js";
import { $, digits, make } from "./dom.js";
import { between, look, redraw, retheme, setMoment, showMesh, shown } from "./view.js";
import { decode, emit } from "./wire.js";

const SECONDS = 3; // of playing from flat to final
let playing = 0;

/** Show the packet of a result, coloured by a field ("" for the material). */
export function start(buffer, field) {
  const [head, arrays] = decode(buffer);
  const fields = Object.entries(head.fields).map(([name, one]) => [name, one.label]);
  $("field").replaceChildren(...[["", "material"], ...fields].map(([value, textContent]) => make("option", { value, textContent })));
  $("field").value = field;
  shown.field = field;
  emit("scene", head, arrays);
  retheme();
  legend(head.fields[field]);
  $("field").onchange = () => {
    shown.field = $("field").value;
    legend(head.fields[shown.field]);
    redraw();
  };
  $("layout").onchange = () => {
    shown.layout = $("layout").value;
    redraw();
    look("home");
  };
  $("grid").onclick = () => {
    const on = $("grid").getAttribute("aria-pressed") !== "true";
    $("grid").setAttribute("aria-pressed", String(on));
    showMesh(on);
  };
  for (const from of ["home", "top", "side"]) $(from).onclick = () => look(from);
  $("scrub").oninput = () => {
    stop();
    go(Number($("scrub").value));
  };
  $("play").onclick = () => (playing ? stop() : play());
  const { numbers } = head;
  $("state").textContent = `${numbers.status}${numbers.stable ? ", stable" : ""} · ${numbers.nodes} nodes`;
  go(1);
}

/** Go to a moment, 0 flat and 1 final, and tell where that is. */
function go(moment) {
  $("scrub").value = moment;
  setMoment(moment);
  const { actuation, ratio } = shown.head;
  const [k, share] = between();
  const at = (values) => (1 - share) * values[k] + share * values[Math.min(k + 1, values.length - 1)];
  $("at").textContent = `free strain ${digits(at(actuation))}, h/d ${digits(at(ratio))}`;
}

function play() {
  const from = Number($("scrub").value) < 1 ? Number($("scrub").value) : 0;
  const began = performance.now();
  $("play").textContent = "❚❚";
  const step = (now) => {
    const moment = Math.min(1, from + Math.max(0, now - began) / (1000 * SECONDS));
    go(moment);
    if (moment < 1) playing = requestAnimationFrame(step);
    else stop();
  };
  playing = requestAnimationFrame(step);
}

function stop() {
  cancelAnimationFrame(playing);
  playing = 0;
  $("play").textContent = "▶";
}
