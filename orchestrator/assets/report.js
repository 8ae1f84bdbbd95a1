// The page: builds it, moves the time, and keeps all parts in step.

const byId = (id) => document.getElementById(id);
const scenes = runs.map((run) => new Scene(run)).filter((scene) => scene.agents.length);
const panelIds = [...new Set(runs.flatMap((run) => run.panels.map((panel) => panel.id)))];

const onScreen = new Set();

/** Draws scenes, plots or both before the next frame, once, however often it was asked for. */
const stale = { scenes: false, plots: false };
/** How long the last drawing took, ms. */
let drawingTime = 0;
const redraw = (...parts) => {
  const waiting = stale.scenes || stale.plots;
  for (const part of parts) stale[part] = true;
  if (printing) drawStale();
  else if (!waiting) requestAnimationFrame(drawStale);
};
const drawStale = () => {
  const start = performance.now();
  if (stale.scenes) scenes.forEach((scene) => !scene.card.hidden && scene.draw());
  if (stale.plots) plots.forEach((plot) => plot.draw());
  Object.assign(stale, { scenes: false, plots: false });
  drawingTime = performance.now() - start;
};
const redrawScenes = () => redraw("scenes");
const redrawPlots = () => redraw("plots");
const redrawAll = () => redraw("scenes", "plots");

const showTime = () => {
  byId("scrub").value = state.time;
  byId("clock").replaceChildren(`${state.time.toFixed(lastTime < 1 ? 4 : 2)} s `, element("small", {}, `of ${short(lastTime)}`));
  redrawScenes();
  plots.forEach((plot) => onScreen.has(plot.card) && plot.drawTop());
};

/** Called when the reader goes to a time of their own choice. */
let onleave = () => {};

function setTime(time) {
  state.time = Math.min(lastTime, Math.max(0, time));
  showTime();
}

function setSpan(span) {
  state.span = span && span[1] - span[0] > lastTime * 1e-4 ? span : null;
  redrawPlots();
}

function setSolo(agent) {
  state.solo = agent;
  document.querySelectorAll("#agents .chip").forEach((chip, index) => chip.setAttribute("aria-pressed", String(index === agent)));
  redrawAll();
}

function setPointed(agent) {
  state.pointed = agent;
  redrawAll();
}

const setPlaying = (playing) => {
  state.playing = playing;
  if (playing) onleave();
  if (playing && state.time >= lastTime) state.time = 0;
  byId("play").classList.toggle("playing", playing);
  byId("play").setAttribute("aria-label", playing ? "Pause" : "Play");
  let before = performance.now();
  const tick = (now) => {
    if (!state.playing) return;
    // A page in the background gets no ticks; it continues where it stood.
    const passed = Math.min(0.25, Math.max(0, (now - before) / 1000));
    before = now;
    setTime(state.time + passed * state.speed);
    if (state.time >= lastTime) setPlaying(false);
    else requestAnimationFrame(tick);
  };
  if (playing) requestAnimationFrame(tick);
  else plots.forEach((plot) => plot.drawTop(true));
};

// Heading -----------------------------------------------------------------------------------------------------------

const buildHeading = () => {
  const first = runs[0];
  const sentence = (text) => text || first.scenario || first.file;
  byId("title").textContent = sentence(first.title);
  const kicker = byId("kicker");
  kicker.append(element("b", {}, first.scenario || first.file));
  const parts = comparing ? [`${runs.length} runs compared`] : [first.variant && `variant ${first.variant}`, ...first.overrides.map((text) => `changed: ${text}`)];
  if (first.thesis) parts.push(`thesis, section ${first.thesis}`);
  for (const part of parts.filter(Boolean)) kicker.append(` · ${part}`);
  const steps = first.dt ? `steps of ${short(first.dt)} s` : null;
  const facts = [`${first.scene.agents.length} agents`, `${short(first.end)} s`, steps, `${first.samples} samples`, comparing ? null : first.file];
  byId("facts").textContent = facts.filter(Boolean).join(" · ");
  const caveats = runs.flatMap((run) => run.caveats.map((text) => (comparing ? `${run.name}: ${text}` : text)));
  byId("caveats").hidden = !caveats.length;
  byId("caveats").textContent = caveats.join("\n");
  buildVerdict();
};

const buildVerdict = () => {
  const place = byId("verdict");
  const judged = runs.flatMap((run) => (run.metrics ?? []).filter((metric) => metric.in_range !== null).map((metric) => ({ ...metric, run })));
  if (!judged.length) return;
  const missed = judged.filter((metric) => !metric.in_range);
  const reasons = [...new Set(runs.map((run) => run.not_held).filter(Boolean))];
  const sentence = reasons.length ? `${judged.length - missed.length} of ${judged.length} bands met, not held against this run` : missed.length ? `${missed.length} of ${judged.length} bands missed` : `all ${judged.length} bands met`;
  if (!reasons.length) place.classList.add(missed.length ? "bad" : "good");
  const ticks = judged.slice(0, 120).map((metric) => element("i", {
    class: metric.in_range ? null : "bad",
    title: `${comparing ? `${metric.run.name}: ` : ""}${metric.id} = ${short(metric.value)}, band ${bandText(metric)}`,
  }));
  place.append(element("a", { href: "#metrics" }, element("strong", {}, sentence), reasons.join("; ")), element("div", { class: "ticks" }, ...ticks));
};

// Metrics -----------------------------------------------------------------------------------------------------------

const bandText = ({ lo: low, hi: high }) => {
  if (low !== null && low === high) return `= ${short(low)}`;
  if (low !== null && high !== null) return `${short(low)} … ${short(high)}`;
  if (low !== null) return `≥ ${short(low)}`;
  return high !== null ? `≤ ${short(high)}` : "";
};

/** The band as a bar, the value as a mark in it or beside it. */
const bullet = ({ value, lo: low, hi: high, in_range: ok }) => {
  if (low === null && high === null) return "";
  const known = [low, high].filter((end) => end !== null);
  const single = low === high;
  const width = known.length === 2 && !single ? high - low : Math.abs(known[0]) || 1;
  const [left, right] = single ? [low - width, high + width] : [low ?? high - width, high ?? low + width];
  const at = (number) => 26 + ((number - left) / (right - left)) * 80;
  const x = value === null ? null : Math.min(129, Math.max(3, at(value)));
  const [from, to] = single ? [64, 68] : [low === null ? 0 : 26, high === null ? 132 : 106];
  const ends = single ? [66] : [low === null ? [] : 26, high === null ? [] : 106].flat();
  const place = element("span");
  // Only numbers go into this text.
  place.innerHTML = `<svg class="bullet" viewBox="0 0 132 14" aria-hidden="true">
    <rect x="0" y="6.5" width="132" height="1" fill="var(--line)"/>
    <rect x="${from}" y="3" width="${to - from}" height="8" rx="2" fill="var(--band)"/>
    ${ends.map((end) => `<rect x="${end - 0.75}" y="1" width="1.5" height="12" fill="var(--soft)"/>`).join("")}
    ${x === null ? "" : `<circle cx="${x}" cy="7" r="4" fill="var(--${ok ? "good" : "bad"})"/>`}</svg>`;
  return place;
};

const verdictCell = (ok) => element("td", { class: ok === null ? "" : ok ? "good" : "bad" }, ok === null ? "" : ok ? "ok" : "missed");
const headRow = (...titles) => element("tr", {}, ...titles.map(([text, numeric]) => element("th", { class: numeric && "n" }, text)));

const metricsOfOne = (metrics) => {
  const row = (metric) => element("tr", {},
    element("td", {}, element("code", {}, metric.id)), element("td", { class: "n" }, short(metric.value)),
    element("td", {}, bullet(metric)), element("td", { class: "n" }, bandText(metric)),
    element("td", { class: "said" }, (metric.thesis ?? "").replace("<=", "≤").replace(">=", "≥")), verdictCell(metric.in_range));
  const table = (rows) => element("table", {}, element("thead", {}, headRow(["metric"], ["measured", 1], ["in its band"], ["band", 1], ["thesis"], [""])), element("tbody", {}, ...rows.map(row)));
  const half = Math.ceil(metrics.length / 2);
  // Sentences of the thesis need the whole width.
  const narrow = metrics.every((metric) => (metric.thesis ?? "").length <= 18);
  const parts = metrics.length > 14 && narrow ? [metrics.slice(0, half), metrics.slice(half)] : [metrics];
  return element("div", { class: "columns" }, ...parts.map(table));
};

const metricsOfMany = () => {
  const ids = [...new Set(runs.flatMap((run) => (run.metrics ?? []).map((metric) => metric.id)))];
  const titles = runs.flatMap((run, index) => [[run.name, 1], ...(index ? [["difference", 1], ["ratio", 1]] : [])]);
  const rows = ids.map((id) => {
    const found = runs.map((run) => (run.metrics ?? []).find((metric) => metric.id === id));
    const base = found[0]?.value ?? null;
    const cells = found.flatMap((metric, index) => {
      const value = metric?.value ?? null;
      const judged = metric && metric.in_range !== null ? (metric.in_range ? "n good" : "n bad") : "n";
      const cell = element("td", { class: judged, title: metric && bandText(metric) ? `band ${bandText(metric)}` : null }, short(value));
      if (!index) return [cell];
      const known = value !== null && base !== null;
      const ratio = known && value * base > 0 ? `× ${short(value / base)}` : "";
      return [cell, element("td", { class: "n" }, known ? short(value - base) : ""), element("td", { class: "n" }, ratio)];
    });
    return element("tr", {}, element("td", {}, element("code", {}, id)), ...cells);
  });
  return element("table", {}, element("thead", {}, headRow(["metric"], ...titles)), element("tbody", {}, ...rows));
};

const buildMetrics = () => {
  const place = byId("metrics");
  place.hidden = !runs.some((run) => run.metrics?.length);
  if (place.hidden) return;
  place.append(element("h2", {}, comparing ? "Metrics, and how they differ from the first run" : "Metrics and their bands"), comparing ? metricsOfMany() : metricsOfOne(runs[0].metrics));
};

const buildAssertions = () => {
  const place = byId("assertions");
  const rows = runs.flatMap((run) => (run.assertions ?? []).map((found) => element("tr", {},
    comparing ? element("td", {}, run.name) : "", element("td", {}, found.name), element("td", {}, element("code", {}, found.signal)),
    element("td", { class: "n" }, found.bound), element("td", {}, found.worst), element("td", { class: found.ok ? "good" : found.fails ? "bad" : "" }, found.word))));
  place.hidden = !rows.length;
  if (place.hidden) return;
  const head = [...(comparing ? [["run"]] : []), ["assertion"], ["signal"], ["bound", 1], ["worst"], [""]];
  place.append(element("h2", {}, "Assertions"), element("table", {}, element("thead", {}, headRow(...head)), element("tbody", {}, ...rows)));
};

const buildMore = () => {
  for (const run of runs) {
    const of = comparing ? ` of ${run.name}` : "";
    if (run.text) byId("more").append(element("details", { class: "card" }, element("summary", {}, `Scenario${of}, with all that was changed`), element("pre", {}, run.text)));
    const lines = run.channels.map(({ topic, fields }) => `${topic.padEnd(24)} ${fields.map(([name, length, unit]) => `${name}${length > 1 ? `[${length}]` : ""}${unit ? ` (${unit})` : ""}`).join("  ")}`);
    byId("more").append(element("details", { class: "card" }, element("summary", {}, `Signals in the log${of}`), element("pre", {}, lines.join("\n"))));
  }
  const widest = Math.max(...runs.map((run) => run.interval));
  const thinned = widest > 1 ? `Curves show the smallest and the largest value of every ${widest} samples, readings are those of the curve. ` : "";
  byId("footer").textContent = `${thinned}Written by phalanx ${report.version} from ${runs.map((run) => run.file).join(", ")}.`;
};

// Controls ----------------------------------------------------------------------------------------------------------

const fillSelect = (id, entries, chosen, onchange) => {
  byId(id).append(...entries.map(([value, text]) => element("option", { value, selected: value === chosen }, text)));
  byId(id).addEventListener("change", (event) => onchange(event.target.value));
};

const buildChips = () => {
  const numbers = runs.reduce((a, b) => (b.scene.agents.length > a.scene.agents.length ? b : a)).scene.agents.map((agent) => agent.number);
  byId("agents").append(...numbers.map((number, agent) => element("button", {
    type: "button", class: "chip", "aria-pressed": "false", title: "Single out this agent",
    onclick: () => setSolo(state.solo === agent ? null : agent),
    onpointerenter: () => setPointed(agent), onpointerleave: () => setPointed(null),
  }, element("i", { class: "dot", "data-hue": agent }), String(number))));
  if (!comparing) return;
  byId("runs-chips").append(...runs.map((run, index) => element("button", {
    type: "button", class: "chip", title: "Show or hide this run",
    onclick: (event) => {
      if (!state.hidden.delete(index)) state.hidden.add(index);
      event.currentTarget.classList.toggle("off", state.hidden.has(index));
      const scene = scenes.find((candidate) => candidate.run === run);
      if (scene) scene.card.hidden = state.hidden.has(index);
      redrawAll();
    },
  }, element("i", { class: `dash dash-${index % DASHES.length}`, "data-hue": index }), run.name)));
};

const paintChips = () => document.querySelectorAll("[data-hue]").forEach((dot) => { dot.style.color = hue(Number(dot.dataset.hue)); });

const buildControls = () => {
  const speeds = [0.1, 0.25, 0.5, 1, 2, 4, 8, 16];
  // A run should pass in about half a minute.
  state.speed = speeds.reduce((a, b) => (Math.abs(Math.log(b / (wholeTime / 25))) < Math.abs(Math.log(a / (wholeTime / 25))) ? b : a));
  fillSelect("speed", speeds.map((speed) => [speed, `${speed}×`]), state.speed, (value) => { state.speed = Number(value); });
  fillSelect("trails", [[Infinity, "all"], [wholeTime / 5, "long"], [wholeTime / 20, "short"], [0, "none"]], Infinity, (value) => { state.trail = Number(value); redrawScenes(); });
  const numbers = runs[0].scene.agents.map((agent, index) => [index, `agent ${agent.number}`]);
  fillSelect("follow", [["", "nobody"], ...numbers], "", (value) => {
    state.follow = value === "" ? null : Number(value);
    camera.shift = [0, 0];
    if (state.follow === null) camera.fitted = false;
    redrawScenes();
  });
  byId("scrub").max = lastTime;
  byId("scrub").addEventListener("input", (event) => {
    onleave();
    setTime(Number(event.target.value));
  });
  byId("play").addEventListener("click", () => setPlaying(!state.playing));
  for (const name of ["links", "targets"]) byId(name).addEventListener("change", (event) => { state[name] = event.target.checked; redrawScenes(); });
  byId("home").addEventListener("click", () => {
    Object.assign(camera, { azimuth: -0.65, elevation: 0.5, fitted: false, touched: false });
    redrawScenes();
  });
  const planar = scenes.every((scene) => scene.planar);
  const moving = planar ? "Drag to move, wheel to zoom" : "Drag to turn, shift and drag to move, wheel to zoom";
  const largest = comparing ? " Numbers below a plot are the largest of all agents, or those of the agent that is singled out." : "";
  byId("hint").textContent = `${moving}.${largest} In a plot: click for a time, drag to zoom, double-click for all. Space plays, arrows step.`;
  document.addEventListener("keydown", (event) => {
    if (event.target.closest("input, select, summary, a")) return;
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (step) onleave();
    if (step) setTime(state.time + (step * lastTime) / (event.shiftKey ? 20 : 400));
    else if (event.key === " ") setPlaying(!state.playing);
    else return;
    event.preventDefault();
  });
};

// Light and dark, size, print ----------------------------------------------------------------------------------------

let themeBefore;
const darkness = window.matchMedia("(prefers-color-scheme: dark)");
const setTheme = (theme) => {
  if (theme) document.documentElement.dataset.theme = theme;
  else delete document.documentElement.dataset.theme;
  readColours();
  paintChips();
  redrawAll();
};
const layOutScenes = () => {
  const shown = Math.max(1, scenes.length);
  const columns = shown > 1 ? 2 : 1;
  byId("scenes").style.gridTemplateColumns = `repeat(${columns}, minmax(0, 1fr))`;
  const room = Math.min(560, Math.max(300, window.innerHeight - 250));
  scenes.forEach((scene) => { scene.card.style.height = `${columns > 1 ? Math.max(210, room / Math.ceil(shown / 2)) : room}px`; });
};

const plots = panelIds.map((id) => new Plot(id));
buildHeading();
buildChips();
buildControls();
buildMetrics();
buildAssertions();
buildMore();
byId("scenes").append(...scenes.map((scene) => scene.card));
byId("plots").append(...plots.map((plot) => plot.card));
layOutScenes();
setTheme(null);
showTime();

byId("theme").addEventListener("click", () => {
  const dark = document.documentElement.dataset.theme ? document.documentElement.dataset.theme === "dark" : darkness.matches;
  setTheme(dark ? "light" : "dark");
});
darkness.addEventListener("change", () => setTheme(document.documentElement.dataset.theme));

const watcher = new IntersectionObserver((entries) => {
  for (const { target, isIntersecting } of entries) {
    if (isIntersecting) onScreen.add(target);
    else onScreen.delete(target);
  }
  plots.forEach((plot) => onScreen.has(plot.card) && plot.stale && plot.draw());
}, { rootMargin: "200px" });
plots.forEach((plot) => watcher.observe(plot.card));
new ResizeObserver(() => {
  layOutScenes();
  redrawAll();
}).observe(document.body);

window.addEventListener("beforeprint", () => {
  printing = true;
  document.documentElement.classList.add("printing");
  layOutScenes();
  themeBefore = document.documentElement.dataset.theme;
  setTheme("light");
});
window.addEventListener("afterprint", () => {
  printing = false;
  document.documentElement.classList.remove("printing");
  layOutScenes();
  setTheme(themeBefore);
});
