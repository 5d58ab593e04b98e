"use strict";
// Draws the chosen loop with its points in front of the others of its role, which are pale.
(() => {
  const { sections, styles, axes } = report.data;

  for (const loops of sections) for (const loop of loops) {
    loop.force = report.unpack(loop.force);
    for (const axis in loop.motion) loop.motion[axis] = report.unpack(loop.motion[axis]);
  }

  const mainOf = (number) => document.getElementById("damper" + number);

  function draw(number) {
    const main = mainOf(number), loops = sections[number], chosen = loops[main.chosen];
    for (const figure of main.querySelectorAll(".loop")) {
      const name = figure.dataset.axis, others = loops.filter((loop) => loop.role === chosen.role && loop !== chosen);
      const filled = (style, loop) => Object.assign({}, style, { name: loop.name, x: loop.motion[name], y: loop.force });
      const data = others.map((loop) => filled(loop.steady ? styles.steady : styles.single, loop));
      const { points } = chosen;
      data.push(filled(styles.chosen, chosen), Object.assign({}, styles.points,
        { x: points[name], y: points.force, text: points.name, textposition: points.textposition }));
      report.draw(figure, { data, layout: axes[name] });
    }
  }

  function choose(number, index) {
    const main = mainOf(number);
    main.chosen = index;
    for (const row of main.querySelectorAll("tr[data-loop]")) row.setAttribute("aria-selected", row.dataset.loop === String(index));
    main.querySelectorAll(".details").forEach((part, i) => { part.hidden = i !== index; });
    draw(number);
  }

  const reach = (loop) => Math.max(...loop.motion.velocity);
  sections.forEach((loops, number) => {
    const main = mainOf(number);
    for (const row of main.querySelectorAll("tr[data-loop]")) {
      row.addEventListener("click", () => choose(number, Number(row.dataset.loop)));
      row.addEventListener("keydown", (event) => { if (event.key === "Enter") choose(number, Number(row.dataset.loop)); });
    }
    main.first = loops.reduce((best, loop, i) => loop.role === "total" && reach(loop) > reach(loops[best]) ? i : best, 0);
  });
  report.start(() => sections.forEach((_, number) => { if (!mainOf(number).hidden) choose(number, mainOf(number).chosen ?? mainOf(number).first); }));
})();
