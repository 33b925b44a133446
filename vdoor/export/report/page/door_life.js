/* The life of a virtual door, from its proposal to the final map; shown by a click on it, or by its number */

const isTold = (candidate) => candidate !== undefined && candidate in data.lives;

function finalDoorOf(candidate) {
  return data.doors.find((door) => door.candidate === candidate);
}

function showLife(candidate) {
  group("life-number").value = candidate;
  const list = group("life-lines");
  list.replaceChildren();
  const door = finalDoorOf(candidate);
  group("life-heading").textContent = `Virtual door ${candidate}${door ? `, door ${door.id} of the map` : ""}`;
  const lines = data.lives[candidate] ?? ["There is no such virtual door here, or it is one of too many to be told; `vdoor why --candidate` tells of any."];
  for (const line of lines) element(list, "li", line);
}

function openLife(candidate) {
  showLife(candidate);
  group("life").scrollIntoView({ block: "nearest" });
}

function candidateAt(event) {
  let under = event.target;
  while (under !== drawing && under.tip === undefined) under = under.parentNode;
  return under === drawing ? undefined : under.candidate;
}

function lifeButton(door) {
  if (!isTold(door.candidate)) return "";
  const made = document.createElement("button");
  made.type = "button";
  made.textContent = door.candidate;
  made.setAttribute("aria-label", `Why door ${door.id} is there: the life of virtual door ${door.candidate}`);
  made.addEventListener("click", () => {
    openLife(door.candidate);
    group("life-number").focus();
  });
  return made;
}

function startLives() {
  const told = Object.keys(data.lives).map(Number);
  group("life").hidden = !told.length;
  if (!told.length) return;
  group("life-number").max = Math.max(...told);
  group("life-number").addEventListener("change", () => showLife(Number(group("life-number").value)));
  showLife(data.doors.map((door) => door.candidate).find(isTold) ?? told[0]);
  let pressed = [0, 0];
  drawing.addEventListener("pointerdown", (event) => (pressed = [event.clientX, event.clientY]));
  drawing.addEventListener("click", (event) => {
    const dragged = Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 4;
    const under = document.elementFromPoint(event.clientX, event.clientY);
    const candidate = dragged || !drawing.contains(under) ? undefined : candidateAt({ target: under });
    if (candidate !== undefined && candidate >= 0) openLife(candidate);
  });
}
