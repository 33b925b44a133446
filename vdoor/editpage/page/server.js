/* What the page asks the server for, and what it shows of the answers. One request at a time. */

let asking = false;

function say(text) {
  group("said").textContent = text;
}

function showSaved() {
  const { undo, redo, file, edits, count } = data.edit;
  for (const [id, what] of [["undo", undo], ["redo", redo]]) {
    group(id).disabled = !what;
    group(id).title = what;
  }
  group("saved").textContent = count ? `Saved in ${file}` : `No edits yet; each is saved at once in ${file}`;
  group("edit-count").textContent = many(count, "edit");
  group("edit-list").replaceChildren();
  for (const edit of edits) element(group("edit-list"), "li", edit);
}

function showState(state) {
  if (state.edit.grid !== data.edit.grid) return location.reload(); // another map was run into the folder
  for (const part of ["facts", "rooms", "doors", "edit"]) data[part] = state[part];
  showResult();
  fitLabels();
  showSaved();
  return showForm();
}

/* A sentence on what cannot be done, beside the place where it was wanted, if there is one */
function complain(sentence, at) {
  const note = group("place-note");
  note.textContent = sentence;
  note.hidden = false;
  tip.hidden = true;
  const box = (at ? frame : group("tools")).getBoundingClientRect();
  const [x, y] = at ?? [box.left + 12, box.bottom];
  note.style.left = `${Math.max(6, Math.min(x + 12, innerWidth - note.offsetWidth - 6))}px`;
  note.style.top = `${Math.max(6, Math.min(y + 12, innerHeight - note.offsetHeight - 6))}px`;
  say("");
}

async function post(name, body) {
  const sent = JSON.stringify({ ...body, seen: data.edit.version });
  const answer = await fetch(name, { method: "POST", headers: { "Content-Type": "application/json" }, body: sent });
  return answer.json();
}

/* Whether it was done. A server that is gone is said as well: what was shown as done is on its disk. */
async function ask(name, body, at) {
  if (asking) return false;
  asking = true;
  group("place-note").hidden = true;
  const slow = setTimeout(() => say("Working …"), 400); // a map of a thousand rooms takes a while
  try {
    const told = await post(name, body);
    if (told.rooms) showState(told);
    if (told.said) say(told.said);
    else complain(told.sentence, at);
    return Boolean(told.said);
  } catch {
    complain("The page's server does not answer. Edits up to now are saved; start `vdoor edit` again.", at);
    return false;
  } finally {
    clearTimeout(slow);
    asking = false;
  }
}

const undo = () => ask("undo", {});
const redo = () => ask("redo", {});
const edit = (words, at) => ask("do", { words }, at);

/* Edits from elsewhere, such as the commands, are shown when one comes back to the page */
async function refresh() {
  if (asking) return;
  try {
    const state = await (await fetch("state")).json();
    if (state.edit && state.edit.version !== data.edit.version) showState(state);
  } catch {
    // The server is gone: the next edit says so.
  }
}
