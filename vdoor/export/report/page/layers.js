/* Layers of the stages, each with its switch and legend */

const layers = new Map(); // id of a layer -> its shapes

function addKey(parent, lines) {
  const key = element(parent, "ul");
  for (const [colour, words] of lines) {
    const item = element(key, "li");
    const swatch = shape(item, "svg", { viewBox: "0 0 10 10", "aria-hidden": "true" });
    shape(swatch, "rect", { width: 10, height: 10, fill: colour });
    item.append(words);
  }
}

function addSwitch(layer, parts, draw) {
  const about = element(group("layers"), "div", undefined, { class: "layer" });
  const label = element(about, "label");
  const box = element(label, "input", undefined, { type: "checkbox", "data-layer": layer.id });
  element(label, "span", layer.name);
  if (layer.key.length) addKey(about, layer.key);
  if (layer.note) element(about, "small", layer.note);
  let drawn = false;
  const show = () => {
    if (box.checked && !drawn) draw?.();
    drawn ||= box.checked;
    parts.forEach((part) => (part.style.display = box.checked ? "" : "none"));
    about.classList.toggle("off", !box.checked);
  };
  box.checked = layer.on;
  box.addEventListener("change", show);
  show();
}

function drawShape(parent, each) {
  const own = each.tip ? shape(parent, "g") : parent;
  shape(own, "path", { d: each.d, stroke: each.colour, "stroke-width": each.wide, class: "line" });
  if (!each.tip) return;
  shape(own, "path", { d: each.d, class: "reach" });
  own.tip = each.tip;
  own.candidate = each.door;
}

/* A layer is drawn when it is first shown: that of a large map has thousands of shapes */
function addLayer(layer) {
  const picture = shape(group("pictures"), "g", { "data-layer": layer.id });
  const drawn = shape(group("shapes"), "g", { "data-layer": layer.id });
  layers.set(layer.id, drawn);
  addSwitch(layer, [picture, drawn], () => {
    if (layer.picture) {
      const { above, ...place } = layer.picture;
      shape(above ? drawn : picture, "image", { ...place, preserveAspectRatio: "none" });
    }
    for (const each of layer.shapes) drawShape(drawn, each);
    drawn.whenDrawn?.();
  });
}

function drawLayers() {
  data.layers.forEach(addLayer);
  const doors = [[data.door_colour, "between two rooms"]];
  addSwitch({ id: "rooms", name: "Rooms", on: true, key: [] }, [group("rooms")]);
  addSwitch({ id: "final-doors", name: "Doors", on: true, key: doors }, [group("doors")]);
  addSwitch({ id: "names", name: "Names, numbers and areas", on: true, key: [] }, [group("names")]);
}
