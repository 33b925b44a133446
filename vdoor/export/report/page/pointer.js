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
