// Small plots over mission time, drawn by hand: a line, its axis, and what is under the pointer.

import { theme, whenThemeChanges } from "./colours.js";
import { POINT, clockText } from "./state.js";

const PAD = { left: 40, right: 6, top: 5, bottom: 15 };

const percent = (v) => `${(100 * v).toFixed(0)} %`;
const plain = (v) => (v === 0 ? "0" : Math.abs(v) >= 100 ? v.toFixed(0) : Math.abs(v) >= 10 ? v.toFixed(1) : v.toFixed(2));
const whole = (v) => String(Math.round(v));

export function bytesText(v) {
  for (const unit of ["B", "kB", "MB", "GB"]) {
    if (v < 999.5 || unit === "GB") return `${unit === "B" || v >= 100 ? v.toFixed(0) : v.toFixed(1)} ${unit}`;
    v /= 1000;
  }
}

// Each: title, what of a point, how it is written, and what else its axis must show.
const KINDS = [
  { name: "coverage", title: "Coverage", of: (p) => p[POINT.coverage], text: percent, colour: "accent",
    cells: true, top: () => 1, line: (m) => m.coverage_goal },
  { name: "entropy", title: "Entropy, bits", of: (p) => p[POINT.entropy], text: plain, colour: "warn",
    cells: true },
  { name: "targets", title: "Targets declared", of: (p) => p[POINT.declared], text: whole, colour: "good",
    second: (p) => p[POINT.found], step: true, top: (m) => (m.targets ? m.targets.length : 1),
    line: (m) => (m.targets ? m.targets.length : null) },
  { name: "separation", title: "Closest pair, m", of: (p) => p[POINT.separation], text: plain, colour: "likely",
    log: true, line: (m) => m.separation_m },
  { name: "bytes", title: "Radio, bytes a second", rate: true, of: (p) => p[POINT.bytes], text: bytesText,
    colour: "link" },
];

export class Plots {
  constructor(section, state, onClick) {
    this.state = state;
    this.at = null; // mission time under the pointer
    this.dirty = true;
    this.plots = KINDS.map((kind) => this.make(section, kind, onClick));
    whenThemeChanges(() => (this.dirty = true));
  }

  make(section, kind, onClick) {
    const figure = document.createElement("figure");
    figure.className = "plot";
    const caption = document.createElement("figcaption");
    const title = document.createElement("b");
    title.textContent = kind.title;
    const value = document.createElement("span");
    caption.append(title, value);
    const canvas = document.createElement("canvas");
    figure.append(caption, canvas);
    section.append(figure);
    const plot = { kind, canvas, value, context: canvas.getContext("2d"), series: [] };
    new ResizeObserver(() => {
      const ratio = devicePixelRatio || 1;
      [canvas.width, canvas.height] = [canvas.clientWidth * ratio, canvas.clientHeight * ratio];
      plot.ratio = ratio;
      this.dirty = true;
    }).observe(canvas);
    canvas.addEventListener("pointermove", (event) => {
      this.at = this.time(plot, event.offsetX);
      this.dirty = true;
    });
    canvas.addEventListener("pointerleave", () => {
      this.at = null;
      this.dirty = true;
    });
    canvas.addEventListener("click", (event) => onClick(this.time(plot, event.offsetX)));
    return plot;
  }

  span() {
    const { mission, points, t } = this.state;
    const first = points.length ? points[0][0] : 0;
    const last = mission.end_s ?? Math.max(t, first + 30);
    return [mission.end_s === null ? Math.min(first, t) : 0, Math.max(last, first + 1)];
  }

  time(plot, x) {
    if (!this.state.mission) return null;
    const [first, last] = this.span();
    const share = (x - PAD.left) / Math.max(plot.canvas.clientWidth - PAD.left - PAD.right, 1);
    return first + Math.min(Math.max(share, 0), 1) * (last - first);
  }

  draw() {
    if (!this.dirty || !this.state.mission) return;
    this.dirty = false;
    for (const plot of this.plots) {
      // Who homes in on signals looks at no cells: there is nothing to plot.
      plot.canvas.parentElement.hidden = this.state.mission.by_signal && plot.kind.cells;
      if (plot.canvas.clientWidth) this.drawOne(plot);
    }
  }

  drawOne(plot) {
    const { kind, context } = plot;
    const { mission, points } = this.state;
    const [w, h] = [plot.canvas.clientWidth, plot.canvas.clientHeight];
    context.setTransform(plot.ratio, 0, 0, plot.ratio, 0, 0);
    context.clearRect(0, 0, w, h);
    const series = plot.series = values(points, kind, kind.of);
    const scale = this.axis(plot, series, mission, w, h);
    const line = kind.line ? kind.line(mission) : null;
    if (line !== null && line !== undefined) {
      context.setLineDash([3, 3]);
      this.path(context, [[scale.first, line], [scale.last, line]], scale, theme.muted, 1);
      context.setLineDash([]);
    }
    this.path(context, thin(series, w), scale, theme[kind.colour], 1.6, kind.step);
    const second = kind.second && mission.targets ? values(points, kind, kind.second) : null;
    if (second) this.path(context, thin(second, w), scale, theme.target, 1.2, true);
    const shown = this.at === null ? series.at(-1) : nearest(series, this.at);
    if (this.at !== null && shown) this.cursor(context, shown, scale, h);
    const both = second && shown ? `, ${kind.text(nearest(second, shown[0])[1])} true` : "";
    plot.value.textContent = shown ? kind.text(shown[1]) + both + (this.at === null ? "" : ` at ${clockText(shown[0])}`) : "–";
  }

  axis(plot, series, mission, w, h) {
    const { kind, context } = plot;
    const [first, last] = this.span();
    const data = series.map((p) => p[1]);
    const line = kind.line ? kind.line(mission) : null;
    const top = Math.max(...data.slice(-4000), kind.top ? kind.top(mission) : 0, line ?? 0, kind.log ? 1 : kind.rate ? 1000 : 1e-9);
    const least = Math.min(...data.slice(-4000), line ?? Infinity, top);
    const low = kind.log ? Math.max(Math.min(least, top / 10), 0.1) : 0;
    const y = kind.log
      ? (v) => Math.log(Math.max(v, low) / low) / Math.log((top * 1.15) / low)
      : (v) => v / (top * 1.08);
    const scale = {
      first, last,
      x: (t) => PAD.left + ((t - first) / (last - first)) * (w - PAD.left - PAD.right),
      y: (v) => h - PAD.bottom - y(v) * (h - PAD.top - PAD.bottom),
    };
    context.font = "10px system-ui, 'DejaVu Sans', sans-serif";
    context.fillStyle = theme.muted;
    context.strokeStyle = theme.edge;
    context.lineWidth = 1;
    context.textAlign = "right";
    for (const v of kind.log ? decades(low, top) : steps(top)) {
      const at = Math.round(scale.y(v)) + 0.5;
      context.beginPath();
      context.moveTo(PAD.left, at);
      context.lineTo(w - PAD.right, at);
      context.stroke();
      context.fillText(kind.text(v), PAD.left - 4, at + 3);
    }
    context.textAlign = "center";
    for (const t of times(first, last, w)) {
      const x = Math.min(Math.max(scale.x(t), PAD.left + 8), w - 16);
      context.fillText(clockText(t), x, h - 3);
    }
    return scale;
  }

  path(context, points, scale, colour, width, step = false) {
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.lineJoin = "round";
    context.beginPath();
    let [before, beforeY] = [null, 0];
    for (const [t, v] of points) {
      const [x, y] = [scale.x(t), scale.y(v)];
      if (before === null) context.moveTo(x, y);
      else {
        if (step) context.lineTo(x, beforeY);
        context.lineTo(x, y);
      }
      [before, beforeY] = [t, y];
    }
    context.stroke();
  }

  cursor(context, [t, v], scale, h) {
    context.strokeStyle = theme.muted;
    context.lineWidth = 1;
    context.beginPath();
    context.moveTo(scale.x(t), PAD.top);
    context.lineTo(scale.x(t), h - PAD.bottom);
    context.stroke();
    context.fillStyle = theme.text;
    context.beginPath();
    context.arc(scale.x(t), scale.y(v), 2.5, 0, 2 * Math.PI);
    context.fill();
  }
}

// [time, value] of the points where the value is known.
function values(points, kind, of) {
  const found = [];
  for (let i = 0; i < points.length; i += 1) {
    let value = of(points[i]);
    if (value === null || value === undefined) continue;
    if (kind.rate) {
      const before = points[Math.max(i - 5, 0)];
      const passed = points[i][0] - before[0];
      if (!(passed > 0)) continue;
      value = Math.max(value - of(before), 0) / passed;
    }
    found.push([points[i][0], value]);
  }
  return found;
}

// At most two points a pixel: the extremes of each stretch.
function thin(series, width) {
  const size = Math.ceil(series.length / Math.max(width, 1));
  if (size < 3) return series;
  const kept = [];
  for (let i = 0; i < series.length; i += size) {
    const part = series.slice(i, i + size);
    const least = part.reduce((a, b) => (b[1] < a[1] ? b : a));
    const most = part.reduce((a, b) => (b[1] > a[1] ? b : a));
    kept.push(...(least[0] < most[0] ? [least, most] : [most, least]));
  }
  return kept;
}

function nearest(series, t) {
  let best = null;
  for (const point of series) if (!best || Math.abs(point[0] - t) < Math.abs(best[0] - t)) best = point;
  return best;
}

function steps(top) {
  const power = 10 ** Math.floor(Math.log10(top / 2));
  const step = [1, 2, 5, 10].map((n) => n * power).find((n) => top / n <= 2.5) ?? top;
  const found = [];
  for (let v = 0; v <= top * 1.001; v += step) found.push(v);
  return found;
}

function decades(low, top) {
  const found = [];
  for (let v = 10 ** Math.ceil(Math.log10(low)); v <= top * 1.001; v *= 10) found.push(v);
  return found;
}

function times(first, last, width) {
  const goal = (last - first) / Math.max(width / 90, 1);
  const step = [5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 21600].find((s) => s >= goal) ?? 86400;
  const found = [];
  for (let t = Math.ceil(first / step) * step; t <= last; t += step) found.push(t);
  return found;
}
