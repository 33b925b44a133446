/* All parts of the page, once each */

showResult();
drawLayers();
listLeftOut();
startLives();
startDrives();
for (const [section, table, lines] of [["numbers", "number-table", data.numbers], ["settings", "setting-table", data.settings]]) {
  group(section).hidden = !lines.length;
  fill(table, [["Stage"], [section === "settings" ? "Setting" : "Number"], ["Value"]], lines);
}
if (data.curve) {
  group("search").hidden = false;
  followSearch(data.curve);
}
frame.style.aspectRatio = Math.max(data.view[2] / data.view[3], 0.75);
new ResizeObserver(() => showView(view)).observe(frame);
showView(data.view);
