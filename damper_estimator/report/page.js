"use strict";
// The page of compare: forces over time and motion, which follow the zoom, and where the models fail.
(() => {
  const sections = report.data;
  const TIME_POINTS = 8500, LINE_POINTS = 2500, CLOUD_POINTS = 2200;

  function unpackRecording(packed) {
    const motion = {};
    for (const axis in packed.motion) motion[axis] = report.unpack(packed.motion[axis]);
    const measured = report.unpack(packed.measured), modelled = packed.modelled.map(report.unpack);
    const residual = modelled.map((force) => force.map((value, i) => value - measured[i]));
    return { time: report.unpack(packed.time), detail: report.unpack(packed.detail), measured, modelled, residual, motion };
  }

  // First index with time >= value.
  function lowerBound(time, value) {
    let low = 0, high = time.length;
    while (low < high) { const middle = (low + high) >> 1; if (time[middle] < value) low = middle + 1; else high = middle; }
    return low;
  }

  // The samples on view, of the finest level of detail with which they are at most so many.
  function rowsOf(detail, first, last, most) {
    const counts = new Array(256).fill(0);
    for (let i = first; i < last; i++) counts[detail[i]] += 1;
    let level = 0, count = counts[0];
    while (level < 255 && count + counts[level + 1] <= most) { level += 1; count += counts[level]; }
    const rows = [];
    for (let i = first; i < last; i++) if (detail[i] <= level) rows.push(i);
    return rows;
  }

  const pick = (values, rows) => values.constructor.from(rows, (i) => values[i]);

  class Damper {
    constructor(element, data) {
      this.element = element; this.data = data; this.unpacked = []; this.index = 0; this.range = null; this.drawn = false;
      const select = element.querySelector(".recording");
      if (select) select.addEventListener("change", () => this.show(Number(select.value), null));
      for (const button of element.querySelectorAll(".zoom")) button.addEventListener("click", () => this.zoomTo(button.dataset.seconds));
      for (const button of element.querySelectorAll(".over")) button.addEventListener("click", () => this.mapOver(button));
      for (const button of element.querySelectorAll(".region")) button.addEventListener("click", () => this.goTo(button));
    }

    get recording() {
      return this.unpacked[this.index] || (this.unpacked[this.index] = unpackRecording(this.data.recordings[this.index]));
    }

    show(index, range) { this.index = index; this.range = range; this.draw(); }

    goTo(button) {
      const index = Number(button.dataset.recording), time = Number(button.dataset.time);
      const select = this.element.querySelector(".recording");
      if (select) select.value = String(index);
      this.show(index, [time - 1, time + 1]);
      this.element.querySelector(".time").scrollIntoView({ behavior: "smooth", block: "center" });
    }

    // "all", or so many seconds about the largest residual of the first model.
    zoomTo(seconds) { this.show(this.index, seconds === "all" ? null : this.worst(Number(seconds))); }

    worst(seconds) {
      const { time, residual } = this.recording;
      let worst = 0;
      residual[0].forEach((value, i) => { if (!(Math.abs(value) <= Math.abs(residual[0][worst]))) if (!Number.isNaN(value)) worst = i; });
      // Within the recording: beside its ends there is nothing to see.
      const last = time[time.length - 1], start = Math.max(Math.min(time[worst] - seconds / 2, last - seconds), time[0]);
      return [start, Math.min(start + seconds, last)];
    }

    span() {
      const time = this.recording.time;
      if (!this.range) return [0, time.length];
      return [Math.max(0, lowerBound(time, this.range[0]) - 1), Math.min(time.length, lowerBound(time, this.range[1]) + 1)];
    }

    draw() {
      // It opens on the worst second, where that is less than all of it.
      if (!this.opened && this.recording.time[this.recording.time.length - 1] - this.recording.time[0] > 2) this.range = this.worst(1);
      this.opened = true;
      this.drawTime();
      this.drawClouds();
      for (const figure of this.element.querySelectorAll(".map")) this.drawMap(figure);
      for (const figure of this.element.querySelectorAll(".curves")) this.drawCurves(figure);
      this.drawn = true;
    }

    drawTime() {
      const { time, detail, measured, modelled, residual } = this.recording, [first, last] = this.span();
      const rows = rowsOf(detail, first, last, TIME_POINTS), x = pick(time, rows);
      const columns = [measured, ...modelled, ...residual], { data, layout } = this.data.time;
      const traces = data.map((trace, i) => Object.assign({}, trace, { x, y: pick(columns[i], rows) }));
      const range = this.range || [time[0], time[time.length - 1]];
      const figure = this.element.querySelector(".time");
      report.draw(figure, { data: traces, layout: Object.assign({}, layout, { xaxis: Object.assign({}, layout.xaxis, { range }) }) });
      if (!figure.dataset.linked) {
        figure.dataset.linked = "yes";
        figure.on("plotly_relayout", (change) => this.zoomed(change));
      }
    }

    zoomed(change) {
      if (change["xaxis.range[0]"] !== undefined) this.range = [change["xaxis.range[0]"], change["xaxis.range[1]"]];
      else if (change["xaxis.range"]) this.range = change["xaxis.range"];
      else if (change["xaxis.autorange"]) this.range = null;
      else return;
      clearTimeout(this.waiting);
      this.waiting = setTimeout(() => { this.drawTime(); this.drawClouds(); }, 40);
    }

    drawClouds() {
      const { detail, measured, modelled, motion } = this.recording, [first, last] = this.span();
      const mode = last - first <= LINE_POINTS ? "lines" : "markers";
      const rows = rowsOf(detail, first, last, mode === "lines" ? LINE_POINTS : CLOUD_POINTS);
      for (const figure of this.element.querySelectorAll(".cloud")) {
        const { data, layout } = this.data.clouds[figure.dataset.axis], x = pick(motion[figure.dataset.axis], rows);
        const traces = data.map((trace, i) => Object.assign({}, trace, { mode, x, y: pick([measured, ...modelled][i], rows) }));
        report.draw(figure, { data: traces, layout });
      }
    }

    drawMap(figure) {
      const map = this.data.maps[Number(figure.dataset.model)][figure.dataset.over];
      if (!map) { Plotly.purge(figure); figure.textContent = "Frequency and amplitude hardly vary in these recordings."; return; }
      if (!figure.querySelector(".plot-container")) figure.textContent = "";
      report.draw(figure, map);
    }

    mapOver(button) {
      const card = button.closest(".card"), figure = card.querySelector(".map");
      for (const other of card.querySelectorAll(".over")) other.setAttribute("aria-pressed", String(other === button));
      figure.dataset.over = button.dataset.over;
      this.drawMap(figure);
    }

    drawCurves(figure) {
      const curves = this.data[figure.dataset.name];
      if (!curves) { figure.textContent = "The recording is too short for this figure."; return; }
      report.draw(figure, curves);
    }
  }

  const dampers = sections.map((data, i) => new Damper(document.getElementById("damper" + i), data));
  const current = () => dampers.find((damper) => !damper.element.hidden);

  report.start((themed) => {
    if (themed) for (const damper of dampers) damper.drawn = false;
    if (!current().drawn) current().draw();
  });
})();
