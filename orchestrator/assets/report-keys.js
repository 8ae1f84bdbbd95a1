// Keys, the address of a time, and light or dark.

/** Keys in the order of the help; `act` gets the event. Those without an action are told in words only. */
const KEYS = [
  { keys: [" "], name: "Space", what: "play, pause", act: () => setPlaying(!state.playing) },
  { keys: ["ArrowLeft", "ArrowRight"], name: "← →", what: "a step back or on; with Shift a larger one", act: (event) => goTo(state.time + ((event.key === "ArrowLeft" ? -1 : 1) * lastTime) / (event.shiftKey ? 20 : 400)) },
  { keys: ["Home"], name: "Home", what: "to the start", act: () => goTo(0) },
  { keys: ["End"], name: "End", what: "to the end", act: () => goToEnd() },
  { keys: ["l"], name: "L", what: "logarithmic or linear scale: of the plot below the pointer, else of all", act: () => toggleScales() },
  { keys: [..."123456789"], name: "1 … 9", what: "single out the agent of this number; again: all", act: (event) => singleOut(Number(event.key)) },
  { keys: ["a", "A"], name: "A", what: "single out the next agent; with Shift the one before", act: (event) => singleOutNext(event.shiftKey ? -1 : 1) },
  { keys: ["0", "Escape"], name: "0, Esc", what: "all agents", act: () => setSolo(null) },
  { keys: ["z"], name: "Z", what: "plots over the whole time", act: () => setSpan(null) },
  { keys: ["v"], name: "V", what: "reset the view of the formation", act: () => resetView() },
  { keys: ["t"], name: "T", what: "light or dark", act: () => toggleTheme() },
  { keys: ["c"], name: "C", what: "copy a link to this time", act: () => copyLink() },
  { keys: ["?"], name: "?", what: "show and hide this list", act: () => toggleHelp() },
];

/** What the End key does; a run that is going on is followed again. */
let goToEnd = () => goTo(lastTime);

const goTo = (time) => {
  onleave();
  setTime(time);
  rememberTime();
};

const toggleScales = () => {
  const below = plots.find((plot) => plot.card.matches(":hover"));
  if (below) return below.toggleScale();
  const lines = plots.filter((plot) => plot.kind === "lines");
  const logarithmic = !lines.some((plot) => plot.logarithmic);
  lines.forEach((plot) => plot.toggleScale(logarithmic));
};

const agentNumbers = () => runs.reduce((a, b) => (b.scene.agents.length > a.scene.agents.length ? b : a)).scene.agents.map((agent) => agent.number);

const singleOut = (number) => {
  const agent = agentNumbers().indexOf(number);
  if (agent >= 0) setSolo(state.solo === agent ? null : agent);
};

const singleOutNext = (step) => {
  const first = step > 0 ? 0 : agentCount - 1;
  const next = state.solo === null ? first : state.solo + step;
  setSolo(next < 0 || next >= agentCount ? null : next);
};

const toggleHelp = () => {
  const help = byId("help");
  if (help.open) help.close();
  else help.showModal();
};

const buildHelp = () => {
  const help = byId("help");
  const rows = KEYS.map(({ name, what }) => element("tr", {}, element("td", {}, element("kbd", {}, name)), element("td", {}, what)));
  help.append(element("h2", {}, "Keys"), element("table", {}, ...rows), element("button", { type: "button", class: "quiet", onclick: toggleHelp }, "close"));
  // A click beside it closes it, too.
  help.addEventListener("click", (event) => { if (event.target === help) help.close(); });
  byId("help-button").addEventListener("click", toggleHelp);
};

/** Whether the focus was moved by the Tab key: then the keys of the focused control are meant. */
let tabbed = false;

const listenToKeys = () => {
  let byTab = false;
  document.addEventListener("pointerdown", () => { byTab = false; }, true);
  document.addEventListener("focusin", () => { tabbed = byTab; });
  // A list that was opened with the mouse has the focus until something is chosen.
  document.addEventListener("change", ({ target }) => { if (!tabbed) target.blur(); });
  document.addEventListener("keydown", (event) => {
    byTab = event.key === "Tab";
    const { target } = event;
    if (event.ctrlKey || event.metaKey || event.altKey || (byId("help").open && event.key !== "?")) return;
    const control = target.closest("button, select, summary, a, input:not([type=range])");
    const moves = ["ArrowLeft", "ArrowRight", "Home", "End"].includes(event.key);
    if (control && tabbed && (event.key === " " || (moves && control.tagName === "SELECT"))) return;
    if (target.tagName === "SELECT" && event.key !== " ") return;
    const entry = KEYS.find(({ keys }) => keys.includes(event.key) || keys.includes(event.key.toLowerCase()));
    if (!entry || (event.repeat && !moves)) return;
    if (control && !tabbed) control.blur();
    event.preventDefault();
    entry.act(event);
  });
};

// Links to a time -----------------------------------------------------------------------------------------------------

/** `#t=12.5`. */
const timeOfAddress = () => {
  const time = Number.parseFloat(new URLSearchParams(location.hash.slice(1)).get("t"));
  return Number.isFinite(time) ? time : null;
};
const addressOfTime = () => `#t=${Number(state.time.toFixed(lastTime < 1 ? 5 : 3))}`;

/** The address follows the time, once that stands still for a moment. */
let remembering = null;
const rememberTime = () => {
  clearTimeout(remembering);
  remembering = setTimeout(() => {
    try {
      if (!state.playing) history.replaceState(null, "", addressOfTime());
    } catch {
      // Some browsers do not change the address of a file.
    }
  }, 250);
};

const openAddress = () => {
  const time = timeOfAddress();
  if (time === null) return;
  onleave();
  setPlaying(false);
  setTime(time);
};

const copyLink = async () => {
  const link = location.href.split("#")[0] + addressOfTime();
  let copied = true;
  try {
    await navigator.clipboard.writeText(link);
  } catch {
    const text = element("textarea", { class: "unseen" }, link);
    document.body.append(text);
    text.select();
    copied = document.execCommand("copy");
    text.remove();
  }
  say(copied ? `Link to t = ${short(state.time)} s copied` : link);
};

/** A message at the edge of the page for a moment. */
let silence = null;
const say = (text) => {
  byId("said").textContent = text;
  byId("said").hidden = false;
  clearTimeout(silence);
  silence = setTimeout(() => { byId("said").hidden = true; }, 2500);
};

// Light and dark ------------------------------------------------------------------------------------------------------

const darkness = window.matchMedia("(prefers-color-scheme: dark)");

const setTheme = (theme) => {
  if (theme) document.documentElement.dataset.theme = theme;
  else delete document.documentElement.dataset.theme;
  readColours();
  paintChips();
  redrawAll();
};

/** The other one; it is remembered as long as it is not that of the system. */
const toggleTheme = () => {
  const dark = document.documentElement.dataset.theme ? document.documentElement.dataset.theme === "dark" : darkness.matches;
  const theme = dark ? "light" : "dark";
  const usual = darkness.matches ? "dark" : "light";
  remembered.set("theme", theme === usual ? null : theme);
  setTheme(theme);
};
