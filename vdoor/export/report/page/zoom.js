/* Zoom: the visible part of the map, in cells */

const NEAREST = 4; // cells across, at the highest zoom
const SQUARE = 50; // pixels
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
    return Math.min(Math.max(at, 0), data.size[axis]);
  });
  view = [middle[0] - width / 2, middle[1] - height / 2, width, height];
  drawing.setAttribute("viewBox", view.join(" "));
  tip.hidden = true; // something else lies under the pointer now
  fitLabels();
  fitScale();
}

/* A label that would cover one before it is left out; those of large rooms come first. Places are kept by squares of the window. */
function fitLabels() {
  const cells = unit();
  const taken = new Map();
  for (const { size, at, lift, scale, least, text } of labels) {
    const high = 13 * scale * cells;
    const y = at[1] + lift * 13 * cells;
    const shown = size / cells >= least && isFree(taken, [at[0] / cells, y / cells], [text.textContent.length * 8 * scale, 14 * scale]);
    text.style.display = shown ? "" : "none";
    if (!shown) continue;
    text.setAttribute("font-size", high);
    text.setAttribute("x", at[0]);
    text.setAttribute("y", y);
  }
}

function isFree(taken, [x, y], [width, height]) {
  const box = [x - width / 2, y - height / 2, x + width / 2, y + height / 2];
  const squares = [];
  for (let right = Math.floor(box[0] / SQUARE); right <= box[2] / SQUARE; right++)
    for (let down = Math.floor(box[1] / SQUARE); down <= box[3] / SQUARE; down++) squares.push(`${right} ${down}`);
  const near = squares.flatMap((square) => taken.get(square) ?? []);
  if (near.some((other) => box[0] < other[2] && other[0] < box[2] && box[1] < other[3] && other[1] < box[3])) return false;
  for (const square of squares) taken.set(square, [...(taken.get(square) ?? []), box]);
  return true;
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

function goToBox(box) {
  const side = Math.max(box.width, box.height, 3 / data.resolution_m) * 1.4;
  showView([box.x + box.width / 2 - side / 2, box.y + box.height / 2 - side / 2, side, side]);
  frame.scrollIntoView({ block: "nearest" });
}

function goTo(name) {
  goToBox(shapes.get(name).getBBox());
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
