"use strict";
// A figure as a file: PNG and SVG as it stands, CSV with what it draws. For the reports' pages and the studio.
(() => {
  const cell = (value) => {
    const text = value === null || value === undefined || Number.isNaN(value) ? "" : String(value);
    return /[",\n]/.test(text) ? '"' + text.replace(/"/g, '""') + '"' : text;
  };
  const plain = (text) => (text || "").replace(/<[^>]*>/g, " ").replace(/\s+/g, " ").trim();
  const titleOf = (axis) => plain(axis && axis.title && axis.title.text);

  // One line for each point: trace, x, y and, of a map, z.
  function table(figure) {
    const rows = [];
    let mapped = false;
    for (const trace of figure._fullData) {
      if (trace.visible !== true || !trace.x && !trace.y) continue;
      const { x, y, z } = trace, name = plain(trace.name);
      if (z) { mapped = true; z.forEach((line, j) => Array.from(line).forEach((value, i) => rows.push([name, x[i], y[j], value]))); }
      else { const n = Math.max(x ? x.length : 0, y ? y.length : 0); for (let i = 0; i < n; i++) rows.push([name, x ? x[i] : i, y ? y[i] : i]); }
    }
    const layout = figure._fullLayout;
    const head = ["trace", titleOf(layout.xaxis) || "x", titleOf(layout.yaxis) || "y", ...(mapped ? ["value"] : [])];
    return [head, ...rows].map((row) => row.map(cell).join(",")).join("\n") + "\n";
  }

  function nameOf(figure) {
    const card = figure.closest(".card, .panel"), title = card && card.querySelector("h2");
    return (plain(title ? title.textContent : "") || figure.parentElement.className || "figure").replace(/[^\p{L}\p{N}]+/gu, "_").slice(0, 60);
  }

  function save(figure, kind) {
    if (kind !== "csv") return Plotly.downloadImage(figure, { format: kind, filename: nameOf(figure), width: figure.clientWidth, height: figure.clientHeight, scale: kind === "png" ? 2 : 1 });
    const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(new Blob([table(figure)], { type: "text/csv" })), download: nameOf(figure) + ".csv" });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  }

  document.addEventListener("click", (event) => {
    const button = event.target.closest("[data-save]");
    for (const menu of document.querySelectorAll(".files[open]")) if (!menu.contains(event.target)) menu.open = false;
    if (!button) return;
    const place = button.closest(".with-files"), figure = place.querySelector(".js-plotly-plot");
    if (figure) save(figure, button.dataset.save);
    button.closest(".files").open = false;
  });

  // The studio brings the menus with its page; a report gets them here.
  for (const place of document.querySelectorAll("main .figure:not(.with-files)")) {
    const menu = document.createElement("details");
    menu.className = "files";
    menu.innerHTML = '<summary title="this figure as a file" aria-label="this figure as a file">⤓</summary><span>' +
      ["png", "svg", "csv"].map((kind) => `<button type="button" data-save="${kind}">${kind.toUpperCase()}</button>`).join("") + "</span>";
    const around = document.createElement("div");
    around.className = "with-files";
    place.replaceWith(around);
    around.append(place, menu);
  }
})();
