"use strict";
/* What the scripts of the page share: the rows of the run, means as the tables have them, and parts of the page. */
const Page = (() => {
  const source = document.getElementById("page-data");
  const data = source ? JSON.parse(source.textContent) : null;
  const TIE = 0.05;   // as reports/tables/statistics.py

  const make = (tag, attributes = {}, ...inside) => {
    const node = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) {
      if (name === "text") node.textContent = value;
      else if (name === "class") node.className = value;
      else if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
      else if (value === true) node.setAttribute(name, "");
      else if (value !== false && value !== null && value !== undefined) node.setAttribute(name, value);
    }
    node.append(...inside);
    return node;
  };

  const rows = [];
  if (data) {
    const names = Object.keys(data.rows);
    for (let i = 0; i < data.rows.method.length; i++) rows.push(Object.fromEntries(names.map((n) => [n, data.rows[n][i]])));
  }
  const unit = (row) => JSON.stringify([row.dataset, row.source_pose, row.target_pose]);
  const distinct = (list) => [...new Set(list)];
  const mean = (list) => list.reduce((a, b) => a + b, 0) / list.length;
  const grouped = (list, key) => {
    const found = new Map();
    for (const each of list) { const k = key(each); if (!found.has(k)) found.set(k, []); found.get(k).push(each); }
    return found;
  };

  /* Mean of each pair of poses over regimes of means over seeds: a Map from the pair. */
  function unitMeans(list, name) {
    const found = new Map();
    for (const [key, part] of grouped(list.filter((row) => row[name] !== null && row[name] !== undefined), unit)) {
      found.set(key, mean([...grouped(part, (row) => row.regime).values()].map((some) => mean(some.map((row) => row[name])))));
    }
    return found;
  }
  const nested = (list, name) => { const found = [...unitMeans(list, name).values()]; return found.length ? mean(found) : null; };

  const shown = (value, digits) => value === null || value === undefined || Number.isNaN(value) ? "–" : value.toFixed(digits);
  const options = (select, values, all) => {
    select.append(make("option", { value: "", text: all }), ...values.map((v) => make("option", { value: String(v), text: String(v) })));
  };

  function download(name, text, kind) {
    const link = make("a", { href: URL.createObjectURL(new Blob([text], { type: kind })), download: name });
    document.body.append(link); link.click(); link.remove();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  /* A head that sorts: text, its term in the glossary, and what is sorted by now. */
  function head(column, state, sort) {
    const now = state.by === column.name ? (state.down ? "descending" : "ascending") : "none";
    const button = make("button", { type: "button", onclick: () => sort(column), title: column.about || null }, column.title);
    const cell = make("th", { "aria-sort": now, class: column.digits === null ? "" : "number" }, button);
    if (document.getElementById(`term-${column.name}`)) {
      cell.append(make("a", { href: `#term-${column.name}`, class: "term", "aria-label": `What “${column.title}” means`, text: "?" }));
    }
    return cell;
  }
  const toggled = (state, column) => {
    state.down = state.by === column.name ? !state.down : column.best === "high";
    state.by = column.name;
  };
  const compare = (a, b, down) => {
    const lost = (v) => v === null || v === undefined || Number.isNaN(v);
    if (lost(a) || lost(b)) return lost(a) - lost(b);
    const order = typeof a === "number" ? a - b : String(a).localeCompare(String(b), "en", { numeric: true });
    return down ? -order : order;
  };

  return { data, rows, TIE, make, unit, distinct, mean, grouped, unitMeans, nested, shown, options, download, head, toggled, compare };
})();
