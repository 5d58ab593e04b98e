"use strict";
(() => {
  const [front] = JSON.parse(document.getElementById("data").textContent);
  const page = document.documentElement;
  const CONFIG = { responsive: true, displaylogo: false, modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"] };
  const colour = (role) => getComputedStyle(page).getPropertyValue("--" + role).trim();
  const axis = (group) => ({ title: { text: group + ", error² / start (1)", standoff: 6 }, type: "log", nticks: 5,
    gridcolor: colour("line"), linecolor: colour("line"), automargin: true });
  const numbers = front.objectives[0].map((_, i) => i);

  function draw() {
    for (const figure of document.querySelectorAll(".pair")) {
      const [a, b] = front.pairs[Number(figure.dataset.pair)];
      const points = (which, name, size, role, symbol) => ({ type: "scatter", mode: "markers", name,
        x: which.map((i) => front.objectives[a][i]), y: which.map((i) => front.objectives[b][i]), text: which.map((i) => "point " + i),
        marker: { size, color: colour(role), symbol }, hovertemplate: "%{text}: %{x:.3g}, %{y:.3g}<extra></extra>" });
      Plotly.react(figure, [points(numbers, "solutions", 6, "model0", "circle"),
        points(front.corners, "best for one group", 10, "model2", "diamond"), points([front.picked], "chosen", 12, "model1", "square")],
        { paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", font: { color: colour("ink"), size: 12,
          family: getComputedStyle(document.body).fontFamily }, margin: { l: 60, r: 12, t: 8, b: 45 }, hovermode: "closest",
          showlegend: false, height: 300, modebar: { bgcolor: "rgba(0,0,0,0)", color: colour("samples") },
          xaxis: axis(front.groups[a]), yaxis: axis(front.groups[b]) }, CONFIG);
    }
  }

  draw();
  document.getElementById("theme").addEventListener("click", () => { page.classList.toggle("dark"); draw(); });
})();
