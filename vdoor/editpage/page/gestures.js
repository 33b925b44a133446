/* Clicks and lines on the map, before the map's own panning sees them */

const DRAG = 5; // pixels: less is a click

let line; // the line that is drawn: its first end, and its shape

function beginLine(event) {
  const from = placeOf(event);
  line = { from, pressed: [event.clientX, event.clientY], shape: shape(drawing, "line", { class: "drawn", x1: from[0], y1: from[1], x2: from[0], y2: from[1] }) };
}

function dropLine() {
  line?.shape.remove();
  line = undefined;
}

function pullLine(event) {
  const [x, y] = placeOf(event);
  line.shape.setAttribute("x2", x);
  line.shape.setAttribute("y2", y);
}

async function endLine(event) {
  const { from } = line;
  const to = placeOf(event);
  fillForm([placeText(from), placeText(to)]);
  await submit([event.clientX, event.clientY]);
  dropLine();
}

const isClick = (event) => Math.hypot(event.clientX - line.pressed[0], event.clientY - line.pressed[1]) < DRAG;

function clickRoom(room, at) {
  if (tool === "rename") {
    pick(room);
    fillForm([room, nameOf(room)]);
    fieldsOf()[1].focus();
    fieldsOf()[1].select();
  } else if (picked === undefined) {
    pick(room);
    fillForm([room]);
    say(`Room ${room}: now click the room to merge into it.`);
  } else {
    fillForm([picked, room]);
    pick(undefined);
    submit(at);
  }
}

function clickThing(event) {
  const at = [event.clientX, event.clientY];
  if (tool === "remove-door") {
    const door = doorUnder(event);
    if (door === undefined) complain("Click on a door.", at);
    else {
      fillForm([door]);
      submit(at);
    }
    return;
  }
  const room = roomUnder(event);
  if (room === undefined) complain("There is no room at this place.", at);
  else clickRoom(room, at);
}

const draws = () => tool === "split" || tool === "add-door";

function startGestures() {
  const capture = (name, act) =>
    frame.addEventListener(name, (event) => {
      if (tool === "look" || !drawing.contains(event.target) || event.button > 0) return;
      act(event);
    }, { capture: true });
  capture("pointerdown", (event) => {
    event.stopPropagation();
    group("place-note").hidden = true;
    if (draws() && !line) beginLine(event);
  });
  capture("pointermove", (event) => line && pullLine(event));
  capture("pointerup", (event) => {
    event.stopPropagation();
    if (!draws()) return clickThing(event);
    if (!line) return undefined;
    const first = !line.clicked && isClick(event);
    line.clicked = true;
    if (!first) return endLine(event);
    return say("Now click where the line ends.");
  });
  capture("click", (event) => event.stopPropagation());
}
