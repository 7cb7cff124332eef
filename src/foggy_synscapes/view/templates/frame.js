// The page of one frame.

import { blob, bytesOf, wordsOf } from "./planes.js";
import { INFINITE, betaAt, distanceTable, level, positionOf, transmittance } from "./optics.js";
import { FOG, gpuPainter, hasGraphics, plainPainter } from "./painters.js";
import { swipe } from "./swipe.js";

const facts = JSON.parse(document.getElementById("facts").textContent);
const { width, height } = facts;
const at = (id) => document.getElementById(id);
const state = { beta: facts.beta, light: facts.airlight.slice(), shown: FOG };
const drawn = []; // times of the last drawings, ms
const MAKERS = { WebGL: gpuPainter, canvas: plainPainter };
const painters = {}; // those made so far, by name
let frame, painter, divider, waiting = false, cursor = null;

function number(value, digits = 3) {
  return value >= 1e5 ? Number(value.toPrecision(digits)).toLocaleString("en") : String(Number(value.toPrecision(digits)));
}

function visibilityOf(beta) {
  return beta > 0 ? `${number(facts.contrast / beta)} m` : "unlimited";
}

function hex(levels) {
  return "#" + levels.map((value) => value.toString(16).padStart(2, "0")).join("");
}

// One drawing for each picture of the screen, however many events a drag sends.
function draw() {
  if (waiting) return;
  waiting = true;
  requestAnimationFrame((now) => {
    waiting = false;
    paint();
    drawn.push(now);
    while (now - drawn[0] > 1000) drawn.shift();
    if (drawn.length > 5) speed((1000 * (drawn.length - 1)) / (now - drawn[0]));
  });
}

function paint() {
  if (!painter.paint(state)) choose("canvas"); // the graphics driver gave up
}

function speed(perSecond) {
  at("speed").textContent = `${perSecond.toFixed(0)} frames/s`;
}

function set(change) {
  Object.assign(state, change);
  const { beta, light } = state;
  if (document.activeElement !== at("density")) at("density").value = positionOf(beta);
  if (document.activeElement !== at("beta")) at("beta").value = number(beta);
  if (document.activeElement !== at("visibility")) at("visibility").value = beta > 0 ? number(facts.contrast / beta) : "";
  at("density").setAttribute("aria-valuetext", `beta ${number(beta)} per metre, visibility ${visibilityOf(beta)}`);
  for (const button of at("betas").children) button.setAttribute("aria-pressed", String(Number(button.value) === beta));
  at("light").value = hex(light);
  at("levels").textContent = light.join(", ");
  at("shown").value = String(state.shown);
  tell();
  draw();
}

// What is under the cursor, by the formula itself, in double precision.
function tell() {
  at("cross").hidden = cursor === null;
  if (cursor === null) return;
  const { x, y } = cursor, pixel = y * width + x;
  at("cross").style.left = `${(100 * (x + 0.5)) / width}%`;
  at("cross").style.top = `${(100 * (y + 0.5)) / height}%`;
  const code = frame.codes[pixel], metres = frame.table[code];
  const t = transmittance(metres, state.beta);
  const clear = [...frame.clear.subarray(3 * pixel, 3 * pixel + 3)];
  const foggy = clear.map((value, channel) => level(value, state.light[channel], t));
  at("readout").textContent =
    `row ${y}, column ${x}: ${code === INFINITE ? "infinitely far" : `${number(metres, 4)} m`}, ` +
    `transmittance ${t.toFixed(4)}, clear ${clear.join(" ")} → foggy ${foggy.join(" ")}`;
}

function pointed(event) {
  const box = at("stage").getBoundingClientRect();
  const inside = (share, size) => Math.min(size - 1, Math.max(0, Math.floor(share * size)));
  return {
    x: inside((event.clientX - box.left) / box.width, width),
    y: inside((event.clientY - box.top) / box.height, height),
  };
}

// A canvas keeps the kind of its first context: each painter has its own, made when it is first asked for.
function choose(name) {
  const canvas = Object.assign(document.createElement("canvas"), { width, height });
  painters[name] ??= ((made) => made && { ...made, canvas })(MAKERS[name](canvas, frame));
  if (!painters[name]) return choose("canvas");
  painter = painters[name];
  painter.canvas.id = "foggy";
  at("foggy").replaceWith(painter.canvas);
  at("painter").value = name;
  drawn.length = 0;
  set({});
}

function compare(on, share) {
  at("clear").hidden = !on;
  at("compare").checked = on;
  divider.set(on, share);
}

function picking(on) {
  at("pick").setAttribute("aria-pressed", String(on));
  at("stage").classList.toggle("picking", on);
}

// Frames per second over two seconds in which the fog comes and goes.
function measure(seconds = 2) {
  const before = state.beta;
  return new Promise((finish) => {
    let first, count = 0;
    requestAnimationFrame(function next(now) {
      first ??= now;
      if (now - first >= 1000 * seconds) {
        set({ beta: before });
        const found = (1000 * count) / (now - first);
        speed(found);
        finish(found);
        return;
      }
      state.beta = betaAt(0.5 - 0.5 * Math.cos((now - first) / 300));
      at("density").value = positionOf(state.beta);
      paint();
      count++;
      requestAnimationFrame(next);
    });
  });
}

function save() {
  paint();
  painter.canvas.toBlob((file) => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(file);
    link.download = `${facts.name.replace(/\.[^.]*$/, "")}_beta_${number(state.beta)}.png`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  });
}

function listen() {
  at("density").addEventListener("input", (event) => set({ beta: Number(betaAt(event.target.valueAsNumber).toPrecision(3)) }));
  at("beta").addEventListener("input", (event) => event.target.valueAsNumber >= 0 && set({ beta: event.target.valueAsNumber }));
  at("visibility").addEventListener("input", (event) => {
    if (event.target.valueAsNumber > 0) set({ beta: facts.contrast / event.target.valueAsNumber });
    else if (event.target.value === "") set({ beta: 0 });
  });
  for (const id of ["beta", "visibility"]) at(id).addEventListener("change", (event) => { event.target.blur(); set({}); });
  at("light").addEventListener("input", (event) => {
    set({ light: [1, 3, 5].map((from) => parseInt(event.target.value.slice(from, from + 2), 16)) });
  });
  at("estimated").addEventListener("click", () => set({ light: facts.estimated.slice() }));
  at("pick").addEventListener("click", () => picking(at("pick").getAttribute("aria-pressed") !== "true"));
  at("shown").addEventListener("change", (event) => set({ shown: Number(event.target.value) }));
  at("compare").addEventListener("change", (event) => compare(event.target.checked));
  at("painter").addEventListener("change", (event) => choose(event.target.value));
  at("measure").addEventListener("click", () => measure());
  at("save").addEventListener("click", save);
  at("stage").addEventListener("pointermove", (event) => { cursor = pointed(event); tell(); });
  at("stage").addEventListener("pointerdown", (event) => {
    cursor = pointed(event);
    tell();
    if (at("pick").getAttribute("aria-pressed") !== "true") return;
    const pixel = 3 * (cursor.y * width + cursor.x);
    picking(false);
    set({ light: [...frame.clear.subarray(pixel, pixel + 3)] });
  });
  at("stage").addEventListener("keydown", (event) => {
    const far = event.shiftKey ? 20 : 1;
    const [dx, dy] = { ArrowLeft: [-far, 0], ArrowRight: [far, 0], ArrowUp: [0, -far], ArrowDown: [0, far] }[event.key] ?? [];
    if (dx === undefined) return;
    const { x, y } = cursor ?? { x: width >> 1, y: height >> 1 };
    cursor = { x: Math.min(width - 1, Math.max(0, x + dx)), y: Math.min(height - 1, Math.max(0, y + dy)) };
    tell();
    event.preventDefault();
  });
  document.addEventListener("keydown", (event) => {
    const { target, key } = event;
    if (event.ctrlKey || event.metaKey || event.altKey || (target.matches?.("input, select") && target.type !== "range")) return;
    const buttons = [...at("betas").children];
    const step = { "+": 0.02, "=": 0.02, "-": -0.02 }[key];
    if (/^[0-9]$/.test(key)) {
      if (buttons[Number(key)]) set({ beta: Number(buttons[Number(key)].value) });
    } else if (step) {
      set({ beta: Number(betaAt(Math.min(1, positionOf(state.beta) + step)).toPrecision(3)) });
    } else if (key === "s") compare(!divider.on);
    else if (key === "t") set({ shown: 1 - state.shown });
    else if (key === "e") set({ light: facts.estimated.slice() });
    else if (key === "m") measure();
    else return;
    if (document.activeElement === at("density")) at("density").value = positionOf(state.beta);
  });
}

async function open() {
  const [clear, codes] = await Promise.all([bytesOf(blob("clear"), 3 * width), wordsOf(blob("distance"), width)]);
  frame = { width, height, clear, codes, table: distanceTable(facts.nearest, facts.farthest) };
  at("name").textContent = facts.name;
  at("about").textContent =
    `${width} × ${height} pixels, ${number(facts.nearest)} m to ${number(facts.farthest)} m; airlight ` +
    `${facts.estimated.join(", ")}, estimated at row ${facts.taken[0]}, column ${facts.taken[1]}`;
  at("exact").textContent =
    "F = t R + (1 - t) L, t = exp(-beta l); visibility = " + `${facts.contrast} / beta. Distance l is stored on 65,534 ` +
    `logarithmic steps, which moves no pixel by more than ${facts.worst.toFixed(3)} of a grey level at any beta: the ` +
    "image here and the rendered one differ by one level at most, where a value lies on the edge between two. The " +
    "numbers under the cursor are computed in double precision.";
  at("stage").style.aspectRatio = `${width} / ${height}`;
  at("stage").style.setProperty("--ratio", width / height);
  for (const beta of [0, ...facts.betas]) {
    const button = document.createElement("button");
    button.value = String(beta);
    button.textContent = beta ? String(beta) : "clear";
    button.title = `visibility ${visibilityOf(beta)}`;
    button.addEventListener("click", () => set({ beta }));
    at("betas").append(button);
  }
  for (const name of Object.keys(MAKERS)) at("painter").append(new Option(name, name));
  Object.assign(at("clear"), { width, height });
  plainPainter(at("clear"), frame).paint({ beta: 0, light: [0, 0, 0], shown: FOG });
  divider = swipe(at("stage"), at("clear"), at("divider"));
  listen();
  choose(hasGraphics() ? "WebGL" : "canvas");
  paint();
  return performance.now(); // ms from opening the file to the first picture
}

window.view = {
  ready: open().catch((error) => {
    at("problem").hidden = false;
    at("problem").textContent = `This page cannot be shown: ${error.message}. It needs a browser of 2023 or newer.`;
    throw error;
  }),
  state,
  set,
  choose,
  measure,
  painter: () => painter.name,
  // RGBA of a state, for tests
  pixels(change = {}) {
    Object.assign(state, change);
    paint();
    return painter.pixels();
  },
};
