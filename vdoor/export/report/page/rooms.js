/* The result: facts, rooms and doors. Drawn anew when they change. */

const shapes = new Map(); // "room 3" -> its shape
const rows = new Map(); // "room 3" -> its row in a table
let labels = [];

function roomText(room) {
  const beside = room.neighbours.length ? `next to ${room.neighbours.join(", ")}` : "no neighbours";
  return `${room.name ? `${room.name}, room` : "Room"} ${room.id}: ${room.area_m2.toFixed(1)} m²\n${many(room.doors.length, "door")}, ${beside}`;
}

function doorText(door) {
  const lines = [`Door ${door.id}: ${door.width_m.toFixed(2)} m wide`, `${door.kind}, between rooms ${door.rooms.join(" and ")}`, ...door.why];
  return [...lines, ...(door.candidate in data.lives ? ["click for its life"] : [])].join("\n");
}

function isNamed() {
  return data.rooms.some((room) => room.name);
}

function showFacts() {
  group("facts").replaceChildren();
  for (const [name, value] of data.facts) {
    const pair = element(group("facts"), "div", undefined, value.length > 40 ? { class: "long" } : {});
    element(pair, "dt", name);
    element(pair, "dd", value, { title: value });
  }
}

function drawRooms() {
  group("rooms").replaceChildren();
  for (const room of data.rooms) {
    const name = `room ${room.id}`;
    shapes.set(name, shape(group("rooms"), "path", { id: `room-${room.id}`, d: room.d, fill: room.colour, "data-name": name }));
    shapes.get(name).tip = roomText(room);
  }
}

function drawDoors() {
  group("doors").replaceChildren();
  for (const door of data.doors) {
    const name = `door ${door.id}`;
    const both = shape(group("doors"), "g", { id: `door-${door.id}`, "data-name": name });
    shape(both, "path", { d: door.d, stroke: data.door_colour, class: "line" });
    shape(both, "path", { d: door.d, class: "reach" });
    both.tip = doorText(door);
    both.candidate = door.candidate;
    shapes.set(name, both);
  }
}

function drawLabels() {
  group("names").replaceChildren();
  labels = [];
  for (const room of data.rooms) {
    const size = Math.sqrt(room.area_m2) / data.resolution_m; // in cells
    labels.push({ size, at: room.at, lift: -0.5, scale: 1, least: 16, text: shape(group("names"), "text", {}, room.name || room.id) });
    const area = shape(group("names"), "text", { class: "small" }, `${room.area_m2.toFixed(1)} m²`);
    labels.push({ size, at: room.at, lift: 0.55, scale: 0.8, least: 60, text: area });
  }
  for (const door of data.doors) {
    const size = Math.max(door.length_m, 0.8) / data.resolution_m;
    const text = shape(group("names"), "text", { class: "door" }, door.id);
    labels.push({ size, at: door.at, lift: -0.95, scale: 0.85, least: 14, text });
  }
  labels.sort((one, other) => other.size - one.size);
}

function showResult() {
  shapes.clear();
  rows.clear();
  tip.hidden = true; // it may tell of what is no more
  showFacts();
  drawRooms();
  drawDoors();
  drawLabels();
  fillTables();
}
