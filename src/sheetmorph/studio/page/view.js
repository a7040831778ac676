// The sheet in space: mesh, colours, lines, ghost of the flat sheet, scan, clipping, camera.

import * as carried from "./three.js";
import { colourOf, themed } from "./colours.js";
import { $ } from "./dom.js";
import { emit, on } from "./wire.js";

// NiceGUI up to 3.15 exports all of the bundle as one object.
const { OrbitControls, THREE } = carried.default ?? carried;
const canvas = $("canvas");
const renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
renderer.localClippingEnabled = true;
const scene = new THREE.Scene();
const camera = new THREE.PerspectiveCamera(32, 1, 1, 20000);
camera.up.set(0, 0, 1);
const controls = new OrbitControls(camera, canvas);
controls.enableDamping = false;
controls.zoomToCursor = true;
const key = new THREE.DirectionalLight(0xffffff, 2.1);
const fill = new THREE.DirectionalLight(0xffffff, 0.7);
scene.add(new THREE.HemisphereLight(0xffffff, 0x9a9488, 1.5), key, fill);

const plane = new THREE.Plane(new THREE.Vector3(-1, 0, 0), 0);
const surface = { vertexColors: true, side: THREE.DoubleSide, roughness: 0.72, metalness: 0 };
const offset = { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 };
const sheet = new THREE.Mesh(new THREE.BufferGeometry(), new THREE.MeshStandardMaterial({ ...surface, ...offset }));
const outline = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ transparent: true, opacity: 0.75 }));
const wires = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ transparent: true, opacity: 0.28 }));
const ghost = new THREE.Mesh(new THREE.BufferGeometry(), new THREE.MeshStandardMaterial({ ...surface, ...offset, transparent: true, opacity: 0.3, depthWrite: false }));
const ghostLines = new THREE.LineSegments(outline.geometry.clone(), new THREE.LineBasicMaterial({ transparent: true, opacity: 0.4 }));
const scan = new THREE.Mesh(new THREE.BufferGeometry(), new THREE.MeshStandardMaterial({ ...surface, transparent: true, opacity: 0.55 }));
const marks = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ depthTest: false }));
scan.visible = wires.visible = ghost.visible = ghostLines.visible = false;
scene.add(sheet, outline, wires, ghost, ghostLines, scan, marks);

/** What is shown: the packet of the newest shape and how it is looked at. */
export const shown = { head: null, arrays: null, moment: 1, field: "", layout: "shape", nodes: null, drawn: 0 };
let own = null; // final positions of the run, while others are shown
let framed = null;
let middle = [0, 0]; // of the flat sheet [mm]
let seen = [0, 0, 0]; // where the camera looks [mm]

on("scene", setScene); // before the parts that are told of the new shape

/** Show another result. */
function setScene(head, arrays) {
  const first = shown.head === null;
  own = null;
  Object.assign(shown, { head, arrays, nodes: new Float32Array(arrays.positions.shape[1] * 3) });
  const corners = arrays.triangles.length;
  for (const mesh of [sheet, ghost]) {
    mesh.geometry.dispose();
    mesh.geometry = new THREE.BufferGeometry();
    for (const name of ["position", "normal", "color"]) {
      mesh.geometry.setAttribute(name, new THREE.BufferAttribute(new Float32Array(3 * corners), 3));
    }
  }
  for (const [lines, pairs] of [[outline, arrays.lines], [wires, arrays.edges], [ghostLines, arrays.lines]]) {
    lines.geometry.dispose();
    lines.geometry = new THREE.BufferGeometry();
    lines.geometry.setAttribute("position", new THREE.BufferAttribute(shown.nodes, 3));
    lines.geometry.setIndex(new THREE.BufferAttribute(pairs, 1));
  }
  const flat = arrays.positions.slice(0, shown.nodes.length);
  ghostLines.geometry.setAttribute("position", new THREE.BufferAttribute(flat, 3));
  expand(ghost.geometry, flat);
  paintParts(ghost.geometry);
  redraw();
  const size = extent();
  const moved = Math.hypot(middle[0] - seen[0], middle[1] - seen[1], mean(shown.nodes) - seen[2]);
  if (first || Math.abs(size / framed - 1) > 0.6 || moved > 0.2 * size) look("home");
}

/** Show other final positions of the nodes [mm]; none for those of the run. */
export function swapFinal(points) {
  const { positions } = shown.arrays;
  const at = positions.length - shown.nodes.length;
  own ??= positions.slice(at);
  positions.set(points ?? own, at);
  shown.moment = 1;
  redraw();
}

/** Go to a moment of the actuation, 0 flat and 1 final. */
export function setMoment(moment) {
  shown.moment = moment;
  redraw();
}

/** The state of the slider: the two computed states beside it, and the share of the second. */
export function between(moment = shown.moment) {
  const progress = shown.arrays.progress;
  const at = moment * progress[progress.length - 1];
  let k = 0;
  while (k < progress.length - 2 && progress[k + 1] <= at) k++;
  const gap = progress[k + 1] - progress[k];
  return [k, gap > 0 ? Math.min(1, Math.max(0, (at - progress[k]) / gap)) : 1];
}

/** A field at the nodes at this moment. */
export function fieldNow(name) {
  const values = shown.arrays[`field.${name}`];
  if (!values) return null;
  const count = values.shape.length > 1 ? values.shape[1] : values.length;
  if (values.shape.length === 1) return values;
  const [k, share] = between();
  const last = Math.min(k + 1, values.shape[0] - 1);
  const now = new Float32Array(count);
  for (let i = 0; i < count; i++) now[i] = (1 - share) * values[k * count + i] + share * values[last * count + i];
  return now;
}

/** Work out positions, normals and colours of this moment, and draw. */
export function redraw() {
  if (!shown.head) return render();
  const { positions } = shown.arrays;
  const count = shown.nodes.length;
  const [k, share] = between();
  const a = k * count;
  const b = Math.min(k + 1, positions.shape[0] - 1) * count;
  for (let i = 0; i < count; i++) shown.nodes[i] = (1 - share) * positions[a + i] + share * positions[b + i];
  expand(sheet.geometry, shown.nodes);
  const field = shown.head.fields[shown.field];
  if (field) paintField(sheet.geometry, field);
  else paintParts(sheet.geometry);
  for (const lines of [outline, wires]) lines.geometry.attributes.position.needsUpdate = true;
  arrange();
  emit("moment");
  render();
}

/** Corners and smooth normals of every triangle. */
function expand(geometry, nodes) {
  const { triangles } = shown.arrays;
  const place = geometry.attributes.position.array;
  const normal = geometry.attributes.normal.array;
  const sums = new Float32Array(nodes.length);
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [3 * triangles[t], 3 * triangles[t + 1], 3 * triangles[t + 2]];
    const ux = nodes[b] - nodes[a], uy = nodes[b + 1] - nodes[a + 1], uz = nodes[b + 2] - nodes[a + 2];
    const vx = nodes[c] - nodes[a], vy = nodes[c + 1] - nodes[a + 1], vz = nodes[c + 2] - nodes[a + 2];
    const n = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
    for (const p of [a, b, c]) for (let d = 0; d < 3; d++) sums[p + d] += n[d];
  }
  for (let i = 0; i < triangles.length; i++) {
    const p = 3 * triangles[i];
    const size = Math.hypot(sums[p], sums[p + 1], sums[p + 2]) || 1;
    for (let d = 0; d < 3; d++) {
      place[3 * i + d] = nodes[p + d];
      normal[3 * i + d] = sums[p + d] / size;
    }
  }
  for (const name of ["position", "normal"]) geometry.attributes[name].needsUpdate = true;
  geometry.computeBoundingSphere();
}

function paintParts(geometry) {
  const [film, ribs] = [themed("--film"), themed("--ribs")];
  const colours = geometry.attributes.color.array;
  shown.arrays.pattern.forEach((inside, t) => {
    for (let i = 0; i < 9; i++) colours[9 * t + i] = (inside ? ribs : film)[i % 3];
  });
  geometry.attributes.color.needsUpdate = true;
}

function paintField(geometry, field) {
  const values = fieldNow(shown.field);
  const colours = geometry.attributes.color.array;
  shown.arrays.triangles.forEach((node, i) => {
    colourOf((values[node] - field.low) / (field.high - field.low), field.diverging, colours, 3 * i);
  });
  geometry.attributes.color.needsUpdate = true;
}

/** Put the flat sheet under or beside the shape. */
function arrange() {
  const beside = shown.layout === "beside";
  const away = beside ? 0.62 * extent() : 0;
  for (const part of [sheet, outline, wires, scan, marks]) part.position.x = away;
  for (const part of [ghost, ghostLines]) {
    part.position.x = -away;
    part.visible = shown.layout !== "shape";
  }
  ghost.material.opacity = beside ? 1 : 0.3;
  ghost.material.depthWrite = beside;
}

/** Longest side of the flat sheet [mm]. */
export function extent() {
  const flat = shown.arrays.positions;
  const low = [Infinity, Infinity], high = [-Infinity, -Infinity];
  for (let i = 0; i < shown.nodes.length; i += 3) {
    for (let d = 0; d < 2; d++) {
      low[d] = Math.min(low[d], flat[i + d]);
      high[d] = Math.max(high[d], flat[i + d]);
    }
  }
  middle = [0, 1].map((d) => (low[d] + high[d]) / 2);
  return Math.max(high[0] - low[0], high[1] - low[1]);
}

/** Show a scan laid over the shape, or none. */
export function setScan(arrays, high) {
  scan.visible = Boolean(arrays);
  if (arrays) {
    scan.geometry.dispose();
    scan.geometry = new THREE.BufferGeometry();
    const colours = new Float32Array(arrays["scan.points"].length);
    arrays["scan.distance"].forEach((distance, i) => colourOf(distance / high, false, colours, 3 * i));
    scan.geometry.setAttribute("position", new THREE.BufferAttribute(arrays["scan.points"], 3));
    scan.geometry.setAttribute("color", new THREE.BufferAttribute(colours, 3));
    scan.geometry.setIndex(new THREE.BufferAttribute(arrays["scan.triangles"], 1));
    scan.geometry.computeVertexNormals();
  }
  render();
}

/** Lines over everything, as pairs of points [mm]. */
export function setMarks(points) {
  marks.geometry.dispose();
  marks.geometry = new THREE.BufferGeometry();
  marks.geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(points.flat()), 3));
  render();
}

/** Cut off what lies beyond a share of the sheet along an axis; "" for nothing. */
export function clip(axis, share) {
  const on = axis ? [plane] : [];
  for (const part of [sheet, outline, wires, scan]) part.material.clippingPlanes = on;
  if (axis && shown.head) {
    const box = new THREE.Box3().setFromArray(shown.nodes);
    if (scan.visible) box.union(scan.geometry.boundingBox ?? box);
    plane.normal.set(axis === "x" ? -1 : 0, axis === "y" ? -1 : 0, axis === "z" ? -1 : 0);
    const add = axis === "x" ? sheet.position.x : 0;
    plane.constant = box.min[axis] + share * (box.max[axis] - box.min[axis]) + 1e-3 + add;
  }
  render();
}

/** Show or hide the lines of the mesh. */
export function showMesh(on) {
  wires.visible = on;
  render();
}

/** Put the camera somewhere: "home", "top" or "side". */
export function look(from) {
  if (!shown.head) return;
  framed = extent();
  const wide = shown.layout === "beside" ? 1.75 : 1;
  const tall = camera.aspect < 1.25 ? 1.25 / camera.aspect : 1;
  const distance = 1.95 * framed * Math.max(tall, wide * 0.85);
  const to = { home: [0.42, -0.8, 0.5], top: [0, -1e-4, 1], side: [0, -1, 0.02] }[from];
  const [x, y] = middle;
  const z = mean(shown.nodes);
  seen = [x, y, z];
  controls.target.set(x, y, z);
  camera.position.set(x + distance * to[0], y + distance * to[1], z + distance * to[2]);
  controls.update();
  render();
}

function mean(nodes) {
  let low = Infinity, high = -Infinity;
  for (let i = 2; i < nodes.length; i += 3) [low, high] = [Math.min(low, nodes[i]), Math.max(high, nodes[i])];
  return (low + high) / 2;
}

/** The point of the sheet under the pointer [mm], or null. */
export function pick(event) {
  const box = canvas.getBoundingClientRect();
  const at = new THREE.Vector2(((event.clientX - box.left) / box.width) * 2 - 1, 1 - ((event.clientY - box.top) / box.height) * 2);
  const ray = new THREE.Raycaster();
  ray.setFromCamera(at, camera);
  const hit = ray.intersectObject(sheet)[0];
  return hit ? [hit.point.x - sheet.position.x, hit.point.y, hit.point.z] : null;
}

/** Where a point [mm] lies on the canvas, in pixels. */
export function project(point) {
  const at = new THREE.Vector3(point[0] + sheet.position.x, point[1], point[2]).project(camera);
  return [((at.x + 1) / 2) * canvas.clientWidth, ((1 - at.y) / 2) * canvas.clientHeight];
}

/** Turn and zoom by keys. */
canvas.addEventListener("keydown", (event) => {
  const turn = { ArrowLeft: [-0.12, 0], ArrowRight: [0.12, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[event.key];
  const zoom = { "+": 0.88, "=": 0.88, "-": 1.14 }[event.key];
  if (!turn && !zoom) return;
  event.preventDefault();
  const arm = new THREE.Spherical().setFromVector3(camera.position.clone().sub(controls.target).applyAxisAngle(new THREE.Vector3(1, 0, 0), -Math.PI / 2));
  if (turn) {
    arm.theta += turn[0];
    arm.phi = Math.min(3.1, Math.max(0.04, arm.phi + turn[1]));
  } else arm.radius *= zoom;
  const from = new THREE.Vector3().setFromSpherical(arm).applyAxisAngle(new THREE.Vector3(1, 0, 0), Math.PI / 2);
  camera.position.copy(controls.target).add(from);
  controls.update();
  render();
});

/** Colours that follow the theme. */
export function retheme() {
  const ink = themed("--ink");
  for (const lines of [outline, wires, ghostLines, marks]) lines.material.color.setRGB(...ink);
  marks.material.color.setRGB(...themed("--held"));
  if (shown.head) {
    paintParts(ghost.geometry);
    redraw();
  }
}

let due = false;

/** Draw in the next frame. */
export function render() {
  if (due) return;
  due = true;
  requestAnimationFrame(() => {
    due = false;
    key.position.copy(camera.position).add(new THREE.Vector3(0, 0, 0.6 * camera.position.length()));
    fill.position.set(-camera.position.y, camera.position.x, 0.2 * camera.position.length());
    renderer.render(scene, camera);
    shown.drawn += 1;
    emit("drawn");
  });
}

function resize() {
  const { clientWidth: width, clientHeight: height } = canvas.parentElement;
  renderer.setPixelRatio(Math.min(2, devicePixelRatio));
  renderer.setSize(width, height, false);
  camera.aspect = width / Math.max(1, height);
  camera.updateProjectionMatrix();
  render();
}

new ResizeObserver(resize).observe(canvas.parentElement);
controls.addEventListener("change", render);
retheme();
