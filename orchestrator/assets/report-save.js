// A plot as a file: SVG and PNG as it is shown, in the colours of paper, and the numbers of its curves as CSV.

const SAVED_WIDTH = 760;
const SAVED_HEIGHT = 300;
/** Pixels of a PNG per pixel of the page. */
const SAVED_SCALE = 3;
const LEGEND_ROW = 18;

const escapeMarkup = (text) => text.replace(/[&<>"]/g, (letter) => `&#${letter.charCodeAt(0)};`);

/** Takes the orders of a canvas that charts give, and makes a drawing of vectors from them. */
class VectorContext {
  constructor() {
    Object.assign(this, { markup: "", path: "", transform: "", stack: [], dash: "", globalAlpha: 1, lineWidth: 1 });
  }

  beginPath() { this.path = ""; }
  moveTo(x, y) { this.path += `M${x.toFixed(2)} ${y.toFixed(2)}`; }
  lineTo(x, y) { this.path += `L${x.toFixed(2)} ${y.toFixed(2)}`; }
  rect(x, y, width, height) { this.box = [x, y, width, height]; }
  setLineDash(dash) { this.dash = dash.join(" "); }
  translate(x, y) { this.transform += `translate(${x} ${y})`; }
  rotate(angle) { this.transform += `rotate(${(angle * 180) / Math.PI})`; }

  save() { this.stack.push({ transform: this.transform, close: "" }); }
  restore() {
    const { transform, close } = this.stack.pop();
    this.markup += close;
    this.transform = transform;
  }

  /** A drawing within the drawing shows nothing beyond its edges. */
  clip() {
    const [x, y, width, height] = this.box;
    this.markup += `<g transform="${this.transform}"><svg x="${x}" y="${y}" width="${width}" height="${height}" viewBox="${this.box.join(" ")}">`;
    this.transform = "";
    this.stack.at(-1).close += "</svg></g>";
  }

  place() { return `${this.transform && ` transform="${this.transform}"`}${this.globalAlpha < 1 ? ` opacity="${this.globalAlpha.toFixed(2)}"` : ""}`; }

  stroke() {
    const dash = this.dash && ` stroke-dasharray="${this.dash}"`;
    this.markup += `<path d="${this.path}" fill="none" stroke="${this.strokeStyle}" stroke-width="${this.lineWidth}" stroke-linejoin="round"${dash}${this.place()}/>`;
  }

  fillRect(x, y, width, height) {
    this.markup += `<rect x="${x.toFixed(2)}" y="${y.toFixed(2)}" width="${width.toFixed(2)}" height="${height.toFixed(2)}" fill="${this.fillStyle}"${this.place()}/>`;
  }

  fillText(text, x, y) {
    const size = Number.parseFloat(/[\d.]+(?=px)/.exec(this.font)[0]);
    // Baselines by number: programs that read the file do not agree on their names.
    const down = size * ({ top: 0.82, middle: 0.34, bottom: -0.2 }[this.textBaseline] ?? 0);
    const anchor = { center: "middle", right: "end" }[this.textAlign] ?? "start";
    const weight = this.font.includes("bold") ? ` font-weight="bold"` : "";
    this.markup += `<text x="${x.toFixed(2)}" y="${(y + down).toFixed(2)}" font-size="${size}"${weight} text-anchor="${anchor}" fill="${this.fillStyle}"${this.place()}>${escapeMarkup(text)}</text>`;
  }

  /** The file. */
  text(width, height) {
    const holder = element("span");
    const family = escapeMarkup(FONT.slice(FONT.indexOf(" ") + 1));
    holder.innerHTML = `<svg width="${width}" height="${height}" viewBox="0 0 ${width} ${height}" font-family="${family}"><rect width="${width}" height="${height}" fill="#ffffff"/>${this.markup}</svg>`;
    return new XMLSerializer().serializeToString(holder.firstChild);
  }
}

/** What a curve is called among those of its run. */
const curveName = (curve) => {
  const agent = curve.agent === null ? "" : `agent ${runs[curve.run].scene.agents[curve.agent].number}`;
  return [agent, curve.label].filter(Boolean).join(" ");
};

/** Entries of the legend with their places: colour, dashes, name. */
const legendOf = (plot) => {
  if (plot.kind === "bands") return [];
  const measure = document.createElement("canvas").getContext("2d");
  measure.font = FONT;
  const names = comparing
    ? plot.entries.map(({ key, curves }) => ({ name: runs[key].name, curve: curves[0], dash: runDash(key) }))
    : plot.curves.map((curve) => ({ name: curveName(curve), curve, dash: curve.second ? [5, 3] : agentDash(curve.agent ?? 0) }));
  let [x, row] = [MARGIN.left, 0];
  return names.filter(({ name, curve }) => name && plot.shown(curve)).map((entry) => {
    const wide = 34 + measure.measureText(entry.name).width + 16;
    if (x + wide > SAVED_WIDTH && x > MARGIN.left) [x, row] = [MARGIN.left, row + 1];
    const placed = { ...entry, x, row };
    x += wide;
    return placed;
  });
};

/** Draws title, plot and legend by `make(width, height)`, which gives a context; returns that and the size. */
const drawForFile = (plot, make) => {
  const legend = legendOf(plot);
  const tall = plot.kind === "bands" ? plot.frame.clientHeight : SAVED_HEIGHT;
  const height = 52 + tall + (legend.length ? (legend.at(-1).row + 1) * LEGEND_ROW + 10 : 0);
  const context = make(SAVED_WIDTH, height);
  const theme = document.documentElement.dataset.theme;
  document.documentElement.dataset.theme = "light";
  readColours();
  const first = runs[0];
  Object.assign(context, { font: FONT.replace("12px", "bold 14px"), fillStyle: colours.ink, textAlign: "left", textBaseline: "top" });
  context.fillText(plot.names.length > 1 ? `${plot.title}: ${plot.name}` : plot.title, 14, 10);
  Object.assign(context, { font: FONT, fillStyle: colours.soft });
  const changes = comparing ? [] : first.overrides;
  context.fillText([first.scenario || first.file, comparing ? "" : first.variant, ...changes].filter(Boolean).join(" · "), 14, 29);
  context.save();
  context.translate(0, 48);
  plot.paint(context, SAVED_WIDTH, tall);
  for (const { x, row, curve, dash, name } of legend) {
    const y = tall + 14 + row * LEGEND_ROW;
    Object.assign(context, { strokeStyle: plot.colour(curve), lineWidth: 2, globalAlpha: 1 });
    context.setLineDash(dash);
    context.beginPath();
    context.moveTo(x, y);
    context.lineTo(x + 26, y);
    context.stroke();
    context.setLineDash([]);
    Object.assign(context, { fillStyle: colours.ink, textAlign: "left", textBaseline: "middle" });
    context.fillText(name, x + 32, y);
  }
  context.restore();
  if (theme) document.documentElement.dataset.theme = theme;
  else delete document.documentElement.dataset.theme;
  readColours();
  plot.draw();
  return { context, height };
};

const asSvg = (plot) => {
  const { context, height } = drawForFile(plot, () => new VectorContext());
  return new Blob([context.text(SAVED_WIDTH, height)], { type: "image/svg+xml" });
};

const asPng = (plot) => {
  const canvas = document.createElement("canvas");
  drawForFile(plot, (width, height) => {
    Object.assign(canvas, { width: width * SAVED_SCALE, height: height * SAVED_SCALE });
    const context = canvas.getContext("2d");
    context.scale(SAVED_SCALE, SAVED_SCALE);
    context.fillStyle = "#ffffff";
    context.fillRect(0, 0, width, height);
    return context;
  });
  return new Promise((done) => canvas.toBlob(done, "image/png"));
};

/** The shortest decimal number that is this number of 32 bits. */
const exactly = (value) => {
  if (!Number.isFinite(value)) return "";
  for (let digits = 6; digits < 9; digits += 1) if (Math.fround(value.toPrecision(digits)) === value) return String(Number(value.toPrecision(digits)));
  return String(Number(value.toPrecision(9)));
};

/** The curves of the plot within the time that it shows: a line for each point; with several runs, each in its turn. */
const asCsv = (plot) => {
  const cell = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
  const view = plot.views.find(Boolean);
  const nameOf = (curve) => curveName(curve) || view.axis;
  const names = [...new Set(plot.curves.map(nameOf))];
  const unit = unitText(view.unit);
  const head = [...(comparing ? ["run"] : []), "t [s]", ...names.map((name) => (unit ? `${name} [${unit}]` : name))];
  const lines = [head.map(cell).join(",")];
  runs.forEach((run, index) => {
    const own = names.map((name) => plot.curves.find((curve) => curve.run === index && nameOf(curve) === name));
    if (!own.some(Boolean)) return;
    for (const curve of own) if (curve) curve.values = valuesOf(curve.source);
    const [first, last] = plot.window(index);
    for (let k = first; k <= last; k += 1)
      lines.push([...(comparing ? [cell(run.name)] : []), exactly(run.time[k]), ...own.map((curve) => (curve ? exactly(curve.values[k]) : ""))].join(","));
  });
  return new Blob([lines.join("\n"), "\n"], { type: "text/csv" });
};

const slug = (text) => text.toLowerCase().replace(/[^a-z0-9]+/g, "-").replace(/^-|-$/g, "");

/** The menu of a plot. */
const saveMenu = (plot) => {
  const save = async (ending, make) => {
    menu.open = false;
    const stem = comparing ? `${runs[0].scenario || "runs"}-comparison` : runs[0].file.replace(/\.mcap$/, "");
    const view = plot.names.length > 1 ? `-${slug(plot.name)}` : "";
    const address = URL.createObjectURL(await make(plot));
    element("a", { href: address, download: `${stem}-${plot.id}${view}.${ending}` }).click();
    setTimeout(() => URL.revokeObjectURL(address), 10_000);
  };
  const entry = (ending, what, make) => element("button", { type: "button", onclick: () => save(ending, make) }, element("b", {}, ending.toUpperCase()), ` ${what}`);
  const menu = element("details", { class: "menu" }, element("summary", { title: "Save this plot" }, "save"),
    element("div", {}, entry("svg", "vectors", asSvg), entry("png", "pixels", asPng), entry("csv", "numbers", asCsv)));
  return menu;
};
// A menu closes when something else is used.
document.addEventListener("click", ({ target }) => document.querySelectorAll("details.menu[open]").forEach((menu) => { if (!menu.contains(target)) menu.open = false; }));
