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
  const drawn = layers.get("search");
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
    const edges = [...(drawn?.children ?? [])].map((part) => part.querySelector(".line") ?? part);
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
  if (drawn) drawn.whenDrawn = () => choose(Number(slider.value));
  choose(curve.number.length - 1);
}

if (data.curve) {
  group("search").hidden = false;
  followSearch(data.curve);
}
