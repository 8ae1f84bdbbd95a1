// The data of the report, what the reader has chosen, and small helpers that plot and scene share.

const report = JSON.parse(document.getElementById("runs").textContent);

/** Little-endian 32-bit floats out of base64. */
const unpack = (text) => {
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let k = 0; k < letters.length; k += 1) bytes[k] = letters.charCodeAt(k);
  return new Float32Array(bytes.buffer);
};

for (const run of report.runs) {
  run.time = unpack(run.time);
  run.end = run.time[run.time.length - 1];
  for (const link of run.scene.links) link.spans = unpack(link.spans);
  for (const agent of run.scene.agents)
    for (const name of ["position", "tracked", "desired"])
      if (agent[name]) agent[name].values = unpack(agent[name].values);
}

/** The values of a curve, unpacked when they are first wanted: most of them never are. */
const valuesOf = (curve) => {
  if (typeof curve.values === "string") curve.values = unpack(curve.values);
  return curve.values;
};

const runs = report.runs;
const comparing = runs.length > 1;
let lastTime = Math.max(...runs.map((run) => run.end));
/** The length of the whole run, s, also while it is going on. */
const wholeTime = report.live?.duration ?? lastTime;
const agentCount = Math.max(...runs.map((run) => run.scene.agents.length));

/** What the reader has chosen. Times in s; agents by their place in the list. */
const state = {
  time: lastTime,
  playing: false,
  speed: 1,
  solo: null,
  pointed: null,
  follow: null,
  trail: Infinity,
  links: true,
  targets: true,
  span: null,
  /** The time below the pointer in any plot; all plots show their values there. */
  hover: null,
  hidden: new Set(),
};

const element = (tag, attributes = {}, ...children) => {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (value !== null && value !== undefined && value !== false) made.setAttribute(name, value === true ? "" : value);
  }
  made.append(...children.filter((child) => child !== null));
  return made;
};

// Okabe and Ito's palette, distinguishable with every common kind of colour blindness.
const HUES = ["blue", "vermilion", "green", "orange", "purple", "sky", "black", "yellow"];
const DASHES = [[], [7, 3], [2, 3], [9, 3, 2, 3]];

let colours = {};
const readColours = () => {
  const style = getComputedStyle(document.documentElement);
  const names = [...HUES, "page", "card", "ink", "soft", "line", "grid", "accent", "good", "bad", "warn"];
  colours = Object.fromEntries(names.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
};
const hue = (index) => colours[HUES[index % HUES.length]];
const runDash = (index) => DASHES[index % DASHES.length];
/** The palette has eight colours; the ninth agent gets the first one again, dashed. */
const agentDash = (index) => DASHES[Math.floor(index / HUES.length) % DASHES.length];

/** A number as a person would write it. */
const short = (value) => {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-3) return value.toExponential(3).replace(/\.?0*e\+?/, "e").replaceAll("-", "−");
  const text = value.toFixed(Math.max(0, Math.min(6, 3 - Math.floor(Math.log10(size)))));
  return (text.includes(".") ? text.replace(/\.?0+$/, "") : text).replace("-", "−");
};

/** Index of the last entry that is not after `time`. */
const indexAt = (times, time) => {
  let low = 0;
  let high = times.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= time) low = middle;
    else high = middle - 1;
  }
  return low;
};

/** Steps of 1, 2 or 5 times a power of ten, about `count` of them over `range`. */
const niceStep = (range, count) => {
  const rough = Math.max(range, 1e-30) / Math.max(count, 1);
  const power = 10 ** Math.floor(Math.log10(rough));
  return power * ([1, 2, 5].find((factor) => factor * power >= rough * 0.999) ?? 10);
};

const ticksBetween = (low, high, step) => {
  const ticks = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + step * 1e-9; k += 1) ticks.push(k * step);
  return ticks;
};

/** Decimals that tell ticks of this distance apart. */
const tickText = (value, step) => {
  if (Math.abs(value) < step * 1e-6) return "0";
  if (Math.abs(value) >= 1e5 || step < 1e-5) return short(value);
  return value.toFixed(Math.max(0, -Math.floor(Math.log10(step) + 1e-9))).replace("-", "−");
};

const superscript = (number) => [...String(number)].map((digit) => (digit === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[digit])).join("");

/** Powers of ten as one writes them. */
const powerText = (power) => (power >= -2 && power <= 3 ? short(10 ** power) : `10${superscript(power)}`);

/** A unit as one writes it: `m/s^2` is m/s². */
const unitText = (unit) => (unit ?? "").replace(/\^(-?\d+)/g, (_, power) => superscript(power)).replaceAll("*", "·");

/** What this browser remembers of an earlier visit; nothing where it may not. */
const remembered = {
  get: (name) => {
    try {
      return localStorage.getItem(`phalanx-${name}`);
    } catch {
      return null;
    }
  },
  set: (name, value) => {
    try {
      if (value === null) localStorage.removeItem(`phalanx-${name}`);
      else localStorage.setItem(`phalanx-${name}`, value);
    } catch {
      // The page works without.
    }
  },
};

/** Fits a canvas to its place on the page; gives its context, scaled to CSS pixels, and its size. */
const fitCanvas = (canvas) => {
  const ratio = Math.max(window.devicePixelRatio || 1, printing ? 2 : 1);
  const { clientWidth: width, clientHeight: height } = canvas;
  const [wide, high] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== wide || canvas.height !== high) Object.assign(canvas, { width: wide, height: high });
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, width, height };
};
let printing = false;
const FONT = '12px system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif';
