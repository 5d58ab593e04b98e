"use strict";
// What the page does without its server: theme, tabs, what the mouse or the focus is on, keys, telling that it goes.
(() => {
  const set = (id, props) => window.dash_clientside.set_props(id, props);
  let page = "", looked = "", drawn = 0;

  window.dash_clientside = Object.assign({}, window.dash_clientside, { studio: {
    theme(clicks, before) {
      const dark = before ? before === "light" : window.matchMedia("(prefers-color-scheme: dark)").matches;
      document.documentElement.classList.toggle("dark", dark);
      return dark ? "dark" : "light";
    },
    introduce(own) { page = own; return own; },
    tab(chosen, ids) { return [ids.map((id) => id.name !== chosen), chosen]; },
    // While a slider moves, the curves follow ten times a second.
    dragged() {
      const cause = window.dash_clientside.callback_context.triggered[0], now = Date.now();
      if (!cause || cause.value === undefined || cause.value === null || now - drawn < 100) return window.dash_clientside.no_update;
      drawn = now;
      return { address: JSON.parse(cause.prop_id.slice(0, cause.prop_id.lastIndexOf("."))).address, place: cause.value };
    },
    news: (told, before) => (JSON.stringify(told) === JSON.stringify(before) ? window.dash_clientside.no_update : told),
    // What is on view after something happened on the page.
    look(...given) {
      const [view, drawn] = given.slice(-2), cause = window.dash_clientside.callback_context.triggered[0];
      if (!drawn || !cause) return window.dash_clientside.no_update;
      const now = view.opened === drawn.opened ? view : { opened: drawn.opened };
      const [id] = cause.prop_id.split(/\.(?=[^.]*$)/), after = changed(now, id, cause.value);
      return !after || JSON.stringify(after) === JSON.stringify(view) ? window.dash_clientside.no_update : after;
    },
  } });

  function changed(view, id, value) {
    if (id === "recording") return (value || 0) === (view.recording || 0) ? view : { opened: view.opened, recording: value };
    if (!value) return null;
    if (id === "all") return { ...view, start: null, stop: null };
    if (id === "unmark") return { ...view, mark: null };
    return relaid(view, JSON.parse(id).name, value);
  }

  // After zooming or marking in a figure.
  function relaid(view, figure, change) {
    if ("selections" in change) return { ...view, mark: markOf(figure, change.selections || []) };
    if (figure !== "time") return null;
    if (change["xaxis.autorange"]) return { ...view, start: null, stop: null };
    return "xaxis.range[0]" in change ? { ...view, start: change["xaxis.range[0]"], stop: change["xaxis.range[1]"] } : null;
  }

  // Corners of what was marked last; null where all marks were taken away.
  function markOf(figure, selections) {
    const own = selections[selections.length - 1];
    if (!own) return null;
    if (own.type !== "path") return { figure, x: [own.x0, own.x1, own.x1, own.x0], y: [own.y0, own.y0, own.y1, own.y1] };
    const corners = own.path.replace(/[MZ]/g, "").split("L").map((corner) => corner.split(",").map(Number));
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
    if (!(event.ctrlKey || event.metaKey) || event.target.closest("input,textarea")) return;
    const button = { z: "undo", y: "redo" }[event.key];
    if (button) { event.preventDefault(); document.getElementById(button).click(); }
  });

  // A button that becomes disabled while it has the focus would swallow the next keys.
  document.addEventListener("click", (event) => { const own = event.target.closest("#undo,#redo"); if (own) own.blur(); });

  // A server that was ended answers nothing: the page says so until it does again.
  const fetched = window.fetch;
  window.fetch = async (...sent) => {
    try {
      const answer = await fetched(...sent);
      document.body.classList.remove("gone");
      return answer;
    } catch (error) {
      document.body.classList.toggle("gone", error.name !== "AbortError");
      throw error;
    }
  };

  window.addEventListener("beforeunload", (event) => { if (document.querySelector("#steps .unsaved")) event.preventDefault(); });
  window.addEventListener("pagehide", () => { if (page) navigator.sendBeacon("/leave", page); });
  // A page that comes back from the browser's memory has no session any longer.
  window.addEventListener("pageshow", (event) => { if (event.persisted) window.location.reload(); });
})();
