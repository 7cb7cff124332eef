// The page of predictions of one test set.

import { blob, bytesOf } from "./planes.js";
import { IGNORE, painted } from "./maps.js";
import { swipe } from "./swipe.js";

const facts = JSON.parse(document.getElementById("facts").textContent);
const { images, rows, classes } = facts;
const at = (id) => document.getElementById(id);
const all = (selector) => [...document.querySelectorAll(selector)];
const SIDES = ["image", "truth", ...rows.map((_, n) => String(n))];
const SHOWN = ["labels", "errors", "change"];
const SORTS = { class: "class", a: "A", b: "B", change: "change", pixels: "pixels" };
const state = { image: 0, a: SIDES[Math.min(2, SIDES.length - 1)], b: SIDES.at(-1), shown: "labels", palette: "cityscapes",
  outlines: false, opacity: 0.7, only: null, order: "name", sort: "change", descending: false };
let maps = null, divider, turn = 0, cursor = null;

function nameOf(side) {
  if (side === "image") return "image";
  return side === "truth" ? "ground truth" : `${rows[side].network} ${rows[side].row}`;
}

function percent(value) {
  return value === null || value === undefined ? "–" : value.toFixed(1);
}

function signed(value) {
  return value === null ? "–" : `${value > 0 ? "+" : value < 0 ? "−" : "±"}${Math.abs(value).toFixed(1)}`;
}

function scores(image, side) {
  return rows[side] ? images[image].scores[side] : null; // {mean, classes}
}

function difference(one, other) {
  return one === null || other === null || one === undefined || other === undefined ? null : other - one;
}

function meanChange(image) {
  return difference(scores(image, state.a)?.mean, scores(image, state.b)?.mean);
}

// Numbers of the images in the order asked for; those without a change come last.
function ordered() {
  const numbers = images.map((_, n) => n);
  if (state.order === "name") return numbers;
  const sign = state.order === "gain" ? -1 : 1;
  const key = new Map(numbers.map((n) => [n, meanChange(n) ?? sign * Infinity]));
  return numbers.sort((one, other) => sign * (key.get(one) - key.get(other)) || one - other);
}

async function load() {
  const { width } = images[state.image], wanted = ++turn;
  const prefix = `${state.image}-`;
  const map = (side) => (side === "image" ? null : bytesOf(blob(prefix + side), width));
  const [truth, a, b] = await Promise.all([map("truth"), map(state.a), map(state.b)]);
  // Two sides that show the ground truth share it, so that errors know it for what it is.
  const shared = (side, found) => (side === "truth" ? truth : found);
  if (wanted === turn) maps = { truth, a: shared(state.a, a), b: shared(state.b, b) };
  return wanted === turn;
}

function how() {
  return { ...state, palette: facts.palettes[state.palette], right: facts.right, wrong: facts.wrong };
}

function paint() {
  const { width, height } = images[state.image];
  for (const [id, side] of [["canvas-a", divider.on ? "b" : "a"], ["canvas-b", "b"], ["canvas-cover", "a"]]) {
    if ((id === "canvas-b" && divider.on) || (id === "canvas-cover" && !divider.on)) continue;
    const canvas = at(id);
    Object.assign(canvas, { width, height }); // which clears it
    const pixels = painted(side, maps, width, how());
    canvas.getContext("2d").putImageData(new ImageData(new Uint8ClampedArray(pixels.buffer), width, height), 0, 0);
    canvas.style.opacity = state.opacity;
    canvas.style.imageRendering = "pixelated";
  }
}

function caption(side) {
  const mean = scores(state.image, state[side])?.mean;
  return `${side.toUpperCase()}: ${nameOf(state[side])}` + (mean === undefined ? "" : `, mean IoU of this image ${percent(mean)}`);
}

// Classes of this image with their scores on both sides, as the table sorts them.
function lines() {
  const a = scores(state.image, state.a)?.classes, b = scores(state.image, state.b)?.classes;
  const found = classes.map((name, id) => {
    const line = { id, class: name, a: a?.[id] ?? null, b: b?.[id] ?? null, pixels: images[state.image].pixels[id] };
    return { ...line, change: difference(line.a, line.b) };
  }).filter((line) => line.pixels > 0 || line.a !== null || line.b !== null);
  const sign = state.descending ? -1 : 1, key = state.sort === "class" ? "id" : state.sort;
  return found.sort((one, other) => {
    const empty = (one[key] === null) - (other[key] === null); // what is not defined comes last
    return empty || sign * (one[key] - other[key]) || one.id - other.id;
  });
}

function tabulate() {
  const [wrong, right] = [facts.wrong, facts.right].map((colour) => `rgb(${colour})`);
  const shown = lines(), largest = Math.max(1, ...shown.map((line) => Math.abs(line.change ?? 0)));
  at("table").tHead.rows[0].replaceChildren(...Object.entries(SORTS).map(([key, text]) => {
    const head = document.createElement("th"), button = document.createElement("button");
    button.textContent = text + (state.sort === key ? (state.descending ? " ↓" : " ↑") : "");
    button.addEventListener("click", () => set({ sort: key, descending: state.sort === key && !state.descending }));
    head.setAttribute("aria-sort", state.sort !== key ? "none" : state.descending ? "descending" : "ascending");
    head.append(button);
    return head;
  }));
  at("table").tBodies[0].replaceChildren(...shown.map((line) => {
    const row = document.createElement("tr");
    row.setAttribute("aria-selected", String(state.only === line.id));
    const button = document.createElement("button"), patch = document.createElement("span");
    patch.className = "patch";
    patch.style.background = `rgb(${facts.palettes[state.palette][line.id]})`;
    button.append(patch, line.class);
    button.addEventListener("click", () => set({ only: state.only === line.id ? null : line.id }));
    const bar = document.createElement("span"), inner = document.createElement("i");
    bar.className = "bar";
    const share = (50 * Math.abs(line.change ?? 0)) / largest;
    Object.assign(inner.style, { width: `${share}%`, left: line.change < 0 ? `${50 - share}%` : "50%",
      background: line.change < 0 ? wrong : right });
    bar.append(inner);
    for (const content of [button, percent(line.a), percent(line.b), signed(line.change), line.pixels.toLocaleString("en")]) {
      const cell = row.insertCell();
      cell.append(content);
    }
    row.cells[3].prepend(bar);
    return row;
  }));
}

function explain() {
  const entry = (colour, text) => {
    const item = document.createElement("span"), patch = document.createElement("span");
    patch.className = "patch";
    patch.style.background = colour && `rgb(${colour})`;
    item.append(patch, text);
    return item;
  };
  const entries = {
    errors: [entry(facts.wrong, "wrong"), entry(null, "right, or without a class in the ground truth")],
    change: [entry(facts.right, "B is right, A was not"), entry(facts.wrong, "B is wrong, A was not")],
    labels: [entry([0, 0, 0], "not labelled")],
  };
  at("key").replaceChildren(...entries[state.shown]);
}

function tell() {
  for (const cross of all(".cross")) {
    cross.hidden = cursor === null;
    if (cursor === null) continue;
    cross.style.left = `${(100 * (cursor.x + 0.5)) / images[state.image].width}%`;
    cross.style.top = `${(100 * (cursor.y + 0.5)) / images[state.image].height}%`;
  }
  if (cursor === null || !maps) return;
  const pixel = cursor.y * images[state.image].width + cursor.x;
  const called = (ids) => (ids ? (ids[pixel] === IGNORE ? "not labelled" : classes[ids[pixel]]) : "–");
  at("readout").textContent = `row ${cursor.y}, column ${cursor.x}: ground truth ${called(maps.truth)}` +
    ["a", "b"].filter((side) => rows[state[side]]).map((side) => `, ${side.toUpperCase()} ${called(maps[side])}`).join("");
}

async function set(change) {
  const loads = ["image", "a", "b"].some((key) => key in change) || !maps;
  Object.assign(state, change);
  if ("image" in change) cursor = null;
  if (loads && !(await load())) return; // something else was asked for meanwhile
  const image = images[state.image], order = ordered();
  if (loads) for (const photo of all(".photo")) photo.src = `data:image/jpeg;base64,${blob(`${state.image}-photo`)}`;
  for (const stage of all(".stage")) {
    stage.style.aspectRatio = `${image.width} / ${image.height}`;
    stage.style.setProperty("--ratio", image.width / image.height);
  }
  at("panes").classList.toggle("one", divider.on);
  at("pane-b").hidden = divider.on;
  at("cover").hidden = !divider.on;
  at("image").replaceChildren(...order.map((n) => {
    const change = meanChange(n);
    return new Option(`${images[n].name.split("/").at(-1)}${change === null ? "" : ` (${signed(change)})`}`, n, n === state.image, n === state.image);
  }));
  for (const key of ["a", "b", "shown", "palette", "order"]) at(key).value = state[key];
  at("outlines").checked = state.outlines;
  at("opacity").value = state.opacity;
  at("swipe").checked = divider.on;
  at("caption-a").textContent = divider.on ? `${caption("a")} | ${caption("b")}` : caption("a");
  at("caption-b").textContent = caption("b");
  paint();
  tabulate();
  explain();
  tell();
}

function step(by) {
  const order = ordered(), place = order.indexOf(state.image) + by;
  return set({ image: order[(place + order.length) % order.length] });
}

function next(list, value, by = 1) {
  return list[(list.indexOf(value) + by + list.length) % list.length];
}

function listen() {
  for (const key of ["a", "b", "shown", "palette", "order"]) {
    at(key).addEventListener("change", (event) => set({ [key]: event.target.value }));
  }
  at("image").addEventListener("change", (event) => set({ image: Number(event.target.value) }));
  at("before").addEventListener("click", () => step(-1));
  at("after").addEventListener("click", () => step(1));
  at("outlines").addEventListener("change", (event) => set({ outlines: event.target.checked }));
  at("opacity").addEventListener("input", (event) => set({ opacity: event.target.valueAsNumber }));
  at("swipe").addEventListener("change", (event) => { divider.set(event.target.checked); set({}); });
  for (const stage of all(".stage")) {
    stage.addEventListener("pointermove", (event) => {
      const box = stage.getBoundingClientRect(), { width, height } = images[state.image];
      const inside = (share, size) => Math.min(size - 1, Math.max(0, Math.floor(share * size)));
      cursor = {
        x: inside((event.clientX - box.left) / box.width, width),
        y: inside((event.clientY - box.top) / box.height, height),
      };
      tell();
    });
  }
  document.addEventListener("keydown", (event) => {
    const { key, target, shiftKey } = event;
    if (event.ctrlKey || event.metaKey || event.altKey || target.matches?.("select, input[type=range]")) return;
    const by = shiftKey ? -1 : 1, pressed = key.toLowerCase();
    if (key === "ArrowLeft") step(-1);
    else if (key === "ArrowRight") step(1);
    else if (pressed === "a" || pressed === "b") set({ [pressed]: next(SIDES, state[pressed], by) });
    else if (pressed === "x") set({ a: state.b, b: state.a });
    else if (pressed === "s") { divider.set(!divider.on); set({}); }
    else if (pressed === "e") set({ shown: next(SHOWN, state.shown, by) });
    else if (pressed === "c") set({ palette: next(["cityscapes", "safe"], state.palette) });
    else if (pressed === "o") set({ outlines: !state.outlines });
    else return;
    event.preventDefault();
  });
}

async function open() {
  at("title").textContent = facts.title;
  at("about").textContent = `${images.length} test images, ${rows.length} rows` +
    (facts.standIn ? "; synthetic sample data, which say nothing about real fog" : "");
  for (const key of ["a", "b"]) {
    for (const side of SIDES) {
      const score = rows[side] ? ` (${percent(rows[side].mean)})` : "";
      at(key).append(new Option(nameOf(side) + score, side));
    }
  }
  divider = swipe(at("stage-a"), at("cover"), at("divider"));
  listen();
  await set({});
  return performance.now();
}

window.view = {
  ready: open().catch((error) => {
    at("problem").hidden = false;
    at("problem").textContent = `This page cannot be shown: ${error.message}. It needs a browser of 2023 or newer.`;
    throw error;
  }),
  state,
  set,
  lines,
  // RGBA of a side, for tests
  pixels: (side) => new Uint8Array(painted(side, maps, images[state.image].width, how()).buffer),
  get divider() { return divider; },
};
