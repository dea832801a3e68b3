"use strict";
/* Every map of the run: filtered, sorted, some at a time. */
(() => {
  const host = document.getElementById("all-maps");
  if (!host || !Page.data || !Page.rows.length) return;
  const { make, rows } = Page, element = (id) => document.getElementById(id), STEP = 50;
  const has = (name) => rows.some((row) => row[name] !== null && row[name] !== undefined);
  const measure = (name) => Page.data.measures.find((m) => m.name === name);
  const columns = [
    { name: "dataset", title: "data set", digits: null }, { name: "regime", title: "regime", digits: null },
    { name: "pair", title: "poses", digits: null }, { name: "seed", title: "seed", digits: 0 }, { name: "method", title: "method", digits: null },
    { name: "missing", title: "missing %", digits: 0 },
    ...["geodesic_mean", "oracle_mean", "excess_mean", "matched", "pck_auc", "flip_rate", "right_limb", "seconds_match"].map(measure).filter((m) => m && has(m.name)),
  ];
  for (const row of rows) row.pair = `${row.source_pose} → ${row.target_pose}`;
  const state = { by: "geodesic_mean", down: true, count: STEP };
  const filters = ["dataset", "regime", "method", "seed"].map((name) => [name, element(`maps-${name}`)]);
  for (const [name, select] of filters) {
    const values = Page.distinct(rows.map((row) => row[name]));
    Page.options(select, values, "all");
    select.closest("label").hidden = values.length < 2;
    select.addEventListener("change", () => { state.count = STEP; draw(); });
  }
  element("maps-more").addEventListener("click", () => { state.count += 200; draw(); });

  function draw() {
    const part = rows.filter((row) => filters.every(([name, select]) => !select.value || String(row[name]) === select.value));
    part.sort((a, b) => Page.compare(a[state.by], b[state.by], state.down));
    const body = make("tbody", {}, ...part.slice(0, state.count).map((row) => make("tr", { class: row.picture ? "open" : "" }, ...columns.map((c) => {
      const words = c.digits === null ? row[c.name] : Page.shown(row[c.name], c.digits);
      const link = c.name === "pair" && row.picture ? make("a", { href: "#pairs", onclick: (event) => { event.preventDefault(); window.openPair(row.picture); } }, words) : words;
      return make("td", { class: c.digits === null ? "" : "number" }, link);
    }))));
    const head = make("thead", {}, make("tr", {}, ...columns.map((c) => Page.head(c, state, (column) => { Page.toggled(state, column); draw(); }))));
    host.replaceChildren(make("table", {}, head, body));
    element("maps-count").textContent = `${Math.min(state.count, part.length)} of ${part.length} maps shown`;
    element("maps-more").hidden = state.count >= part.length;
  }
  draw();
})();
