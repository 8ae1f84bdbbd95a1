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
  if (state.playing && !playing) rememberTime();
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

// Size and paper ------------------------------------------------------------------------------------------------------

const layOutScenes = () => {
  const width = byId("scenes").clientWidth;
  if (!width) return;
  const shown = scenes.filter((scene) => !scene.card.hidden);
  const room = Math.min(560, Math.max(300, window.innerHeight - 250));
  // Beside or above each other, whichever shows the formation larger; on a small screen above each other.
  const choices = [1, 2].filter((columns) => columns === 1 || (shown.length > 1 && width > 520)).map((columns) => {
    const rows = Math.max(1, Math.ceil(shown.length / columns));
    const height = width > 520 ? Math.max(230, room / rows) : Math.min(room, Math.max(260, width));
    return { columns, height, scale: Math.min(...shown.map((scene) => scene.fit(width / columns, height))) };
  });
  const { columns, height, scale } = choices.reduce((a, b) => (b.scale > a.scale * 1.02 ? b : a));
  byId("scenes").style.gridTemplateColumns = `repeat(${columns}, minmax(0, 1fr))`;
  // No higher than what it shows, if there are several.
  const needed = Math.max(0, ...shown.map((scene) => scene.heightAt(scale)));
  const high = shown.length > 1 ? Math.min(height, Math.max(230, needed)) : height;
  shown.forEach((scene) => { scene.card.style.height = `${high}px`; });
  if (!camera.touched && state.follow === null) camera.fitted = false;
};

const plots = panelIds.map((id) => new Plot(id));
buildHeading();
buildChips();
buildControls();
buildMetrics();
buildAssertions();
buildTraffic();
buildMore();
document.querySelector("main").classList.toggle("comparing", comparing);
byId("scenes").append(...scenes.map((scene) => scene.card));
// Agents without a position have no scene, and need nothing to look at it with.
if (!scenes.length) for (const id of ["home", "scenes", "view"]) byId(id).hidden = true;
byId("plots").append(...plots.map((plot) => plot.card));
buildHelp();
listenToKeys();
layOutScenes();
setTheme(remembered.get("theme"));
showTime();
openAddress();

byId("theme").addEventListener("click", toggleTheme);
window.addEventListener("hashchange", openAddress);
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
  layOutTables();
  redrawAll();
}).observe(document.body);

let themeBefore;
window.addEventListener("beforeprint", () => {
  printing = true;
  document.documentElement.classList.add("printing");
  layOutScenes();
  layOutTables();
  themeBefore = document.documentElement.dataset.theme;
  setTheme("light");
});
window.addEventListener("afterprint", () => {
  printing = false;
  document.documentElement.classList.remove("printing");
  layOutScenes();
  layOutTables();
  setTheme(themeBefore);
});
