"use strict";
(() => {
  const sections = JSON.parse(document.getElementById("data").textContent);
  const page = document.documentElement;
  const KINDS = { f4: Float32Array, f8: Float64Array };
  const CONFIG = { responsive: true, displaylogo: false, modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"] };
  const AXES = { displacement: "displacement in mm", velocity: "velocity in m/s", acceleration: "acceleration in m/s²" };
  const BUCKETS = 1500, LINE_POINTS = 2500, CLOUD_POINTS = 2200;

  const colour = (role) => getComputedStyle(page).getPropertyValue("--" + role).trim();
  const modelColour = (i) => colour("model" + (i % 5));

  function unpack(column) {
    const text = atob(column.bdata), bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
    return new KINDS[column.dtype](bytes.buffer);
  }

  function unpackRecording(packed) {
    const motion = {};
    for (const axis in packed.motion) motion[axis] = unpack(packed.motion[axis]);
    const measured = unpack(packed.measured), modelled = packed.modelled.map(unpack);
    const residual = modelled.map((own) => own.map((value, i) => value - measured[i]));
    return { name: packed.name, time: unpack(packed.time), measured, modelled, residual, motion };
  }

  function axis(title, more) {
    return Object.assign({ title: { text: title, standoff: 6 }, gridcolor: colour("line"), zerolinecolor: colour("samples"),
      linecolor: colour("line"), automargin: true }, more || {});
  }

  function layout(more) {
    return Object.assign({ paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", font: { color: colour("ink"), size: 12,
      family: getComputedStyle(document.body).fontFamily }, margin: { l: 55, r: 12, t: 8, b: 40 }, hovermode: "closest",
      legend: { orientation: "h", x: 0, xanchor: "left", y: 1, yanchor: "bottom", bgcolor: "rgba(0,0,0,0)" },
      modebar: { bgcolor: "rgba(0,0,0,0)", color: colour("samples"), activecolor: colour("ink") },
      hoverlabel: { bgcolor: colour("card"), font: { color: colour("ink") } } }, more);
  }

  // First index with time >= value.
  function lowerBound(time, value) {
    let low = 0, high = time.length;
    while (low < high) { const middle = (low + high) >> 1; if (time[middle] < value) low = middle + 1; else high = middle; }
    return low;
  }

  // Smallest and largest value of each bucket, in order, so that no peak is lost; breaks stay breaks.
  function thin(time, values, first, last) {
    if (last - first <= 4 * BUCKETS) return { x: Array.from(time.subarray(first, last)), y: Array.from(values.subarray(first, last)) };
    const width = Math.ceil((last - first) / BUCKETS), x = [], y = [];
    for (let start = first; start < last; start += width) {
      const end = Math.min(start + width, last);
      let low = -1, high = -1, gap = -1;
      for (let i = start; i < end; i++) {
        const value = values[i];
        if (Number.isNaN(value)) { gap = i; continue; }
        if (low < 0 || value < values[low]) low = i;
        if (high < 0 || value > values[high]) high = i;
      }
      const chosen = [...new Set([low, high, gap])].filter((i) => i >= 0).sort((a, b) => a - b);
      for (const i of chosen) { x.push(time[i]); y.push(values[i]); }
    }
    return { x, y };
  }

  // Rows for a cloud: evenly spread, and the extremes of the force and of the axis.
  function cloudRows(recording, values, first, last) {
    const step = Math.max(1, Math.ceil((last - first) / CLOUD_POINTS)), rows = [];
    for (let i = first; i < last; i += step) {
      let low = i, high = i;
      if (step > 1) for (let j = i; j < Math.min(i + step, last); j++) {
        if (recording.measured[j] < recording.measured[low]) low = j;
        if (recording.measured[j] > recording.measured[high]) high = j;
      }
      // Every second bucket gives its largest, the others their smallest force: the cloud keeps its outline.
      rows.push(step === 1 ? i : (rows.length & 1 ? low : high));
    }
    return rows;
  }

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
      return [time[worst] - seconds / 2, time[worst] + seconds / 2];
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
      const { time, measured, modelled, residual } = this.recording, [first, last] = this.span();
      const line = (values, name, paint, more) => Object.assign({ type: "scatter", mode: "lines", name,
        line: { color: paint, width: 1.2 }, hovertemplate: "%{x:.4f} s: %{y:.4g} N<extra>" + name + "</extra>" }, thin(time, values, first, last), more);
      const names = this.data.models.map((name) => name.replace(/[<>&]/g, ""));
      const traces = [line(measured, "measured", colour("measured"), { line: { color: colour("measured"), width: 2.2 } })];
      modelled.forEach((values, i) => traces.push(line(values, names[i], modelColour(i))));
      residual.forEach((values, i) => traces.push(line(values, names[i] + " - measured", modelColour(i), { yaxis: "y2", showlegend: false })));
      const full = [time[0], time[time.length - 1]];
      const figure = this.element.querySelector(".time");
      Plotly.react(figure, traces, layout({
        xaxis: axis("time in s", { anchor: "y2", range: this.range || full }),
        yaxis: axis("force in N", { domain: [0.36, 1], fixedrange: true }),
        yaxis2: axis("residual in N", { domain: [0, 0.3], fixedrange: true }),
        hovermode: "x", dragmode: "zoom",
      }), CONFIG);
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
      const recording = this.recording, [first, last] = this.span(), lines = last - first <= LINE_POINTS;
      for (const figure of this.element.querySelectorAll(".cloud")) {
        const values = recording.motion[figure.dataset.axis];
        const rows = lines ? Array.from({ length: last - first }, (_, i) => first + i) : cloudRows(recording, values, first, last);
        const x = rows.map((i) => values[i]);
        const trace = (force, name, paint, size, opacity) => ({ type: "scatter", mode: lines ? "lines" : "markers", name,
          x, y: rows.map((i) => force[i]), line: { color: paint, width: 1.3 }, marker: { color: paint, size, opacity }, hoverinfo: "x+y" });
        const traces = [trace(recording.measured, "measured", colour("measured"), 3, 0.5)];
        recording.modelled.forEach((force, i) => traces.push(trace(force, this.data.models[i], modelColour(i), 3, 0.65)));
        Plotly.react(figure, traces, layout({ showlegend: false, xaxis: axis(AXES[figure.dataset.axis]), yaxis: axis("force in N") }), CONFIG);
      }
    }

    drawMap(figure) {
      const map = this.data.maps[Number(figure.dataset.model)][figure.dataset.over];
      if (!map) { Plotly.purge(figure); figure.textContent = "Frequency and amplitude hardly vary in these recordings."; return; }
      if (!figure.querySelector(".plot-container")) figure.textContent = "";
      const { data, layout: own } = map;
      data[0].colorbar.outlinewidth = 0;
      Plotly.react(figure, data, layout({ xaxis: axis(own.xaxis.title.text, { type: own.xaxis.type }),
        yaxis: axis(own.yaxis.title.text, { type: own.yaxis.type }) }), CONFIG);
    }

    mapOver(button) {
      const card = button.closest(".card"), figure = card.querySelector(".map");
      for (const other of card.querySelectorAll(".over")) other.setAttribute("aria-pressed", String(other === button));
      figure.dataset.over = button.dataset.over;
      this.drawMap(figure);
    }

    drawCurves(figure) {
      const curves = this.data[figure.dataset.name];
      if (!curves) { figure.textContent = "The recording is too short to tell."; return; }
      const paint = (trace) => modelColour(Number(trace.role.slice(5)));
      const traces = curves.data.map((trace) => Object.assign({}, trace, { line: { color: paint(trace), width: 1.6 }, marker: { color: paint(trace), size: 5 } }));
      const own = curves.layout, y = { range: own.yaxis.range, rangemode: own.yaxis.rangemode };
      Plotly.react(figure, traces, layout({ showlegend: own.showlegend, xaxis: axis(own.xaxis.title.text),
        yaxis: axis(own.yaxis.title.text, y) }), CONFIG);
    }
  }

  const dampers = sections.map((data, i) => new Damper(document.getElementById("damper" + i), data));
  const current = () => dampers.find((damper) => !damper.element.hidden);

  function theme(dark) {
    page.classList.toggle("dark", dark);
    dampers.forEach((damper) => { damper.drawn = false; });
    current().draw();
  }

  for (const tab of document.querySelectorAll(".tab")) tab.addEventListener("click", () => {
    for (const other of document.querySelectorAll(".tab")) other.setAttribute("aria-pressed", String(other === tab));
    dampers.forEach((damper, i) => { damper.element.hidden = String(i) !== tab.dataset.section; });
    if (!current().drawn) current().draw();
  });
  const wantsDark = window.matchMedia("(prefers-color-scheme: dark)");
  wantsDark.addEventListener("change", () => theme(wantsDark.matches));
  document.getElementById("theme").addEventListener("click", () => theme(!page.classList.contains("dark")));
  theme(wantsDark.matches);
})();
