// Puts the page together, and draws when there is news.

import { Link } from "./link.js";
import { MapView } from "./map.js";
import { Orders, offer } from "./orders.js";
import { Agents, Log, Radio, legend } from "./panels.js";
import { Plots } from "./plots.js";
import { State, clockText } from "./state.js";
import { TERRAIN } from "./grounds.js";
import { Timeline } from "./timeline.js";

const $ = (selector) => document.querySelector(selector);
const FRAMES_KEPT = 600;

const state = new State();
let online = false;
let chosen = 0;
let news = true;

const options = {
  layer: "belief", trails: Infinity, links: true, ranges: false, targets: true, terrain: true, groups: true, chosen: 0,
  onClick: (id, x, y) => orders.placed(x, y) || choose(id === chosen ? 0 : id),
};
const link = new Link(
  (message) => {
    const kind = state.take(message, performance.now());
    if (kind === "mission" && chosen) link.ask({ seen_by: chosen });
    if (kind === "mission") link.ask({ layer: named(options.layer) });
    if (kind === "ground") drawLegend();
    if (kind === "answer") orders.answered(message);
    news = true;
  },
  (cells) => {
    state.cells(cells);
    news = true;
  },
  (open) => {
    online = open;
    if (!open) orders.lost();
    news = true;
  },
);
const orders = new Orders(link, state);
const timeline = new Timeline(link, state);
const views = {
  all: new MapView($("#all-view"), state, options, null),
  agent: new MapView($("#agent-view"), state, options, () => chosen),
};
const plots = new Plots($("#plots"), state, (t) => timeline.seek(t));
const agents = new Agents($("#agents table"), state, (id) => choose(id === chosen ? 0 : id));
const radio = new Radio($("#radio"), state);
const log = new Log($("#log"), state);
const drawLegend = legend($("#legend"), state, () => options.layer);
let legendOf = -1;

// Of the layers that the server tells: "pheromone/3", say; empty for our own.
function named(layer) {
  return layer.startsWith("layer:") ? layer.slice(6) : "";
}

// Offers what there is to be seen: named layers, terrain, groups.
function offerLayers() {
  const more = $("#more-layers");
  const known = [...more.children].map((option) => option.value.slice(6));
  if (known.join() !== state.layers.join()) {
    more.replaceChildren(...state.layers.map((name) => new Option(name, `layer:${name}`)));
    more.hidden = !state.layers.length;
    if (named(options.layer)) $("#layer").value = options.layer;
  }
  $("#terrain-option").hidden = !state.grounds.has(TERRAIN);
  $("#groups-option").hidden = !state.groups.size;
}

function choose(id) {
  chosen = options.chosen = id;
  $("#agent-view").hidden = !id;
  const [name, note] = $("#agent-view figcaption").children;
  name.textContent = `Agent ${id}`;
  note.textContent = "its own map, and only whom it hears";
  $("#seen-by").value = String(id);
  orders.to.value = id ? String(id) : "";
  state.hears = [];
  state.maps.delete(id);
  link.ask({ seen_by: id });
  news = true;
}

$("#seen-by").addEventListener("change", (event) => choose(Number(event.target.value)));
$("#layer").addEventListener("change", (event) => {
  options.layer = event.target.value;
  link.ask({ layer: named(options.layer) });
  drawLegend();
  news = true;
});
$("#trails").addEventListener("change", (event) => {
  options.trails = event.target.value === "all" ? Infinity : Number(event.target.value);
  views.all.moved();
  views.agent.moved();
});
for (const name of ["links", "ranges", "targets", "terrain", "groups"]) {
  $(`#${name}`).addEventListener("change", (event) => {
    options[name] = event.target.checked;
    news = true;
  });
}
$("#fit").addEventListener("click", () => {
  views.all.fit();
  views.agent.fit();
});
addEventListener("keydown", (event) => {
  if (event.target.closest("input, select, dialog")) return;
  if (event.key === "Escape") {
    if (orders.aiming) orders.aim(false);
    else if (chosen) choose(0);
  } else if (event.key === " " && timeline.recording && !event.target.closest("button")) {
    event.preventDefault();
    timeline.toggle();
  } else if (timeline.recording && (event.key === "ArrowLeft" || event.key === "ArrowRight")) {
    timeline.seek(state.t + (event.key === "ArrowLeft" ? -5 : 5));
  }
});

function status() {
  const { mission } = state;
  if (!online) return ["connection lost, trying again", "bad"];
  if (!mission) return ["waiting", "warn"];
  if (mission.recording) return [state.player && state.player.playing ? `recording, ${state.player.speed} ×` : "recording, paused", ""];
  const phases = [...state.rows.values()].map((row) => row.phase);
  if (phases.length && phases.every((phase) => phase === "landed" || phase === "failed")) return ["all down", ""];
  if (!state.connected) return ["no router: the bus is away", "bad"];
  if (state.silent) return ["nothing heard", "warn"];
  return ["live", "good"];
}

function header() {
  const { mission } = state;
  const [text, kind] = status();
  $("#status").textContent = text;
  $("#status").className = `chip ${kind}`;
  if (!mission) return;
  $("#name").textContent = mission.name;
  document.title = `${mission.name} – uavbridge`;
  const about = [mission.planner, mission.seed === null ? "" : `seed ${mission.seed}`, mission.clock];
  if (mission.radio) about.push(`radio emulated (${mission.radio})`);
  $("#about").textContent = [...about, `${state.vehicles.size} vehicles`].filter(Boolean).join(", ");
  const limit = document.createElement("small");
  limit.textContent = mission.duration_s === null ? "" : ` of ${clockText(mission.duration_s)}`;
  $("#clock").replaceChildren(clockText(state.t), limit);
}

function panels() {
  header();
  if (legendOf !== state.version) {
    legendOf = state.version;
    drawLegend();
  }
  offerLayers();
  offer($("#seen-by"), [...state.rows.keys()].sort((a, b) => a - b));
  if (chosen) $("#seen-by").value = String(chosen);
  orders.draw();
  timeline.draw();
  agents.draw(chosen);
  radio.draw(chosen);
  log.draw();
  if (state.changed.points) plots.dirty = true;
  state.changed.points = false;
}

const frames = { gaps: [], work: [], last: 0, shown: 0 };

function frame(now) {
  if (frames.last) keep(frames.gaps, now - frames.last);
  frames.last = now;
  const began = performance.now();
  if (news) panels();
  for (const view of Object.values(views)) {
    if (!view.figure.hidden && (news || view.dirty)) view.draw(began);
  }
  news = false;
  plots.draw();
  keep(frames.work, performance.now() - began);
  if (now - frames.shown > 1000) {
    frames.shown = now;
    const { mean, worst } = figures(frames.gaps.slice(-60));
    const text = `${(1000 / mean).toFixed(0)} frames/s, slowest ${worst.toFixed(0)} ms`;
    $("#frames").textContent = frames.gaps.length > 30 ? text : "";
  }
  requestAnimationFrame(frame);
}

function keep(list, value) {
  list.push(value);
  if (list.length > FRAMES_KEPT) list.shift();
}

function figures(values) {
  const sorted = values.slice().sort((a, b) => a - b);
  const sum = sorted.reduce((a, b) => a + b, 0);
  return {
    count: sorted.length,
    mean: sum / Math.max(sorted.length, 1),
    p95: sorted[Math.floor(0.95 * (sorted.length - 1))] ?? 0,
    worst: sorted.at(-1) ?? 0,
  };
}

// What is on the page, for tests and for the curious.
Object.defineProperty(window, "__drawn", {
  get: () => ({
    t: state.t,
    online,
    version: state.version,
    updates: state.updates,
    name: state.mission && state.mission.name,
    all: views.all.drawn,
    agent: $("#agent-view").hidden ? null : views.agent.drawn,
    points: state.points,
    cell: (column, row, view = "all") => views[view].cells.colour(column, row),
    words: (owner = 0) => Array.from(state.maps.get(owner)?.words ?? []),
  }),
});
Object.defineProperty(window, "__frames", {
  get: () => ({ gaps: figures(frames.gaps), work: figures(frames.work) }),
});
Object.defineProperty(window, "__link", { get: () => link });

requestAnimationFrame(frame);
