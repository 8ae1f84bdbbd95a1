// What stands and moves in a scene: the ground, obstacles, robots, drones.

const closed = (count, point) => Array.from({ length: count + 1 }, (_, k) => point((2 * Math.PI * k) / count));

/** A grid on the ground with its coordinates, m. */
const drawGround = (scene) => (scene.planar ? drawPaper(scene) : drawFloor(scene));

const drawPaper = (scene) => {
  const { context, width, height, centre, middle, scale } = scene;
  const step = niceStep(width / scale, Math.max(3, width / 90));
  const label = (text, x, y, align) => {
    context.fillStyle = colours.soft;
    context.textAlign = align;
    context.textBaseline = "middle";
    context.fillText(text, x, y);
  };
  for (const x of ticksBetween(centre[0] - middle[0] / scale, centre[0] + (width - middle[0]) / scale, step)) {
    const [px] = scene.project(x, 0, 0);
    scene.line([[px, 0], [px, height]], Math.abs(x) < step / 1e6 ? colours.line : colours.grid, 1);
    if (px > 40 && px < width - 40) label(tickText(x, step), px, height - 10, "center");
  }
  for (const y of ticksBetween(centre[1] - (height - middle[1]) / scale, centre[1] + middle[1] / scale, step)) {
    const [, py] = scene.project(0, y, 0);
    scene.line([[0, py], [width, py]], Math.abs(y) < step / 1e6 ? colours.line : colours.grid, 1);
    if (py > 16 && py < height - 24) label(tickText(y, step), 8, py, "left");
  }
  label("m", width - 8, height - 10, "right");
};

const drawFloor = (scene) => {
  const { context, low, high, step } = scene;
  const size = Math.max(high[0] - low[0], high[1] - low[1]);
  // Numbers at every line, or as many as there is room for.
  const labelStep = niceStep(size, Math.max(1, Math.min(6, (size * scene.scale) / 40)));
  const [x0, y0, z] = low;
  const [x1, y1] = high;
  for (const x of ticksBetween(x0, x1, step)) scene.line([scene.project(x, y0, z), scene.project(x, y1, z)], colours.line, 1);
  for (const y of ticksBetween(y0, y1, step)) scene.line([scene.project(x0, y, z), scene.project(x1, y, z)], colours.line, 1);
  // Numbers go to the two edges in front, heights to the corner at the left.
  const nearer = (a, b) => (scene.project(...a)[2] <= scene.project(...b)[2] ? a : b);
  const edgeY = nearer([(x0 + x1) / 2, y0, z], [(x0 + x1) / 2, y1, z])[1];
  const edgeX = nearer([x0, (y0 + y1) / 2, z], [x1, (y0 + y1) / 2, z])[0];
  const outward = (at, middle) => Math.sign(at - middle) * step * 0.35;
  context.fillStyle = colours.soft;
  context.textAlign = "center";
  context.textBaseline = "middle";
  const label = (text, position) => {
    const [x, y] = scene.project(...position);
    context.fillText(text, x, y);
  };
  for (const x of ticksBetween(x0, x1, labelStep)) label(tickText(x, labelStep), [x, edgeY + outward(edgeY, (y0 + y1) / 2), z]);
  for (const y of ticksBetween(y0, y1, labelStep)) label(tickText(y, labelStep), [edgeX + outward(edgeX, (x0 + x1) / 2), y, z]);
  const corners = [[x0, y0], [x0, y1], [x1, y0], [x1, y1]];
  const left = corners.reduce((a, b) => (scene.project(...a, z)[0] < scene.project(...b, z)[0] ? a : b));
  scene.line([scene.project(...left, z), scene.project(...left, high[2])], colours.line, 1);
  context.textAlign = "right";
  const heightStep = niceStep(high[2] - z, Math.max(2, Math.min(5, ((high[2] - z) * scene.scale) / 60)));
  for (const tick of ticksBetween(z, high[2], heightStep)) {
    const [x, y] = scene.project(...left, tick);
    scene.line([[x - 3, y], [x, y]], colours.soft, 1);
    if (tick > z) context.fillText(`${tickText(tick, heightStep)} m`, x - 6, y);
  }
};

const drawObstacle = (scene, { centre, radius, rings }) => {
  const { context } = scene;
  const circle = (size) => closed(48, (angle) => scene.project(centre[0] + size * Math.cos(angle), centre[1] + size * Math.sin(angle), 0));
  const trace = (points) => {
    context.beginPath();
    points.forEach(([x, y], k) => (k ? context.lineTo(x, y) : context.moveTo(x, y)));
  };
  trace(circle(radius));
  context.fillStyle = colours.soft;
  context.globalAlpha = 0.55;
  context.fill();
  context.globalAlpha = 1;
  scene.line(circle(radius), colours.ink, 1.2);
  if (!rings) return;
  // The boundaries hold for the centre of an agent: drawn for the one that is singled out, else for the largest.
  const chosen = scene.agents[state.pointed ?? state.solo ?? state.follow ?? -1];
  const own = chosen ? chosen.radius ?? 0 : Math.max(...scene.agents.map((agent) => agent.radius ?? 0));
  const [inner, outer] = rings.map((ring) => ring * (own + radius));
  trace(circle(outer));
  context.fillStyle = colours.bad;
  context.globalAlpha = 0.06;
  context.fill();
  context.globalAlpha = 1;
  scene.line(circle(outer), colours.bad, 1, [2, 4]);
  scene.line(circle(inner), colours.bad, 1.2, [6, 3]);
};

const drawNumber = (scene, number, x, y, colour, inside) => {
  const { context } = scene;
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.font = FONT.replace("12px", "600 12px");
  if (!inside) {
    context.lineWidth = 3;
    context.strokeStyle = colours.card;
    context.strokeText(number, x, y);
  }
  context.fillStyle = inside ? colours.card : colour;
  context.fillText(number, x, y);
  context.font = FONT;
};

/** An omnidirectional robot from above: its disc, three wheels, and where it heads. */
const drawRobot = (scene, agent, [x, y = 0, heading = 0], colour) => {
  const { context } = scene;
  const [px, py] = scene.project(x, y, 0);
  const size = Math.max(7, (agent.radius ?? 0) * scene.scale);
  context.fillStyle = colour;
  context.beginPath();
  context.arc(px, py, size, 0, 2 * Math.PI);
  context.fill();
  context.strokeStyle = colours.card;
  context.lineWidth = 1.5;
  context.stroke();
  const along = (angle, length) => scene.project(x + (Math.cos(angle) * length) / scene.scale, y + (Math.sin(angle) * length) / scene.scale, 0);
  for (const offset of [0, 2 * Math.PI / 3, -2 * Math.PI / 3]) {
    const angle = heading + offset;
    const [wx, wy] = along(angle, size);
    const [dx, dy] = [Math.sin(angle) * size * 0.32, Math.cos(angle) * size * 0.32];
    scene.line([[wx - dx, wy - dy], [wx + dx, wy + dy]], colours.ink, Math.max(2, size * 0.16));
  }
  scene.line([along(heading, size * 0.2), along(heading, size + 9)], colours.ink, 2);
  drawNumber(scene, String(agent.number), ...(size >= 9 ? [px, py] : along(heading + 2.4, size + 10)), colour, size >= 9);
};

/** A quadcopter with its attitude, its shadow, and a line down to it. */
const drawDrone = (scene, agent, [x, y, z, roll = 0, pitch = 0, yaw = 0], colour) => {
  const { context } = scene;
  const floor = scene.low[2];
  const size = Math.max(agent.radius ?? 0, 11 / scene.scale);
  const [px, py] = scene.project(x, y, z);
  const shadow = closed(16, (angle) => scene.project(x + size * Math.cos(angle), y + size * Math.sin(angle), floor));
  context.beginPath();
  shadow.forEach(([sx, sy], k) => (k ? context.lineTo(sx, sy) : context.moveTo(sx, sy)));
  const strength = context.globalAlpha;
  context.globalAlpha = strength * 0.18;
  context.fillStyle = colours.ink;
  context.fill();
  context.globalAlpha = strength * 0.5;
  scene.line([[px, py], scene.project(x, y, floor)], colour, 1, [1, 3]);
  context.globalAlpha = strength;
  const [cr, sr, cp, sp, cy, sy] = [roll, pitch, yaw].flatMap((angle) => [Math.cos(angle), Math.sin(angle)]);
  // From the body's plane to space: yaw, pitch, roll.
  const body = (a, b) => scene.project(
    x + a * cy * cp + b * (cy * sp * sr - sy * cr),
    y + a * sy * cp + b * (sy * sp * sr + cy * cr),
    z - a * sp + b * cp * sr,
  );
  const arms = [[1, 0], [0, 1], [-1, 0], [0, -1]];
  scene.line([body(size, 0), body(-size, 0)], colours.ink, 2);
  scene.line([body(0, size), body(0, -size)], colours.ink, 2);
  arms.forEach(([a, b], k) => {
    const disc = closed(18, (angle) => body(a * size + size * 0.55 * Math.cos(angle), b * size + size * 0.55 * Math.sin(angle)));
    context.beginPath();
    disc.forEach(([dx, dy], j) => (j ? context.lineTo(dx, dy) : context.moveTo(dx, dy)));
    context.fillStyle = colour;
    // The rotor in front is solid.
    context.globalAlpha = strength * (k === 0 ? 0.95 : 0.4);
    context.fill();
    context.globalAlpha = strength;
    scene.line(disc, colour, 1.3);
  });
  context.beginPath();
  context.arc(px, py, 3, 0, 2 * Math.PI);
  context.fillStyle = colour;
  context.fill();
  drawNumber(scene, String(agent.number), px, py - 22, colour, false);
};
