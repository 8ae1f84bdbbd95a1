// The page of a run that is going on: it grows with every frame that its server sends.

const live = { following: true, over: false, sceneAt: 0, plotsAt: 0, box: "", spacing: 0 };
/** Least time between two pictures, ms; more on a slow machine, since the run needs its processor too. */
const SCENE_EVERY = 50;
const PLOTS_EVERY = 500;
const isDue = (since, least) => performance.now() - since >= Math.max(least, 5 * drawingTime);
/** Points of a curve from which on every second one is dropped. */
const MOST_POINTS = 4000;

/** A list of numbers in `holder[name]` that can grow, `width` of them at a time. */
const growing = (holder, name, width) => {
  let length = holder[name].length;
  let room = new Float32Array(Math.max(2048 * width, 2 * length));
  room.set(holder[name]);
  const show = () => { holder[name] = room.subarray(0, length); };
  show();
  return {
    width,
    push(values) {
      if (length + width > room.length) {
        const larger = new Float32Array(2 * room.length);
        larger.set(room);
        room = larger;
      }
      room.set(values, length);
      length += width;
      show();
    },
    replaceLast(values) { room.set(values, length - width); },
    thin() {
      const rows = length / width;
      let kept = 0;
      for (let row = (rows - 1) % 2; row < rows; row += 2, kept += 1) room.copyWithin(kept * width, row * width, (row + 1) * width);
      length = kept * width;
      show();
    },
  };
};

const [run] = runs;
const clockRow = growing(run, "time", 1);
const curvesOf = run.panels.flatMap((panel) => panel.views.flatMap((view) => view.curves));
for (const curve of curvesOf) valuesOf(curve);
// In the order in which a frame has them.
const rows = [
  ...run.scene.agents.flatMap((agent) =>
    ["position", "tracked", "desired"].filter((name) => agent[name]).map((name) => growing(agent[name], "values", agent[name].width))),
  ...curvesOf.map((curve) => growing(curve, "values", 1)),
];
for (const link of run.scene.links) link.spans = [...link.spans];

const growLinks = (pairs, time, before) => {
  for (const [from, to] of pairs) {
    let link = run.scene.links.find((known) => known.from === from && known.to === to);
    if (!link) run.scene.links.push((link = { from, to, spans: [] }));
    const last = link.spans.length - 1;
    if (last > 0 && link.spans[last] >= before - 1e-6) link.spans[last] = time;
    else link.spans.push(time, time);
  }
};

/** The box of the scene follows the run, as long as the camera was not moved. */
const refit = () => {
  for (const scene of scenes) {
    scene.measure();
    const box = JSON.stringify([scene.low, scene.high]);
    if (box !== live.box && !camera.touched && state.follow === null) camera.fitted = false;
    live.box = box;
  }
};

const takeFrame = ({ time, values, links }) => {
  const before = run.end;
  if (time <= before) return;
  const numbers = unpack(values);
  // Points are spread evenly over the time: one that is close to the last but one takes the place of the last one.
  const count = run.time.length;
  const add = count > 1 && run.time[count - 1] - run.time[count - 2] < live.spacing ? "replaceLast" : "push";
  let at = 0;
  for (const row of rows) {
    row[add](numbers.subarray(at, at + row.width));
    at += row.width;
  }
  clockRow[add]([time]);
  if (run.time.length > MOST_POINTS) {
    [clockRow, ...rows].forEach((row) => row.thin());
    live.spacing = (2 * (time - run.time[0])) / MOST_POINTS;
  }
  growLinks(links, time, before);
  run.end = lastTime = time;
  byId("scrub").max = time;
  if (isDue(live.plotsAt, PLOTS_EVERY)) {
    live.plotsAt = performance.now();
    refit();
    redraw("plots");
  }
  if (live.following && isDue(live.sceneAt, SCENE_EVERY)) {
    live.sceneAt = performance.now();
    showNow();
  }
};

const showNow = () => {
  state.time = lastTime;
  byId("scrub").value = lastTime;
  byId("clock").replaceChildren(`${lastTime.toFixed(2)} s `, element("small", {}, `of ${short(wholeTime)}`));
  redraw("scenes");
};

// Where the run stands, and the way back to it ----------------------------------------------------------------------

const lamp = element("button", { type: "button", class: "chip live", title: "Follow the run", onclick: () => follow(true) }, element("i", { class: "dot" }), element("span", {}, "live"));
const news = element("span", { class: "facts" });
byId("play").before(lamp);
byId("facts").after(element("p", { class: "facts" }, news));
const since = report.live.no_past ? ` · curves from t = ${run.time[0].toFixed(2)} s on, since ${report.live.no_past}` : "";
byId("facts").textContent = `${run.scene.agents.length} agents · ${short(wholeTime)} s · steps of ${short(run.dt)} s${since}`;
byId("footer").textContent = `Shown by phalanx ${report.version} while it runs; what is between two frames is only in the log.`;

const follow = (following) => {
  live.following = following && !live.over;
  lamp.setAttribute("aria-pressed", String(live.following));
  if (live.following) {
    setPlaying(false);
    showNow();
  }
};
onleave = () => follow(false);
goToEnd = () => follow(true);
follow(timeOfAddress() === null);

const source = new EventSource("events");
source.addEventListener("frame", (event) => takeFrame(JSON.parse(event.data)));
source.addEventListener("status", (event) => { news.textContent = JSON.parse(event.data).text; });
source.addEventListener("over", (event) => {
  source.close();
  const { text, frame } = JSON.parse(event.data);
  if (frame) takeFrame(frame);
  live.over = true;
  lamp.lastChild.textContent = "over";
  lamp.disabled = true;
  news.textContent = text;
  document.documentElement.dataset.over = "";
  refit();
  redrawAll();
  if (live.following) state.time = lastTime;
  showTime();
});
source.addEventListener("error", () => {
  if (source.readyState !== EventSource.CLOSED) news.textContent = "The connection is gone; trying again.";
});
