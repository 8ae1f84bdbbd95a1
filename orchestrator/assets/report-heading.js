// The heading: which run it is, its verdict in a sentence, and what was violated. At the end of the page: all that is known.

const buildHeading = () => {
  const first = runs[0];
  byId("title").textContent = first.title || first.scenario || first.file;
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
  buildAlarms();
  buildVerdict();
};

/** Violated assertions of all runs, those first that fail a run. */
const alarms = runs.flatMap((run) => (run.assertions ?? []).filter((found) => !found.ok).map((found) => ({ ...found, run })))
  .sort((a, b) => Number(b.fails) - Number(a.fails));

/** A time as a link that sets the playback to it. */
const timeLink = (time, text) => element("a", { href: `#t=${Number(time.toFixed(6))}`, title: "Show the formation at this time" }, text);

const buildAlarms = () => {
  byId("alarms").hidden = !alarms.length;
  byId("alarms").append(...alarms.map(({ name, first, worst, worst_at: worstAt, fails, run }) => element("p", { class: fails ? "bad" : "warn" },
    element("b", {}, fails ? "Violated" : "Warning", comparing ? `, ${run.name}` : ""), `: ${name}: `,
    first ? timeLink(first.time, relation(first.text)) : "",
    worstAt !== null && Math.abs(worstAt - (first?.time ?? NaN)) > 1e-6 ? "; worst " : "",
    worstAt !== null && Math.abs(worstAt - (first?.time ?? NaN)) > 1e-6 ? timeLink(worstAt, relation(worst)) : "")));
};

const buildVerdict = () => {
  const place = byId("verdict");
  const all = runs.flatMap((run) => (run.metrics ?? []).map((metric) => ({ ...metric, run })));
  const judged = all.filter((metric) => metric.ok !== null);
  const missed = judged.filter((metric) => !metric.ok);
  const reasons = [...new Set(runs.map((run) => run.not_held).filter(Boolean))];
  if (judged.length) {
    const count = `${judged.length - missed.length} of ${judged.length}`;
    const sentence = reasons.length ? `${count} in their regression range, not held against this run` : missed.length ? `${missed.length} of ${judged.length} outside their regression range` : `all ${judged.length} in their regression range`;
    if (!reasons.length) place.classList.add(missed.length ? "bad" : "good");
    place.append(element("a", { href: "#metrics" }, element("strong", {}, sentence), reasons.join("; ")));
  }
  const counts = ["met", "not met", "qualitative"].map((word) => [all.filter((metric) => metric.against_thesis === word).length, word]);
  const thesis = counts.filter(([count]) => count).map(([count, word]) => `${count} ${word}`);
  if (thesis.length) place.append(element("a", { class: "against", href: "#metrics" }, `against the thesis: ${thesis.join(", ")}`));
  const words = [[alarms.filter((found) => found.fails).length, "assertion violated", "assertions violated", "bad"], [alarms.filter((found) => !found.fails).length, "warning", "warnings", "warn"]];
  for (const [count, one, many, kind] of words)
    if (count) place.append(element("a", { class: `count ${kind}`, href: "#assertions" }, `${count} ${count > 1 ? many : one}`));
  if (!judged.length) return;
  place.append(element("div", { class: "ticks" }, ...judged.slice(0, 120).map((metric) => element("i", {
    class: metric.ok ? null : "bad",
    title: `${comparing ? `${metric.run.name}: ` : ""}${metric.id} = ${short(metric.value)}, regression range ${rangeText(metric)}`,
  }))));
};

const buildMore = () => {
  for (const run of runs) {
    const of = comparing ? ` of ${run.name}` : "";
    if (run.text) byId("more").append(element("details", { class: "card" }, element("summary", {}, `Scenario${of}, with all that was changed`), element("pre", {}, run.text)));
    const lines = run.channels.map(({ topic, fields }) => `${topic.padEnd(24)} ${fields.map(([name, length, unit]) => `${name}${length > 1 ? `[${length}]` : ""}${unit ? ` (${unitText(unit)})` : ""}`).join("  ")}`);
    byId("more").append(element("details", { class: "card" }, element("summary", {}, `Signals in the log${of}`), element("pre", {}, lines.join("\n"))));
  }
  const widest = Math.max(...runs.map((run) => run.interval));
  const thinned = widest > 1 ? `Curves show the smallest and the largest value of every ${widest} samples, readings are those of the curve. ` : "";
  byId("footer").textContent = `${thinned}Written by phalanx ${report.version} from ${runs.map((run) => run.file).join(", ")}.`;
};
