"use strict";
// What the page does without its server: theme, tabs, what the mouse or the focus is on, keys, messages that the server is gone.
(() => {
  const set = (id, props) => window.dash_clientside.set_props(id, props);
  let page = "", looked = "", drawn = 0, marked = "";
  const trail = []; // what was on view before, newest last

  // A tab's own name: it goes on in the session's file that it wrote, another tab writes a file of its own.
  function tabName() {
    const name = sessionStorage.getItem("studio-tab") || Array.from(crypto.getRandomValues(new Uint8Array(12)), (byte) => byte.toString(16).padStart(2, "0")).join("");
    sessionStorage.setItem("studio-tab", name);
    return name;
  }

  window.dash_clientside = Object.assign({}, window.dash_clientside, { studio: {
    theme(clicks, before) {
      const dark = before ? before === "light" : window.matchMedia("(prefers-color-scheme: dark)").matches;
      document.documentElement.classList.toggle("dark", dark);
      return dark ? "dark" : "light";
    },
    arrive: () => ({ query: window.location.search, tab: tabName() }),
    // The server was started again, or let this page go: the address says how to go on.
    reload(lost) {
      const last = Number(sessionStorage.getItem("studio-reloaded") || 0), now = Date.now();
      if (lost && now - last > 10000) { sessionStorage.setItem("studio-reloaded", now); window.location.reload(); }
      return lost;
    },
    // The address follows what is open and on view.
    locate(place, view, tab, sight) {
      if (!place) return window.dash_clientside.no_update;
      const query = new URLSearchParams(), last = trail[trail.length - 1];
      for (const [name, value] of Object.entries(place))
        for (const item of [].concat(value)) if (item !== null && item !== "") query.append(name, item);
      if (view.recording) query.append("show", view.recording);
      if (typeof view.start === "number") query.append("from", Number(view.start.toFixed(4)));
      if (typeof view.stop === "number") query.append("to", Number(view.stop.toFixed(4)));
      if (tab && tab !== "fails") query.append("tab", tab);
      if (sight === "corners") query.append("dampers", "all");
      window.history.replaceState(null, "", "/?" + query);
      if (last && last.opened !== view.opened) trail.length = 0;
      if (!last || !sameStretch(last, view)) trail.push(view);
      return query.toString();
    },
    // The overview of all dampers, or one of them in depth.
    overview(_all, _one, _open, now) {
      const cause = window.dash_clientside.callback_context.triggered[0];
      if (!cause || !cause.value) return now;
      return cause.prop_id.startsWith("overview") && now !== "corners" ? "corners" : "depth";
    },
    // While a slider moves, what waits for its end is grey.
    stale: (preview, generation) => (preview && preview.generation === generation ? "yes" : "no"),
    freeze: (clicks) => [clicks % 2 === 1, clicks % 2 === 1 ? "Resume" : "Freeze"],
    introduce(id) { page = id; return id; },
    tab(chosen, ids) { return [ids.map((id) => id.name !== chosen), chosen]; },
    // While a slider moves, the curves follow ten times a second.
    dragged() {
      const cause = window.dash_clientside.callback_context.triggered[0], now = Date.now();
      if (!cause || cause.value === undefined || cause.value === null || now - drawn < 100) return window.dash_clientside.no_update;
      drawn = now;
      return { address: JSON.parse(cause.prop_id.slice(0, cause.prop_id.lastIndexOf("."))).address, place: cause.value };
    },
    news: (after, before) => (JSON.stringify(after) === JSON.stringify(before) ? window.dash_clientside.no_update : after),
    // What is on view after something happened on the page.
    look(...given) {
      const [tool, view, drawn] = given.slice(-3), causes = window.dash_clientside.callback_context.triggered;
      // Where a redrawn figure reports together with a click, the click is what the user did.
      const cause = causes.find((one) => one.prop_id.endsWith(".n_clicks")) || causes[0];
      if (!drawn || !cause) return window.dash_clientside.no_update;
      const now = view.opened === drawn.opened ? view : { opened: drawn.opened };
      const [id, property] = cause.prop_id.split(/\.(?=[^.]*$)/);
      const after = property === "clickData" ? (tool === "cursor" ? clicked(now, id, cause.value) : null) : changed(now, id, cause.value);
      return !after || JSON.stringify(after) === JSON.stringify(view) ? window.dash_clientside.no_update : after;
    },
  } });

  const sameStretch = (one, other) => ["opened", "recording", "start", "stop"].every((name) => (one[name] || null) === (other[name] || null));

  // A click sets the first cursor, the next one the second, a third begins again.
  function clicked(view, id, value) {
    const at = value && value.points && value.points[0];
    if (!at || JSON.parse(id).name !== "time") return null;
    const before = view.cursors || [];
    if (before[before.length - 1] === at.x) return null;
    return { ...view, cursors: before.length === 1 ? [before[0], at.x] : [at.x] };
  }

  function changed(view, id, value) {
    if (id === "recording") return (value || 0) === (view.recording || 0) ? view : { opened: view.opened, recording: value };
    if (!value) return null;
    if (id === "back") { trail.pop(); return { ...(trail.pop() || { opened: view.opened }), mark: view.mark }; }
    if (id === "all") return { ...view, start: null, stop: null, cursors: [] };
    if (id === "unmark") return { ...view, mark: null };
    return relaid(view, JSON.parse(id).name, value);
  }

  // After zooming or marking in a figure.
  function relaid(view, figure, change) {
    if ("selections" in change) {
      const mark = markOf(figure, change.selections || []), same = mark && JSON.stringify(mark) === marked;
      marked = JSON.stringify(mark);
      return same ? null : { ...view, mark }; // a redrawn figure reports its old mark again
    }
    if (figure !== "time") return null;
    if (change["xaxis.autorange"]) return { ...view, start: null, stop: null };
    return "xaxis.range[0]" in change ? { ...view, start: change["xaxis.range[0]"], stop: change["xaxis.range[1]"] } : null;
  }

  // Corners of what was marked last; null where all marks were taken away.
  function markOf(figure, selections) {
    const selection = selections[selections.length - 1];
    if (!selection) return null;
    if (selection.type !== "path") return { figure, x: [selection.x0, selection.x1, selection.x1, selection.x0], y: [selection.y0, selection.y0, selection.y1, selection.y1] };
    const corners = selection.path.replace(/[MZ]/g, "").split("L").map((corner) => corner.split(",").map(Number));
    return { figure, x: corners.map((corner) => corner[0]), y: corners.map((corner) => corner[1]) };
  }

  function hover(event) {
    const row = event.target.closest && event.target.closest("[data-effect]");
    if (row && row.dataset.effect !== looked) { looked = row.dataset.effect; set("hovered", { data: looked }); }
  }
  const unlook = () => { looked = ""; set("hovered", { data: "" }); };
  document.addEventListener("mouseover", hover);
  document.addEventListener("focusin", hover);
  document.addEventListener("click", (event) => { if (event.target.closest("#unlook")) unlook(); });

  document.addEventListener("keydown", (event) => {
    if (event.key === "Escape" && looked) unlook();
    if (!(event.ctrlKey || event.metaKey) || event.altKey || typing(event.target)) return;
    const key = event.key.toLowerCase(), name = key === "y" || (key === "z" && event.shiftKey) ? "redo" : key === "z" ? "undo" : "";
    if (name) { event.preventDefault(); event.stopPropagation(); document.getElementById(name).click(); }
  }, true);

  // While something is typed that the page has not taken yet, undo is that of the text; everywhere else of the model.
  let typed = null;
  const typing = (field) => field === typed && field.matches("textarea,input:not([type=radio],[type=checkbox],[type=range])");
  document.addEventListener("input", (event) => { typed = event.target; }, true);
  for (const name of ["change", "focusout"]) document.addEventListener(name, (event) => { if (event.target === typed) typed = null; }, true);
  document.addEventListener("keydown", (event) => { if (event.key === "Enter") typed = null; });

  // A button that becomes disabled while it has the focus would swallow the next keys.
  document.addEventListener("click", (event) => { const button = event.target.closest("#undo,#redo"); if (button) button.blur(); });

  // Files that are dropped or picked are sent one after the other; a folder's files with the folder's name before them.
  async function send(files) {
    const report = (text, bad) => { const message = document.getElementById("upload-message"); message.textContent = text; message.classList.toggle("bad", !!bad); };
    const added = [], refused = [];
    for (const [name, file] of files) {
      const [text, good] = await new Promise((done) => {
        const sent = new XMLHttpRequest();
        sent.open("POST", "/upload?name=" + encodeURIComponent(name));
        sent.setRequestHeader("X-Studio-Page", page);
        sent.setRequestHeader("Content-Type", "application/octet-stream");
        sent.upload.onprogress = (event) => report(`${name}: ${Math.round(100 * event.loaded / Math.max(event.total, 1))} %`);
        sent.onload = () => done([sent.responseText, sent.status === 200]);
        sent.onerror = () => done([`${name}: the studio did not take it`, false]);
        sent.send(file);
      });
      (good ? added : refused).push(text);
    }
    report([added.length ? `added ${added.join(", ")}` : "", ...refused].filter(Boolean).join("; "), refused.length);
    if (added.length) set("added", { data: added });
  }

  async function inFolder(entry, before) {
    if (entry.isFile) return [[before + entry.name, await new Promise((done, fail) => entry.file(done, fail))]];
    const reader = entry.createReader(), found = [];
    for (;;) {
      const some = await new Promise((done, fail) => reader.readEntries(done, fail));
      if (!some.length) break;
      for (const item of some) found.push(...(await inFolder(item, before + entry.name + "/")));
    }
    return found;
  }

  const withFiles = (event) => event.dataTransfer && Array.from(event.dataTransfer.types).includes("Files");
  document.addEventListener("dragover", (event) => { if (withFiles(event)) { event.preventDefault(); document.body.classList.add("dropping"); } });
  document.addEventListener("dragleave", (event) => { if (!event.relatedTarget) document.body.classList.remove("dropping"); });
  document.addEventListener("drop", async (event) => {
    if (!withFiles(event)) return;
    event.preventDefault();
    document.body.classList.remove("dropping");
    const entries = Array.from(event.dataTransfer.items).map((item) => item.webkitGetAsEntry && item.webkitGetAsEntry());
    const plain = Array.from(event.dataTransfer.files);
    const found = await Promise.all(entries.map((entry, i) => (entry ? inFolder(entry, "") : [[plain[i].name, plain[i]]])));
    send(found.flat());
  });
  document.addEventListener("click", (event) => {
    const button = event.target.closest("#add-files,#add-folder");
    if (!button) return;
    const picker = Object.assign(document.createElement("input"), { type: "file", multiple: true, webkitdirectory: button.id === "add-folder" });
    picker.addEventListener("change", () => send(Array.from(picker.files, (file) => [file.webkitRelativePath || file.name, file])));
    picker.click();
  });

  // What was unfolded by hand is known to the page, which folds it after opening.
  document.addEventListener("toggle", (event) => { if (["chooser", "library"].includes(event.target.id)) set(event.target.id, { open: event.target.open }); }, true);

  // A server that was ended answers nothing: the page says so until it does again.
  const fetched = window.fetch;
  window.fetch = async (...sent) => {
    try {
      const answer = await fetched(...sent);
      document.body.classList.remove("gone");
      document.body.classList.toggle("locked", answer.status === 403);
      return answer;
    } catch (error) {
      document.body.classList.toggle("gone", error.name !== "AbortError");
      throw error;
    }
  };

  window.addEventListener("beforeunload", (event) => { if (document.querySelector("#unkept:not(:empty)")) event.preventDefault(); });
  window.addEventListener("pagehide", () => { if (page) navigator.sendBeacon("/leave", page); });
  // A page that comes back from the browser's memory has no session any longer; its address names what it had.
  window.addEventListener("pageshow", (event) => { if (event.persisted) window.location.reload(); });
})();
