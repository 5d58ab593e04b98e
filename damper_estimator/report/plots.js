"use strict";
// Draws the figures that stand in the page's data, each into the element that names it, in the theme's colours.
(() => {
  const { sections, arrays } = JSON.parse(document.getElementById("data").textContent);
  const page = document.documentElement;
  const CONFIG = { responsive: true, displaylogo: false, modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"] };
  const PLAIN = Object.assign({}, CONFIG, { displayModeBar: false });
  const colour = (role) => getComputedStyle(page).getPropertyValue("--" + role).trim();

  // A copy in which "@role" is the theme's colour and {array: n} the n-th array.
  function painted(value) {
    if (typeof value === "string") return value.startsWith("@") ? colour(value.slice(1)) : value;
    if (value && value.array >= 0) return arrays[value.array];
    if (Array.isArray(value)) return value.map(painted);
    if (value && typeof value === "object") return Object.fromEntries(Object.entries(value).map(([key, own]) => [key, painted(own)]));
    return value;
  }

  function layout(own) {
    const axis = { gridcolor: colour("line"), zerolinecolor: colour("samples"), linecolor: colour("line"), automargin: true };
    const complete = Object.assign({ paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
      font: { color: colour("ink"), size: 12, family: getComputedStyle(document.body).fontFamily },
      margin: { l: 50, r: 14, t: 24, b: 40 }, hovermode: "closest", showlegend: false,
      legend: { itemsizing: "constant", orientation: "h", x: 0, xanchor: "left", y: 1, yanchor: "bottom", bgcolor: "rgba(0,0,0,0)" },
      modebar: { bgcolor: "rgba(0,0,0,0)", color: colour("samples"), activecolor: colour("ink") },
      hoverlabel: { bgcolor: colour("card"), font: { color: colour("ink") }, align: "left" } }, painted(own));
    for (const name of Object.keys(complete)) if (/^[xy]axis/.test(name)) complete[name] = Object.assign({}, axis, complete[name]);
    return complete;
  }

  function draw(element) {
    const figure = sections[Number(element.closest("main").id.slice(6))][element.dataset.name];
    if (!figure || element.closest("main[hidden], details:not([open])")) return;
    if (figure.height) element.style.height = figure.height + "px";
    Plotly.react(element, painted(figure.data), layout(figure.layout), figure.plain ? PLAIN : CONFIG);
  }

  function drawAll() { document.querySelectorAll(".plot").forEach(draw); }

  function theme(dark) { page.classList.toggle("dark", dark); drawAll(); }

  for (const tab of document.querySelectorAll(".tab")) tab.addEventListener("click", () => {
    for (const other of document.querySelectorAll(".tab")) other.setAttribute("aria-pressed", String(other === tab));
    document.querySelectorAll("main.damper").forEach((main, i) => { main.hidden = String(i) !== tab.dataset.section; });
    drawAll();
  });
  for (const part of document.querySelectorAll("details")) part.addEventListener("toggle", () => part.querySelectorAll(".plot").forEach(draw));
  const wantsDark = window.matchMedia("(prefers-color-scheme: dark)");
  wantsDark.addEventListener("change", () => theme(wantsDark.matches));
  document.getElementById("theme").addEventListener("click", () => theme(!page.classList.contains("dark")));
  theme(wantsDark.matches);
})();
