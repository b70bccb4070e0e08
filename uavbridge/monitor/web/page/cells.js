// The picture of a map's cells: one pixel a cell, north up, changed cells only.

import { ageColours, ageStep, beliefColours, whenThemeChanges } from "./colours.js";

export class Cells {
  constructor() {
    this.canvas = document.createElement("canvas");
    this.key = "";
    whenThemeChanges(() => (this.key = ""));
  }

  // Brings the picture up to date; returns whether there is one.
  // Over terrain, cells that nobody saw let it through.
  paint(map, mission, layer, t, through) {
    if (!map || !mission.grid) return false;
    if (layer === "none" || layer.startsWith("layer:")) {
      map.fresh.length = 0;
      this.key = "";
      return false;
    }
    const [, , , columns, rows] = mission.grid;
    const key = `${columns} ${rows} ${layer} ${mission.prior} ${through}`;
    const aged = layer === "age" && Math.floor(t) !== this.second;
    if (this.key !== key || this.map !== map || aged) {
      if (this.canvas.width !== columns || this.canvas.height !== rows || !this.image) {
        [this.canvas.width, this.canvas.height] = [columns, rows];
        this.context = this.canvas.getContext("2d");
        this.image = this.context.createImageData(columns, rows);
        this.pixels = new Uint32Array(this.image.data.buffer);
      }
      Object.assign(this, { key, map, layer, through, second: Math.floor(t), columns, rows });
      this.table = layer === "age" ? ageColours() : beliefColours(mission.prior);
      for (let flat = 0; flat < map.words.length; flat += 1) this.dot(flat);
      this.context.putImageData(this.image, 0, 0);
    } else if (map.fresh.length) {
      for (const flat of map.fresh) this.dot(flat);
      this.context.putImageData(this.image, 0, 0);
    }
    map.fresh.length = 0;
    return true;
  }

  dot(flat) {
    const word = this.map.words[flat];
    const [column, row] = [Math.floor(flat / this.rows), flat % this.rows];
    const seen = word >>> 8;
    let at = (word & 255) + (seen ? 256 : 0);
    const there = (this.rows - 1 - row) * this.columns + column;
    if (this.through && !seen) {
      this.pixels[there] = 0;
      return;
    }
    if (this.layer === "age") at = seen ? ageStep(this.second - (seen - 1)) : 255;
    this.pixels[there] = this.table[at];
  }

  // [r, g, b] of a cell as it is drawn.
  colour(column, row) {
    const value = this.pixels[(this.rows - 1 - row) * this.columns + column];
    return [value & 255, (value >> 8) & 255, (value >> 16) & 255];
  }
}
