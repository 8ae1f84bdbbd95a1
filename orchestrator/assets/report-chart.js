// One plot over time as a drawing: ranges, axes, curves. It draws on a canvas, or on anything that takes the same orders.

const MARGIN = { left: 66, right: 14, top: 8, bottom: 22 };
const LINES_HEIGHT = 210;
const ROW_HEIGHT = 17;

class Chart {
  /** Draws axes and curves, `width` times `height` pixels. */
  paint(context, width, height) {
    for (const curve of this.curves) curve.values = valuesOf(curve.source);
    Object.assign(this, { width, height });
    context.font = FONT;
    if (this.kind === "bands") this.drawBands(context);
    else this.drawLines(context);
  }

  timeAt(x) {
    const [start, end] = state.span ?? [0, lastTime];
    const share = (x - MARGIN.left) / Math.max(1, this.width - MARGIN.left - MARGIN.right);
    return start + Math.min(1, Math.max(0, share)) * (end - start);
  }

  x(time) {
    const [start, end] = state.span ?? [0, lastTime];
    return MARGIN.left + ((time - start) / Math.max(end - start, 1e-12)) * (this.width - MARGIN.left - MARGIN.right);
  }

  y(value) {
    const [low, high] = this.range;
    const [v, a, b] = this.logarithmic ? [Math.log10(value), Math.log10(low), Math.log10(high)] : [value, low, high];
    return this.height - MARGIN.bottom - ((v - a) / (b - a)) * (this.height - MARGIN.top - MARGIN.bottom);
  }

  shown(curve) {
    return !state.hidden.has(curve.run);
  }

  colour(curve) {
    if (comparing) return hue(curve.run);
    return curve.agent === null ? colours.ink : hue(curve.agent);
  }

  /** How strongly a curve stands out, 0 to 1. */
  weight(curve) {
    const chosen = state.pointed ?? state.solo;
    if (chosen === null || curve.agent === null) return 1;
    return chosen === curve.agent ? 1 : 0.12;
  }

  /** First and last index of a run that the plot shows. */
  window(run) {
    const times = runs[run].time;
    const [start, end] = state.span ?? [0, lastTime];
    return [indexAt(times, start), Math.min(times.length - 1, indexAt(times, end) + 1)];
  }

  findRange() {
    let values = [];
    const { limits } = this.views.find(Boolean);
    // What was asked for may exceed a limit by far; the plot is about what acts.
    const counts = (curve) => this.shown(curve) && !(limits.length && curve.second);
    for (const curve of this.curves.filter(counts)) {
      const [first, last] = this.window(curve.run);
      for (let k = first; k <= last; k += 1) values.push(curve.values[k]);
    }
    values = Float32Array.from(values.filter((value) => Number.isFinite(value) && (!this.logarithmic || value > 0))).sort();
    if (!values.length) return [this.logarithmic ? 0.1 : 0, 1];
    let [low, high] = [values[0], values[values.length - 1]];
    if (this.logarithmic) {
      // A curve that touches zero for an instant must not squeeze all others.
      low = Math.max(low, values[Math.floor(values.length * 0.004)] / 2, high * 1e-14);
      if (high / low < 3) [low, high] = [low / 2, high * 2];
      return [low / 1.15, high * 1.3];
    }
    [low, high] = this.withoutPeaks(values, low, high, limits);
    for (const [, value] of limits)
      if (value >= low - (high - low) && value <= high + (high - low)) [low, high] = [Math.min(low, value), Math.max(high, value)];
    if (this.magnitude) low = Math.min(low, 0);
    const room = (high - low || Math.abs(high) || 1) * 0.05;
    return [low === 0 ? 0 : low - room, high + room];
  }

  /** A peak that is short and high must not flatten everything else; a button shows it. */
  withoutPeaks(values, low, high, limits) {
    const at = (share) => values[Math.round(share * (values.length - 1))];
    const [usualLow, usualHigh] = [at(0.015), at(0.985)];
    const usual = usualHigh - usualLow;
    const peaks = !limits.length && usual > 0 && high - low > 3 * usual;
    this.rangeButton.hidden = !peaks;
    this.rangeButton.textContent = this.whole ? "cut peaks" : "show peaks";
    this.rangeButton.title = `All values: ${short(low)} … ${short(high)}`;
    this.cut = peaks && !this.whole ? [low, high] : null;
    return this.cut ? [Math.max(low, usualLow - usual / 3), Math.min(high, usualHigh + usual / 3)] : [low, high];
  }

  drawTimeAxis(context) {
    const [start, end] = state.span ?? [0, lastTime];
    const step = niceStep(end - start, Math.max(2, (this.width - 80) / 90));
    context.textAlign = "center";
    context.textBaseline = "top";
    for (const tick of ticksBetween(start, end, step)) {
      const x = Math.round(this.x(tick)) + 0.5;
      this.rule(context, x, MARGIN.top, x, this.height - MARGIN.bottom, colours.grid);
      context.fillStyle = colours.soft;
      context.fillText(`${tickText(tick, step)} s`, Math.min(x, this.width - 16), this.height - MARGIN.bottom + 6);
    }
  }

  rule(context, x0, y0, x1, y1, colour) {
    context.strokeStyle = colour;
    context.lineWidth = 1;
    context.beginPath();
    context.moveTo(x0, y0);
    context.lineTo(x1, y1);
    context.stroke();
  }

  drawLines(context) {
    this.cut = null;
    this.rangeButton.hidden = true;
    this.range = this.findRange();
    this.drawTimeAxis(context);
    this.drawValueAxis(context);
    context.save();
    context.beginPath();
    context.rect(MARGIN.left, MARGIN.top - 2, this.width - MARGIN.left - MARGIN.right, this.height - MARGIN.top - MARGIN.bottom + 4);
    context.clip();
    const ordered = this.curves.filter((curve) => this.shown(curve)).sort((a, b) => this.weight(a) - this.weight(b));
    const bold = this.largest();
    for (const curve of ordered) this.drawCurve(context, curve, bold.length > 0);
    for (const curve of bold) this.drawCurve(context, curve);
    context.restore();
    this.drawLimits(context);
    this.drawCut(context);
  }

  drawValueAxis(context) {
    const [low, high] = this.range;
    const right = this.width - MARGIN.right;
    const label = (value, text, strong) => {
      const y = Math.round(this.y(value)) + 0.5;
      this.rule(context, MARGIN.left, y, right, y, colours.grid);
      context.fillStyle = colours.soft;
      if (strong) context.fillText(text, MARGIN.left - 7, y);
    };
    context.textAlign = "right";
    context.textBaseline = "middle";
    if (this.logarithmic) {
      const decades = [Math.floor(Math.log10(low)), Math.ceil(Math.log10(high))];
      const stride = Math.ceil((decades[1] - decades[0]) / 7);
      for (let power = decades[0]; power <= decades[1]; power += 1)
        for (const factor of decades[1] - decades[0] <= 4 ? [1, 2, 5] : [1]) {
          const value = factor * 10 ** power;
          if (value >= low && value <= high) label(value, factor === 1 ? powerText(power) : short(value), factor === 1 ? power % stride === 0 : decades[1] - decades[0] <= 2);
        }
    } else {
      const step = niceStep(high - low, 5);
      for (const tick of ticksBetween(low, high, step)) label(tick, tickText(tick, step), true);
    }
    context.save();
    context.translate(11, MARGIN.top + (this.height - MARGIN.top - MARGIN.bottom) / 2);
    context.rotate(-Math.PI / 2);
    context.textAlign = "center";
    context.fillStyle = colours.soft;
    context.fillText(this.axis, 0, 0);
    context.restore();
  }

  /** Where runs are compared by norms: the largest of all agents, one curve per run. */
  largest() {
    if (!comparing || !this.magnitude || (state.pointed ?? state.solo) !== null) return [];
    return runs.flatMap((run, index) => {
      const own = this.curves.filter((curve) => curve.run === index && this.shown(curve) && !curve.second && curve.agent !== null);
      if (own.length < 2) return [];
      const values = own[0].values.map((_, k) => own.reduce((most, curve) => Math.max(most, curve.values[k]), -Infinity));
      return [{ run: index, agent: null, values, bold: true }];
    });
  }

  /** Says how far the curves go beyond what is shown. */
  drawCut(context) {
    if (!this.cut) return;
    const [low, high] = this.cut;
    const right = this.width - MARGIN.right - 4;
    context.fillStyle = colours.soft;
    context.textAlign = "right";
    context.textBaseline = "top";
    if (high > this.range[1]) context.fillText(`▲ up to ${short(high)}`, right, MARGIN.top);
    context.textBaseline = "bottom";
    if (low < this.range[0]) context.fillText(`▼ down to ${short(low)}`, right, this.height - MARGIN.bottom - 2);
  }

  drawCurve(context, curve, behind = false) {
    const times = runs[curve.run].time;
    const [first, last] = this.window(curve.run);
    const strong = this.weight(curve);
    const alone = (state.pointed ?? state.solo) === curve.agent;
    context.strokeStyle = this.colour(curve);
    context.globalAlpha = comparing && !alone && curve.agent !== null ? strong * (behind ? 0.22 : 0.55) : strong;
    context.lineWidth = alone || curve.bold ? 2 : behind ? 1 : 1.4;
    context.lineJoin = "round";
    context.setLineDash(curve.second ? [5, 3] : comparing ? runDash(curve.run) : agentDash(curve.agent ?? 0));
    context.beginPath();
    let drawing = false;
    for (let k = first; k <= last; k += 1) {
      const value = curve.values[k];
      if (!Number.isFinite(value) || (this.logarithmic && value <= 0)) {
        drawing = false;
        continue;
      }
      if (drawing) context.lineTo(this.x(times[k]), this.y(value));
      else context.moveTo(this.x(times[k]), this.y(value));
      drawing = true;
    }
    context.stroke();
    context.setLineDash([]);
    context.globalAlpha = 1;
  }

  drawLimits(context) {
    context.textAlign = "right";
    context.textBaseline = "bottom";
    for (const [label, value] of this.views.find(Boolean).limits) {
      if (value < this.range[0] || value > this.range[1]) continue;
      const y = Math.round(this.y(value)) + 0.5;
      context.setLineDash([6, 4]);
      this.rule(context, MARGIN.left, y, this.width - MARGIN.right, y, colours.bad);
      context.setLineDash([]);
      context.fillStyle = colours.bad;
      context.fillText(label, this.width - MARGIN.right - 4, y - 2);
    }
  }

  drawBands(context) {
    this.drawTimeAxis(context);
    context.textBaseline = "middle";
    this.curves.forEach((curve, row) => {
      const top = MARGIN.top + row * ROW_HEIGHT;
      context.textAlign = "right";
      context.fillStyle = colours.soft;
      context.fillText(curve.label, MARGIN.left - 7, top + ROW_HEIGHT / 2);
      context.fillStyle = colours.grid;
      context.fillRect(MARGIN.left, top + ROW_HEIGHT / 2 - 0.5, this.width - MARGIN.left - MARGIN.right, 1);
      if (!this.shown(curve)) return;
      const most = curve.values.reduce((a, b) => Math.max(a, Math.abs(b)), 1e-12);
      const times = runs[curve.run].time;
      const [first, last] = this.window(curve.run);
      context.fillStyle = this.colour(curve);
      for (let k = first, next; k < last; k = next) {
        for (next = k + 1; next < last && curve.values[next] === curve.values[k]; next += 1);
        if (!curve.values[k]) continue;
        context.globalAlpha = this.weight(curve) * (0.4 + (0.6 * Math.abs(curve.values[k])) / most);
        const [from, to] = [Math.max(MARGIN.left, this.x(times[k])), Math.min(this.width - MARGIN.right, this.x(times[next]))];
        context.fillRect(from, top + 3, Math.max(1, to - from), ROW_HEIGHT - 6);
      }
      context.globalAlpha = 1;
    });
  }
}
