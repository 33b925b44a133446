/* Paths along which a robot drives, by a slider or by itself */

const SECONDS_TO_DRIVE = 20; // from start to end, if it drives by itself

/* The segment that holds a place of the slider, and how far it is along this segment */
function segmentAt(at, value) {
  let [low, high] = [0, at.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (at[middle] <= value) low = middle;
    else high = middle;
  }
  const long = at[high] - at[low];
  return { row: low, next: high, share: long > 0 ? Math.min(Math.max((value - at[low]) / long, 0), 1) : 1 };
}

function clock(seconds) {
  const whole = Math.round(seconds);
  return whole < 60 ? `${whole} s` : `${Math.floor(whole / 60)} min ${whole % 60} s`;
}

const between = (values, { row, next, share }) => values[row] + (values[next] - values[row]) * share;

function driveText(drive, place, value) {
  const driven = `${between(drive.along_m, place).toFixed(1)} of ${drive.along_m.at(-1).toFixed(1)} m`;
  if (drive.unit === "m") return driven;
  const room = drive.rooms[place.next] ? `, room ${drive.rooms[place.next]}` : "";
  return `${clock(value)} of ${clock(drive.at.at(-1))}: ${driven}, ${(100 * between(drive.swept, place)).toFixed(0)} % of what will be swept${room}`;
}

/* The floor that the tool has passed: the picture of the layer is seen where the path, as wide as the tool, has been */
function sweptPath(drive, drawn) {
  const floor = drawn.querySelector("image");
  if (!floor || !drive.tool_m) return undefined;
  const mask = shape(drawn, "mask", { id: `passed-${drive.layer}`, maskUnits: "userSpaceOnUse", x: -1e6, y: -1e6, width: 2e6, height: 2e6 });
  floor.setAttribute("mask", `url(#passed-${drive.layer})`);
  const wide = drive.tool_m / data.resolution_m + 2; // cells at the edge are swept if their middle is
  return shape(mask, "path", { class: "passed", "stroke-width": wide });
}

function addDrive(drive) {
  const drawn = layers.get(drive.layer);
  const passed = sweptPath(drive, drawn);
  const done = shape(drawn, "path", { class: "driven" });
  const robot = shape(drawn, "circle", { class: "robot", r: drive.radius_m / data.resolution_m });
  const [xs, ys] = [0, 1].map((axis) => drive.points.map((each) => each[axis]));
  const places = drive.points.map(([x, y]) => `${x} ${y}`);
  const name = drive.unit === "m" ? "Route" : "Coverage";
  const line = element(group("drives"), "p");
  const id = `drive-${drive.layer}`;
  element(line, "label", name, { for: id });
  const play = element(line, "button", "Drive", { type: "button", "aria-label": `Drive along: ${name.toLowerCase()}` });
  const slider = element(line, "input", undefined, { type: "range", id, min: 0, max: drive.at.at(-1), step: "any" });
  const text = element(line, "output", undefined, { for: id });

  function show(value) {
    const place = segmentAt(drive.at, value);
    const [x, y] = [between(xs, place), between(ys, place)];
    const way = `M${[...places.slice(0, place.row + 1), `${x} ${y}`].join("L")}`;
    done.setAttribute("d", value < drive.at.at(-1) ? way : ""); // at its end the path has the colours of its parts
    passed?.setAttribute("d", way);
    robot.setAttribute("cx", x);
    robot.setAttribute("cy", y);
    text.textContent = driveText(drive, place, value);
    slider.setAttribute("aria-valuetext", text.textContent);
  }

  let from; // when it began to drive by itself, in milliseconds
  function stop() {
    from = undefined;
    play.textContent = "Drive";
  }
  function step(now) {
    if (from === undefined) return;
    const share = (now - from) / 1000 / SECONDS_TO_DRIVE;
    slider.value = Math.min(share, 1) * drive.at.at(-1);
    show(Number(slider.value));
    if (share < 1) requestAnimationFrame(step);
    else stop();
  }
  play.addEventListener("click", () => {
    if (from !== undefined) return stop();
    const share = Number(slider.value) / drive.at.at(-1);
    from = performance.now() - (share < 1 ? share : 0) * 1000 * SECONDS_TO_DRIVE;
    play.textContent = "Stop";
    return requestAnimationFrame(step);
  });
  slider.addEventListener("input", () => {
    stop();
    show(Number(slider.value));
  });
  slider.value = drive.at.at(-1);
  show(drive.at.at(-1));
}

function startDrives() {
  group("drive").hidden = !data.drives.length;
  data.drives.forEach(addDrive);
}
