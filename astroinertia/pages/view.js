"use strict";
const byId = (id) => document.getElementById(id);
const data = JSON.parse(byId("data").textContent);
const canvas = byId("canvas"), pen = canvas.getContext("2d");
const bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
const frames = data.frames.map((frame) => ({
  ...frame,
  points: frame.points && new Int16Array(bytes(frame.points).buffer),
  colours: frame.colours && bytes(frame.colours),
}));
const AXES = ["#8fe3ff", "#8dffb0", "#ffffff"], UNDEFINED = "#b8b8b8";
let yaw = 0.6, pitch = 0.35, zoom = 1, now = 0, playing = 0, asked = false;

function view() {
  const [c, s, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
  return [[c, s, 0], [-s * sp, c * sp, cp], [s * cp, -c * cp, sp]];
}
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

function draw() {
  asked = false;
  const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  const frame = frames[now], seen = view(), scale = (0.45 * Math.min(width, height - 60) * zoom) / frame.width;
  const place = (point) => [width / 2 + scale * dot(seen[0], point), (height - 40) / 2 - scale * dot(seen[1], point), dot(seen[2], point)];
  if (frame.points) drawParticles(frame, seen, scale, width, height);
  if (byId("shell").checked || !frame.points) drawShell(frame, place, seen);
  if (byId("axes").checked) drawAxes(frame, place);
  drawScale(scale, height - byId("bar").offsetHeight - 14);
  drawDirections(seen, width - 52, height - byId("bar").offsetHeight - 46);
  byId("now").textContent = frame.caption;
  byId("time").value = now;
}

function drawParticles(frame, seen, scale, width, height) {
  const { points, colours } = frame, size = Math.min(6, Math.max(1.6, data.dot * scale)), unit = (scale * frame.span) / 32767;
  const [[a, b], [d, e, f]] = seen, x0 = width / 2 - size / 2, y0 = (height - 40) / 2 - size / 2;
  let last = -1;
  for (let k = 0; k < colours.length; k++) {
    if (colours[k] !== last) pen.fillStyle = data.map[(last = colours[k])];
    const x = points[3 * k], y = points[3 * k + 1], z = points[3 * k + 2];
    pen.fillRect(x0 + unit * (a * x + b * y), y0 - unit * (d * x + e * y + f * z), size, size);
  }
}

function drawShell(frame, place, seen) {
  const point = (one, two, three) =>
    [0, 1, 2].map((i) => one * frame.lengths[0] * frame.axes[0][i] + two * frame.lengths[1] * frame.axes[1][i] + three * frame.lengths[2] * frame.axes[2][i]);
  const lines = [];
  for (let k = 0; k < 12; k++) lines.push((t) => [Math.cos((k * Math.PI) / 12) * Math.sin(t), Math.sin((k * Math.PI) / 12) * Math.sin(t), Math.cos(t)]);
  for (let k = -3; k <= 3; k++) lines.push((t) => [Math.cos((k * Math.PI) / 8) * Math.cos(t), Math.cos((k * Math.PI) / 8) * Math.sin(t), Math.sin((k * Math.PI) / 8)]);
  for (const line of lines) {
    for (let step = 0; step < 72; step++) {
      const [from, mid, to] = [step, step + 0.5, step + 1].map((at) => line((at * Math.PI) / 36));
      // The outward normal of an ellipsoid is (u_k / a_k) along axis k.
      const facing = [0, 1, 2].reduce((sum, k) => sum + (mid[k] / Math.max(frame.lengths[k], 1e-9)) * dot(seen[2], frame.axes[k]), 0);
      const [p, q] = [place(point(...from)), place(point(...to))];
      pen.strokeStyle = facing > 0 ? "rgba(232,215,180,.75)" : "rgba(232,215,180,.16)";
      pen.lineWidth = facing > 0 ? 1.1 : 0.8;
      pen.beginPath();
      pen.moveTo(p[0], p[1]);
      pen.lineTo(q[0], q[1]);
      pen.stroke();
    }
  }
}

function drawAxes(frame, place) {
  pen.font = "bold 15px system-ui, sans-serif";
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  frame.axes.forEach((axis, k) => {
    const end = axis.map((component) => component * frame.lengths[k]);
    const [from, to] = [place(end.map((component) => -component)), place(end)];
    pen.setLineDash(frame.defined[k] ? [] : [7, 5]);
    for (const [colour, width] of [["rgba(0,0,0,.65)", 5], [frame.defined[k] ? AXES[k] : UNDEFINED, 2.4]]) {
      pen.strokeStyle = pen.fillStyle = colour;
      pen.lineWidth = width;
      pen.beginPath();
      pen.moveTo(from[0], from[1]);
      pen.lineTo(to[0], to[1]);
      pen.stroke();
    }
    pen.setLineDash([]);
    const [dx, dy] = [to[0] - from[0], to[1] - from[1]], length = Math.hypot(dx, dy) || 1;
    pen.fillText(String(k + 1), to[0] + (13 * dx) / length, to[1] + (13 * dy) / length);
  });
}

// A length of 1, 2 or 5 times a power of ten, with a tick at each of its parts.
function drawScale(scale, bottom) {
  const most = 150 / scale;
  const [size, name] = data.lengths.reduce((best, unit) => (unit[0] <= most ? unit : best), data.lengths[0]);
  const tens = 10 ** Math.floor(Math.log10(most / size)), times = [5, 2, 1].find((k) => k * tens <= most / size);
  const long = times * tens * size * scale, parts = times === 2 ? 4 : 5, left = 20;
  pen.strokeStyle = pen.fillStyle = "#d8d8e2";
  pen.lineWidth = 1.5;
  pen.beginPath();
  pen.moveTo(left, bottom);
  pen.lineTo(left + long, bottom);
  for (let k = 0; k <= parts; k++) {
    const x = left + (k * long) / parts;
    pen.moveTo(x, bottom);
    pen.lineTo(x, bottom - (k % parts === 0 ? 9 : 5));
  }
  pen.stroke();
  pen.font = "13px system-ui, sans-serif";
  pen.textAlign = "left";
  pen.textBaseline = "bottom";
  pen.fillText(`${Number((times * tens).toPrecision(1))} ${name}`, left, bottom - 12);
}

function drawDirections(seen, x, y) {
  pen.font = "italic 13px system-ui, sans-serif";
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  ["x", "y", "z"].forEach((name, k) => {
    const [dx, dy] = [26 * seen[0][k], -26 * seen[1][k]];
    pen.strokeStyle = pen.fillStyle = seen[2][k] < -0.01 ? "#85858f" : "#d8d8e2";
    pen.lineWidth = 1.5;
    pen.beginPath();
    pen.moveTo(x, y);
    pen.lineTo(x + dx, y + dy);
    pen.stroke();
    if (Math.hypot(dx, dy) > 5) pen.fillText(name, x + 1.45 * dx, y + 1.45 * dy);
  });
}

const redraw = () => { if (!asked) { asked = true; requestAnimationFrame(draw); } };
const turn = (across, up) => { yaw -= across; pitch = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, pitch + up)); redraw(); };
const enlarge = (factor) => { zoom = Math.max(0.2, Math.min(40, zoom * factor)); redraw(); };
const show = (number) => { now = (number + frames.length) % frames.length; redraw(); };
const look = (y, p) => { yaw = y; pitch = p; redraw(); };

function play() {
  playing = playing ? clearInterval(playing) || 0 : setInterval(() => show(now + 1), 1000 * data.pause);
  byId("play").textContent = playing ? "Pause" : "Play";
}

const held = new Map();
canvas.addEventListener("pointerdown", (event) => { held.set(event.pointerId, event); canvas.setPointerCapture(event.pointerId); });
for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => held.delete(event.pointerId));
canvas.addEventListener("pointermove", (event) => {
  const before = held.get(event.pointerId);
  if (!before) return;
  const other = [...held.values()].find((each) => each.pointerId !== event.pointerId);
  if (other) {
    const apart = (one) => Math.hypot(one.clientX - other.clientX, one.clientY - other.clientY) || 1;
    enlarge(apart(event) / apart(before));
  } else turn((event.clientX - before.clientX) / 180, (event.clientY - before.clientY) / 180);
  held.set(event.pointerId, event);
});
canvas.addEventListener("wheel", (event) => { event.preventDefault(); enlarge(Math.exp(-event.deltaY / 600)); }, { passive: false });
canvas.addEventListener("dblclick", () => { zoom = 1; look(0.6, 0.35); });
window.addEventListener("keydown", (event) => {
  if (event.target.tagName === "INPUT" || event.target.tagName === "BUTTON") return;
  const moves = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] };
  if (moves[event.key]) turn(...moves[event.key]);
  else if (event.key === " ") play();
  else return;
  event.preventDefault();
});
window.addEventListener("resize", redraw);
byId("time").max = frames.length - 1;
byId("time").addEventListener("input", (event) => show(Number(event.target.value)));
byId("play").addEventListener("click", play);
byId("side").addEventListener("click", () => look(0, 0));
byId("pole").addEventListener("click", () => look(0, Math.PI / 2));
for (const id of ["axes", "shell"]) byId(id).addEventListener("change", redraw);
if (frames.length < 2) byId("play").hidden = byId("time").hidden = true;
draw();
