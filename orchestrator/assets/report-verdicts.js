// Metrics with their verdicts, and assertions, as tables; where a table does not fit, every row is a card.

for (const run of runs)
  run.metrics = run.metrics?.map((metric) => ({ ...metric, low: metric.lo, high: metric.hi, ok: metric.in_range }));

/** Relations as one writes them, on one line. */
const relation = (text) => text.replaceAll("<=", "≤").replaceAll(">=", "≥").replace(/([≤≥<>=]) /g, "$1\u00a0").replace(/(\de|[\s≤≥<>=(]|^)-(\d)/g, "$1−$2");

const rangeText = ({ low, high }) => {
  if (low !== null && low === high) return `= ${short(low)}`;
  if (low !== null && high !== null) return `${short(low)} … ${short(high)}`;
  if (low !== null) return `≥ ${short(low)}`;
  return high !== null ? `≤ ${short(high)}` : "";
};

/** The range as a bar, the value as a mark in it or beside it. */
const bullet = ({ value, low, high, ok }) => {
  if (low === null && high === null) return null;
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

/** What the thesis says: a short text stays on its line. */
const saidKind = (text) => (text.length > 20 ? "said" : "short");
/** A cell with its heading, which a card shows beside it. */
const cell = (label, kind, ...children) => element("td", { class: kind || null, "data-label": label }, ...children);
const headRow = (titles) => element("thead", {}, element("tr", {}, ...titles.map(([text, kind]) => element("th", { class: kind ?? null }, text))));
const table = (head, rows, kind = null) => element("table", { class: kind }, head, element("tbody", {}, ...rows.flat()));

/** The name of a metric with its symbol; what it means unfolds below, with its formula where that is long. */
const metricName = ({ id, symbol, description }) => {
  const isLong = (symbol ?? "").length > 32;
  const name = [element("code", {}, id), symbol && !isLong ? element("span", { class: "symbol" }, symbol) : null].filter(Boolean);
  const meaning = [isLong ? element("code", {}, symbol) : null, description ? element("span", {}, description) : null].filter(Boolean);
  if (!meaning.length) return element("td", { class: "name" }, element("span", {}, ...name));
  return element("td", { class: "name" }, element("details", { class: "meaning" }, element("summary", { title: description ?? symbol }, ...name), ...meaning.map((part) => element("p", {}, part))));
};

/** Tables that do not fit give up their drawings, then their columns; there is room to scroll one that compares. */
const layOutTables = () => {
  for (const place of document.querySelectorAll(".scroll")) {
    const { classList } = place.firstChild;
    const fits = () => place.scrollWidth <= place.clientWidth;
    classList.remove("narrow", "stacked");
    if (!fits()) classList.add("narrow");
    if (!fits() && (place.clientWidth < 900 || !classList.contains("many"))) classList.add("stacked");
  }
};

const measured = ({ value, unit }) => (value !== null && unit && unit !== "1" ? `${short(value)}\u00a0${unitText(unit)}` : short(value));
const rangeWord = (ok) => (ok === null ? "" : ok ? "ok" : "MISSED");
const rangeKind = (ok) => (ok === null ? "" : ok ? "good" : "bad");

/** Whether the value meets what the thesis states, in words, and by how much it does not. */
const thesisWord = ({ against_thesis: verdict, ratio }) => {
  if (!verdict || verdict === "not stated") return "";
  return verdict === "not met" && Number.isFinite(ratio) ? `not met × ${short(Number(ratio.toPrecision(3)))}` : verdict;
};
const thesisKind = ({ against_thesis: verdict }) => ({ met: "good", "not met": "warn" })[verdict] ?? "";
const isThesisJudged = (metrics) => metrics.some((metric) => thesisWord(metric));
/** Why a value is not what the thesis states; `null` if it is. */
const reasonOf = (metric) => (metric?.against_thesis === "not met" ? metric.reason : null);
/** That, in a row below its own. */
const reasonRow = (reason, columns) => (reason ? [element("tr", { class: "reason" }, element("td", { colspan: columns }, reason))] : []);

const metricsOfOne = (metrics) => {
  const judged = isThesisJudged(metrics);
  const stated = judged || metrics.some((metric) => metric.thesis);
  const ranged = metrics.some(rangeText);
  const head = [["metric"], ["measured", "n"], ...(ranged ? [["in its range", "drawn"], ["regression range", "n"], [""]] : []), ...(stated ? [["thesis"]] : []), ...(judged ? [["against the thesis"]] : [])];
  const rows = metrics.map((metric) => {
    const cells = [
      metricName(metric), cell("measured", "n", measured(metric)),
      ...(ranged ? [
        cell("in its range", "drawn", bullet(metric) ?? ""), cell("regression range", "n", rangeText(metric)),
        cell("in its range", rangeKind(metric.ok), rangeWord(metric.ok)),
      ] : []),
    ];
    if (stated) cells.push(cell("thesis", saidKind(metric.thesis ?? ""), relation(metric.thesis ?? "")));
    if (judged) cells.push(cell("against the thesis", thesisKind(metric), thesisWord(metric)));
    return [element("tr", { class: reasonOf(metric) ? "explained" : null }, ...cells), ...reasonRow(reasonOf(metric), head.length)];
  });
  return table(headRow(head), rows);
};

/** Columns of one of several runs: what any of its metrics has. The first run has no differences. */
const columnsOf = (run, index) => {
  const metrics = run.metrics ?? [];
  const has = (text) => metrics.some(text);
  const difference = (metric, base) => (metric?.value != null && base?.value != null ? metric.value - base.value : null);
  return [
    { title: "measured", numeric: true, text: measured, kind: (metric) => rangeKind(metric.ok) },
    has(rangeText) && { title: "regression range", numeric: true, text: (metric) => `${rangeText(metric)} ${rangeWord(metric.ok)}`.trim(), kind: (metric) => (metric.ok === false ? "bad" : "") },
    has((metric) => metric.thesis) && { title: "thesis", text: (metric) => relation(metric.thesis ?? ""), kind: (metric) => saidKind(metric.thesis ?? "") },
    has(thesisWord) && { title: "against the thesis", text: thesisWord, kind: thesisKind },
    index > 0 && { title: "difference", numeric: true, text: (metric, base) => (difference(metric, base) === null ? "" : short(difference(metric, base))) },
    index > 0 && { title: "ratio", numeric: true, text: (metric, base) => (metric.value * base?.value > 0 ? `× ${short(metric.value / base.value)}` : "") },
  ].filter(Boolean);
};

const metricsOfMany = () => {
  const ids = [...new Set(runs.flatMap((run) => (run.metrics ?? []).map((metric) => metric.id)))];
  const columns = runs.map(columnsOf);
  const count = 1 + columns.flat().length;
  const rows = ids.map((id) => {
    const found = runs.map((run) => (run.metrics ?? []).find((metric) => metric.id === id));
    const cells = runs.flatMap((run, index) => columns[index].map(({ title, text, kind, numeric }, column) => {
      const metric = found[index];
      const kinds = [column ? "" : "first", numeric ? "n" : "", (metric && kind?.(metric)) || ""].filter(Boolean).join(" ");
      return cell(`${run.name}: ${title}`, kinds, metric ? text(metric, found[0]) : "");
    }));
    const reasons = runs.flatMap((run, index) => (reasonOf(found[index]) ? [`${run.name}: ${reasonOf(found[index])}`] : []));
    return [element("tr", { class: reasons.length ? "explained" : null }, metricName(found.find(Boolean)), ...cells), ...reasons.flatMap((reason) => reasonRow(reason, count))];
  });
  const names = element("tr", {}, element("th", {}), ...runs.map((run, index) => element("th", { class: "first", colspan: columns[index].length }, run.name)));
  const titles = columns.flatMap((own) => own.map(({ title, numeric }, column) => element("th", { class: [column ? "" : "first", numeric ? "n" : ""].filter(Boolean).join(" ") }, title)));
  return table(element("thead", {}, names, element("tr", {}, element("th", {}, "metric"), ...titles)), rows, "many");
};

const buildMetrics = () => {
  const place = byId("metrics");
  place.hidden = !runs.some((run) => run.metrics?.length);
  if (place.hidden) return;
  const all = runs.flatMap((run) => run.metrics ?? []);
  const hints = [];
  if (all.some(rangeText)) hints.push("The regression range lies around an earlier result of this program: it tells whether the numbers are still the same.");
  if (isThesisJudged(all)) hints.push("Whether a number meets what the thesis states is in the last columns.");
  if (all.some((metric) => metric.description)) hints.push("Click a metric to read what it means.");
  place.append(
    element("h2", {}, comparing ? "Metrics, and how they differ from the first run" : "Metrics"),
    hints.length ? element("p", { class: "hint" }, hints.join(" ")) : "",
    element("div", { class: "scroll" }, comparing ? metricsOfMany() : metricsOfOne(runs[0].metrics)),
  );
};

const buildAssertions = () => {
  const place = byId("assertions");
  const rows = runs.flatMap((run) => (run.assertions ?? []).map((found) => element("tr", {},
    ...(comparing ? [cell("run", "", run.name)] : []), element("td", { class: "name" }, found.name), cell("signal", "said", element("code", {}, found.signal)),
    cell("bound", "n", relation(found.bound)), cell("worst", "", relation(found.worst)),
    cell("verdict", found.ok ? "good" : found.fails ? "bad" : "warn", found.word))));
  place.hidden = !rows.length;
  if (place.hidden) return;
  const head = [...(comparing ? [["run"]] : []), ["assertion"], ["signal"], ["bound", "n"], ["worst"], [""]];
  place.append(element("h2", {}, "Assertions"), element("div", { class: "scroll" }, table(headRow(head), rows)));
};

/** What the links did, beside what the scenario asks of them. */
const buildTraffic = () => {
  const place = byId("traffic");
  const both = ({ asked, measured }) => `${short(measured)} (${short(asked)})`;
  const rows = runs.flatMap((run) => (run.traffic ?? []).map((link) => element("tr", {},
    ...(comparing ? [cell("run", "", run.name)] : []), element("td", { class: "name" }, `${link.from} → ${link.to} ${link.topic.split("/").pop()}`),
    cell("sent", "n", String(link.sent)), cell("loss (asked)", "n", both(link.loss)), cell("delay, s (asked)", "n", both(link.delay_s)),
    cell("rate, Hz (asked)", "n", both(link.rate_hz)), cell("mean age, s", "n", short(link.age_s.mean)), cell("largest age, s", "n", short(link.age_s.largest)),
    cell("least interval, s", "n", short(link.interval_s.least)), cell("kB", "n", short(link.bytes / 1000)))));
  place.hidden = !rows.length;
  if (place.hidden) return;
  const titles = ["sent", "loss (asked)", "delay, s (asked)", "rate, Hz (asked)", "mean age, s", "largest age, s", "least interval, s", "kB"];
  const head = [...(comparing ? [["run"]] : []), ["link"], ...titles.map((title) => [title, "n"])];
  place.append(element("h2", {}, "Links"), element("div", { class: "scroll" }, table(headRow(head), rows)));
};
