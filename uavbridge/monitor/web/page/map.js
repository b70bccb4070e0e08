// One map: pan, zoom, and everything that is drawn on it.
//
// Three canvases: cells (a pixel a cell), trails (what was flown, drawn once), and the
// visible one, on which they and all that moves are put together.

import { Cells } from "./cells.js";
import { agentColour, theme, whenThemeChanges } from "./colours.js";
import { TERRAIN } from "./grounds.js";
import { placed } from "./state.js";

const MARGIN = 0.07;
const ENDED = new Set(["landed", "failed"]);
const TAU = 2 * Math.PI;

export class MapView {
  // `agent`: null for everything that is known, else a function that names the agent.
  constructor(figure, state, options, agent) {
    Object.assign(this, { figure, state, options, agent });
    this.canvas = figure.querySelector("canvas");
    this.context = this.canvas.getContext("2d", { alpha: false });
    this.readout = figure.querySelector(".readout");
    this.cells = new Cells();
    this.flown = document.createElement("canvas");
    this.inked = new Map(); // id -> numbers of its trail that are on `flown`
    this.view = null; // metres to pixels: { scale, x, y }
    this.version = 0;
    this.pointer = null;
    this.dirty = true;
    this.drawn = null; // what is on the canvas, for whoever wants to compare
    new ResizeObserver(() => this.resized()).observe(this.canvas);
    whenThemeChanges(() => this.moved());
    this.listen();
  }

  listen() {
    const canvas = this.canvas;
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom(Math.exp(-event.deltaY * 0.0015), event.offsetX, event.offsetY);
    }, { passive: false });
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      this.drag = { x: event.offsetX, y: event.offsetY, far: false };
    });
    canvas.addEventListener("pointermove", (event) => this.hover(event));
    canvas.addEventListener("pointerleave", () => {
      this.pointer = null;
      this.dirty = true;
    });
    canvas.addEventListener("pointerup", (event) => {
      const drag = this.drag;
      this.drag = null;
      if (drag && !drag.far) this.clicked(event.offsetX, event.offsetY);
    });
    canvas.addEventListener("keydown", (event) => {
      const [w, h] = [canvas.clientWidth / 2, canvas.clientHeight / 2];
      if (event.key === "+" || event.key === "=") this.zoom(1.3, w, h);
      else if (event.key === "-") this.zoom(1 / 1.3, w, h);
      else if (event.key === "0") this.fit();
    });
  }

  hover(event) {
    const [x, y] = [event.offsetX, event.offsetY];
    this.pointer = { x, y };
    this.dirty = true;
    const drag = this.drag;
    if (!drag || !this.view) return;
    drag.far ||= Math.hypot(x - drag.x, y - drag.y) > 4;
    if (!drag.far) return;
    this.view.x += x - drag.x;
    this.view.y += y - drag.y;
    [drag.x, drag.y] = [x, y];
    this.ownView = true;
    this.moved();
  }

  clicked(x, y) {
    const [east, north] = this.metres(x, y);
    let [best, nearest] = [18, 0];
    for (const one of this.shown()) {
      const [px, py] = this.pixels(one.x, one.y);
      const away = Math.hypot(px - x, py - y);
      if (away < best) [best, nearest] = [away, one.id];
    }
    this.options.onClick(nearest, east, north);
  }

  zoom(factor, x, y) {
    if (!this.view) return;
    const scale = Math.min(Math.max(this.view.scale * factor, 1e-3), 500);
    const real = scale / this.view.scale;
    this.view = { scale, x: x - (x - this.view.x) * real, y: y - (y - this.view.y) * real };
    this.ownView = true;
    this.moved();
  }

  fit() {
    this.ownView = false;
    this.view = null;
    this.moved();
  }

  resized() {
    const ratio = devicePixelRatio || 1;
    const [w, h] = [this.canvas.clientWidth, this.canvas.clientHeight];
    for (const canvas of [this.canvas, this.flown]) {
      [canvas.width, canvas.height] = [Math.max(Math.round(w * ratio), 1), Math.max(Math.round(h * ratio), 1)];
    }
    this.ratio = ratio;
    if (!this.ownView) this.view = null;
    this.moved();
  }

  // The view changed: trails must be drawn anew.
  moved() {
    this.inked.clear();
    this.dirty = true;
  }

  // Shows the area and all vehicles, unless a person chose another view.
  place() {
    if (this.view) return true;
    const [w, h] = [this.canvas.clientWidth, this.canvas.clientHeight];
    const box = this.box();
    if (!box || !w || !h) return false;
    const [west, south, east, north] = box;
    const scale = Math.min(w / (east - west), h / (north - south)) / (1 + 2 * MARGIN);
    this.view = { scale, x: w / 2 - (scale * (west + east)) / 2, y: h / 2 + (scale * (south + north)) / 2 };
    return true;
  }

  box() {
    const grid = this.state.mission && this.state.mission.grid;
    const places = [...this.state.vehicles.values()].map((one) => [one.x, one.y]);
    if (grid) {
      const [west, south, cell, columns, rows] = grid;
      places.push([west, south], [west + columns * cell, south + rows * cell]);
    }
    if (!places.length) return null;
    const xs = places.map((p) => p[0]);
    const ys = places.map((p) => p[1]);
    const [west, south, east, north] = [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)];
    const least = Math.max(east - west, north - south, 20) * 0.05;
    return [west - least * 0.2, south - least * 0.2, east + least * 0.2 + 1, north + least * 0.2 + 1];
  }

  pixels(x, y) {
    return [this.view.x + this.view.scale * x, this.view.y - this.view.scale * y];
  }

  metres(px, py) {
    return [(px - this.view.x) / this.view.scale, (this.view.y - py) / this.view.scale];
  }

  // Vehicles that this view knows of.
  shown() {
    const all = [...this.state.vehicles.values()];
    if (!this.agent) return all;
    const [self, hears] = [this.agent(), new Set(this.state.hears)];
    return all.filter((one) => one.id === self || hears.has(one.id));
  }

  shownLinks() {
    if (!this.agent) return this.state.links;
    const self = this.agent();
    return this.state.hears.map((id) => [Math.min(id, self), Math.max(id, self)]);
  }

  shownDeclared() {
    if (!this.agent) return this.state.declared.map(([column, row]) => [column, row]);
    const row = this.state.rows.get(this.agent());
    return row ? row.declared : [];
  }

  draw(now) {
    const { state, context } = this;
    if (this.version !== state.version) {
      this.version = state.version;
      this.fit();
    }
    if (!state.mission || !this.canvas.clientWidth) return;
    const known = this.place();
    context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    context.fillStyle = theme.ground;
    context.fillRect(0, 0, this.canvas.clientWidth, this.canvas.clientHeight);
    if (!known) return;
    const owner = this.agent ? this.agent() : 0;
    const painted = this.cells.paint(state.maps.get(owner), state.mission, this.options.layer, state.t,
      this.options.terrain && state.grounds.has(TERRAIN));
    const grounds = this.grounds(painted);
    if (state.mission.grid) this.area(painted, grounds);
    const vehicles = this.shown().map((one) => ({ ...one, ...placed(one, now) }));
    const byId = new Map(vehicles.map((one) => [one.id, one]));
    const links = this.options.links ? this.shownLinks().filter(([a, b]) => byId.has(a) && byId.has(b)) : [];
    const columns = this.columns();
    this.targets();
    this.trails(vehicles);
    this.wires(links, byId);
    const groups = this.options.groups ? this.groups(byId) : [];
    if (this.options.ranges || this.options.chosen) this.ranges(vehicles);
    for (const one of vehicles) this.vehicle(one);
    this.scaleBar();
    this.tell(owner);
    this.dirty = vehicles.some((one) => !one.still);
    this.drawn = { ...this.account(vehicles, links, painted), grounds, groups, columns };
  }

  account(vehicles, links, painted) {
    return {
      vehicles: vehicles.map(({ id, x, y, z, heading }) => {
        const [px, py] = this.pixels(x, y);
        return { id, x, y, z, heading, px, py };
      }),
      links,
      declared: this.shownDeclared(),
      targets: this.trueTargets(),
      cells: painted,
      trails: Object.fromEntries([...this.inked.keys()].map((id) => [id, this.state.trails.get(id)])),
      scale: this.view.scale,
    };
  }

  // What lies under the cells: terrain, and the layer chosen. Returns the names of those drawn.
  grounds() {
    const { context, state, options } = this;
    const layer = options.layer.startsWith("layer:") ? options.layer.slice(6) : "";
    const wanted = [[options.terrain ? TERRAIN : "", 1], [layer, options.terrain && state.grounds.has(TERRAIN) ? 0.7 : 1]];
    const found = wanted.filter(([name]) => name && state.grounds.has(name));
    for (const [name, alpha] of found) {
      state.grounds.get(name).draw(context, (x, y) => this.pixels(x, y), this.view.scale, alpha);
    }
    return found.map(([name]) => name);
  }

  // Members joined to who leads them; among several leaders, or none, to the first of the group.
  groups(byId) {
    const teams = new Map();
    for (const [id, { group, leads }] of this.state.groups) {
      if (!byId.has(id)) continue;
      if (!teams.has(group)) teams.set(group, { group, ids: [], leader: null });
      const team = teams.get(group);
      team.ids.push(id);
      if (leads && team.leader === null) team.leader = id;
    }
    const { context } = this;
    for (const team of teams.values()) {
      const centre = byId.get(team.leader ?? team.ids[0]);
      context.strokeStyle = agentColour(centre.id);
      context.lineWidth = 3;
      context.globalAlpha = 0.55;
      context.setLineDash([2, 4]);
      context.beginPath();
      for (const id of team.ids) {
        context.moveTo(...this.pixels(centre.x, centre.y));
        context.lineTo(...this.pixels(byId.get(id).x, byId.get(id).y));
      }
      context.stroke();
      context.setLineDash([]);
      context.globalAlpha = 1;
      if (team.leader !== null) this.crown(centre);
    }
    return [...teams.values()];
  }

  crown({ x, y }) {
    const [px, py] = this.pixels(x, y);
    this.outlined(() => {
      this.context.moveTo(px - 7, py - 10);
      this.context.lineTo(px - 7, py - 17);
      this.context.lineTo(px - 3, py - 13);
      this.context.lineTo(px, py - 18);
      this.context.lineTo(px + 3, py - 13);
      this.context.lineTo(px + 7, py - 17);
      this.context.lineTo(px + 7, py - 10);
      this.context.closePath();
    }, theme.hot, 1.5);
  }

  area(painted, grounds) {
    const { context } = this;
    const [west, south, cell, columns, rows] = this.state.mission.grid;
    const [left, bottom] = this.pixels(west, south);
    const side = this.view.scale * cell;
    const [w, h] = [side * columns, side * rows];
    if (painted) {
      context.imageSmoothingEnabled = false;
      context.globalAlpha = grounds.length ? 0.6 : 1;
      context.drawImage(this.cells.canvas, left, bottom - h, w, h);
      context.globalAlpha = 1;
    } else if (!grounds.length) {
      context.fillStyle = theme.unseen;
      context.fillRect(left, bottom - h, w, h);
    }
    context.lineWidth = 1;
    if (side >= 14) {
      context.strokeStyle = theme.ground;
      context.globalAlpha = Math.min((side - 14) / 40 + 0.15, 0.5);
      context.beginPath();
      for (let c = 1; c < columns; c += 1) {
        context.moveTo(left + c * side, bottom);
        context.lineTo(left + c * side, bottom - h);
      }
      for (let r = 1; r < rows; r += 1) {
        context.moveTo(left, bottom - r * side);
        context.lineTo(left + w, bottom - r * side);
      }
      context.stroke();
      context.globalAlpha = 1;
    }
    context.strokeStyle = theme.faint;
    context.strokeRect(left - 0.5, bottom - h - 0.5, w + 1, h + 1);
  }

  // Where nobody may fly.
  columns() {
    const { context, view } = this;
    const { columns } = this.state.mission;
    for (const [x, y, radius] of columns) {
      const [px, py] = this.pixels(x, y);
      this.outlined(() => context.arc(px, py, radius * view.scale, 0, TAU), theme.bad, 1.2);
      context.fillStyle = theme.bad;
      context.globalAlpha = 0.15;
      context.fill();
      context.globalAlpha = 1;
    }
    return columns.length;
  }

  trueTargets() {
    return this.agent || !this.options.targets ? [] : this.state.mission.targets ?? [];
  }

  targets() {
    const { context } = this;
    const { grid, targets } = this.state.mission;
    for (const [x, y] of this.trueTargets()) {
      const [px, py] = this.pixels(x, y);
      this.outlined(() => {
        context.moveTo(px + 7, py);
        context.arc(px, py, 7, 0, TAU);
        for (const [dx, dy] of [[0, -1], [0, 1], [-1, 0], [1, 0]]) {
          context.moveTo(px + 4 * dx, py + 4 * dy);
          context.lineTo(px + 10 * dx, py + 10 * dy);
        }
      }, theme.target, 1.7);
    }
    if (!grid) return;
    const [west, south, cell] = grid;
    const cellOf = ([x, y]) => `${Math.floor((x - west) / cell)} ${Math.floor((y - south) / cell)}`;
    const real = !this.agent && targets ? new Set(targets.map(cellOf)) : null;
    for (const [column, row] of this.shownDeclared()) {
      const [px, py] = this.pixels(west + (column + 0.5) * cell, south + (row + 0.5) * cell);
      const r = Math.max((this.view.scale * cell) / 2 + 2, 8);
      const right = !real || real.has(`${column} ${row}`);
      this.outlined(() => {
        context.moveTo(px, py - 1.35 * r);
        context.lineTo(px + 1.35 * r, py);
        context.lineTo(px, py + 1.35 * r);
        context.lineTo(px - 1.35 * r, py);
        context.closePath();
      }, right ? theme.good : theme.bad, 2);
    }
  }

  outlined(path, colour, width) {
    const { context } = this;
    context.beginPath();
    path();
    context.strokeStyle = theme.halo;
    context.lineWidth = width + 2;
    context.stroke();
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.stroke();
  }

  trails(vehicles) {
    const length = this.options.trails;
    if (length === 0) return;
    const ink = this.flown.getContext("2d");
    if (length !== Infinity || !this.inked.size) {
      ink.setTransform(1, 0, 0, 1, 0, 0);
      ink.clearRect(0, 0, this.flown.width, this.flown.height);
      this.inked.clear();
    }
    ink.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    ink.lineWidth = 1.25;
    ink.lineJoin = "round";
    ink.globalAlpha = 0.75;
    const own = this.agent ? this.agent() : 0;
    const flown = vehicles.filter((one) => !own || one.id === own);
    for (const { id, u, v } of flown) {
      const trail = this.state.trails.get(id);
      if (!trail) continue;
      let first = this.inked.get(id) ?? 0;
      if (length !== Infinity) first = recent(trail, length * Math.max(Math.hypot(u, v), 3));
      if (first > trail.length) first = 0; // thinned meanwhile
      if (trail.length - first < 4 && first) continue;
      this.stroke(ink, trail, Math.max(first - 2, 0), agentColour(id));
      this.inked.set(id, trail.length);
    }
    this.context.globalAlpha = 0.7;
    this.context.drawImage(this.flown, 0, 0, this.canvas.clientWidth, this.canvas.clientHeight);
    this.context.lineWidth = 1.25;
    for (const { id, x, y } of flown) {
      const trail = this.state.trails.get(id);
      if (!trail || !trail.length) continue;
      this.context.strokeStyle = agentColour(id);
      this.context.beginPath();
      this.context.moveTo(...this.pixels(trail.at(-2), trail.at(-1)));
      this.context.lineTo(...this.pixels(x, y));
      this.context.stroke();
    }
    this.context.globalAlpha = 1;
  }

  stroke(ink, trail, first, colour) {
    if (trail.length - first < 4) return;
    ink.strokeStyle = colour;
    ink.beginPath();
    ink.moveTo(...this.pixels(trail[first], trail[first + 1]));
    for (let i = first + 2; i < trail.length; i += 2) ink.lineTo(...this.pixels(trail[i], trail[i + 1]));
    ink.stroke();
  }

  wires(links, byId) {
    const { context } = this;
    if (!links.length) return;
    const chosen = this.options.chosen;
    for (const mine of [false, true]) {
      context.strokeStyle = mine ? theme.accent : theme.link;
      context.globalAlpha = mine ? 0.85 : Math.max(0.1, 0.6 / (1 + links.length / 60));
      context.lineWidth = mine ? 1.5 : 1;
      context.beginPath();
      for (const [a, b] of links) {
        if ((a === chosen || b === chosen) !== mine) continue;
        context.moveTo(...this.pixels(byId.get(a).x, byId.get(a).y));
        context.lineTo(...this.pixels(byId.get(b).x, byId.get(b).y));
      }
      context.stroke();
    }
    context.globalAlpha = 1;
  }

  ranges(vehicles) {
    const { context } = this;
    const range = this.state.mission.range_m;
    if (!range) return;
    context.lineWidth = 1;
    context.setLineDash([5, 5]);
    for (const one of vehicles) {
      if (!this.options.ranges && one.id !== this.options.chosen) continue;
      context.strokeStyle = agentColour(one.id);
      context.globalAlpha = one.id === this.options.chosen ? 0.9 : 0.35;
      context.beginPath();
      context.arc(...this.pixels(one.x, one.y), range * this.view.scale, 0, TAU);
      context.stroke();
    }
    context.setLineDash([]);
    context.globalAlpha = 1;
  }

  vehicle(one) {
    const { context } = this;
    const [px, py] = this.pixels(one.x, one.y);
    const row = this.state.rows.get(one.id);
    const crowded = this.state.vehicles.size > 40;
    const room = Math.min(this.canvas.clientWidth, this.canvas.clientHeight);
    const size = Math.min(Math.max(room / 75, 4), 8) * (crowded ? 0.75 : 1);
    const chosen = one.id === this.options.chosen;
    context.save();
    context.translate(px, py);
    if (chosen) {
      context.strokeStyle = theme.accent;
      context.lineWidth = 2;
      context.beginPath();
      context.arc(0, 0, size + 6, 0, TAU);
      context.stroke();
    }
    const speed = Math.hypot(one.u, one.v);
    if (speed > 0.5) { // where it will be in five seconds
      context.strokeStyle = agentColour(one.id);
      context.lineWidth = 1.5;
      context.beginPath();
      context.moveTo(0, 0);
      context.lineTo(5 * one.u * this.view.scale, -5 * one.v * this.view.scale);
      context.stroke();
    }
    context.rotate(-one.heading); // the screen's y goes down
    context.beginPath();
    context.moveTo(1.35 * size, 0);
    context.lineTo(-size, 0.85 * size);
    context.lineTo(-0.5 * size, 0);
    context.lineTo(-size, -0.85 * size);
    context.closePath();
    context.globalAlpha = row && ENDED.has(row.phase) ? 0.45 : 1;
    context.fillStyle = row && (row.phase === "failed" || (row.alive === false && row.phase !== "landed")) ? theme.bad : agentColour(one.id);
    context.lineWidth = 2.5;
    context.strokeStyle = theme.halo;
    context.stroke();
    context.fill();
    context.restore();
    if (!crowded || chosen || this.view.scale * 30 > 60) this.label(String(one.id), px + size + 5, py - size);
  }

  label(text, x, y) {
    const { context } = this;
    context.font = "600 11px system-ui, 'DejaVu Sans', sans-serif";
    context.lineWidth = 3;
    context.strokeStyle = theme.halo;
    context.strokeText(text, x, y);
    context.fillStyle = theme.text;
    context.fillText(text, x, y);
  }

  scaleBar() {
    const { context } = this;
    const goal = 110 / this.view.scale;
    const power = 10 ** Math.floor(Math.log10(goal));
    const length = [5, 2, 1].map((step) => step * power).find((step) => step <= goal) ?? power;
    const width = length * this.view.scale;
    const [x, y] = [this.canvas.clientWidth - 16 - width, 22];
    context.strokeStyle = theme.muted;
    context.lineWidth = 1.5;
    context.beginPath();
    context.moveTo(x, y - 4);
    context.lineTo(x, y);
    context.lineTo(x + width, y);
    context.lineTo(x + width, y - 4);
    context.stroke();
    context.fillStyle = theme.muted;
    context.font = "11px system-ui, 'DejaVu Sans', sans-serif";
    context.textAlign = "center";
    context.fillText(length >= 1000 ? `${length / 1000} km` : `${length} m`, x + width / 2, y - 7);
    context.textAlign = "start";
  }

  // What is under the pointer, in words.
  tell(owner) {
    if (!this.pointer) {
      this.readout.textContent = "";
      return;
    }
    const [x, y] = this.metres(this.pointer.x, this.pointer.y);
    const parts = [`${x.toFixed(0)} m E, ${y.toFixed(0)} m N`];
    const [map, grid] = [this.state.maps.get(owner), this.state.mission.grid];
    if (map && grid) {
      const [west, south, cell, columns, rows] = grid;
      const [column, row] = [Math.floor((x - west) / cell), Math.floor((y - south) / cell)];
      if (column >= 0 && row >= 0 && column < columns && row < rows) {
        const word = map.words[column * rows + row];
        const seen = word >>> 8;
        parts.push(`cell ${column}, ${row}`, `P ${((word & 255) / 255).toFixed(2)}`);
        parts.push(seen ? `seen ${Math.max(Math.floor(this.state.t) - (seen - 1), 0)} s ago` : "never seen");
      }
    }
    for (const [name, ground] of this.state.grounds) {
      const value = name === TERRAIN || this.drawn?.grounds.includes(name) ? ground.at(x, y) : null;
      if (value !== null) parts.push(`${name} ${name === TERRAIN ? `${value.toFixed(0)} m` : value.toPrecision(3)}`);
    }
    this.readout.textContent = parts.join("   ");
  }
}

// Where the last so many metres of a trail begin.
function recent(trail, metres) {
  let at = trail.length - 2;
  for (let left = metres; at >= 2 && left > 0; at -= 2) {
    left -= Math.hypot(trail[at] - trail[at - 2], trail[at + 1] - trail[at - 1]);
  }
  return Math.max(at, 0);
}
