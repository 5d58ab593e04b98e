"use strict";
// The fleet's page: filters and sorts the rows that stand in the page's data, draws them, and opens their reports.
(() => {
  const { data } = report;
  const find = (id) => document.getElementById(id);
  const PER_PAGE = 50, MOST_VEHICLES = 40, MANY = 3000;
  const ALL = "";
  const state = { sort: null, down: true, page: 0, rows: [] };
  let verb, table;

  const vehicle = (i) => table.vehicle.names[table.vehicle.of[i]];
  const damper = (i) => table.damper.names[table.damper.of[i]];
  const day = (ms) => (ms === null ? "" : new Date(ms).toISOString().slice(0, 16).replace("T", " "));
  const values = () => table.measures[find("measure").value] || [];

  function options(select, names, labels) {
    const before = select.value;
    select.replaceChildren(...names.map((name, k) => new Option(labels ? labels[k] : name, name)));
    if (names.includes(before)) select.value = before;
  }

  function chooseVerb() {
    verb = find("verb").value;
    table = data.verbs[verb];
    const measures = Object.keys(data.measures).filter((name) => name in table.measures);
    options(find("measure"), measures, measures.map((name) => data.measures[name]));
    if (measures.includes(data.first[verb])) find("measure").value = data.first[verb];
    options(find("vehicle"), [ALL, ...table.vehicle.names], ["all " + table.vehicle.names.length, ...table.vehicle.names]);
    options(find("damper"), [ALL, ...table.damper.names], ["all " + table.damper.names.length, ...table.damper.names]);
    Object.assign(state, { sort: find("measure").value, down: true });
    update();
  }

  function chosen() {
    const wanted = find("search").value.toLowerCase(), far = find("far").checked, failed = find("failed").checked;
    const vehicle = table.vehicle.names.indexOf(find("vehicle").value), mine = table.damper.names.indexOf(find("damper").value);
    const rows = [];
    for (let i = 0; i < table.recording.length; i++) {
      if ((vehicle < 0 || table.vehicle.of[i] === vehicle) && (mine < 0 || table.damper.of[i] === mine) && (!far || table.far[i])
        && (!failed || table.reason[i]) && (!wanted || table.recording[i].toLowerCase().includes(wanted))) rows.push(i);
    }
    return rows;
  }

  // Draws a figure of the page's data with these traces, the chosen quantity at its vertical axis.
  function draw(element, name, traces, title, more) {
    const { layout } = data.figures[name], yaxis = Object.assign({}, layout.yaxis, { title: { text: title } });
    report.draw(element, { data: traces, layout: Object.assign({}, layout, { yaxis }, more) });
  }

  function open(i) { if (table.link[i]) window.open(table.link[i], "_blank", "noopener"); }

  function cloud(element, name, rows, x) {
    const y = values(), known = rows.filter((i) => x[i] !== null && y[i] !== null && y[i] !== undefined);
    const type = known.length > MANY ? "scattergl" : "scatter";
    const trace = (style, shown) => Object.assign({}, style, { type, x: shown.map((i) => x[i]), y: shown.map((i) => y[i]), customdata: shown,
      text: shown.map((i) => table.recording[i] + "<br>" + vehicle(i) + ", " + damper(i)) });
    const [near, far] = data.figures[name].data;
    const annotations = known.length ? [] : [{ text: "no values", showarrow: false, xref: "paper", yref: "paper", x: 0.5, y: 0.5 }];
    draw(element, name, [trace(near, known.filter((i) => !table.far[i])), trace(far, known.filter((i) => table.far[i]))], data.measures[find("measure").value], { annotations });
    if (!element.listening) { element.on("plotly_click", (event) => open(event.points[0].customdata)); element.listening = true; }
  }

  function boxes(element, rows, of, names, most) {
    const y = values(), groups = new Map();
    for (const i of rows) if (y[i] !== null && y[i] !== undefined) { if (!groups.has(of[i])) groups.set(of[i], []); groups.get(of[i]).push(y[i]); }
    const middle = (found) => { const sorted = Float64Array.from(found).sort(); return sorted[sorted.length >> 1]; };
    const order = [...groups].map(([k, found]) => [k, found, middle(found)]).sort((a, b) => b[2] - a[2]).slice(0, most);
    const [style] = data.figures.boxes.data;
    draw(element, "boxes", order.map(([k, found]) => Object.assign({}, style, { name: names[k] || "unknown", y: found })), data.measures[find("measure").value]);
    return groups.size;
  }

  function phenomena(rows) {
    const diagnoses = data.verbs.diagnose;
    if (!diagnoses) return;
    const keep = diagnoses === table ? rows : diagnoses.recording.map((_, i) => i).filter((i) => (!find("vehicle").value || diagnoses.vehicle.names[diagnoses.vehicle.of[i]] === find("vehicle").value)
      && (!find("damper").value || diagnoses.damper.names[diagnoses.damper.of[i]] === find("damper").value));
    const done = keep.filter((i) => !diagnoses.reason[i]), counts = new Map(), first = new Map();
    for (const i of done) diagnoses.missing[i].forEach((name, k) => { counts.set(name, (counts.get(name) || 0) + 1); if (k === 0) first.set(name, (first.get(name) || 0) + 1); });
    const names = [...counts.keys()].sort((a, b) => counts.get(a) - counts.get(b)), share = (map) => names.map((name) => 100 * (map.get(name) || 0) / done.length);
    const nothing = done.filter((i) => diagnoses.verdict[i] === "nothing_missing").length, changed = done.filter((i) => diagnoses.verdict[i] === "parameters_changed").length;
    find("diagnosed").textContent = `share of ${done.length} diagnosed recordings (filled: ranked first); nothing is missing in ${nothing}, parameters changed in ${changed}`;
    const y = names.map((name) => name.replaceAll("_", " ")), [all, leading] = data.figures.missing.data;
    draw(find("missing"), "missing", [Object.assign({}, all, { y, x: share(counts) }), Object.assign({}, leading, { y, x: share(first) })], "");
  }

  // The kinds of the recording's faults; their sentences show on hovering.
  const kinds = (i) => table.data[i].map((sentence) => sentence.split(":")[0].replaceAll("_", " ")).join(", ");

  function columns() {
    const faults = table.data.some((found) => found.length) ? [["data", "data", kinds]] : [];
    const list = [["recording", "recording", (i) => table.recording[i]], ["vehicle", "vehicle", vehicle], ["damper", "damper", damper], ...faults,
      ["begin", "begin (UTC)", (i) => table.begin[i]], ["temperature", "deg C", (i) => table.temperature[i]]];
    for (const name of Object.keys(table.measures)) list.push([name, data.measures[name], (i) => table.measures[name][i]]);
    if (table.missing.length) list.push(["missing", "missing", (i) => table.missing[i].join(", ") || table.verdict[i] || ""]);
    return list;
  }

  function sorted(rows) {
    const column = columns().find(([key]) => key === state.sort);
    if (!column) return rows;
    const sign = state.down ? -1 : 1, value = column[2];
    return [...rows].sort((a, b) => {
      const x = value(a), y = value(b);
      if (x === null || y === null) return (x === null) - (y === null);
      return sign * (typeof x === "string" ? x.localeCompare(y, undefined, { numeric: true }) : x - y);
    });
  }

  function element(kind, text, more) { return Object.assign(document.createElement(kind), { textContent: text }, more); }

  function rowOf(i, list) {
    const row = element("tr", "", { className: table.far[i] ? "far" : "" });
    for (const [key, , value] of list) {
      const content = value(i), cell = element("td", "");
      if (key === "recording" && table.link[i]) cell.append(element("a", content, { href: table.link[i], target: "_blank", rel: "noopener" }));
      else if (typeof content === "number") { cell.textContent = key === "begin" ? day(content) : String(content); cell.className = "number"; }
      else cell.textContent = content === null ? "" : content;
      if (key === "data") { cell.title = table.data[i].join("\n"); if (table.spoiled[i]) cell.className = "reason"; }
      row.append(cell);
      if (key === "temperature" && table.reason[i]) { row.append(element("td", table.reason[i], { className: "reason", colSpan: list.length - row.childElementCount })); break; }
    }
    return row;
  }

  function list() {
    const all = columns(), rows = sorted(state.rows), last = Math.max(0, Math.ceil(rows.length / PER_PAGE) - 1);
    state.page = Math.min(state.page, last);
    const head = element("tr", "");
    for (const [key, label] of all) {
      const cell = element("th", "", { scope: "col" }), button = element("button", label + (state.sort === key ? (state.down ? " ▾" : " ▴") : ""), { type: "button" });
      if (state.sort === key) cell.setAttribute("aria-sort", state.down ? "descending" : "ascending");
      button.addEventListener("click", () => { state.down = state.sort === key ? !state.down : true; state.sort = key; state.page = 0; list(); });
      cell.append(button);
      head.append(cell);
    }
    find("rows").tHead.replaceChildren(head);
    find("rows").tBodies[0].replaceChildren(...rows.slice(state.page * PER_PAGE, (state.page + 1) * PER_PAGE).map((i) => rowOf(i, all)));
    find("page").textContent = `${state.page + 1} of ${last + 1}`;
    find("before").disabled = state.page === 0;
    find("after").disabled = state.page === last;
  }

  function update() {
    state.rows = chosen();
    state.page = 0;
    find("count").textContent = `${state.rows.length} of ${table.recording.length} rows`;
    const sound = state.rows.filter((i) => !table.spoiled[i]);
    cloud(find("time"), "time", sound, table.begin);
    cloud(find("warm"), "temperature", sound, table.temperature);
    const count = boxes(find("byvehicle"), sound, table.vehicle.of, table.vehicle.names, MOST_VEHICLES);
    find("vehicles").textContent = "median, quartiles, range" + (count > MOST_VEHICLES ? `; the ${MOST_VEHICLES} worst of ${count}` : "; the worst first");
    boxes(find("bydamper"), sound, table.damper.of, table.damper.names, MOST_VEHICLES);
    phenomena(state.rows);
    list();
  }

  function pick(row) { find("vehicle").value = row.dataset.vehicle; find("damper").value = row.dataset.damper; update(); }

  for (const id of ["measure", "vehicle", "damper", "far", "failed"]) find(id).addEventListener("change", update);
  find("verb").addEventListener("change", chooseVerb);
  let waiting;
  find("search").addEventListener("input", () => { clearTimeout(waiting); waiting = setTimeout(update, 150); });
  find("reset").addEventListener("click", () => { for (const id of ["vehicle", "damper", "search"]) find(id).value = ALL; for (const id of ["far", "failed"]) find(id).checked = false; update(); });
  find("before").addEventListener("click", () => { state.page -= 1; list(); });
  find("after").addEventListener("click", () => { state.page += 1; list(); });
  for (const row of document.querySelectorAll("tr.pick")) {
    row.addEventListener("click", () => pick(row));
    row.addEventListener("keydown", (event) => { if (event.key === "Enter") pick(row); });
  }
  report.start(() => (table ? update() : chooseVerb()));
})();
