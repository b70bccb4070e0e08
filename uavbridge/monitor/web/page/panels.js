// The agents' table, the log of events, the legend. Everything goes in as text.

import { agentColour, beliefColours, theme, whenThemeChanges } from "./colours.js";
import { layerColours } from "./grounds.js";
import { bytesText } from "./plots.js";
import { clockText } from "./state.js";

const LOG_LINES = 400;
const PHASES = { search: "good", failed: "bad", yielded: "warn", landed: "dim", hold: "warn" };

export class Agents {
  constructor(table, state, onChoose) {
    Object.assign(this, { body: table.querySelector("tbody"), state, onChoose });
    this.rows = new Map();
    this.version = 0;
  }

  draw(chosen) {
    const { state } = this;
    if (this.version !== state.version) {
      this.version = state.version;
      this.rows.clear();
      this.body.replaceChildren();
    }
    for (const id of state.changed.rows) this.fill(id);
    state.changed.rows.clear();
    for (const [id, row] of this.rows) {
      row.className = id === chosen ? "chosen" : "";
      const one = state.vehicles.get(id);
      if (one) set(row.cells[3], one.z.toFixed(0), "n");
    }
  }

  fill(id) {
    const row = this.rows.get(id) ?? this.add(id);
    const { phase, mode, battery, neighbours, note, failure, alive } = this.state.rows.get(id);
    const cells = row.cells;
    const gone = alive === false && phase !== "landed";
    set(cells[1], gone ? "gone" : phase || "–", gone ? "bad" : PHASES[phase] ?? "");
    set(cells[2], mode || "–", "");
    const charge = battery === null ? "–" : (100 * battery).toFixed(0);
    set(cells[4], charge, `n ${battery === null || battery > 0.3 ? "" : battery > 0.15 ? "warn" : "bad"}`);
    set(cells[5], String(neighbours), "n");
    set(cells[6], failure || note, failure ? "bad" : "");
    cells[6].title = failure || note;
  }

  add(id) {
    const row = document.createElement("tr");
    for (let i = 0; i < 7; i += 1) row.append(document.createElement("td"));
    set(row.cells[0], String(id), "id");
    row.cells[0].style.color = agentColour(id);
    row.addEventListener("click", () => this.onChoose(id));
    const after = [...this.rows.keys()].filter((other) => other > id).sort((a, b) => a - b)[0];
    this.body.insertBefore(row, after === undefined ? null : this.rows.get(after));
    this.rows.set(id, row);
    return row;
  }
}

// What became of the frames, all agents together, or the one that is chosen.
export class Radio {
  constructor(element, state) {
    Object.assign(this, { element, state });
  }

  draw(chosen) {
    const rows = [...this.state.rows.values()].filter((row) => !chosen || row.id === chosen);
    const sum = (of) => rows.reduce((total, row) => total + of(row), 0);
    const lost = new Map();
    const rejected = new Map(); // agents of one process have one count
    for (const row of rows) {
      for (const [why, number] of Object.entries(row.dropped ?? {})) lost.set(why, (lost.get(why) ?? 0) + number);
      for (const [why, number] of Object.entries(row.rejected ?? {})) {
        rejected.set(why, Math.max(rejected.get(why) ?? 0, number));
      }
    }
    const parts = [`${bytesText(sum((row) => row.bytes_sent))} sent`, `${bytesText(sum((row) => row.bytes_heard))} heard`];
    const offered = sum((row) => row.bytes_offered ?? 0);
    if (offered) parts.unshift(`${bytesText(offered)} offered`);
    const named = (what, counts) => {
      const sorted = [...counts].sort((a, b) => b[1] - a[1]);
      const told = sorted.map(([why, number]) => `${number.toLocaleString("en")} ${why}`);
      return told.length ? `; frames ${what}: ${told.join(", ")}` : "";
    };
    const missed = named("not heard", lost) + named("rejected", rejected);
    const text = rows.length ? `Radio: ${parts.join(", ")}${missed}${clocksText(rows)}` : "";
    if (this.element.textContent !== text) this.element.textContent = text;
  }
}

// How far the clock of another machine is off the launcher's: the worst of these agents'.
function clocksText(rows) {
  const known = rows.filter((row) => row.clock_ms);
  if (!known.length) return "";
  const size = ({ clock_ms }) => Math.abs(clock_ms[0]) + clock_ms[1];
  const { id, clock_ms } = known.reduce((worst, row) => (size(row) > size(worst) ? row : worst));
  const [offset, error, date] = clock_ms.map((ms) => ms.toFixed(1));
  return `; clock of agent ${id} ${offset} ms off (within ${error}), its machine's date ${date} ms`;
}

function set(cell, text, kind) {
  if (cell.textContent !== text) cell.textContent = text;
  if (cell.className !== kind) cell.className = kind;
}

export class Log {
  constructor(section, state) {
    Object.assign(this, { section, list: section.querySelector("ol"), state, version: 0 });
  }

  draw() {
    const { state, list, section } = this;
    if (this.version !== state.version) {
      this.version = state.version;
      list.replaceChildren();
    }
    if (!state.changed.events.length) return;
    const atEnd = section.scrollTop + section.clientHeight > section.scrollHeight - 30;
    list.append(...state.changed.events.splice(0).slice(-LOG_LINES).map(line));
    while (list.childElementCount > LOG_LINES) list.firstChild.remove();
    if (atEnd) section.scrollTop = section.scrollHeight;
  }
}

function line(event) {
  const item = document.createElement("li");
  const time = document.createElement("time");
  time.textContent = clockText(event.t_s);
  const who = document.createElement("i");
  who.textContent = event.agent ?? "";
  if (event.agent !== null) who.style.color = agentColour(event.agent);
  const what = document.createElement("b");
  what.textContent = event.text;
  if (["failure", "declared", "order"].includes(event.sort)) item.className = event.sort;
  item.append(time, who, what);
  return item;
}

// What the colours and marks mean.
export function legend(bar, state, layer) {
  const draw = () => {
    const parts = [];
    const { mission } = state;
    const signals = mission && mission.by_signal; // no cells are looked at
    if (layer() === "belief" && mission && !signals) parts.push(["P(target) 0 … 1", 120, ramp]);
    if (!signals) parts.push(["never seen", 14, (c, w, h) => fill(c, theme.unseen, w, h)]);
    if (mission && mission.targets) parts.push(["true target", 18, ring]);
    parts.push([signals ? "reached" : "declared", 18, (c, w, h) => diamond(c, w, h, theme.good)]);
    if (mission && mission.targets && !signals) parts.push(["declared, none there", 18, (c, w, h) => diamond(c, w, h, theme.bad)]);
    if (mission && mission.columns.length) parts.push(["no-fly column", 18, disc]);
    const shown = layer().startsWith("layer:") ? state.grounds.get(layer().slice(6)) : null;
    if (shown) {
      const { low, high, name } = shown.told;
      parts.push([`${name} ${low.toPrecision(3)} … ${high.toPrecision(3)}`, 120, scaleOf(low, high)]);
    }
    const range = mission && mission.range_known ? mission.range_m : undefined;
    bar.replaceChildren(...parts.map(([text, width, paint]) => entry(text, width, paint, state)));
    const note = document.createElement("span");
    note.textContent = range === undefined ? "" : range === null ? "radio: unlimited range" : `radio range ${range} m`;
    bar.append(note);
  };
  whenThemeChanges(draw);
  return draw;
}

function entry(text, width, paint, state) {
  const span = document.createElement("span");
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [width, 14];
  paint(canvas.getContext("2d"), width, 14, state);
  span.append(canvas, text);
  return span;
}

function fill(context, colour, w, h) {
  context.fillStyle = colour;
  context.fillRect(0, 1, w, h - 2);
}

function ramp(context, w, h, state) {
  const table = beliefColours(state.mission.prior);
  strip(context, w, h, (share) => table[256 + Math.round(255 * share)]);
}

function scaleOf(low, high) {
  return (context, w, h) => strip(context, w, h, (share) => layerColours(low, high)[Math.round(255 * share)]);
}

function strip(context, w, h, colour) {
  for (let x = 0; x < w; x += 1) {
    const value = colour(x / (w - 1));
    context.fillStyle = `rgb(${value & 255} ${(value >> 8) & 255} ${(value >> 16) & 255})`;
    context.fillRect(x, 1, 1, h - 2);
  }
}

function ring(context, w, h) {
  context.strokeStyle = theme.target;
  context.lineWidth = 1.7;
  context.beginPath();
  context.arc(w / 2, h / 2, 4.5, 0, 2 * Math.PI);
  context.moveTo(w / 2, 0);
  context.lineTo(w / 2, h);
  context.moveTo(w / 2 - 7, h / 2);
  context.lineTo(w / 2 + 7, h / 2);
  context.stroke();
}

function disc(context, w, h) {
  context.fillStyle = context.strokeStyle = theme.bad;
  context.beginPath();
  context.arc(w / 2, h / 2, 5.5, 0, 2 * Math.PI);
  context.globalAlpha = 0.12;
  context.fill();
  context.globalAlpha = 0.9;
  context.stroke();
}

function diamond(context, w, h, colour) {
  context.strokeStyle = colour;
  context.lineWidth = 2;
  context.beginPath();
  context.moveTo(w / 2, 1);
  context.lineTo(w / 2 + 6, h / 2);
  context.lineTo(w / 2, h - 1);
  context.lineTo(w / 2 - 6, h / 2);
  context.closePath();
  context.stroke();
}
