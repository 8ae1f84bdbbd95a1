// The formation at one instant: seen from above for robots on the ground, as an orbit view for drones.

/** The view, shared by all runs of a report. */
const camera = { azimuth: -0.65, elevation: 0.5, scale: 1, shift: [0, 0], fitted: false, touched: false };

/** Pixels above and below the formation: names, buttons, numbers. */
const AROUND = 96;
/** Pixels that the heights take at the left. */
const LEFT_MARK = 40;

class Scene {
  constructor(run) {
    this.run = run;
    this.planar = run.scene.planar;
    this.agents = run.scene.agents.filter((agent) => agent.position);
    this.canvas = element("canvas", { role: "img", "aria-label": `The formation of ${run.name}` });
    this.card = element("div", { class: "scene" }, this.canvas, comparing ? element("span", { class: "name" }, run.name) : null);
    this.measure();
    this.listen();
  }

  /** The box in which everything happens. */
  measure() {
    this.low = [Infinity, Infinity, Infinity];
    this.high = [-Infinity, -Infinity, -Infinity];
    const take = (x, y, z) => [x, y, z].forEach((value, axis) => {
      if (!Number.isFinite(value)) return;
      this.low[axis] = Math.min(this.low[axis], value);
      this.high[axis] = Math.max(this.high[axis], value);
    });
    for (const agent of this.agents)
      for (const path of [agent.position, agent.desired].filter(Boolean))
        for (let k = 0; k < path.values.length; k += path.width)
          take(path.values[k], path.width > 1 ? path.values[k + 1] : 0, this.planar || path.width < 3 || agent.planar ? 0 : path.values[k + 2]);
    for (const { centre, radius } of this.run.scene.obstacles) {
      take(centre[0] - radius, centre[1] - radius, 0);
      take(centre[0] + radius, centre[1] + radius, 0);
    }
    for (let axis = 0; axis < 3; axis += 1)
      if (!(this.high[axis] > this.low[axis])) [this.low[axis], this.high[axis]] = [(this.low[axis] || 0) - 0.5, (this.low[axis] || 0) + 0.5];
    if (this.planar) return;
    // The floor ends at lines of its grid.
    this.low[2] = Math.min(0, this.low[2]);
    this.step = niceStep(Math.max(this.high[0] - this.low[0], this.high[1] - this.low[1]), 6);
    for (const axis of [0, 1]) {
      this.low[axis] = Math.floor(this.low[axis] / this.step) * this.step;
      this.high[axis] = Math.ceil(this.high[axis] / this.step) * this.step;
    }
  }

  listen() {
    this.canvas.addEventListener("pointerdown", (event) => {
      this.drag = { x: event.clientX, y: event.clientY, pan: this.planar || event.shiftKey || event.button === 2 };
      this.canvas.setPointerCapture(event.pointerId);
    });
    this.canvas.addEventListener("pointermove", (event) => {
      if (!this.drag) return;
      camera.touched = true;
      const [dx, dy] = [event.clientX - this.drag.x, event.clientY - this.drag.y];
      Object.assign(this.drag, { x: event.clientX, y: event.clientY });
      if (this.drag.pan) camera.shift = [camera.shift[0] + dx, camera.shift[1] + dy];
      else {
        camera.azimuth += dx * 0.008;
        camera.elevation = Math.max(0, Math.min(Math.PI / 2, camera.elevation + dy * 0.006));
      }
      redrawScenes();
    });
    for (const end of ["pointerup", "pointercancel"]) this.canvas.addEventListener(end, () => { this.drag = null; });
    this.canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    this.canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      camera.touched = true;
      const factor = Math.exp(-event.deltaY * 0.0015);
      const rect = this.canvas.getBoundingClientRect();
      const pointer = [event.clientX - rect.left - rect.width / 2, event.clientY - rect.top - rect.height / 2];
      camera.shift = camera.shift.map((shift, axis) => pointer[axis] - (pointer[axis] - shift) * factor);
      camera.scale *= factor;
      redrawScenes();
    }, { passive: false });
  }

  /** From metres to pixels, and how far away it is. */
  project(x, y, z) {
    const [cx, cy, cz] = this.centre;
    if (this.planar) return [this.middle[0] + (x - cx) * this.scale, this.middle[1] - (y - cy) * this.scale, 0];
    const { sinA, cosA, sinE, cosE } = this.turn;
    const right = (x - cx) * cosA - (y - cy) * sinA;
    const away = (x - cx) * sinA + (y - cy) * cosA;
    const depth = away * cosE - (z - cz) * sinE;
    const near = this.distance / Math.max(this.distance * 0.1, this.distance + depth);
    const up = (z - cz) * cosE + away * sinE;
    return [this.middle[0] + right * this.scale * near, this.middle[1] - up * this.scale * near, depth];
  }

  /** What the box covers on the screen, at one pixel per metre. */
  spread() {
    this.turnTo(camera);
    Object.assign(this, { scale: 1, middle: [0, 0] });
    let [left, right, top, bottom] = [Infinity, -Infinity, Infinity, -Infinity];
    for (const x of [this.low[0], this.high[0]])
      for (const y of [this.low[1], this.high[1]])
        for (const z of [this.low[2], this.high[2]]) {
          const [px, py] = this.project(x, y, z);
          [left, right, top, bottom] = [Math.min(left, px), Math.max(right, px), Math.min(top, py), Math.max(bottom, py)];
        }
    return { left, right, top, bottom };
  }

  /** Pixels per metre with which everything fits into so many pixels, numbers at the edges included. */
  fit(width, height) {
    const { left, right, top, bottom } = this.spread();
    return Math.min((width - (this.planar ? 60 : 2 * LEFT_MARK)) / (right - left), (height - AROUND) / (bottom - top));
  }

  /** Height in pixels that the box takes at so many pixels per metre. */
  heightAt(scale) {
    const { top, bottom } = this.spread();
    return (bottom - top) * scale + AROUND;
  }

  turnTo({ azimuth, elevation }) {
    this.turn = { sinA: Math.sin(azimuth), cosA: Math.cos(azimuth), sinE: Math.sin(elevation), cosE: Math.cos(elevation) };
    this.centre = this.low.map((low, axis) => (low + this.high[axis]) / 2);
    this.distance = 3 * Math.hypot(...this.low.map((low, axis) => this.high[axis] - low));
  }

  /** Aims the camera; the first time, and on request, so that everything is in view. */
  aim(width, height) {
    this.turnTo(camera);
    if (!camera.fitted) {
      const { left, right, top, bottom } = this.spread();
      camera.home = this.fit(width, height);
      camera.scale = 1;
      camera.shift = [(-(left + right) / 2) * camera.home + (this.planar ? 0 : LEFT_MARK / 4), (-(top + bottom) / 2) * camera.home];
      camera.fitted = true;
    }
    this.scale = camera.home * camera.scale;
    this.middle = [width / 2 + camera.shift[0], height / 2 + camera.shift[1]];
    if (state.follow !== null && this.agents[state.follow]) {
      this.centre = this.place(this.agents[state.follow].position, state.time).slice(0, 3);
      if (this.planar || this.agents[state.follow].planar) this.centre[2] = 0;
    }
  }

  /** Coordinates at a time, between two frames. */
  place(path, time) {
    const times = this.run.time;
    const k = indexAt(times, time);
    const next = Math.min(k + 1, times.length - 1);
    const share = next > k ? Math.min(1, Math.max(0, (time - times[k]) / (times[next] - times[k]))) : 0;
    return Array.from({ length: path.width }, (_, j) => {
      const [a, b] = [path.values[k * path.width + j], path.values[next * path.width + j]];
      return a + (b - a) * share;
    });
  }

  /** A place as pixels; `flat` if a third coordinate is no height. */
  point(coordinates, flat = false) {
    return this.project(coordinates[0], coordinates[1] ?? 0, this.planar || flat ? 0 : coordinates[2] ?? 0);
  }

  colour(index) {
    return hue(index);
  }

  faded(index) {
    const chosen = state.pointed ?? state.solo;
    return chosen !== null && chosen !== index;
  }

  draw() {
    if (!this.canvas.clientWidth) return;
    const { context, width, height } = fitCanvas(this.canvas);
    Object.assign(this, { context, width, height });
    this.aim(width, height);
    context.font = FONT;
    context.lineJoin = "round";
    drawGround(this);
    for (const obstacle of this.run.scene.obstacles) drawObstacle(this, obstacle);
    const time = Math.min(state.time, this.run.end);
    this.agents.forEach((agent, index) => this.drawTrail(agent, index, time));
    const places = this.agents.map((agent) => this.place(agent.position, time));
    if (state.links) for (const link of this.run.scene.links) this.drawLink(link, places, time);
    if (state.targets) this.agents.forEach((agent, index) => this.drawTarget(agent, index, places[index], time));
    const order = places.map((place, index) => [this.point(place, this.agents[index].planar)[2], index]).sort((a, b) => b[0] - a[0]);
    for (const [, index] of order) {
      context.globalAlpha = this.faded(index) ? 0.3 : 1;
      if (this.agents[index].planar) drawRobot(this, this.agents[index], places[index], this.colour(index));
      else drawDrone(this, this.agents[index], places[index], this.colour(index));
      context.globalAlpha = 1;
    }
  }

  line(points, colour, width, dash = []) {
    const { context } = this;
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.setLineDash(dash);
    context.beginPath();
    points.forEach(([x, y], k) => (k ? context.lineTo(x, y) : context.moveTo(x, y)));
    context.stroke();
    context.setLineDash([]);
  }

  drawTrail(agent, index, time) {
    if (state.trail <= 0) return;
    const { width, values } = agent.position;
    const times = this.run.time;
    const last = indexAt(times, time);
    const first = indexAt(times, Math.max(0, time - state.trail));
    const fresh = indexAt(times, Math.max(0, time - Math.min(state.trail, this.run.end / 12)));
    const at = (k) => this.point(values.subarray(k * width, k * width + Math.min(3, width)), agent.planar);
    const path = (from, to) => Array.from({ length: Math.max(0, to - from + 1) }, (_, k) => at(from + k));
    const strength = this.faded(index) ? 0.25 : 1;
    const { context } = this;
    context.globalAlpha = 0.5 * strength;
    this.line(path(first, fresh), this.colour(index), 1.2, agentDash(index));
    const pieces = 8;
    for (let piece = 0; piece < pieces; piece += 1) {
      const [from, to] = [piece, piece + 1].map((k) => Math.round(fresh + ((last - fresh) * k) / pieces));
      const points = path(from, to);
      if (piece === pieces - 1) points.push(this.point(this.place(agent.position, time), agent.planar));
      context.globalAlpha = (0.5 + (0.5 * (piece + 1)) / pieces) * strength;
      this.line(points, this.colour(index), 1.2 + (1.4 * (piece + 1)) / pieces);
    }
    context.globalAlpha = 1;
  }

  drawLink({ from, to, spans }, places, time) {
    let on = false;
    for (let k = 0; k < spans.length; k += 2) on ||= time >= spans[k] - 1e-6 && time <= spans[k + 1] + 1e-6;
    if (!on || !places[from] || !places[to]) return;
    const chosen = state.pointed ?? state.solo;
    const concerned = chosen === to || chosen === from;
    const { context } = this;
    const [a, b] = [from, to].map((index) => this.point(places[index], this.agents[index].planar));
    const length = Math.hypot(b[0] - a[0], b[1] - a[1]);
    if (length < 1) return;
    const [ux, uy] = [(b[0] - a[0]) / length, (b[1] - a[1]) / length];
    const head = [a[0] + ux * length * 0.64, a[1] + uy * length * 0.64];
    const colour = chosen === to ? this.colour(to) : colours.soft;
    context.globalAlpha = chosen === null ? 0.6 : concerned ? 0.95 : 0.15;
    this.line([a, b], colour, concerned ? 1.6 : 1);
    context.fillStyle = colour;
    context.beginPath();
    context.moveTo(head[0] + ux * 5, head[1] + uy * 5);
    context.lineTo(head[0] - ux * 4 - uy * 4, head[1] - uy * 4 + ux * 4);
    context.lineTo(head[0] - ux * 4 + uy * 4, head[1] - uy * 4 - ux * 4);
    context.fill();
    context.globalAlpha = 1;
  }

  /** The place in the formation as a ring, what the agent tracks as a cross if that is something else. */
  drawTarget(agent, index, place, time) {
    const { context } = this;
    context.globalAlpha = this.faded(index) ? 0.2 : 0.9;
    const path = agent.desired ?? agent.tracked;
    if (path) {
      const [x, y] = this.point(this.place(path, time));
      this.line([this.point(place, agent.planar), [x, y]], this.colour(index), 1, [2, 3]);
      context.strokeStyle = this.colour(index);
      context.lineWidth = 1.5;
      context.beginPath();
      context.arc(x, y, 6, 0, 2 * Math.PI);
      context.stroke();
    }
    if (agent.desired && agent.tracked) {
      const [x, y] = this.point(this.place(agent.tracked, time));
      this.line([[x - 4, y - 4], [x + 4, y + 4]], this.colour(index), 1.3);
      this.line([[x - 4, y + 4], [x + 4, y - 4]], this.colour(index), 1.3);
    }
    context.globalAlpha = 1;
  }
}
