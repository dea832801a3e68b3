"use strict";
/* Curves drawn in the page: hover for values, methods on and off, a dot opens its map. */
const Charts = (() => {
  const NS = "http://www.w3.org/2000/svg", HEIGHT = 380, LEFT = 58, RIGHT = 16, TOP = 14, BOTTOM = 48;
  const svg = (tag, attributes = {}, ...inside) => {
    const node = document.createElementNS(NS, tag);
    for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
    node.append(...inside);
    return node;
  };

  function scale(axis, low, high) {
    const f = axis.log ? Math.log10 : (v) => v, a = f(axis.min), b = f(axis.max);
    return (v) => low + (high - low) * (f(Math.min(Math.max(v, axis.min), axis.max)) - a) / (b - a || 1);
  }
  function ticks(axis, count) {
    if (axis.log) {
      for (const steps of [[1, 2, 5], [1, 1.5, 2, 3, 4, 5, 7]]) {   // the finer ones where the first give one or two
        const found = [];
        for (let decade = Math.floor(Math.log10(axis.min)); decade <= Math.log10(axis.max); decade++)
          for (const m of steps) { const v = m * 10 ** decade; if (v >= axis.min * 0.999 && v <= axis.max * 1.001) found.push(v); }
        if (found.length > 2) return found;
      }                                                             // else as on a linear axis
    }
    const span = axis.max - axis.min, rough = span / (count || 6), base = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map((m) => m * base).find((s) => s >= rough), found = [];
    for (let v = Math.ceil(axis.min / step) * step; v <= axis.max + 1e-9 * span; v += step) found.push(v);
    return found;
  }
  const label = (v) => Number(v.toPrecision(4)).toLocaleString("en", { maximumFractionDigits: 3 });

  /* series: [{name, color, line: [[x, y, words]], dots: [[x, y, words, open]], dash}] */
  function chart(host, { series, x, y, title }) {
    const hidden = host.hiddenSeries || (host.hiddenSeries = new Set());
    const draw = () => {
      const WIDTH = Math.max(320, Math.min(960, host.clientWidth || 860));   // user units are pixels
      host.drawnAt = WIDTH;
      const px = scale(x, LEFT, WIDTH - RIGHT), py = scale(y, HEIGHT - BOTTOM, TOP);
      const root = svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": title, class: "plot" });
      for (const v of ticks(x, WIDTH / 130)) {
        root.append(svg("line", { x1: px(v), x2: px(v), y1: TOP, y2: HEIGHT - BOTTOM, class: "grid" }));
        const words = svg("text", { x: px(v), y: HEIGHT - BOTTOM + 18, "text-anchor": "middle" }); words.textContent = label(v); root.append(words);
      }
      for (const v of ticks(y)) {
        root.append(svg("line", { x1: LEFT, x2: WIDTH - RIGHT, y1: py(v), y2: py(v), class: "grid" }));
        const words = svg("text", { x: LEFT - 7, y: py(v) + 4, "text-anchor": "end" }); words.textContent = label(v); root.append(words);
      }
      const under = svg("text", { x: (LEFT + WIDTH - RIGHT) / 2, y: HEIGHT - 8, "text-anchor": "middle", class: "axis" }); under.textContent = x.label;
      const beside = svg("text", { x: 14, y: (TOP + HEIGHT - BOTTOM) / 2, "text-anchor": "middle", class: "axis", transform: `rotate(-90 14 ${(TOP + HEIGHT - BOTTOM) / 2})` });
      beside.textContent = y.label; root.append(under, beside);
      const targets = [];
      for (const each of series) {
        if (hidden.has(each.name)) continue;
        if (each.line && each.line.length > 1) {
          const path = each.line.map(([a, b], i) => `${i ? "L" : "M"}${px(a).toFixed(1)} ${py(b).toFixed(1)}`).join("");
          root.append(svg("path", { d: path, fill: "none", stroke: each.color, "stroke-width": 2.2, "stroke-dasharray": each.dash || "none" }));
        }
        if (each.line && each.line.length === 1) {
          const [[a, b]] = each.line;
          root.append(svg("circle", { cx: px(a).toFixed(1), cy: py(b).toFixed(1), r: 4, fill: each.color }));
        }
        for (const [a, b, words] of each.line || []) targets.push({ x: px(a), y: py(b), words, color: each.color });
        for (const [a, b, words, open] of each.dots || []) {
          const dot = svg("circle", { cx: px(a).toFixed(1), cy: py(b).toFixed(1), r: 3.6, fill: each.color, "fill-opacity": 0.55, class: open ? "open" : "" });
          targets.push({ x: px(a), y: py(b), words, color: each.color, open });
          root.append(dot);
        }
      }
      const mark = svg("circle", { r: 6, fill: "none", "stroke-width": 2, visibility: "hidden" });
      root.append(mark);
      const tip = Page.make("div", { class: "tip", hidden: true });
      const nearest = (event) => {
        const box = root.getBoundingClientRect(), k = WIDTH / box.width;
        const a = (event.clientX - box.left) * k, b = (event.clientY - box.top) * k;
        let best = null, least = 30;
        for (const each of targets) { const d = Math.hypot(each.x - a, each.y - b); if (d < least) { least = d; best = each; } }
        return best && { ...best, left: best.x / k, top: best.y / k, width: box.width };
      };
      root.addEventListener("pointermove", (event) => {
        const found = nearest(event);
        tip.hidden = !found; mark.setAttribute("visibility", found ? "visible" : "hidden");
        root.style.cursor = found && found.open ? "pointer" : "";
        if (!found) return;
        mark.setAttribute("cx", found.x); mark.setAttribute("cy", found.y); mark.setAttribute("stroke", found.color);
        tip.textContent = found.words;
        tip.style.top = `${found.top + 12}px`;
        if (found.left > found.width / 2) { tip.style.left = ""; tip.style.right = `${found.width - found.left + 8}px`; }
        else { tip.style.right = ""; tip.style.left = `${found.left + 8}px`; }
      });
      root.addEventListener("pointerleave", () => { tip.hidden = true; mark.setAttribute("visibility", "hidden"); });
      root.addEventListener("click", (event) => { const found = nearest(event); if (found && found.open) window.openPair(found.open); });
      const legend = Page.make("div", { class: "legend" }, ...Page.distinct(series.map((s) => s.name)).map((name) => {
        const own = series.find((s) => s.name === name);
        return Page.make("button", { type: "button", "aria-pressed": String(!hidden.has(name)), onclick: () => { hidden.has(name) ? hidden.delete(name) : hidden.add(name); draw(); } },
          Page.make("span", { class: "chip", style: `--tint:${own.color}` }), name);
      }));
      host.replaceChildren(Page.make("div", { class: "canvas" }, root, tip), legend);
    };
    if (host.observed) host.observed.disconnect();
    host.observed = new ResizeObserver(() => { if (host.clientWidth && Math.abs(Math.min(960, host.clientWidth) - host.drawnAt) > 8) draw(); });
    draw();
    host.observed.observe(host);
  }

  const range = (values, log) => {
    const low = Math.min(...values), high = Math.max(...values);
    return log ? { min: Math.max(low, 1e-3) / 1.15, max: high * 1.15 } : { min: 0, max: high * 1.04 || 1 };
  };
  const short = (v, digits = 2) => v === null ? "–" : v.toFixed(digits);

  /* Medians of groups of equal size, in the order of x. */
  function medians(points, groups = 6) {
    const sorted = [...points].sort((a, b) => a[0] - b[0]), found = [];
    const count = Math.min(groups, Math.floor(sorted.length / 3));
    const middle = (list) => { const s = [...list].sort((a, b) => a - b), k = (s.length - 1) / 2; return (s[Math.floor(k)] + s[Math.ceil(k)]) / 2; };
    for (let g = 0; g < count; g++) {
      const part = sorted.slice(Math.round(g * sorted.length / count), Math.round((g + 1) * sorted.length / count));
      const a = middle(part.map((p) => p[0])), b = middle(part.map((p) => p[1]));
      found.push([a, b, `median of ${part.length} maps: ${short(b)} at ${a.toFixed(0)} % missing`]);
    }
    return found;
  }

  function errorChart(host) {
    const rows = Page.rows.filter((row) => row.geodesic_mean > 0 && row.missing !== null);
    if (!rows.length) return;
    const series = Page.data.methods.map((m) => {
      const own = rows.filter((row) => row.method === m.name);
      const dots = own.map((row) => [row.missing, row.geodesic_mean,
        `${m.name}: ${short(row.geodesic_mean)} at ${row.missing.toFixed(0)} % missing\n${row.dataset}: ${row.source_pose} → ${row.target_pose}, ${row.regime}, seed ${row.seed}${row.picture ? "\nclick to open" : ""}`, row.picture]);
      return { name: m.name, color: m.color, dots, line: medians(dots).map((p) => [p[0], p[1], `${m.name}, ${p[2]}`]) };
    }).filter((s) => s.dots.length);
    chart(host, { series, title: "Error against missing surface", x: { label: "missing surface, % (mean of both scans)", ...range(rows.map((r) => r.missing)) },
      y: { label: "mean error × 100 / √area (log)", log: true, ...range(rows.map((r) => r.geodesic_mean), true) } });
  }

  function pckChart(host, group) {
    const { radii, curves } = Page.data.pck, own = curves.filter((c) => `${c.dataset}, ${c.regime}` === group), from = radii.findIndex((r) => r >= 0.5);
    const color = Object.fromEntries(Page.data.methods.map((m) => [m.name, m.color]));
    const series = own.map((c) => ({ name: c.method, color: color[c.method],
      line: radii.slice(from).map((r, i) => [r, 100 * c.values[from + i], `${c.method}: ${(100 * c.values[from + i]).toFixed(1)} % within ${label(r)}`]) }));
    chart(host, { series, title: `PCK, ${group}`, x: { label: "geodesic radius × 100 / √area", log: true, min: radii[from], max: radii[radii.length - 1] }, y: { label: "points matched within, %", min: 0, max: 100 } });
  }

  function eq18Chart(host, group) {
    const own = Page.data.stability.filter((r) => `${r.dataset}, ${r.operator}` === group && r.error !== null), poses = Page.distinct(own.map((r) => r.pose));
    const series = poses.map((pose, i) => {
      const mine = [...Page.grouped(own.filter((r) => r.pose === pose), (r) => r.threshold).entries()].sort((a, b) => a[0] - b[0]);
      return { name: pose, color: `hsl(${Math.round(360 * i / poses.length)} 60% 45%)`, line: mine.map(([t, part]) => {
        const error = Page.mean(part.map((r) => r.error)), missing = Page.mean(part.map((r) => r.missing));
        return [t, error, `${pose} at threshold ${t}: ${error.toPrecision(3)}, ${missing.toFixed(0)} % missing`];
      }) };
    });
    const all = own.map((r) => r.threshold), low = Math.min(...all), high = Math.max(...all), room = low === high ? 0.05 : 0;
    chart(host, { series, title: `Eq. 18, ${group}`, x: { label: "peak threshold τ", min: low - room, max: high + room }, y: { label: "Eq. 18, relative to the reference", ...range(own.map((r) => r.error)) } });
  }

  function choosing(id, groups, drawn) {
    const host = document.getElementById(id), select = document.getElementById(`${id}-group`);
    if (!host || !Page.data || !groups.length) return;
    select.append(...groups.map((g) => Page.make("option", { value: g, text: g })));
    select.closest("label").hidden = groups.length < 2;
    select.addEventListener("change", () => { host.hiddenSeries = null; drawn(host, select.value); });
    drawn(host, groups[0]);
    host.closest("figure").classList.add("drawn");
  }
  if (Page.data) {
    const missing = document.getElementById("chart-missing");
    if (missing) { errorChart(missing); if (missing.firstChild) missing.closest("figure").classList.add("drawn"); }
    choosing("chart-pck", Page.distinct(Page.data.pck.curves.map((c) => `${c.dataset}, ${c.regime}`)), pckChart);
    choosing("chart-eq18", Page.distinct(Page.data.stability.map((r) => `${r.dataset}, ${r.operator}`)), eq18Chart);
  }
  return { chart };
})();
