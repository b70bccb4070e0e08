// Play, pause, speed and scrub for recordings.

import { clockText } from "./state.js";

const SEEK_EVERY_MS = 150;

export class Timeline {
  constructor(link, state) {
    Object.assign(this, { link, state });
    this.bar = document.querySelector("#timeline");
    this.play = document.querySelector("#play");
    this.moment = document.querySelector("#moment");
    this.text = document.querySelector("#moment-text");
    this.speed = document.querySelector("#speed");
    this.held = 0; // until then the slider is the person's, not ours
    this.play.addEventListener("click", () => this.toggle());
    this.speed.addEventListener("change", () => this.link.ask({ speed: Number(this.speed.value) }));
    this.moment.addEventListener("input", () => {
      this.held = performance.now() + 600;
      clearTimeout(this.later);
      this.later = setTimeout(() => this.seek(Number(this.moment.value)), SEEK_EVERY_MS);
    });
  }

  get recording() {
    return Boolean(this.state.mission && this.state.mission.recording);
  }

  toggle() {
    if (this.state.player) this.link.ask({ play: !this.state.player.playing });
  }

  seek(t) {
    if (this.recording) this.link.ask({ seek_s: Math.max(t, 0) });
  }

  draw() {
    this.bar.hidden = !this.recording;
    const { player, mission, t } = this.state;
    if (!this.recording || !player) return;
    this.play.textContent = player.playing ? "Pause" : "Play";
    this.moment.max = String(mission.end_s);
    if (performance.now() > this.held) this.moment.value = String(t);
    if (document.activeElement !== this.speed) this.speed.value = String(player.speed);
    const end = clockText(mission.end_s);
    this.text.textContent = `${clockText(t)} of ${end}${player.seeking ? " …" : ""}`;
  }
}
