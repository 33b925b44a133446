/* Tables */

const ROWS_AT_FIRST = 100; // thousands of rows are slow to lay out, and long to walk through by keyboard
const whole = new Set(); // ids of the tables whose rows are all wanted

function addRow(body, heads, cells) {
  const row = element(body, "tr");
  cells.forEach((value, column) => {
    const cell = element(row, column ? "td" : "th", undefined, heads[column][1] ? { class: "number" } : {});
    if (!column) cell.setAttribute("scope", "row");
    cell.append(value);
  });
  return row;
}

/* A row for each item: `cellsOf` gives its cells, and `made` is told of it. Of a long table the rest comes when it is wanted */
function fill(id, heads, items, cellsOf = (item) => item, made = () => {}) {
  const table = group(id);
  table.replaceChildren();
  const head = element(element(table, "thead"), "tr");
  for (const [name, number] of heads) element(head, "th", name, { scope: "col", class: number ? "number" : "" });
  const body = element(table, "tbody");
  const add = (some) => some.map((item) => {
    const row = addRow(body, heads, cellsOf(item));
    made(row, item);
    return row;
  });
  add(whole.has(id) ? items : items.slice(0, ROWS_AT_FIRST));
  if (body.rows.length < items.length) offerRest(table, heads.length, items, add);
}

function offerRest(table, columns, items, add) {
  const foot = element(table, "tfoot");
  const cell = element(element(foot, "tr"), "td", undefined, { colspan: columns });
  const rest = element(cell, "button", `Show all ${items.length}`, { type: "button", class: "rest" });
  rest.addEventListener("click", () => {
    whole.add(table.id);
    const [first] = add(items.slice(ROWS_AT_FIRST));
    foot.remove();
    first.querySelector("button")?.focus({ preventScroll: true });
  });
}

addEventListener("beforeprint", () => document.querySelectorAll("button.rest").forEach((rest) => rest.click()));

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

function connect(row, name) {
  rows.set(name, row);
  row.addEventListener("pointerenter", () => mark(name));
  row.addEventListener("pointerleave", () => mark(undefined));
}

const point = (values) => values.map((value) => value.toFixed(2)).join(", ");

function fillRooms() {
  const named = isNamed();
  const heads = [["Room"], ...(named ? [["Name"]] : []), ["Area, m²", true], ["Centre x, y, m", true], ["Doors"], ["Next to rooms"]];
  const cells = (room) => [
    button(`room ${room.id}`, room.colour), ...(named ? [room.name] : []), room.area_m2.toFixed(2), point(room.centre_m),
    room.doors.join(", ") || "none", room.neighbours.join(", ") || "none",
  ];
  fill("room-table", heads, data.rooms, cells, (row, room) => connect(row, `room ${room.id}`));
}

function fillDoors() {
  const told = data.doors.some((door) => isTold(door.candidate));
  const heads = [["Door"], ["Rooms"], ["Width, m", true], ["Length, m", true], ["Tilt, °", true], ["Kind"], ["Middle x, y, m", true], ...(told ? [["Why"]] : [])];
  const cells = (door) => [
    button(`door ${door.id}`, data.door_colour), door.rooms.join(" and "), door.width_m.toFixed(2), door.length_m.toFixed(2),
    door.tilt_deg.toFixed(1), door.kind, point(door.middle_m), ...(told ? [lifeButton(door)] : []),
  ];
  fill("door-table", heads, data.doors, cells, (row, door) => connect(row, `door ${door.id}`));
  group("no-doors").hidden = data.doors.length > 0;
}

function fillTables() {
  fillRooms();
  fillDoors();
}
