// One panel of the page: its card with controls, a canvas for the curves and one above it for cursor and dots.

/** Drawn below the pointer: cursor and dots of all plots on the screen, once before the next frame. */
let hovering = false;
const setHover = (time) => {
  state.hover = time;
  if (hovering) return;
  hovering = true;
  requestAnimationFrame(() => {
    hovering = false;
    plots.forEach((plot) => onScreen.has(plot.card) && plot.drawTop(true));
  });
};

class Plot extends Chart {
  constructor(id) {
    super();
    this.id = id;
    this.panels = runs.map((run) => run.panels.find((panel) => panel.id === id));
    const first = this.panels.find(Boolean);
    this.kind = first.kind;
    this.names = [...new Set(this.panels.flatMap((panel) => panel?.views.map((view) => view.name) ?? []))];
    this.readAt = 0;
    this.base = element("canvas", { role: "img", "aria-label": first.title });
    this.top = element("canvas");
    this.frame = element("div", { class: "frame" }, this.base, this.top);
    this.readings = element("div", { class: "readings" });
    this.scaleButton = element("button", { type: "button", class: "quiet", onclick: () => this.toggleScale() });
    this.rangeButton = element("button", { type: "button", class: "quiet", hidden: true, onclick: () => this.toggleRange() });
    this.title = first.title;
    this.card = element("section", { class: "card plot", id: `plot-${id}` },
      element("header", {}, element("h2", {}, first.title), element("span", { class: "space" }), this.chooser(), this.scaleButton, this.rangeButton, saveMenu(this)),
      this.frame, this.readings);
    this.choose(this.names[0]);
    this.listen();
  }

  /** Buttons for a few views, a list for many. */
  chooser() {
    if (this.names.length < 2) return null;
    const short = this.names.length <= 4 && this.names.join("").length < 34;
    if (!short) {
      const options = this.names.map((name) => element("option", {}, name));
      return element("select", { "aria-label": "What is shown", onchange: (event) => this.choose(event.target.value) }, ...options);
    }
    const tab = (name) => element("button", { type: "button", onclick: () => this.choose(name) }, name);
    this.tabs = this.names.map(tab);
    return element("span", { class: "tabs" }, ...this.tabs);
  }

  choose(name) {
    this.name = name;
    this.views = this.panels.map((panel) => panel?.views.find((view) => view.name === name));
    const view = this.views.find(Boolean);
    this.logarithmic = view.logarithmic;
    this.whole = false;
    this.magnitude = view.logarithmic || view.axis === "norm";
    this.axis = `${view.axis}${view.unit ? ` [${unitText(view.unit)}]` : ""}`;
    this.tabs?.forEach((tab) => tab.setAttribute("aria-pressed", tab.textContent === name));
    this.curves = this.views.flatMap((view, run) => (view?.curves ?? []).map((curve) => ({ ...curve, run, source: curve, values: null })));
    const rows = Math.max(1, this.curves.length);
    this.frame.style.height = `${this.kind === "bands" ? MARGIN.top + MARGIN.bottom + rows * ROW_HEIGHT : LINES_HEIGHT}px`;
    this.labelScale();
    this.list();
    this.draw();
  }

  toggleScale(logarithmic = !this.logarithmic) {
    if (this.kind === "bands") return;
    this.logarithmic = logarithmic;
    this.labelScale();
    this.draw();
  }

  toggleRange() {
    this.whole = !this.whole;
    this.draw();
  }

  labelScale() {
    this.scaleButton.textContent = this.logarithmic ? "log" : "linear";
    this.scaleButton.title = "Logarithmic or linear scale (key L)";
    this.scaleButton.hidden = this.kind === "bands";
  }

  listen() {
    const time = (event) => this.timeAt(event.offsetX);
    this.top.addEventListener("pointerdown", (event) => {
      this.drag = { from: event.offsetX, to: event.offsetX };
      this.top.setPointerCapture(event.pointerId);
    });
    this.top.addEventListener("pointermove", (event) => {
      if (this.drag) this.drag.to = event.offsetX;
      setHover(time(event));
    });
    this.top.addEventListener("pointerup", (event) => {
      const drag = this.drag;
      this.drag = null;
      if (!drag) return;
      const ends = [this.timeAt(drag.from), time(event)].sort((a, b) => a - b);
      if (Math.abs(event.offsetX - drag.from) > 6) setSpan(ends);
      else goTo(ends[0]);
    });
    // The finger scrolls the page.
    this.top.addEventListener("pointercancel", () => {
      this.drag = null;
      setHover(null);
    });
    this.top.addEventListener("pointerleave", () => setHover(null));
    this.top.addEventListener("dblclick", () => setSpan(null));
  }

  draw() {
    // A plot out of sight is drawn when it comes into sight.
    this.stale = !this.base.clientWidth || !(onScreen.has(this.card) || printing);
    if (this.stale) return;
    const { context, width, height } = fitCanvas(this.base);
    this.paint(context, width, height);
    if (printing) this.drawCursor(context);
    this.drawTop(true);
  }

  /** Curves that belong together in the list below the plot: one entry per agent, or per run if there are several. */
  list() {
    const groups = new Map();
    for (const curve of this.curves) {
      const key = comparing ? curve.run : curve.agent ?? -1;
      groups.set(key, [...(groups.get(key) ?? []), curve]);
    }
    this.entries = [...groups].map(([key, curves]) => {
      const value = element("b", {}, "");
      const dot = element("i", { class: comparing ? `dash dash-${key % DASHES.length}` : "dot" });
      const name = comparing ? runs[key].name : key < 0 ? curves[0].label : String(runs[0].scene.agents[key].number);
      const node = element("span", { title: comparing || key < 0 ? null : "Click to single out this agent" }, dot, name, value);
      if (!comparing && key >= 0) {
        node.addEventListener("click", () => setSolo(state.solo === key ? null : key));
        node.addEventListener("pointerenter", () => setPointed(key));
        node.addEventListener("pointerleave", () => setPointed(null));
      }
      return { key, curves, value, dot, node };
    });
    const second = this.curves.find((curve) => curve.second);
    const key = second ? [element("em", {}, `solid: ${this.curves[0].label}, dashed: ${second.label}`)] : [];
    if (comparing && this.magnitude && this.kind === "lines") key.unshift(element("em", {}, "bold: the largest of all agents"));
    const listed = this.kind === "bands" || this.entries.length > 12 ? [] : this.entries.map((entry) => entry.node);
    this.readings.replaceChildren(...listed, ...key);
  }

  /** What a list entry reads at an instant. */
  reading(entry, time) {
    const at = (curve) => (time > runs[curve.run].end ? NaN : curve.values[indexAt(runs[curve.run].time, time)]);
    const chosen = state.pointed ?? state.solo;
    if (!comparing || chosen !== null) {
      const curves = comparing ? entry.curves.filter((curve) => curve.agent === chosen || curve.agent === null) : entry.curves;
      return curves.map((curve) => short(at(curve))).join(" | ");
    }
    const largest = Math.max(...entry.curves.filter((curve) => !curve.second).map((curve) => Math.abs(at(curve))));
    return short(largest);
  }

  /** Cursor, dots and numbers. The numbers change ten times a second at most, so that one can read them. */
  drawTop(now = false) {
    if (this.stale || !this.base.clientWidth) return;
    const { context } = fitCanvas(this.top);
    context.font = FONT;
    const bottom = this.height - MARGIN.bottom;
    if (this.drag && Math.abs(this.drag.to - this.drag.from) > 6) {
      context.fillStyle = colours.accent;
      context.globalAlpha = 0.15;
      context.fillRect(Math.min(this.drag.from, this.drag.to), MARGIN.top, Math.abs(this.drag.to - this.drag.from), bottom - MARGIN.top);
      context.globalAlpha = 1;
    }
    this.drawCursor(context);
    if (state.hover !== null && this.inside(state.hover)) this.drawHover(context, bottom);
    const time = state.hover ?? state.time;
    if (this.kind === "lines" && this.inside(time)) this.drawDots(context, time);
    if (now || performance.now() - this.readAt > 100) this.read(time);
  }

  inside(time) {
    return time >= (state.span?.[0] ?? 0) && time <= (state.span?.[1] ?? lastTime) + 1e-9;
  }

  drawCursor(context) {
    const cursor = Math.round(this.x(state.time)) + 0.5;
    if (this.inside(state.time)) this.rule(context, cursor, MARGIN.top, cursor, this.height - MARGIN.bottom, colours.accent);
  }

  /** The time below the pointer, of whichever plot; the number stands in that one. */
  drawHover(context, bottom) {
    const x = this.x(state.hover);
    context.setLineDash([2, 3]);
    this.rule(context, x, MARGIN.top, x, bottom, colours.soft);
    context.setLineDash([]);
    if (!this.top.matches(":hover")) return;
    const text = `${state.hover.toFixed(lastTime < 1 ? 4 : 2)} s`;
    const left = x > this.width / 2;
    const wide = context.measureText(text).width;
    context.fillStyle = colours.card;
    context.fillRect(left ? x - wide - 8 : x + 4, MARGIN.top, wide + 4, 15);
    context.fillStyle = colours.ink;
    context.textAlign = left ? "right" : "left";
    context.textBaseline = "top";
    context.fillText(text, left ? x - 6 : x + 6, MARGIN.top + 1);
  }

  drawDots(context, time) {
    for (const curve of this.curves) {
      if (!this.shown(curve) || this.weight(curve) < 1 || (comparing && state.solo === null) || time > runs[curve.run].end) continue;
      const value = curve.values[indexAt(runs[curve.run].time, time)];
      if (!(value >= this.range[0] && value <= this.range[1])) continue;
      context.beginPath();
      context.arc(this.x(time), this.y(value), 3, 0, 2 * Math.PI);
      context.fillStyle = this.colour(curve);
      context.fill();
      context.strokeStyle = colours.card;
      context.stroke();
    }
  }

  read(time) {
    this.readAt = performance.now();
    for (const entry of this.entries) {
      entry.value.textContent = this.reading(entry, time);
      entry.dot.style.color = this.colour(entry.curves[0]);
      entry.node.classList.toggle("faint", this.weight(entry.curves[0]) < 1 && !comparing);
      entry.node.hidden = !this.shown(entry.curves[0]);
    }
  }
}
