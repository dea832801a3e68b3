"use strict";
/* The pairs of the page: one is shown at a time, in the viewer or as its still picture; and the scans. */
window.medialScenes = {};   // what the files of views/ put here

/* A packed scene: from the page, or from a file beside it. */
function packedScene(name, source) {
  const here = document.getElementById(`scene-${name}`);
  if (here) return Promise.resolve(here.textContent);
  if (window.medialScenes[name]) return Promise.resolve(window.medialScenes[name]);
  if (!source) return Promise.reject(new Error("there is no view"));
  return new Promise((resolve, reject) => {
    const script = document.createElement("script");
    script.src = source;
    script.onload = () => resolve(window.medialScenes[name]);
    script.onerror = () => reject(new Error(`${source} is missing`));
    document.head.append(script);
  });
}

(() => {
  const figures = [...document.querySelectorAll("figure.pair")];
  if (!figures.length) return;
  const element = (id) => document.getElementById(id);
  const select = element("pair"), worst = element("worst"), still = element("still"), filter = element("filter");
  const stage = element("viewer");
  let view = null, shown = null, turn = 0, broken = false;

  function listed() {
    const group = filter ? filter.value : "";
    const list = figures.filter((figure) => !group || figure.dataset.group === group);
    const error = (figure) => { const value = Number(figure.dataset.error); return Number.isNaN(value) ? Infinity : value; };
    if (worst.checked) list.sort((a, b) => (error(b) > error(a)) - (error(b) < error(a)));   // unknown ones first
    return list;
  }

  function fill() {
    const list = listed();
    select.textContent = "";
    for (const figure of list) {
      const { title, caption, error, name } = figure.dataset, option = document.createElement("option");
      option.value = name;
      option.textContent = `${title}, ${caption.replace(/\.$/, "")} (error ${Number.isNaN(Number(error)) ? "unknown" : Number(error).toFixed(1)})`;
      select.append(option);
    }
    show(list.includes(shown) ? shown : list[0]);
  }

  function stills() {
    for (const figure of figures) figure.hidden = figure !== shown || !(still.checked || broken);
    stage.hidden = still.checked || broken;
  }

  async function show(figure) {
    shown = figure;
    select.value = figure.dataset.name;
    const words = new URLSearchParams(location.hash.slice(1));
    if (words.has("pair") || turn) {
      words.set("pair", figure.dataset.name);
      if (turn) words.delete("point");
      try { history.replaceState(null, "", `#${words}`); } catch (error) { /* no address */ }
    }
    stills();
    const mine = ++turn;
    try {
      const scene = await MedialView.decode(await packedScene(figure.dataset.name, figure.dataset.source));
      if (mine !== turn) return;
      if (view) view.destroy();
      view = window.view = MedialView.mount(stage, scene, { failed: () => { broken = true; stills(); } });
    } catch (error) {
      broken = true;
      stills();
      broken = false;
    }
  }

  const step = (by) => {
    const list = listed(), place = list.indexOf(shown);
    show(list[(place + by + list.length) % list.length]);
  };
  element("previous").addEventListener("click", () => step(-1));
  element("next").addEventListener("click", () => step(1));
  select.addEventListener("change", () => show(figures.find((figure) => figure.dataset.name === select.value)));
  worst.addEventListener("change", fill);
  still.addEventListener("change", stills);
  if (filter) filter.addEventListener("change", fill);
  window.openPair = (name) => {
    const figure = figures.find((each) => each.dataset.name === name);
    if (!figure) return;
    if (filter) filter.value = "";
    seen.disconnect();
    shown = figure;
    turn += 1;
    fill();
    element("pairs").scrollIntoView();
  };
  for (const link of document.querySelectorAll("[data-open]")) {
    link.addEventListener("click", (event) => { event.preventDefault(); window.openPair(link.dataset.open); });
  }
  const wanted = new URLSearchParams(location.hash.slice(1)).get("pair");
  shown = figures.find((figure) => figure.dataset.name === wanted) || null;
  stage.textContent = "The clouds are read when they come into view ...";
  const seen = new IntersectionObserver((entries) => {
    if (entries.some((entry) => entry.isIntersecting)) { seen.disconnect(); fill(); }
  }, { rootMargin: "600px" });
  for (const figure of figures) figure.hidden = true;
  seen.observe(stage);
  window.addEventListener("beforeprint", () => {
    for (const figure of figures) figure.hidden = false;
    for (const image of document.images) image.loading = "eager";
  });
})();

/* Scans, with a slider for the threshold; the picture below shows the same where there is no WebGL. */
(() => {
  const select = document.getElementById("scan"), stage = document.getElementById("scan-viewer");
  if (!select) return;
  let view = null, turn = 0;
  async function show() {
    const mine = ++turn, option = select.selectedOptions[0];
    try {
      const scene = await MedialView.decode(await packedScene(option.value, option.dataset.source));
      if (mine !== turn) return;
      if (view) view.destroy();
      view = window.scanView = MedialView.mount(stage, scene, { hash: false, failed: () => { stage.hidden = true; } });
    } catch (error) {
      stage.hidden = true;
    }
  }
  select.addEventListener("change", show);
  stage.textContent = "The scan is read when it comes into view ...";
  const seen = new IntersectionObserver((entries) => {
    if (entries.some((entry) => entry.isIntersecting)) { seen.disconnect(); show(); }
  }, { rootMargin: "300px" });
  seen.observe(stage);
})();
