"use strict";
// The gallery: one scene in four panels, layers on or off, one cursor for all panels.
const gallery = JSON.parse(document.getElementById("scenes").textContent);
const SVG = "http://www.w3.org/2000/svg";
const PANELS = [["observed", "Observed"], ["labels", "Layers"], ["cgan", "cGAN"], ["phy", "PHY"]];
const element = (id) => document.getElementById(id);
const cursor = { row: 0, line: 0 };
let current = 0;

function svgNode(name, attributes) {
  const node = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  return node;
}

function drawing(scene) {
  const svg = svgNode("svg", { viewBox: `-0.5 -0.5 ${scene.n_range_lines} ${scene.n_range_bins}`, preserveAspectRatio: "none", "aria-hidden": "true" });
  const overlay = svgNode("g", { class: "overlay" });
  for (const layer of scene.layers) for (const piece of layer) overlay.append(svgNode("polyline", { points: piece.join(" ") }));
  svg.append(overlay, svgNode("line", { class: "cursor across" }), svgNode("line", { class: "cursor down" }));
  return svg;
}

function panel(scene, key, title) {
  const figure = document.createElement("figure");
  figure.className = "panel";
  const caption = document.createElement("figcaption");
  const scores = scene.scores[key];
  caption.textContent = title;
  if (scores) {
    const small = document.createElement("span");
    small.className = "small";
    small.textContent = ` SSIM ${scores.ssim.toFixed(2)}, PSNR ${scores.psnr.toFixed(1)} dB`;
    caption.append(small);
  }
  const stage = document.createElement("div");
  stage.className = `stage ${key}`;
  // Tall scenes are squeezed, so that a panel fits a screen.
  stage.style.aspectRatio = `${scene.n_range_lines} / ${Math.min(scene.n_range_bins, 1.9 * scene.n_range_lines)}`;
  if (key !== "labels") {
    const image = document.createElement("img");
    image.src = scene.images[key];
    image.alt = `${title} echogram of scene ${scene.name}, ${scene.n_layers} layers below the surface`;
    stage.append(image);
  } else {
    stage.setAttribute("role", "img");
    stage.setAttribute("aria-label", `Layers of scene ${scene.name}: the surface and ${scene.n_layers} layers below it`);
  }
  stage.append(drawing(scene));
  stage.addEventListener("pointermove", (event) => follow(event, stage));
  stage.addEventListener("pointerdown", (event) => follow(event, stage));
  figure.append(caption, stage);
  return figure;
}

function follow(event, stage) {
  const scene = gallery.scenes[current];
  const box = stage.getBoundingClientRect();
  cursor.line = Math.floor(((event.clientX - box.left) / box.width) * scene.n_range_lines);
  cursor.row = Math.floor(((event.clientY - box.top) / box.height) * scene.n_range_bins);
  moveCursor();
}

function heightOf(layer, line) {
  for (const piece of layer) {
    for (let i = 0; i + 3 < piece.length; i += 2) {
      if (piece[i] <= line && line <= piece[i + 2]) {
        const share = (line - piece[i]) / (piece[i + 2] - piece[i]);
        return piece[i + 1] + share * (piece[i + 3] - piece[i + 1]);
      }
    }
  }
  return null;
}

function placeText(scene) {
  const heights = scene.layers.map((layer) => heightOf(layer, cursor.line));
  const parts = [`range bin ${cursor.row}, range line ${cursor.line}`];
  if (heights[0] !== null) {
    const below = cursor.row - heights[0];
    parts.push(`${(below * gallery.bin_size_s * 1e9).toFixed(1)} ns two-way from the surface`);
    parts.push(below >= 0 ? `${(below * gallery.snow_per_bin_m).toFixed(2)} m deep in snow` : `${(-below * gallery.air_per_bin_m).toFixed(2)} m above it in air`);
  }
  const near = heights.findIndex((height) => height !== null && Math.abs(height - cursor.row) <= 3);
  if (near >= 0) parts.push(near === 0 ? "at the surface" : `at layer ${near}`);
  return parts.join(" \u00b7 ");
}

function moveCursor() {
  const scene = gallery.scenes[current];
  cursor.row = Math.max(0, Math.min(scene.n_range_bins - 1, cursor.row));
  cursor.line = Math.max(0, Math.min(scene.n_range_lines - 1, cursor.line));
  for (const line of document.querySelectorAll(".cursor.across")) {
    for (const [key, value] of [["x1", -0.5], ["x2", scene.n_range_lines], ["y1", cursor.row], ["y2", cursor.row]]) line.setAttribute(key, value);
  }
  for (const line of document.querySelectorAll(".cursor.down")) {
    for (const [key, value] of [["y1", -0.5], ["y2", scene.n_range_bins], ["x1", cursor.line], ["x2", cursor.line]]) line.setAttribute(key, value);
  }
  const readout = element("readout");
  readout.textContent = placeText(scene);
  readout.setAttribute("aria-valuemax", scene.n_range_bins - 1);
  readout.setAttribute("aria-valuenow", cursor.row);
  readout.setAttribute("aria-valuetext", readout.textContent);
}

function show(index) {
  current = (index + gallery.scenes.length) % gallery.scenes.length;
  const scene = gallery.scenes[current];
  element("panels").replaceChildren(...PANELS.map(([key, title]) => panel(scene, key, title)));
  element("scene").value = String(current);
  [...element("strip").children].forEach((button, i) => button.setAttribute("aria-current", String(i === current)));
  moveCursor();
}

function switchLayers() {
  element("viewer").classList.toggle("plain", !element("layers").checked);
}

const MOVES = { ArrowUp: [-1, 0], ArrowDown: [1, 0], PageUp: [-10, 0], PageDown: [10, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1], Home: [-1e9, 0], End: [1e9, 0] };

function startGallery() {
  gallery.scenes.forEach((scene, i) => {
    element("scene").append(new Option(`${scene.name}, ${scene.n_layers} layers`, String(i)));
    const button = document.createElement("button");
    button.type = "button";
    const image = document.createElement("img");
    image.src = scene.images.observed;
    image.alt = `Scene ${scene.name}`;
    button.append(image, `${scene.n_layers} layers`);
    button.addEventListener("click", () => show(i));
    element("strip").append(button);
  });
  element("scene").addEventListener("change", (event) => show(Number(event.target.value)));
  element("previous").addEventListener("click", () => show(current - 1));
  element("next").addEventListener("click", () => show(current + 1));
  element("layers").addEventListener("change", switchLayers);
  element("readout").addEventListener("keydown", (event) => {
    const move = MOVES[event.key];
    if (!move) return;
    event.preventDefault();
    cursor.row += move[0];
    cursor.line += move[1];
    moveCursor();
  });
  element("viewer").hidden = false;
  // A scene of many layers, but not of the most.
  const first = Math.floor(0.7 * gallery.scenes.length);
  cursor.row = Math.floor(gallery.scenes[first].n_range_bins / 3);
  cursor.line = Math.floor(gallery.scenes[first].n_range_lines / 2);
  switchLayers();
  show(first);
}

// Figures enlarge in a dialog, which Escape closes.
function enlarge(image) {
  const dialog = document.createElement("dialog");
  const form = document.createElement("form");
  form.method = "dialog";
  const close = document.createElement("button");
  close.textContent = "Close";
  form.append(close);
  dialog.setAttribute("aria-label", "Enlarged figure");
  dialog.append(form, image.cloneNode());
  dialog.addEventListener("close", () => dialog.remove());
  document.body.append(dialog);
  dialog.showModal();
}

startGallery();
for (const button of document.querySelectorAll(".zoom")) button.addEventListener("click", () => enlarge(button.firstElementChild));
