// Draws one sample (see samples.js) of a world on a canvas. Shapes of one look go into one path: a few hundred bodies in a
// dozen views are then a few dozen fills a frame.

const SMALLEST = 7; // pixels of an avatar's radius: its number shall be read
const TURN = Math.PI * 2;
export const PRESENT = 1;
export const AWAKE = 2;
export const HELD = 4;

/** Adds a circle or box of the scene at a place, in pixels, to the current path. */
export function addShape(ctx, shape, px, py, angle, scale) {
  if (shape.radius > 0) {
    const r = Math.max(shape.radius * scale, 1);
    // With a spoke, so that one sees it turn.
    ctx.moveTo(px + r * Math.cos(angle), py - r * Math.sin(angle));
    ctx.arc(px, py, r, -angle, TURN - angle);
    ctx.lineTo(px, py);
    return;
  }
  const hx = shape.half[0] * scale;
  const hy = shape.half[1] * scale;
  const c = Math.cos(angle);
  const s = -Math.sin(angle); // pixels have y down
  const ax = c * hx;
  const ay = s * hx;
  const bx = -s * hy;
  const by = c * hy;
  ctx.moveTo(px + ax + bx, py + ay + by);
  ctx.lineTo(px - ax + bx, py - ay + by);
  ctx.lineTo(px - ax - bx, py - ay - by);
  ctx.lineTo(px + ax - bx, py + ay - by);
  ctx.closePath();
}

/** The parts that never move: floor, grid of 1, 5 or 10 m, walls and obstacles. */
export function drawBackground(ctx, width, height, fit, scene, colours) {
  ctx.fillStyle = colours.outside;
  ctx.fillRect(0, 0, width, height);
  const x0 = fit.left + scene.lower[0] * fit.scale;
  const x1 = fit.left + scene.upper[0] * fit.scale;
  const y0 = fit.top - scene.upper[1] * fit.scale;
  const y1 = fit.top - scene.lower[1] * fit.scale;
  ctx.fillStyle = colours.floor;
  ctx.fillRect(x0, y0, x1 - x0, y1 - y0);
  const step = [1, 5, 10, 50].find((m) => m * fit.scale >= 14) ?? 100;
  ctx.strokeStyle = colours.grid;
  ctx.lineWidth = 1;
  ctx.beginPath();
  for (let x = Math.ceil(scene.lower[0] / step) * step; x <= scene.upper[0]; x += step) {
    const px = Math.round(fit.left + x * fit.scale) + 0.5;
    ctx.moveTo(px, y0);
    ctx.lineTo(px, y1);
  }
  for (let y = Math.ceil(scene.lower[1] / step) * step; y <= scene.upper[1]; y += step) {
    const py = Math.round(fit.top - y * fit.scale) + 0.5;
    ctx.moveTo(x0, py);
    ctx.lineTo(x1, py);
  }
  ctx.stroke();
  ctx.fillStyle = colours.wall;
  ctx.beginPath();
  for (const s of scene.statics) {
    addShape(ctx, s, fit.left + s.x * fit.scale, fit.top - s.y * fit.scale, s.angle, fit.scale);
  }
  ctx.fill();
}

/** Bodies, each in its authority's colour; those asleep are dimmed, those held by the view's own avatar outlined. */
export function drawBodies(ctx, fit, scene, sample, look) {
  const { world } = sample;
  const groups = new Map();
  for (let id = 0; id < scene.bodies.length; ++id) {
    if (!(world.flags[id] & PRESENT)) continue;
    const key = world.owner[id] * 2 + (world.flags[id] & AWAKE ? 1 : 0);
    const group = groups.get(key);
    if (group) group.push(id);
    else groups.set(key, [id]);
  }
  ctx.lineWidth = 1;
  ctx.strokeStyle = look.colours.outline;
  for (const [key, ids] of groups) {
    ctx.globalAlpha = key & 1 ? 1 : look.asleep;
    ctx.fillStyle = look.fills.of(key >> 1);
    ctx.beginPath();
    for (const id of ids) place(ctx, fit, scene.bodies[id], world, id);
    ctx.fill();
    ctx.stroke();
  }
  ctx.globalAlpha = 1;
  ctx.lineWidth = 2.5;
  ctx.strokeStyle = look.colours.held;
  ctx.beginPath();
  for (let id = 0; id < scene.bodies.length; ++id) {
    if ((world.flags[id] & (PRESENT | HELD)) === (PRESENT | HELD)) place(ctx, fit, scene.bodies[id], world, id);
  }
  ctx.stroke();
}

function place(ctx, fit, shape, world, id) {
  addShape(ctx, shape, fit.left + world.x[id] * fit.scale, fit.top - world.y[id] * fit.scale, world.angle[id], fit.scale);
}

/** Avatars: discs in their owners' colours with their numbers on them. */
export function drawAvatars(ctx, fit, scene, sample, look) {
  const { world } = sample;
  const r = Math.max(scene.avatar.radius * fit.scale, SMALLEST);
  for (let slot = 0; slot < scene.slots; ++slot) {
    const id = scene.bodies.length + slot;
    if (!(world.flags[id] & PRESENT)) continue;
    const { canvas, half } = look.sprites.of(slot, r, slot === look.own, look.sharp);
    ctx.drawImage(canvas, fit.left + world.x[id] * fit.scale - half, fit.top - world.y[id] * fit.scale - half, half * 2, half * 2);
  }
}

/** What the view's own peer thinks about its avatar: threshold in force, a contact it predicts, where it is heading. */
export function drawIntent(ctx, fit, scene, sample, look) {
  const id = scene.bodies.length + look.own;
  const { world } = sample;
  if (!(world.flags[id] & PRESENT)) return;
  const px = fit.left + world.x[id] * fit.scale;
  const py = fit.top - world.y[id] * fit.scale;
  const r = Math.max(scene.avatar.radius * fit.scale, SMALLEST);
  const tx = sample.target ? fit.left + sample.target.x * fit.scale : px;
  const ty = sample.target ? fit.top - sample.target.y * fit.scale : py;
  // Not on the number.
  if (Math.hypot(tx - px, ty - py) > r + 4) {
    ctx.strokeStyle = look.colours.own;
    ctx.lineWidth = 1.5;
    ctx.beginPath();
    ctx.moveTo(tx - 5, ty);
    ctx.lineTo(tx + 5, ty);
    ctx.moveTo(tx, ty - 5);
    ctx.lineTo(tx, ty + 5);
    ctx.stroke();
  }
  if (sample.threshold > 0) {
    ctx.strokeStyle = sample.predicted ? look.colours.alarm : look.colours.own;
    ctx.lineWidth = sample.predicted ? 2 : 1;
    ctx.setLineDash([5, 4]);
    ctx.beginPath();
    ctx.arc(px, py, sample.threshold * fit.scale, 0, TURN);
    ctx.stroke();
    ctx.setLineDash([]);
  }
  if (sample.predicted) {
    ctx.font = `bold ${Math.round(Math.max(r, 13))}px system-ui, sans-serif`;
    ctx.textAlign = "center";
    ctx.textBaseline = "alphabetic";
    ctx.lineWidth = 3;
    ctx.strokeStyle = look.colours.floor;
    ctx.strokeText("!", px, py - r - 3);
    ctx.fillStyle = look.colours.alarm;
    ctx.fillText("!", px, py - r - 3);
  }
}

/** Outlines of another world, and, for `lines`, a line from each entity to where that world has it, if that is `least` m away. */
export function drawGhosts(ctx, fit, scene, sample, ghost, style) {
  const { world } = sample;
  const outlines = [];
  // What is closer than a pixel or two cannot be seen, and would only hide the numbers.
  const leastBody = Math.max(style.least, 1.5 / fit.scale);
  const leastAvatar = Math.max(style.leastAvatar ?? style.least, 2.5 / fit.scale);
  const disc = { radius: Math.max(scene.avatar.radius, SMALLEST / fit.scale) };
  ctx.strokeStyle = style.colour;
  ctx.lineWidth = style.width;
  ctx.beginPath();
  const count = scene.bodies.length + scene.slots;
  for (let id = 0; id < count; ++id) {
    if (!(ghost.flags[id] & PRESENT) || !(world.flags[id] & PRESENT)) continue;
    const dx = ghost.x[id] - world.x[id];
    const dy = ghost.y[id] - world.y[id];
    const least = id < scene.bodies.length ? leastBody : leastAvatar;
    if (dx * dx + dy * dy < least * least) continue;
    outlines.push(id);
    // From the rim of an avatar on, so that its number can be read.
    const rim = id < scene.bodies.length ? 0 : Math.max(scene.avatar.radius * fit.scale, SMALLEST) / fit.scale;
    const far = Math.hypot(dx, dy);
    if (!style.lines || far < rim) continue;
    ctx.moveTo(fit.left + (world.x[id] + (dx / far) * rim) * fit.scale, fit.top - (world.y[id] + (dy / far) * rim) * fit.scale);
    ctx.lineTo(fit.left + ghost.x[id] * fit.scale, fit.top - ghost.y[id] * fit.scale);
  }
  ctx.stroke();
  ctx.setLineDash(style.dash);
  ctx.lineWidth = 1.2;
  ctx.beginPath();
  for (const id of outlines) {
    place(ctx, fit, id < scene.bodies.length ? scene.bodies[id] : disc, ghost, id);
  }
  ctx.stroke();
  ctx.setLineDash([]);
}
