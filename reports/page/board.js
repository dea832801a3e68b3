"use strict";
/* The leaderboard: means of the chosen maps, sorted, and as CSV or LaTeX. */
(() => {
  const host = document.getElementById("board");
  if (!host || !Page.data) return;
  const { make, rows, data, shown } = Page, element = (id) => document.getElementById(id);
  const DEFAULT = ["geodesic_mean", "matched", "excess_mean", "geodesic_median", "pck_auc", "flip_rate", "seconds_match"];
  const measures = data.measures.filter((m) => rows.some((row) => row[m.name] !== null && row[m.name] !== undefined));
  const MAKE_WAY = data.partial.length ? ["geodesic_median"] : []; // for the columns of scans that share little surface
  const chosen = new Set(measures.map((m) => m.name).filter((name) => DEFAULT.concat(data.partial).includes(name) && !MAKE_WAY.includes(name)));
  const state = { by: "geodesic_mean", down: false };
  const filters = { dataset: element("board-dataset"), regime: element("board-regime"), seed: element("board-seed") };
  const names = { dataset: "all data sets", regime: "all regimes", seed: "all seeds" };
  for (const [name, select] of Object.entries(filters)) {
    const values = Page.distinct(rows.map((row) => row[name]));
    Page.options(select, values, names[name]);
    select.closest("label").hidden = values.length < 2;
    select.addEventListener("change", () => draw());
  }
  const hidden = new Set();
  const boxes = (place, list, label, checked, change) => list.forEach((each) => {
    const box = make("input", { type: "checkbox", checked: checked(each), onchange: () => { change(each, box.checked); draw(); } });
    element(place).append(make("label", {}, box, ` ${label(each)}`));
  });
  boxes("board-methods", data.methods, (m) => m.name, () => true, (m, on) => on ? hidden.delete(m.name) : hidden.add(m.name));
  boxes("board-columns", measures, (m) => m.title, (m) => chosen.has(m.name), (m, on) => on ? chosen.add(m.name) : chosen.delete(m.name));
  element("board-rank").addEventListener("change", (event) => { state.by = event.target.value; state.down = state.by === "wins"; draw(); });

  function selected() {
    return rows.filter((row) => !hidden.has(row.method) && Object.entries(filters).every(([name, s]) => !s.value || String(row[name]) === s.value));
  }

  /* Pairs of poses on which each method has the lowest error, alone or with others. */
  function wins(parts) {
    const found = new Map(parts.map((p) => [p.name, { wins: 0, ties: 0 }]));
    const means = new Map(parts.map((p) => [p.name, Page.unitMeans(p.rows, "geodesic_mean")]));
    for (const key of Page.distinct([...means.values()].flatMap((m) => [...m.keys()]))) {
      const list = parts.filter((p) => means.get(p.name).has(key)).map((p) => [p.name, means.get(p.name).get(key)]);
      const least = Math.min(...list.map(([, value]) => value)), near = list.filter(([, value]) => value < least + Page.TIE);
      for (const [name] of near) found.get(name)[near.length === 1 ? "wins" : "ties"] += 1;
    }
    return found;
  }

  function board() {
    const part = selected(), cell = (row) => JSON.stringify([Page.unit(row), row.regime, row.seed]);
    const wanted = new Set(part.map(cell)).size;
    const list = data.methods.filter((m) => !hidden.has(m.name)).map((m) => {
      const own = part.filter((row) => row.method === m.name);
      const lacking = wanted - new Set(own.map(cell)).size;
      const matched = Page.nested(own, "matched");
      const notes = [matched !== null && matched < 99 ? `matches ${matched.toFixed(0)} % of the points` : "", lacking ? `lacks ${lacking} of ${wanted} maps` : ""];
      const values = Object.fromEntries(measures.map((measure) => [measure.name, Page.nested(own, measure.name)]));
      const seeds = [...Page.grouped(own, (row) => row.seed).values()].map((some) => Page.nested(some, "geodesic_mean"));
      const centre = seeds.length ? Page.mean(seeds) : 0;
      const spread = seeds.length > 1 ? Math.sqrt(seeds.reduce((a, v) => a + (v - centre) ** 2, 0) / (seeds.length - 1)) : null;
      return { ...m, rows: own, values, spread, maps: own.length, note: notes.filter(Boolean).join("; ") };
    }).filter((m) => m.maps);
    const rivals = list.filter((m) => !m.beyond && !m.note), count = wins(rivals);
    for (const m of list) Object.assign(m, count.get(m.name) || { wins: null, ties: null });
    const value = (m) => state.by === "wins" ? (m.wins === null ? null : m.wins + m.ties / 1000) : state.by === "name" ? m.name : state.by === "maps" ? m.maps : m.values[state.by];
    list.sort((a, b) => (a.beyond - b.beyond) || (Boolean(a.note) - Boolean(b.note)) || Page.compare(value(a), value(b), state.down));
    return list;
  }

  function best() {
    if (filters.seed.value || hidden.size) return {};
    const found = data.unbeaten.find((each) => each.dataset === filters.dataset.value && each.regime === filters.regime.value);
    return found ? found.best : {};
  }

  const columns = () => [
    { name: "name", title: "method", digits: null },
    ...measures.filter((m) => chosen.has(m.name)),
    { name: "wins", title: "best on", digits: 0, best: "high", about: "Pairs of poses on which it has the lowest mean error, alone + together with others within 0.05." },
    { name: "maps", title: "maps", digits: 0 },
  ];
  function text(m, column) {
    if (column.name === "name") return m.name + (m.beyond ? " ‡" : m.note ? " †" : "");
    if (column.name === "maps") return String(m.maps);
    if (column.name === "wins") return m.wins === null ? "–" : m.ties ? `${m.wins} + ${m.ties}` : String(m.wins);
    const main = shown(m.values[column.name], column.digits);
    return column.name === "geodesic_mean" && m.spread !== null ? `${main} ± ${shown(m.spread, column.digits)}` : main;
  }

  function draw() {
    const list = board(), heads = columns(), bold = best();
    const isBest = (m, c) => !m.beyond && !m.note && (bold[c.name] || []).includes(m.name);
    const table = make("table", {}, make("thead", {}, make("tr", {}, ...heads.map((c) => Page.head(c, state, (column) => { Page.toggled(state, column); draw(); })))));
    const body = make("tbody");
    for (const m of list) {
      body.append(make("tr", { "data-method": m.name }, ...heads.map((c) => {
        if (c.name === "name") return make("th", { scope: "row" }, make("span", { class: "chip", style: `--tint:${m.color}` }), text(m, c));
        const words = text(m, c);
        return make("td", { class: "number", "data-column": c.name }, isBest(m, c) ? make("b", { text: words }) : words);
      })));
    }
    table.append(body);
    host.replaceChildren(table);
    const notes = list.filter((m) => m.note && !m.beyond).map((m) => `† not ranked: ${m.name} ${m.note}.`);
    if (list.some((m) => m.beyond)) notes.push("‡ looks at the ground truth: no competitor.");
    const pairs = Page.distinct(selected().map(Page.unit)).length;
    const decided = heads.some((c) => list.some((m) => isBest(m, c)));
    notes.unshift(`${pairs} ${pairs === 1 ? "pair" : "pairs"} of poses; regimes and seeds are averaged within each. ` +
      (filters.seed.value || hidden.size ? "Bold, what nothing beats beyond noise, is not decided for a part of the seeds or methods."
        : decided ? "Bold: what nothing beats beyond noise."
        : pairs < data.fewest ? `Nothing is bold: that takes ${data.fewest} pairs of poses.`
        : "Nothing is bold: no method is beaten beyond noise."));
    element("board-notes").replaceChildren(...notes.map((note) => make("p", { class: "note", text: note })));
    return { list, heads };
  }

  const chosenName = () => Object.values(filters).map((s) => s.value).filter(Boolean).join("-").replace(/[^\w.-]+/g, "_") || "all";
  element("board-csv").addEventListener("click", () => {
    const { list, heads } = draw(), quote = (s) => /[",\r\n]/.test(s) ? `"${s.replace(/"/g, '""')}"` : s;
    const lines = [[...heads.map((c) => c.title), "not ranked"], ...list.map((m) => [...heads.map((c) => c.name === "name" ? m.name : text(m, c)), m.note])];
    Page.download(`leaderboard-${chosenName()}.csv`, lines.map((line) => line.map(quote).join(",")).join("\n") + "\n", "text/csv");
  });
  const TEX = { "\\": "\\textbackslash{}", "~": "\\textasciitilde{}", "^": "\\textasciicircum{}", "±": "$\\pm$", "–": "--", "†": "$^\\dagger$", "‡": "$^\\ddagger$", "√": "$\\surd$", "×": "$\\times$" };
  const tex = (s) => s.replace(/[\\~^±–†‡√×&%$#_{}]/g, (c) => TEX[c] || `\\${c}`);
  element("board-tex").addEventListener("click", () => {
    const { list, heads } = draw(), bold = best();
    const cell = (m, c) => !m.beyond && !m.note && (bold[c.name] || []).includes(m.name) ? `\\textbf{${tex(text(m, c))}}` : tex(text(m, c));
    const lines = [`\\begin{tabular}{${heads.map((c) => c.digits === null ? "l" : "r").join("")}}`, "\\toprule", `${heads.map((c) => tex(c.title)).join(" & ")} \\\\`, "\\midrule",
      ...list.map((m) => `${heads.map((c) => cell(m, c)).join(" & ")} \\\\`), "\\bottomrule", "\\end{tabular}"];
    Page.download(`leaderboard-${chosenName()}.tex`, lines.join("\n") + "\n", "text/x-tex");
  });
  element("board-tools").hidden = false;
  draw();
})();
