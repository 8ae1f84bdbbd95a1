// The controls below the scene: time, speed, agents, runs, what is shown.

const fillSelect = (id, entries, chosen, onchange) => {
  byId(id).append(...entries.map(([value, text]) => element("option", { value, selected: value === chosen }, text)));
  byId(id).addEventListener("change", (event) => onchange(event.target.value));
};

const buildChips = () => {
  byId("agents").append(...agentNumbers().map((number, agent) => element("button", {
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
      layOutScenes();
      redrawAll();
    },
  }, element("i", { class: `dash dash-${index % DASHES.length}`, "data-hue": index }), run.name)));
};

const paintChips = () => document.querySelectorAll("[data-hue]").forEach((dot) => { dot.style.color = hue(Number(dot.dataset.hue)); });

const resetView = () => {
  Object.assign(camera, { azimuth: -0.65, elevation: 0.5, fitted: false, touched: false });
  redrawScenes();
};

const buildControls = () => {
  const speeds = [0.1, 0.25, 0.5, 1, 2, 4, 8, 16];
  // A run should pass in about half a minute.
  state.speed = speeds.reduce((a, b) => (Math.abs(Math.log(b / (wholeTime / 25))) < Math.abs(Math.log(a / (wholeTime / 25))) ? b : a));
  fillSelect("speed", speeds.map((speed) => [speed, `${speed}×`]), state.speed, (value) => { state.speed = Number(value); });
  fillSelect("trails", [[Infinity, "all"], [wholeTime / 5, "long"], [wholeTime / 20, "short"], [0, "none"]], Infinity, (value) => { state.trail = Number(value); redrawScenes(); });
  const numbers = runs[0].scene.agents.map((agent, index) => [index, `agent ${agent.number}`]);
  fillSelect("follow", [["", "no agent"], ...numbers], "", (value) => {
    state.follow = value === "" ? null : Number(value);
    camera.shift = [0, 0];
    if (state.follow === null) camera.fitted = false;
    redrawScenes();
  });
  byId("scrub").max = lastTime;
  byId("scrub").addEventListener("input", (event) => goTo(Number(event.target.value)));
  byId("play").addEventListener("click", () => setPlaying(!state.playing));
  for (const name of ["links", "targets"]) byId(name).addEventListener("change", (event) => { state[name] = event.target.checked; redrawScenes(); });
  byId("home").addEventListener("click", resetView);
  const planar = scenes.every((scene) => scene.planar);
  const touched = window.matchMedia("(pointer: coarse)").matches;
  const moving = touched ? (planar ? "Drag sideways to move" : "Drag sideways to turn") : planar ? "Drag to move, wheel to zoom" : "Drag to turn, shift and drag to move, wheel to zoom";
  const largest = comparing ? " Numbers below a plot are the largest of all agents, or those of the agent that is singled out." : "";
  const keys = touched ? "" : " Space plays, arrows step, ? shows all keys.";
  byId("hint").textContent = `${scenes.length ? `${moving}.` : ""}${largest} In a plot: click for a time, drag to zoom, double-click for all.${keys}`;
};
