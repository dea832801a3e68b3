"use strict";
/* The pairs of the page: one is shown at a time, in the viewer or as its still picture. */
(() => {
  const figures = [...document.querySelectorAll("figure.pair")];
  if (!figures.length) return;
  const element = (id) => document.getElementById(id);
  const select = element("pair"), worst = element("worst"), still = element("still"), filter = element("filter");
  const stage = element("viewer");
  let view = null, shown = null, turn = 0, broken = false;
  window.medialScenes = {};   // what the files of views/ put here

  function listed() {
    const group = filter ? filter.value : "";
    const list = figures.filter((figure) => !group || figure.dataset.group === group);
    if (worst.checked) list.sort((a, b) => Number(b.dataset.error) - Number(a.dataset.error));
    return list;
  }

  function fill() {
    const list = listed();
    select.textContent = "";
    for (const figure of list) {
      const { title, caption, error, name } = figure.dataset, option = document.createElement("option");
      option.value = name;
      option.textContent = `${title}, ${caption.replace(/\.$/, "")} (error ${Number(error).toFixed(1)})`;
      select.append(option);
    }
    show(list.includes(shown) ? shown : list[0]);
  }

  /* Packed scene of a figure: from the page, or from a file beside it. */
  function packed(figure) {
    const { name, source } = figure.dataset, here = element(`scene-${name}`);
    if (here) return Promise.resolve(here.textContent);
    if (window.medialScenes[name]) return Promise.resolve(window.medialScenes[name]);
    if (!source) return Promise.reject(new Error("this pair has no view"));
    return new Promise((resolve, reject) => {
      const script = document.createElement("script");
      script.src = source;
      script.onload = () => resolve(window.medialScenes[name]);
      script.onerror = () => reject(new Error(`${source} is missing`));
      document.head.append(script);
    });
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
      const scene = await MedialView.decode(await packed(figure));
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
