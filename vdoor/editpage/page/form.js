/* The form of a tool: filled in by clicks on the map, or by hand */

function addField(form, [name, options], index) {
  const label = element(form, "label", name);
  if (!options) return element(label, "input", undefined, { name: `field-${index}`, autocomplete: "off", required: "" });
  const list = element(label, "select", undefined, { name: `field-${index}` });
  for (const [value, text] of options()) element(list, "option", text, { value });
  list.selectedIndex = Math.min(index, list.options.length - 1); // of two rooms not the same one twice
  return list;
}

const fieldsOf = () => [...group("edit-form").querySelectorAll("input, select")];

/* Keeps what was filled in, unless the tool is another */
function showForm() {
  const form = group("edit-form");
  const before = form.dataset.tool === tool ? fieldsOf().map((field) => field.value) : [];
  form.replaceChildren();
  form.dataset.tool = tool;
  form.hidden = tool === "look";
  if (form.hidden) return;
  FIELDS[tool].forEach((field, index) => addField(form, field, index));
  element(form, "button", "Do it", { type: "submit" });
  fillForm(before);
  if (picked) pick(picked);
}

function fillForm(values) {
  fieldsOf().forEach((field, index) => {
    const value = values[index];
    if (value === undefined) return;
    const listed = field.options === undefined || [...field.options].some((option) => option.value === String(value));
    if (listed) field.value = value;
  });
}

function nameOf(id) {
  return data.rooms.find((room) => room.id === Number(id))?.name ?? "";
}

async function submit(at) {
  const words = fieldsOf().map((field) => field.value.replaceAll(" ", tool === "rename" ? " " : ""));
  const done = await edit([tool, ...words], at);
  if (done && tool !== "rename") fieldsOf().forEach((field) => field.options ?? (field.value = ""));
  return done;
}

function startForm() {
  const form = group("edit-form");
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    submit();
  });
  form.addEventListener("change", (event) => {
    if (tool === "rename" && event.target.name === "field-0") fieldsOf()[1].value = nameOf(event.target.value);
  });
}
