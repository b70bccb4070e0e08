// What the page knows of the mission: made from the server's messages alone.

import { Ground } from "./grounds.js";

const TRAIL_NUMBERS = 4000; // numbers kept of one vehicle, then every other one goes
const TRAIL_STEP_M = 0.5;

export const POINT = { t: 0, coverage: 1, entropy: 2, declared: 3, found: 4, separation: 5, bytes: 6, frames: 7 };

export class State {
  constructor() {
    this.updates = 0;
    this.version = 0; // of the mission: greater means that all before is void
    this.forget(null);
  }

  forget(mission) {
    this.version += 1;
    this.mission = mission;
    this.t = mission ? mission.t_s : 0;
    this.vehicles = new Map(); // id -> vehicle
    this.rows = new Map(); // id -> what the agent says of itself
    this.links = [];
    this.points = mission ? mission.points : [];
    this.events = [];
    this.declared = [];
    this.maps = new Map(); // owner, 0: the union -> cells
    this.grounds = new Map(); // name -> picture of numbers over the ground
    this.layers = []; // names of those that may be asked for
    this.groups = new Map(); // id -> { group, leads }
    this.seenBy = 0;
    this.hears = [];
    this.player = null;
    this.connected = true;
    this.silent = false;
    this.changed = { rows: new Set(), events: [], points: true, declared: true };
    this.trails = new Map();
    for (const [id, track] of Object.entries(mission ? mission.tracks : {})) {
      this.trails.set(Number(id), track.slice());
    }
  }

  // Returns what the message was: "mission", "ground", "update" or "answer".
  take(message, now) {
    if (message.kind === "mission") {
      this.forget(message);
    } else if (message.kind === "ground" && this.mission) {
      const known = this.grounds.get(message.name);
      if (known) known.take(message);
      else this.grounds.set(message.name, new Ground(message));
    } else if (message.kind === "update" && this.mission) {
      this.update(message, now);
    }
    return message.kind;
  }

  update(news, now) {
    this.updates += 1;
    this.t = news.t_s;
    this.connected = news.connected ?? true;
    this.silent = news.silent ?? false;
    this.player = "playing" in news
      ? { playing: news.playing, speed: news.speed, seeking: news.seeking ?? false } : null;
    for (const [id, x, y, z, u, v, heading] of news.vehicles) this.move(id, x, y, z, u, v, heading, now);
    for (const [id, track] of Object.entries(news.tracks ?? {})) this.extend(Number(id), track);
    for (const row of news.rows ?? []) {
      this.rows.set(row.id, row);
      this.changed.rows.add(row.id);
    }
    this.links = news.links ?? this.links;
    if (news.points) {
      this.points.push(...news.points);
      this.changed.points = true;
    }
    if (news.events) {
      this.events.push(...news.events);
      this.changed.events.push(...news.events);
    }
    if (news.groups) this.groups = new Map(news.groups.map(([id, group, leads]) => [id, { group, leads }]));
    this.layers = news.layers ?? this.layers;
    if (news.declared) this.declared = news.declared;
    this.seenBy = news.seen_by ?? 0;
    if (news.hears) this.hears = news.hears;
  }

  move(id, x, y, z, u, v, heading, now) {
    let one = this.vehicles.get(id);
    if (!one) {
      one = { id, x, y, z, heading, from: { x, y, heading }, since: now, gap: 200 };
      this.vehicles.set(id, one);
    } else {
      one.from = placed(one, now);
      one.gap = Math.min(Math.max(now - one.since, 50), 400);
      one.since = now;
    }
    Object.assign(one, { x, y, z, u, v, heading });
  }

  extend(id, track) {
    let trail = this.trails.get(id);
    if (!trail) this.trails.set(id, (trail = []));
    for (let i = 0; i < track.length; i += 2) {
      const last = trail.length;
      const still = last && Math.hypot(track[i] - trail[last - 2], track[i + 1] - trail[last - 1]) < TRAIL_STEP_M;
      if (!still) trail.push(track[i], track[i + 1]);
    }
    if (trail.length > TRAIL_NUMBERS) this.trails.set(id, thinned(trail));
  }

  // Cells of one map: u32 owner, count, then count times flat cell and value.
  cells(buffer) {
    const words = new Uint32Array(buffer);
    const [owner, count] = words;
    if (!this.mission || !this.mission.grid || words.length !== 2 + 2 * count) return;
    const [, , , columns, rows] = this.mission.grid;
    let map = this.maps.get(owner);
    if (!map) {
      map = { words: new Uint32Array(columns * rows), fresh: [], whole: true };
      this.maps.set(owner, map);
    }
    for (let i = 2; i < words.length; i += 2) {
      if (words[i] >= map.words.length) continue;
      map.words[words[i]] = words[i + 1];
      map.fresh.push(words[i]);
    }
  }
}

// Where a vehicle is shown at a moment: on its way from the update before to the newest.
export function placed(one, now) {
  const share = Math.min((now - one.since) / one.gap, 1);
  const turn = Math.atan2(Math.sin(one.heading - one.from.heading), Math.cos(one.heading - one.from.heading));
  return {
    x: one.from.x + share * (one.x - one.from.x),
    y: one.from.y + share * (one.y - one.from.y),
    heading: one.from.heading + share * turn,
    still: share === 1,
  };
}

function thinned(trail) {
  const half = [];
  for (let i = 0; i < trail.length; i += 4) half.push(trail[i], trail[i + 1]);
  return half;
}

export function clockText(seconds) {
  if (seconds === null || seconds === undefined || !Number.isFinite(seconds)) return "–";
  const whole = Math.max(Math.floor(seconds), 0);
  const pad = (n) => String(n).padStart(2, "0");
  const [h, m, s] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60, whole % 60];
  return h ? `${h}:${pad(m)}:${pad(s)}` : `${m}:${pad(s)}`;
}
