"use strict";
// For all pages: draws the figures that Python made, in the theme's template and colours; switches theme and damper.
const report = (() => {
  const THEMES = JSON.parse(document.getElementById("themes").textContent);
  const TYPES = { f4: Float32Array, f8: Float64Array, u1: Uint8Array };
  const CONFIG = { responsive: true, displaylogo: false, modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"] };
  const PLAIN = Object.assign({}, CONFIG, { displayModeBar: false });
  const root = document.documentElement, tabs = document.querySelectorAll(".tab");
  const theme = () => THEMES[root.classList.contains("dark") ? "dark" : "light"];

  function unpack(column) {
    const text = atob(column.bdata), bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
    return new TYPES[column.dtype](bytes.buffer);
  }

  // A copy in which "@role" is the theme's colour and {array: n} the n-th array.
  function coloured(value, arrays) {
    if (typeof value === "string") return value.startsWith("@") ? theme().colours[value.slice(1)] || value : value;
    if (!value || typeof value !== "object" || ArrayBuffer.isView(value)) return value;
    if (Array.isArray(value)) return value.map((inner) => coloured(inner, arrays));
    if (value.array >= 0) return arrays[value.array];
    return Object.fromEntries(Object.entries(value).map(([key, inner]) => [key, coloured(inner, arrays)]));
  }

  function draw(element, figure, arrays) {
    const layout = Object.assign({ template: theme().template }, coloured(figure.layout, arrays));
    Plotly.react(element, coloured(figure.data, arrays), layout, figure.plain ? PLAIN : CONFIG);
  }

  // Calls redraw(true) when the theme has changed and redraw(false) when another damper is shown; draws at once.
  function start(redraw) {
    const show = (dark) => { root.classList.toggle("dark", dark); redraw(true); };
    for (const tab of tabs) tab.addEventListener("click", () => {
      for (const other of tabs) other.setAttribute("aria-pressed", String(other === tab));
      document.querySelectorAll("main.damper").forEach((main, i) => { main.hidden = String(i) !== tab.dataset.section; });
      redraw(false);
    });
    const wantsDark = window.matchMedia("(prefers-color-scheme: dark)");
    wantsDark.addEventListener("change", () => show(wantsDark.matches));
    document.getElementById("theme").addEventListener("click", () => show(!root.classList.contains("dark")));
    show(wantsDark.matches);
  }

  return { data: JSON.parse(document.getElementById("data").textContent), draw, start, unpack };
})();
