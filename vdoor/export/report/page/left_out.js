/* What the map shows as free but no room has, and why */

function showPlace(place) {
  const box = document.querySelector("#layers [data-layer=left-out]");
  if (!box.checked) box.click();
  goToBox({ x: place.at[0] - 1, y: place.at[1] - 1, width: 2, height: 2 });
}

function placeButton(place, index) {
  if (!place.at) return "others";
  const made = document.createElement("button");
  made.type = "button";
  made.textContent = index + 1;
  made.setAttribute("aria-label", `Show place ${index + 1} that was left out on the map`);
  made.addEventListener("click", () => showPlace(place));
  return made;
}

function listLeftOut() {
  group("left-out").hidden = !data.left_out.length;
  fill(
    "left-out-table",
    [["Place"], ["Area, m²", true], ["At x, y, m", true], ["Why"]],
    data.left_out.map((place, index) => [placeButton(place, index), place.area_m2.toFixed(2), place.place_m ? point(place.place_m) : "", place.why]),
  );
}
