// The socket to the server: orders go out as JSON, packets come in with a head and arrays.

const listeners = new Map();
let socket = null;
let wait = 300;
let queued = [];

/** Listen to packets of one kind; `handler(head, arrays)`. */
export function on(kind, handler) {
  if (!listeners.has(kind)) listeners.set(kind, []);
  listeners.get(kind).push(handler);
}

/** Tell listeners of something that did not come from the server. */
export function emit(kind, head = {}, arrays = {}) {
  for (const handler of listeners.get(kind) ?? []) handler(head, arrays);
}

/** Send an order; while the connection is broken, the last edits wait for it. */
export function order(what, more = {}) {
  const text = JSON.stringify({ do: what, ...more });
  if (socket?.readyState === WebSocket.OPEN) socket.send(text);
  else if (!more.drag) queued = [...queued.slice(-20), text];
}

/** The random name of this tab, by which the server knows it again after a lost connection. */
export function tab() {
  let name = sessionStorage.getItem("tab");
  if (!name) name = renamed();
  return name;
}

function renamed() {
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  const name = [...bytes].map((b) => b.toString(16).padStart(2, "0")).join("");
  sessionStorage.setItem("tab", name);
  return name;
}

/** Connect, and connect again whenever the connection is lost. */
export function connect() {
  const scheme = location.protocol === "https:" ? "wss" : "ws";
  socket = new WebSocket(`${scheme}://${location.host}/live/${tab()}`);
  socket.binaryType = "arraybuffer";
  socket.onopen = () => { wait = 300; };
  socket.onmessage = (event) => {
    const [head, arrays] = decode(event.data);
    emit(head.kind, head, arrays);
    if (head.kind === "hello") {
      for (const text of queued) socket.send(text);
      queued = [];
    }
  };
  socket.onclose = (event) => {
    if (event.code === 4001) renamed(); // a copy of this tab has taken its name
    emit("lost", { reason: event.reason });
    setTimeout(connect, wait);
    wait = Math.min(4000, 2 * wait);
  };
}

/** Head and arrays of a packet. */
export function decode(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const arrays = {};
  for (const [name, told] of Object.entries(head.arrays ?? {})) {
    const Kind = told.type === "u4" ? Uint32Array : Float32Array;
    const count = told.shape.reduce((a, b) => a * b, 1);
    arrays[name] = new Kind(buffer, 4 + length + told.at, count);
    arrays[name].shape = told.shape;
  }
  return [head, arrays];
}
