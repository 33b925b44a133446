/* Tables */

function fill(id, heads, lines) {
  const table = group(id);
  table.replaceChildren();
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

const point = (values) => values.map((value) => value.toFixed(2)).join(", ");

function fillRooms() {
  const named = isNamed();
  const heads = [["Room"], ...(named ? [["Name"]] : []), ["Area, m²", true], ["Centre x, y, m", true], ["Doors"], ["Next to rooms"]];
  const lines = data.rooms.map((room) => [
    button(`room ${room.id}`, room.colour), ...(named ? [room.name] : []), room.area_m2.toFixed(2), point(room.centre_m),
    room.doors.join(", ") || "none", room.neighbours.join(", ") || "none",
  ]);
  connect(fill("room-table", heads, lines), data.rooms.map((room) => `room ${room.id}`));
}

function fillDoors() {
  const told = data.doors.some((door) => isTold(door.candidate));
  const heads = [["Door"], ["Rooms"], ["Width, m", true], ["Length, m", true], ["Tilt, °", true], ["Kind"], ["Middle x, y, m", true], ...(told ? [["Why"]] : [])];
  const lines = data.doors.map((door) => [
    button(`door ${door.id}`, data.door_colour), door.rooms.join(" and "), door.width_m.toFixed(2), door.length_m.toFixed(2),
    door.tilt_deg.toFixed(1), door.kind, point(door.middle_m), ...(told ? [lifeButton(door)] : []),
  ]);
  connect(fill("door-table", heads, lines), data.doors.map((door) => `door ${door.id}`));
  group("no-doors").hidden = data.doors.length > 0;
}

function fillTables() {
  fillRooms();
  fillDoors();
}
