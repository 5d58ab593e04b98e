"use strict";
// Draws each figure of the page's data into the element that names it.
(() => {
  const { sections, arrays } = report.data;

  function draw(element) {
    const figure = sections[Number(element.closest("main").id.slice(6))][element.dataset.name];
    if (!figure || element.closest("main[hidden], details:not([open])")) return;
    if (figure.height) element.style.height = figure.height + "px";
    // With the same revision the zoom outlasts a change of theme.
    report.draw(element, Object.assign({}, figure, { layout: Object.assign({ uirevision: "kept" }, figure.layout) }), arrays);
  }

  for (const part of document.querySelectorAll("details")) part.addEventListener("toggle", () => part.querySelectorAll(".plot").forEach(draw));
  report.start(() => document.querySelectorAll(".plot").forEach(draw));
})();
