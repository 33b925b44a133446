"use strict";

const data = JSON.parse(document.getElementById("data").textContent);
const [frame, drawing, tip, where] = ["frame", "drawing", "tip", "where"].map((id) => document.getElementById(id));

/* Elements: text is always inserted as text, never as markup; attributes are set one by one. */

function element(parent, name, text, attributes = {}) {
  const made = document.createElement(name);
  if (text !== undefined) made.textContent = text;
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  parent.append(made);
  return made;
}

function shape(parent, name, attributes = {}, text) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  parent.append(made);
  return made;
}

function group(id) {
  return document.getElementById(id);
}

function many(count, noun) {
  return `${count} ${noun}${count === 1 ? "" : "s"}`;
}

/* Facts */

for (const [name, value] of data.facts) {
  const pair = element(group("facts"), "div", undefined, value.length > 40 ? { class: "long" } : {});
  element(pair, "dt", name);
  element(pair, "dd", value, { title: value });
}

/* Map: rooms, doors, and the layers of the stages */

const shapes = new Map(); // "room 3" -> its shape
const rows = new Map(); // "room 3" -> its row in a table

function roomText(room) {
  const beside = room.neighbours.length ? `next to ${room.neighbours.join(", ")}` : "no neighbours";
  return `${room.name ? `${room.name}, room` : "Room"} ${room.id}: ${room.area_m2.toFixed(1)} m²\n${many(room.doors.length, "door")}, ${beside}`;
}

function doorText(door) {
  return `Door ${door.id}: ${door.width_m.toFixed(2)} m wide\n${door.kind}, between rooms ${door.rooms.join(" and ")}`;
}

for (const room of data.rooms) {
  const name = `room ${room.id}`;
  shapes.set(name, shape(group("rooms"), "path", { id: `room-${room.id}`, d: room.d, fill: room.colour, "data-name": name }));
  shapes.get(name).tip = roomText(room);
}

for (const door of data.doors) {
  const name = `door ${door.id}`;
  const both = shape(group("doors"), "g", { id: `door-${door.id}`, "data-name": name });
  shape(both, "path", { d: door.d, stroke: data.door_colour, class: "line" });
  shape(both, "path", { d: door.d, class: "reach" });
  both.tip = doorText(door);
  shapes.set(name, both);
}

const named = data.rooms.some((room) => room.name);
const labels = [];
for (const room of data.rooms) {
  const [x, y] = room.at;
  const size = Math.sqrt(room.area_m2) / data.resolution_m; // in cells
  labels.push({ size, at: [x, y], lift: -0.5, scale: 1, least: 16, text: shape(group("names"), "text", {}, room.name || room.id) });
  const area = shape(group("names"), "text", { class: "small" }, `${room.area_m2.toFixed(1)} m²`);
  labels.push({ size, at: [x, y], lift: 0.55, scale: 0.8, least: 60, text: area });
}
for (const door of data.doors) {
  const size = Math.max(door.length_m, 0.8) / data.resolution_m;
  const text = shape(group("names"), "text", { class: "door" }, door.id);
  labels.push({ size, at: door.at, lift: -0.95, scale: 0.85, least: 14, text });
}

const layers = new Map();

function addSwitch(layer, parts) {
  const about = element(group("layers"), "div", undefined, { class: "layer" });
  const label = element(about, "label");
  const box = element(label, "input", undefined, { type: "checkbox", "data-layer": layer.id });
  element(label, "span", layer.name);
  if (layer.key.length) {
    const key = element(about, "ul");
    for (const [colour, words] of layer.key) {
      const item = element(key, "li");
      const swatch = shape(item, "svg", { viewBox: "0 0 10 10", "aria-hidden": "true" });
      shape(swatch, "rect", { width: 10, height: 10, fill: colour });
      item.append(words);
    }
  }
  if (layer.note) element(about, "small", layer.note);
  const show = () => parts.forEach((part) => (part.style.display = box.checked ? "" : "none"));
  box.checked = layer.on;
  box.addEventListener("change", show);
  show();
}

for (const layer of data.layers) {
  const picture = shape(group("pictures"), "g", { "data-layer": layer.id });
  if (layer.picture) shape(picture, "image", { ...layer.picture, preserveAspectRatio: "none" });
  const drawn = shape(group("shapes"), "g", { "data-layer": layer.id });
  layers.set(layer.id, drawn);
  for (const each of layer.shapes) {
    const parent = each.tip ? shape(drawn, "g") : drawn;
    shape(parent, "path", { d: each.d, stroke: each.colour, "stroke-width": each.wide, class: "line" });
    if (each.tip) {
      shape(parent, "path", { d: each.d, class: "reach" });
      parent.tip = each.tip;
    }
  }
  addSwitch(layer, [picture, drawn]);
}
addSwitch({ id: "rooms", name: "Rooms", on: true, key: [] }, [group("rooms")]);
addSwitch({ id: "final-doors", name: "Doors", on: true, key: [[data.door_colour, many(data.doors.length, "door")]] }, [group("doors")]);
addSwitch({ id: "names", name: named ? "Names and areas" : "Numbers and areas", on: true, key: [] }, [group("names")]);

/* Zoom: the visible part of the map, in cells */

const NEAREST = 4; // cells across, at the highest zoom
let view = data.view;

function unit() {
  return Math.max(view[2] / drawing.clientWidth, view[3] / drawing.clientHeight); // cells per pixel
}

function showView(next) {
  const [whole, least] = [Math.max(data.view[2], data.view[3]), NEAREST];
  const scale = Math.min(Math.max(Math.max(next[2], next[3]), least), 2 * whole) / Math.max(next[2], next[3]);
  const [width, height] = [next[2] * scale, next[3] * scale];
  const middle = [0, 1].map((axis) => {
    const at = next[axis] + next[axis + 2] / 2;
    return Math.min(Math.max(at, data.view[axis]), data.view[axis] + data.view[axis + 2]);
  });
  view = [middle[0] - width / 2, middle[1] - height / 2, width, height];
  drawing.setAttribute("viewBox", view.join(" "));
  fitLabels();
  fitScale();
}

function fitLabels() {
  const cells = unit();
  for (const { size, at, lift, scale, least, text } of labels) {
    const high = 13 * scale * cells;
    text.style.display = size / cells < least ? "none" : "";
    text.setAttribute("font-size", high);
    text.setAttribute("x", at[0]);
    text.setAttribute("y", at[1] + lift * 13 * cells);
  }
}

function fitScale() {
  const metres = unit() * data.resolution_m; // per pixel
  const long = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500].findLast((length) => length / metres < 140) ?? 0.05;
  const bar = group("scale");
  bar.style.width = `${long / metres}px`;
  bar.firstElementChild.textContent = `${long} m`;
}

function placeOf(event) {
  const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(drawing.getScreenCTM().inverse());
  return [point.x, point.y];
}

function zoom(factor, [x, y] = [view[0] + view[2] / 2, view[1] + view[3] / 2]) {
  const least = NEAREST / Math.max(view[2], view[3]);
  const by = Math.min(Math.max(factor, least), (2 * Math.max(data.view[2], data.view[3])) / Math.max(view[2], view[3]));
  showView([x + (view[0] - x) * by, y + (view[1] - y) * by, view[2] * by, view[3] * by]);
}

function move(right, down) {
  showView([view[0] + right, view[1] + down, view[2], view[3]]);
}

function goTo(name) {
  const box = shapes.get(name).getBBox();
  const side = Math.max(box.width, box.height, 3 / data.resolution_m) * 1.4;
  showView([box.x + box.width / 2 - side / 2, box.y + box.height / 2 - side / 2, side, side]);
  frame.scrollIntoView({ block: "nearest" });
}

group("closer").addEventListener("click", () => zoom(1 / 1.5));
group("farther").addEventListener("click", () => zoom(1.5));
group("whole").addEventListener("click", () => showView(data.view));
frame.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey || event.target !== frame) return;
  const step = Math.max(view[2], view[3]) / 10;
  const keys = {
    ArrowLeft: () => move(-step, 0), ArrowRight: () => move(step, 0), ArrowUp: () => move(0, -step), ArrowDown: () => move(0, step),
    "+": () => zoom(1 / 1.5), "=": () => zoom(1 / 1.5), "-": () => zoom(1.5), 0: () => showView(data.view),
  };
  if (!(event.key in keys)) return;
  keys[event.key]();
  event.preventDefault();
});
drawing.addEventListener("wheel", (event) => {
  event.preventDefault();
  zoom(Math.exp(Math.max(-60, Math.min(60, event.deltaY)) * 0.004), placeOf(event));
}, { passive: false });

/* Pointers: one moves the map, two zoom it; without a button pressed, a pointer shows the tip of what is under it */

const held = new Map();

drawing.addEventListener("pointerdown", (event) => {
  held.set(event.pointerId, [event.clientX, event.clientY]);
  drawing.setPointerCapture(event.pointerId);
  drawing.classList.add("moving");
});
for (const end of ["pointerup", "pointercancel"]) {
  drawing.addEventListener(end, (event) => {
    held.delete(event.pointerId);
    if (!held.size) drawing.classList.remove("moving");
  });
}
drawing.addEventListener("pointermove", (event) => {
  if (!held.has(event.pointerId)) return hover(event);
  const before = held.get(event.pointerId);
  const now = [event.clientX, event.clientY];
  const other = [...held.keys()].find((id) => id !== event.pointerId);
  const cells = unit();
  if (other !== undefined) {
    const at = held.get(other);
    const apart = ([x, y]) => Math.max(Math.hypot(x - at[0], y - at[1]), 1);
    zoom(apart(before) / apart(now), placeOf({ clientX: (now[0] + at[0]) / 2, clientY: (now[1] + at[1]) / 2 }));
  } else move((before[0] - now[0]) * cells, (before[1] - now[1]) * cells);
  held.set(event.pointerId, now);
  return undefined;
});
drawing.addEventListener("pointerleave", () => {
  tip.hidden = where.hidden = true;
  mark(undefined);
});

function mark(name) {
  document.querySelectorAll(".hot").forEach((part) => part.classList.remove("hot"));
  for (const part of [shapes.get(name), rows.get(name)]) part?.classList.add("hot");
}

function hover(event) {
  const [x, y] = placeOf(event);
  const [x_m, y_m, ax, ay, bx, by] = data.world_m;
  where.textContent = `x ${(x_m + x * ax + y * bx).toFixed(2)} m, y ${(y_m + x * ay + y * by).toFixed(2)} m, column ${Math.floor(x)}, row ${Math.floor(y)}`;
  where.hidden = false;
  let under = event.target;
  while (under !== drawing && under.tip === undefined) under = under.parentNode;
  tip.hidden = under === drawing;
  mark(under.dataset.name);
  if (tip.hidden) return;
  tip.textContent = under.tip;
  const box = frame.getBoundingClientRect();
  tip.style.left = `${Math.min(event.clientX - box.left + 14, box.width - tip.offsetWidth - 6)}px`;
  const below = event.clientY - box.top + 16;
  tip.style.top = `${below + tip.offsetHeight > box.height ? below - tip.offsetHeight - 26 : below}px`;
}

/* Tables */

function fill(id, heads, lines) {
  const table = group(id);
  const head = element(element(table, "thead"), "tr");
  for (const [name, number] of heads) element(head, "th", name, { scope: "col", class: number ? "number" : "" });
  const body = element(table, "tbody");
  for (const line of lines) {
    const row = element(body, "tr");
    line.forEach((value, column) => {
      const cell = element(row, column ? "td" : "th", undefined, heads[column][1] ? { class: "number" } : {});
      if (!column) cell.setAttribute("scope", "row");
      cell.append(value);
    });
  }
  return [...body.rows];
}

function button(name, colour) {
  const made = document.createElement("button");
  made.type = "button";
  made.textContent = name.split(" ")[1];
  made.setAttribute("aria-label", `Show ${name} on the map`);
  made.style.borderLeftColor = colour;
  made.addEventListener("click", () => { goTo(name); mark(name); });
  made.addEventListener("focus", () => mark(name));
  return made;
}

function connect(made, names) {
  made.forEach((row, index) => {
    rows.set(names[index], row);
    row.addEventListener("pointerenter", () => mark(names[index]));
    row.addEventListener("pointerleave", () => mark(undefined));
  });
}

const place = (point) => point.map((value) => value.toFixed(2)).join(", ");
connect(
  fill("room-table",
    [["Room"], ...(named ? [["Name"]] : []), ["Area, m²", true], ["Centre x, y, m", true], ["Doors"], ["Next to rooms"]],
    data.rooms.map((room) => [button(`room ${room.id}`, room.colour), ...(named ? [room.name] : []), room.area_m2.toFixed(2), place(room.centre_m), room.doors.join(", ") || "none", room.neighbours.join(", ") || "none"])),
  data.rooms.map((room) => `room ${room.id}`));
connect(
  fill("door-table",
    [["Door"], ["Rooms"], ["Width, m", true], ["Length, m", true], ["Tilt, °", true], ["Kind"], ["Middle x, y, m", true]],
    data.doors.map((door) => [button(`door ${door.id}`, data.door_colour), door.rooms.join(" and "), door.width_m.toFixed(2), door.length_m.toFixed(2), door.tilt_deg.toFixed(1), door.kind, place(door.middle_m)])),
  data.doors.map((door) => `door ${door.id}`));
if (!data.doors.length) element(group("door-table").parentNode, "p", "This map has no doors.");

for (const [section, table, lines] of [["numbers", "number-table", data.numbers], ["settings", "setting-table", data.settings]]) {
  group(section).hidden = !lines.length;
  fill(table, [["Stage"], [section === "settings" ? "Setting" : "Number"], ["Value"]], lines);
}

/* The search: its costs, and the doors that the best string of a generation keeps */

const CURVE = { width: 900, height: 270, left: 64, right: 810, top: 14, bottom: 226 };
const LINES = ["worst", "mean", "best"]; // the best is drawn last and labelled lowest

function steps(low, high, wanted) {
  const rough = (high - low) / wanted;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((times) => times * power >= rough);
  const found = [];
  for (let value = Math.ceil(low / step) * step; value <= high + step * 1e-9; value += step) found.push(Number(value.toPrecision(12)));
  return found;
}

function drawCurve(curve) {
  const svg = group("curve");
  svg.setAttribute("viewBox", `0 0 ${CURVE.width} ${CURVE.height}`);
  const costs = LINES.flatMap((name) => curve[name]).filter((cost) => cost !== null);
  let [low, high] = [Math.min(...costs), Math.max(...costs)];
  if (!(high > low)) [low, high] = [(low || 0) - 1, (low || 0) + 1];
  const last = Math.max(curve.number.at(-1), 1);
  const x = (number) => CURVE.left + (number / last) * (CURVE.right - CURVE.left);
  const y = (cost) => CURVE.bottom - ((cost - low) / (high - low)) * (CURVE.bottom - CURVE.top);
  for (const cost of steps(low, high, 5)) {
    shape(svg, "line", { class: "axis", x1: CURVE.left, x2: CURVE.right, y1: y(cost), y2: y(cost) });
    shape(svg, "text", { x: CURVE.left - 8, y: y(cost) + 4, "text-anchor": "end" }, cost);
  }
  for (const number of steps(0, last, 8).filter(Number.isInteger)) {
    shape(svg, "text", { x: x(number), y: CURVE.bottom + 20, "text-anchor": "middle" }, number);
  }
  shape(svg, "text", { x: (CURVE.left + CURVE.right) / 2, y: CURVE.bottom + 40, "text-anchor": "middle" }, "generation");
  shape(svg, "text", { transform: `translate(14 ${(CURVE.top + CURVE.bottom) / 2}) rotate(-90)`, "text-anchor": "middle" }, "cost");
  const ends = [];
  for (const name of LINES) {
    const points = curve.number.map((number, row) => [number, curve[name][row]]).filter(([, cost]) => cost !== null);
    if (!points.length) continue;
    shape(svg, "polyline", { class: name, points: points.map(([number, cost]) => `${x(number)},${y(cost)}`).join(" ") });
    if (points.length === 1) shape(svg, "circle", { class: name, cx: x(points[0][0]), cy: y(points[0][1]), r: 3 });
    ends.push({ name, at: y(points.at(-1)[1]) });
  }
  ends.sort((one, other) => other.at - one.at || LINES.indexOf(other.name) - LINES.indexOf(one.name)); // from the bottom up, no label over the one below
  ends.forEach((end, row) => {
    end.at = row ? Math.min(end.at, ends[row - 1].at - 15) : end.at;
    shape(svg, "text", { class: end.name, x: CURVE.right + 10, y: end.at + 4 }, end.name);
  });
  const here = shape(svg, "line", { class: "here", y1: CURVE.top, y2: CURVE.bottom });
  return { here, x, numberAt: (at) => ((at - CURVE.left) / (CURVE.right - CURVE.left)) * last };
}

function followSearch(curve) {
  const { here, x, numberAt } = drawCurve(curve);
  const slider = group("generation");
  const edges = [...(layers.get("search")?.children ?? [])].map((part) => part.querySelector(".line") ?? part);
  const choices = [];
  const removed = new Set();
  for (const flips of curve.flips) {
    for (const edge of flips) if (!removed.delete(edge)) removed.add(edge);
    choices.push(new Set(removed));
  }
  const text = (cost) => (cost === null ? "not finite" : Number(cost.toPrecision(7)));
  function choose(row) {
    slider.value = row;
    slider.setAttribute("aria-valuetext", `generation ${curve.number[row]}`);
    here.setAttribute("x1", x(curve.number[row]));
    here.setAttribute("x2", x(curve.number[row]));
    const out = choices[row];
    group("chosen").textContent = `${curve.number[row]}: best ${text(curve.best[row])}, mean ${text(curve.mean[row])}, worst ${text(curve.worst[row])}; ${curve.edges - out.size} of ${many(curve.edges, "virtual door")} kept; ${curve.evaluations[row]} evaluations`;
    if (edges.length !== curve.edges) return;
    edges.forEach((edge, index) => {
      edge.setAttribute("stroke", data.colours[out.has(index) ? 1 : 0]);
      edge.setAttribute("stroke-width", out.has(index) ? 2 : 3);
    });
  }
  slider.max = curve.number.length - 1;
  slider.addEventListener("input", () => choose(Number(slider.value)));
  group("curve").addEventListener("pointermove", (event) => {
    const box = group("curve").getScreenCTM().inverse();
    const wanted = numberAt(new DOMPoint(event.clientX, event.clientY).matrixTransform(box).x);
    const away = curve.number.map((number) => Math.abs(number - wanted));
    choose(away.indexOf(Math.min(...away)));
  });
  choose(curve.number.length - 1);
}

if (data.curve) {
  group("search").hidden = false;
  followSearch(data.curve);
}

frame.style.aspectRatio = Math.max(data.view[2] / data.view[3], 0.75);
new ResizeObserver(() => showView(view)).observe(frame);
showView(data.view);
