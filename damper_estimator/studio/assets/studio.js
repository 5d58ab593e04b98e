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
  } });

  function look(event) {
    const row = event.target.closest && event.target.closest("[data-effect]");
    if (row && row.dataset.effect !== looked) { looked = row.dataset.effect; set("hovered", { data: looked }); }
  }
  const unlook = () => { looked = ""; set("hovered", { data: "" }); };
  document.addEventListener("mouseover", look);
  document.addEventListener("focusin", look);
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
