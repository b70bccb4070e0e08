// Numbers over the ground as pictures: terrain with its shading, and layers such as pheromones.

import { rgb, theme, whenThemeChanges } from "./colours.js";

export const TERRAIN = "terrain";
const LOW = [92, 122, 88]; // green valleys, brown slopes, pale tops
const MIDDLE = [150, 132, 96];
const HIGH = [196, 189, 178]; // with room for the light above it

// One picture, made anew when the server tells of another moment.
export class Ground {
  constructor(told) {
    this.take(told);
    whenThemeChanges(() => this.paint());
  }

  take(told) {
    const [west, south, cell, columns, rows] = told.grid;
    Object.assign(this, { told, west, south, cell, columns, rows });
    this.values = bytes(told.values);
    this.shade = told.shade ? bytes(told.shade) : null;
    this.canvas ??= document.createElement("canvas");
    [this.canvas.width, this.canvas.height] = [columns, rows];
    this.paint();
  }

  paint() {
    const context = this.canvas.getContext("2d");
    const image = context.createImageData(this.columns, this.rows);
    const pixels = new Uint32Array(image.data.buffer);
    const table = this.shade ? null : layerColours(this.told.low, this.told.high);
    for (let column = 0; column < this.columns; column += 1) {
      for (let row = 0; row < this.rows; row += 1) {
        const flat = column * this.rows + row;
        const at = (this.rows - 1 - row) * this.columns + column;
        pixels[at] = table ? table[this.values[flat]] : lit(this.values[flat], this.shade[flat]);
      }
    }
    context.putImageData(image, 0, 0);
  }

  // On a map: `pixels` turns metres into pixels.
  draw(context, pixels, scale, alpha = 1) {
    const [left, top] = pixels(this.west, this.south + this.rows * this.cell);
    context.globalAlpha = alpha;
    context.imageSmoothingEnabled = Boolean(this.shade);
    context.drawImage(this.canvas, left, top, this.columns * this.cell * scale, this.rows * this.cell * scale);
    context.globalAlpha = 1;
  }

  // The number at a place; null where there is none.
  at(x, y) {
    const [column, row] = [Math.floor((x - this.west) / this.cell), Math.floor((y - this.south) / this.cell)];
    if (column < 0 || row < 0 || column >= this.columns || row >= this.rows) return null;
    const { low, high } = this.told;
    return low + ((high - low) * this.values[column * this.rows + row]) / 255;
  }
}

// 256 colours of the numbers from `low` to `high`: nothing is pale, more goes over blue to hot; where
// there are negative ones, those go to blue and the others to hot.
export function layerColours(low, high) {
  const [none, some, much] = [theme.unseen, theme.accent, theme.hot].map(rgb);
  const table = new Uint32Array(256);
  const most = Math.max(Math.abs(low), Math.abs(high)) || 1;
  for (let i = 0; i < 256; i += 1) {
    const value = (low + ((high - low) * i) / 255) / most;
    const share = Math.sqrt(Math.abs(value)); // little is told from nothing
    if (low < 0) table[i] = packed(mix(none, value < 0 ? some : much, share));
    else table[i] = packed(share < 0.5 ? mix(none, some, 2 * share) : mix(some, much, 2 * share - 1));
  }
  return table;
}

function lit(height, shade) {
  const share = height / 255;
  const colour = share < 0.5 ? mix(LOW, MIDDLE, 2 * share) : mix(MIDDLE, HIGH, 2 * share - 1);
  const light = 0.2 + (0.85 * shade) / 180; // level ground has 180
  return packed(colour.map((part) => Math.min(Math.round(part * light), 255)));
}

function mix(a, b, share) {
  return a.map((part, i) => Math.round(part + share * (b[i] - part)));
}

function packed([r, g, b]) {
  return ((255 << 24) | (b << 16) | (g << 8) | r) >>> 0; // as ImageData has it, little-endian
}

function bytes(text) {
  return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
}
