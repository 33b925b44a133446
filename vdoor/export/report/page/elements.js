"use strict";

const data = JSON.parse(document.getElementById("data").textContent);
const [frame, drawing, tip, where] = ["frame", "drawing", "tip", "where"].map((id) => document.getElementById(id));

/* Elements: text is always inserted as text, never as markup; attributes are set one by one. */

function element(parent, name, text, attributes = {}) {
  const made = document.createElement(name);
  if (text !== undefined) made.textContent = text;
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  parent.append(made);
  return made;
}

function shape(parent, name, attributes = {}, text) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  parent.append(made);
  return made;
}

function group(id) {
  return document.getElementById(id);
}

function many(count, noun) {
  return `${count} ${noun}${count === 1 ? "" : "s"}`;
}
