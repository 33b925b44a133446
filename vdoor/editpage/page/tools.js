/* The tools: what each is for, and the fields that it has for those who do not point */

const HINTS = {
  look: "Drag to move, turn the wheel to zoom. Choose a tool to edit.",
  rename: "Click a room and type its name.",
  split: "Draw a line across a room, by dragging or by two clicks; it is extended to the walls.",
  merge: "Click two rooms with a door between them; the first one's name stays.",
  "add-door": "Draw a line from jamb to jamb.",
  "remove-door": "Click a door: the rooms that it joins become one.",
};

let tool = "look";
let picked; // the room that was clicked first, to be merged

const roomTitle = (room) => (room.name ? `${room.id} ${room.name}` : `${room.id}`);
const roomOptions = () => data.rooms.map((room) => [room.id, roomTitle(room)]);
const doorOptions = () => data.doors.map((door) => [door.id, `${door.id}, rooms ${door.rooms.join(" and ")}`]);

const FIELDS = {
  look: [],
  rename: [["Room", roomOptions], ["Name"]],
  split: [["From x,y"], ["To x,y"]],
  merge: [["Room", roomOptions], ["With", roomOptions]],
  "add-door": [["From x,y"], ["To x,y"]],
  "remove-door": [["Door", doorOptions]],
};

function pick(room) {
  picked = room;
  document.querySelectorAll(".picked").forEach((part) => part.classList.remove("picked"));
  if (room) shapes.get(`room ${room}`)?.classList.add("picked");
}

function choose(name) {
  tool = name in HINTS ? name : "look";
  pick(undefined);
  frame.dataset.tool = tool;
  group("place-note").hidden = true;
  document.querySelector(`[name=tool][value=${tool}]`).checked = true;
  group("hint").textContent = HINTS[tool];
  showForm();
}

/* X,Y of a place of the drawing, in metres, as the commands take it */
function placeText([x, y]) {
  const [x_m, y_m, ax, ay, bx, by] = data.world_m;
  return `${(x_m + x * ax + y * bx).toFixed(3)},${(y_m + x * ay + y * by).toFixed(3)}`;
}

function roomUnder(event) {
  const name = document.elementsFromPoint(event.clientX, event.clientY).find((part) => part.dataset?.name?.startsWith("room "))?.dataset.name;
  return name && Number(name.slice(5));
}

function doorUnder(event) {
  const part = document.elementsFromPoint(event.clientX, event.clientY).find((each) => each.parentNode?.dataset?.name?.startsWith("door "));
  return part && Number(part.parentNode.dataset.name.slice(5));
}
