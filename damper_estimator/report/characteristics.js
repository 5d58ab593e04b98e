"use strict";
(() => {
  const sections = JSON.parse(document.getElementById("data").textContent);
  const page = document.documentElement;
  const CONFIG = { responsive: true, displaylogo: false, modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"] };
  const AXES = { displacement: "displacement in mm", velocity: "velocity in m/s", acceleration: "acceleration in m/s²" };
  const colour = (role) => getComputedStyle(page).getPropertyValue("--" + role).trim();

  function unpack(column) {
    const text = atob(column.bdata), bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
    return Array.from(new Float32Array(bytes.buffer));
  }

  for (const loops of sections) for (const loop of loops) {
    loop.force = unpack(loop.force);
    for (const axis in loop.motion) loop.motion[axis] = unpack(loop.motion[axis]);
  }

  function axis(title) {
    return { title: { text: title, standoff: 6 }, gridcolor: colour("line"), zerolinecolor: colour("samples"),
      linecolor: colour("line"), automargin: true };
  }

  function layout(title) {
    return { paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", font: { color: colour("ink"), size: 12,
      family: getComputedStyle(document.body).fontFamily }, margin: { l: 55, r: 12, t: 8, b: 40 }, hovermode: "closest",
      showlegend: false, modebar: { bgcolor: "rgba(0,0,0,0)", color: colour("samples"), activecolor: colour("ink") },
      hoverlabel: { bgcolor: colour("card"), font: { color: colour("ink") } }, xaxis: axis(title), yaxis: axis("force in N") };
  }

  // The chosen loop with its points in front; the others of the same role pale behind it.
  function draw(number) {
    const main = document.getElementById("damper" + number), loops = sections[number], chosen = loops[main.chosen];
    for (const figure of main.querySelectorAll(".loop")) {
      const name = figure.dataset.axis;
      const traces = loops.filter((l) => l.role === chosen.role && l !== chosen).map((l) => ({ type: "scatter", mode: "lines",
        name: l.name, x: l.motion[name], y: l.force, line: { color: colour("samples"), width: 1, dash: l.steady ? "solid" : "dot" },
        opacity: 0.55, hovertemplate: "%{y:.0f} N<extra>" + l.name + "</extra>" }));
      traces.push({ type: "scatter", mode: "lines", x: chosen.motion[name], y: chosen.force, line: { color: colour("model0"), width: 2.5 },
        hovertemplate: "%{x:.4g}, %{y:.0f} N<extra>" + chosen.name + "</extra>" });
      traces.push({ type: "scatter", mode: "markers+text", x: chosen.points[name], y: chosen.points.force, text: chosen.points.name,
        textposition: chosen.points.name.map((n) => "CGDH".includes(n) ? "middle left" : "middle right"),
        textfont: { size: 14, color: colour("ink") }, marker: { size: 9, color: colour("model1") },
        hovertemplate: "%{text}: %{x:.4g}, %{y:.0f} N<extra></extra>" });
      Plotly.react(figure, traces, layout(AXES[name]), CONFIG);
    }
  }

  function choose(number, index) {
    const main = document.getElementById("damper" + number);
    main.chosen = index;
    for (const row of main.querySelectorAll("tr[data-loop]")) row.setAttribute("aria-selected", row.dataset.loop === String(index));
    main.querySelectorAll(".details").forEach((part, i) => { part.hidden = i !== index; });
    draw(number);
  }

  sections.forEach((loops, number) => {
    const main = document.getElementById("damper" + number);
    for (const row of main.querySelectorAll("tr[data-loop]")) {
      row.addEventListener("click", () => choose(number, Number(row.dataset.loop)));
      row.addEventListener("keydown", (event) => { if (event.key === "Enter") choose(number, Number(row.dataset.loop)); });
    }
    const reach = (l) => Math.max(...l.motion.velocity);
    const first = loops.reduce((best, l, i) => l.role === "total" && reach(l) > reach(loops[best]) ? i : best, 0);
    main.first = first;
    if (!main.hidden) choose(number, first);
  });
  for (const tab of document.querySelectorAll(".tab")) tab.addEventListener("click", () => {
    document.querySelectorAll("main").forEach((main, i) => { main.hidden = String(i) !== tab.dataset.section; });
    document.querySelectorAll(".tab").forEach((other) => other.setAttribute("aria-pressed", other === tab));
    const number = Number(tab.dataset.section), main = document.getElementById("damper" + number);
    choose(number, main.chosen ?? main.first);
  });
  document.getElementById("theme").addEventListener("click", () => {
    page.classList.toggle("dark");
    sections.forEach((_, number) => { if (!document.getElementById("damper" + number).hidden) draw(number); });
  });
})();
