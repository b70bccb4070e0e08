// Colours of the page's theme, and of the cells of a map.

const NAMES = ["ground", "panel", "edge", "text", "muted", "faint", "accent", "good", "warn", "bad",
  "unseen", "cleared", "likely", "hot", "link", "target", "halo"];
const STEEPNESS = 3.2; // log-odds away from the prior that take the full colour
const OLD_S = 300; // looks older than this have the faintest colour

const light = matchMedia("(prefers-color-scheme: light)");
const agentColours = new Map();

export let theme = read();
const onTheme = [];

export function whenThemeChanges(act) {
  onTheme.push(act);
}

light.addEventListener("change", () => {
  theme = read();
  agentColours.clear();
  onTheme.forEach((act) => act());
});

function read() {
  const style = getComputedStyle(document.documentElement);
  return Object.fromEntries(NAMES.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
}

// A vehicle's own: the golden angle keeps neighbours in the list apart.
export function agentColour(id) {
  let colour = agentColours.get(id);
  if (!colour) {
    colour = `hsl(${(id * 137.508 + 150) % 360} ${light.matches ? "75% 36%" : "80% 68%"})`;
    agentColours.set(id, colour);
  }
  return colour;
}

export function rgb(hex) {
  const value = parseInt(hex.slice(1), 16);
  return [value >> 16, (value >> 8) & 255, value & 255];
}

function mixed(a, b, share) {
  return a.map((part, i) => Math.round(part + share * (b[i] - part)));
}

function packed([r, g, b]) {
  return ((255 << 24) | (b << 16) | (g << 8) | r) >>> 0; // as ImageData has it, little-endian
}

// 512 colours: of P = 0..255 / 255 in cells never seen, then in cells seen.
export function beliefColours(prior) {
  const [unseen, cleared, likely, hot] = [theme.unseen, theme.cleared, theme.likely, theme.hot].map(rgb);
  const odds = (p) => Math.log(p / (1 - p));
  const table = new Uint32Array(512);
  for (let i = 0; i < 256; i += 1) {
    const p = Math.min(Math.max(i / 255, 1 / 1024), 1 - 1 / 1024);
    const away = (odds(p) - odds(prior)) / STEEPNESS;
    let colour = unseen;
    if (away < 0) colour = mixed(unseen, cleared, Math.min(0.35 - 0.65 * away, 1));
    else if (away < 0.5) colour = mixed(mixed(unseen, cleared, 0.35), likely, 2 * away);
    else colour = mixed(likely, hot, Math.min(2 * away - 1, 1));
    // Where nobody looked, the prior shows through only faintly.
    table[i] = packed(Math.abs(away) < 0.02 ? unseen : mixed(unseen, colour, 0.4));
    table[256 + i] = packed(colour);
  }
  return table;
}

// 256 colours: of looks just now to long ago; the last: never.
export function ageColours() {
  const table = new Uint32Array(256);
  for (let i = 0; i < 255; i += 1) {
    table[i] = packed(mixed(rgb(theme.accent), rgb(theme.unseen), 0.15 + 0.7 * (i / 254)));
  }
  table[255] = packed(rgb(theme.unseen));
  return table;
}

export function ageStep(age_s) {
  return Math.min(Math.max(Math.round((254 * age_s) / OLD_S), 0), 254);
}
