/* Starts the tools; what is chosen and half typed comes back after a reload */

const KEPT = "vdoor-edit";

function keep() {
  const form = fieldsOf().map((field) => field.value);
  sessionStorage.setItem(KEPT, JSON.stringify({ tool, form, view }));
}

function bringBack() {
  let kept = {};
  try {
    kept = JSON.parse(sessionStorage.getItem(KEPT)) ?? {};
  } catch {
    // What another page has left there is no reason to fail.
  }
  choose(kept.tool ?? "look");
  fillForm(kept.form ?? []);
  if (kept.view) showView(kept.view);
}

function startKeys() {
  document.addEventListener("keydown", (event) => {
    const typing = /^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName) && event.target.type !== "radio" && event.target.type !== "range";
    if (event.key === "Escape") {
      dropLine();
      pick(undefined);
      group("place-note").hidden = true;
    }
    if (typing || !(event.ctrlKey || event.metaKey) || event.altKey) return;
    const act = { z: event.shiftKey ? redo : undo, y: redo }[event.key.toLowerCase()];
    if (!act) return;
    event.preventDefault();
    act();
  });
}

startForm();
startGestures();
startKeys();
for (const choice of document.getElementsByName("tool")) choice.addEventListener("change", () => choose(choice.value));
group("undo").addEventListener("click", undo);
group("redo").addEventListener("click", redo);
addEventListener("pagehide", keep);
addEventListener("focus", refresh);
showSaved();
bringBack();
