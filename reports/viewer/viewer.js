/* Interactive view of point clouds and the maps between them.

   MedialView.mount(element, scene) draws one panel for the source and one for each map, all with one camera.
   A target that would show its inner side is seen from behind: half a turn about the axis that points up.
   A scene comes from MedialView.decode(text): base64 of deflated arrays behind a JSON head (reports/viewer/packing.py).
   Needs regl (WebGL 1). Without WebGL it says so, and what is in the element's <noscript>-like [data-still] stays. */
"use strict";
const MedialView = (() => {
  const CLICK = 6;          // pixels: a shorter drag is a click
  const REACH = 14;         // pixels from a point within which it is hit
  const NARROWEST = 170;    // pixels of a panel

  /* ---------------------------------------------------------------- reading */

  const KINDS = { u1: Uint8Array, i1: Int8Array, u2: Uint16Array, i4: Int32Array, f4: Float32Array };

  async function decode(text) {
    const packed = Uint8Array.from(atob(text.trim()), (c) => c.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
    const buffer = await new Response(stream).arrayBuffer();
    const size = new DataView(buffer).getUint32(0, true);
    const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, size)));
    const array = (entry) => {
      if (!entry) return null;
      const Kind = KINDS[entry.kind];
      return new Kind(buffer.slice(entry.start, entry.start + entry.count * Kind.BYTES_PER_ELEMENT));
    };
    const scene = { ...head, clouds: head.clouds.map((cloud) => readCloud(cloud, array)) };
    scene.maps = head.maps.map((map) => ({
      ...map,
      image: array(map.image),
      fill: array(map.fill),
      confidence: array(map.confidence),
      errors: array(map.errors),
      landmarks: array(map.landmarks),
    }));
    scene.truth = array(head.truth);
    scene.luts = Object.fromEntries(Object.entries(head.luts).map(([name, entry]) => [name, array(entry)]));
    return scene;
  }

  function readCloud(cloud, array) {
    const grid = array(cloud.points), n = grid.length / 3, points = new Float32Array(3 * n);
    for (let i = 0; i < 3 * n; i++) points[i] = cloud.low[i % 3] + cloud.step * grid[i];
    const normals = cloud.normals ? unfolded(array(cloud.normals)) : null;
    const centers = cloud.centers ? Float32Array.from(array(cloud.centers), (v, i) => cloud.low[i % 3] + cloud.step * v) : null;
    const fields = cloud.fields.map((field) => ({ ...field, values: array(field.values) }));
    return { ...cloud, n, points, normals, centers, colors: array(cloud.colors), fields };
  }

  /* Octahedral normals of two bytes as unit vectors. */
  function unfolded(bytes) {
    const n = bytes.length / 2, out = new Float32Array(3 * n);
    for (let i = 0; i < n; i++) {
      let x = bytes[2 * i] / 127, y = bytes[2 * i + 1] / 127;
      const z = 1 - Math.abs(x) - Math.abs(y);
      if (z < 0) [x, y] = [(1 - Math.abs(y)) * (x >= 0 ? 1 : -1), (1 - Math.abs(x)) * (y >= 0 ? 1 : -1)];
      const length = Math.hypot(x, y, z) || 1;
      out.set([x / length, y / length, z / length], 3 * i);
    }
    return out;
  }

  /* ---------------------------------------------------------------- camera */

  const product = (a, b) => [
    a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
    a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
    a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
    a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
  ];
  const unit = (q) => { const l = Math.hypot(...q) || 1; return q.map((v) => v / l); };
  const turn = (axis, angle) => {
    const s = Math.sin(angle / 2);
    return [Math.cos(angle / 2), axis[0] * s, axis[1] * s, axis[2] * s];
  };
  /* Columns of the rotation matrix, as WebGL takes them. */
  const matrix = ([w, x, y, z]) => [
    1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y),
    2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x),
    2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y),
  ];

  /* Standing upright: the axis that points up becomes the screen's y. */
  const upright = (up) => up === 2 ? turn([1, 0, 0], -Math.PI / 2) : up === 0 ? turn([0, 0, 1], Math.PI / 2) : [1, 0, 0, 0];
  const VIEWS = {
    front: [[0, 1, 0], 0], back: [[0, 1, 0], Math.PI], left: [[0, 1, 0], -Math.PI / 2],
    right: [[0, 1, 0], Math.PI / 2], top: [[1, 0, 0], Math.PI / 2], oblique: [[0, 1, 0], -0.6],
  };

  /* ---------------------------------------------------------------- drawing */

  const VERTEX = `
    precision highp float;
    attribute vec3 position, normal, color;
    attribute float shown;
    uniform mat3 rotation; uniform vec2 scale, pan; uniform float size; uniform bool lit;
    varying vec3 tint; varying float facing;
    void main() {
      vec3 p = rotation * position;
      gl_Position = shown < 0.5 ? vec4(2.0, 2.0, 2.0, 1.0) : vec4((p.xy + pan) * scale, -0.3 * p.z, 1.0);
      gl_PointSize = size; tint = color;
      facing = lit ? (rotation * normal).z : 1.0;
    }`;
  const FRAGMENT = `
    precision mediump float;
    varying vec3 tint; varying float facing; uniform vec3 inside;
    void main() {
      vec2 d = gl_PointCoord - 0.5;
      if (dot(d, d) > 0.25) discard;
      vec3 shade = facing < 0.0 ? inside : tint * (0.52 + 0.48 * facing);
      gl_FragColor = vec4(shade, 1.0);
    }`;

  function drawing(regl) {
    return regl({
      vert: VERTEX, frag: FRAGMENT, primitive: "points",
      attributes: {
        position: regl.prop("position"), normal: regl.prop("normal"), color: regl.prop("color"),
        shown: regl.prop("shown"),
      },
      uniforms: {
        rotation: regl.prop("rotation"), scale: regl.prop("scale"), pan: regl.prop("pan"), size: regl.prop("size"),
        lit: regl.prop("lit"), inside: regl.prop("inside"),
      },
      count: regl.prop("count"),
      viewport: regl.prop("box"), scissor: { enable: true, box: regl.prop("box") },
    });
  }

  /* ---------------------------------------------------------------- the view */

  class View {
    constructor(element, scene, options = {}) {
      this.element = element; this.scene = scene; this.options = options;
      this.start = scene.start || "front";
      this.camera = this.from(this.start);
      this.state = { behind: true, color: "", chosen: null, landmarks: true, centers: false, frame: 0, threshold: null, scale: "fixed",
        size: 1, maps: scene.maps.map((_, k) => k) };
      this.state.color = this.colorings()[0].name;
      this.state.marked = scene.maps.findIndex((m) => m.landmarks && m.landmarks.length);
      if (scene.filter) this.state.threshold = scene.filter.low;
      this.build();
      this.restore();
      this.upload();
      this.listen();
      this.draw();
    }

    /* What points can be coloured by. */
    colorings() {
      const [source] = this.scene.clouds, maps = this.scene.maps, found = [];
      if (source.colors) found.push({ name: "place", label: source.colorLabel || "place on the body" });
      if (maps.some((m) => m.errors)) found.push({ name: "error", label: "error of the map" });
      if (maps.some((m) => m.confidence)) found.push({ name: "confidence", label: "confidence of the map" });
      source.fields.forEach((f) => found.push({ name: `field:${f.name}`, label: f.label }));
      found.push({ name: "plain", label: "nothing (shading alone)" });
      return found;
    }

    build() {
      const make = (tag, attributes = {}, ...inside) => {
        const node = document.createElement(tag);
        for (const [key, value] of Object.entries(attributes)) {
          if (key === "text") node.textContent = value; else if (key in node && key !== "list") node[key] = value;
          else node.setAttribute(key, value);
        }
        node.append(...inside); return node;
      };
      this.make = make;
      this.element.classList.add("mv");
      this.element.textContent = "";
      this.canvas = make("canvas", { className: "mv-gl" });
      this.overlay = make("canvas", { className: "mv-overlay", tabIndex: 0 });
      this.overlay.setAttribute("role", "img");
      this.overlay.setAttribute("aria-label", `${this.scene.title}. Drag to turn, scroll or pinch to zoom, arrow keys turn, tap a point to see its match.`);
      this.stage = make("div", { className: "mv-stage" }, this.canvas, this.overlay);
      this.readout = make("div", { className: "mv-readout" });
      this.readout.setAttribute("aria-live", "polite");
      this.legend = make("div", { className: "mv-legend" });
      this.tools = make("div", { className: "mv-tools" });
      this.element.append(this.tools, this.stage, this.legend, this.readout);
      const colour = make("select", { title: "Colour of the points" },
        ...this.colorings().map((c) => make("option", { value: c.name, text: c.label })));
      colour.value = this.state.color;
      colour.onchange = () => { this.state.color = colour.value; this.changed(true); };
      this.colourSelect = colour;
      this.tools.append(make("label", {}, "Colour ", colour));
      const view = make("select", { title: "View from" }, make("option", { value: "", text: "turned" }),
        ...Object.keys(VIEWS).map((name) => make("option", { value: name, text: name })));
      view.value = this.start; this.viewSelect = view;
      view.onchange = () => { if (view.value) this.look(view.value); };
      this.tools.append(make("label", {}, "View ", view));
      this.slider = make("input", { type: "range", min: 0, max: 0, value: 0 });
      this.slider.oninput = () => { this.state.frame = Number(this.slider.value); this.changed(true); };
      this.sliderLabel = make("label", { className: "mv-hidden" }, make("span", { text: "t" }), " ", this.slider);
      this.tools.append(this.sliderLabel);
      if (this.scene.filter) {
        const f = this.scene.filter, input = make("input", { type: "range", min: f.low, max: f.high, step: (f.high - f.low) / 200, value: f.low });
        this.filterLabel = make("span", {});
        input.oninput = () => { this.state.threshold = Number(input.value); this.changed(true); };
        this.filterInput = input;
        this.tools.append(make("label", {}, f.label, " ", input, " ", this.filterLabel));
      }
      const box = (name, label) => {
        const input = make("input", { type: "checkbox", checked: this.state[name] });
        input.onchange = () => { this.state[name] = input.checked; this.changed(); };
        this.tools.append(make("label", {}, input, " ", label));
        return input;
      };
      this.boxes = {};
      if (this.scene.maps.some((m) => m.landmarks && m.landmarks.length)) this.boxes.landmarks = this.whose(box("landmarks", "landmarks"));
      if (this.scene.clouds.some((c) => c.centers)) this.boxes.centers = box("centers", "medial centres");
      if (this.scene.clouds.some((c) => c.behind)) {
        this.boxes.behind = box("behind", "target turned by 180°");
        this.boxes.behind.parentNode.title = "Turned by half a turn, else one looks into its inner side";
      }
      if (this.scene.maps.some((m) => m.errors)) {
        const input = make("input", { type: "checkbox" });
        input.onchange = () => { this.state.scale = input.checked ? "auto" : "fixed"; this.changed(true); };
        this.autoLabel = make("label", { title: "Colours up to the 99 % quantile of the errors shown, instead of a fixed error" }, input, " automatic scale");
        this.autoBox = input;
        this.tools.append(this.autoLabel);
      }
      const size = make("input", { type: "range", min: 0.4, max: 2.5, step: 0.1, value: 1, title: "Size of the points" });
      size.oninput = () => { this.state.size = Number(size.value); this.changed(); };
      this.tools.append(make("label", {}, "Size ", size));
      const picture = make("button", { type: "button", text: "PNG", title: "Save the view as a picture" });
      picture.onclick = () => this.save();
      const reset = make("button", { type: "button", text: "Reset", title: "The first view, nothing chosen" });
      reset.onclick = () => { this.state.chosen = null; this.look(this.start); };
      this.tools.append(picture, reset);
      try {
        this.regl = createREGL({ canvas: this.canvas, attributes: { antialias: true, preserveDrawingBuffer: true } });
      } catch (error) {
        this.regl = null;
      }
      if (!this.regl) {
        this.readout.textContent = "WebGL is not available here, so the clouds cannot be turned; the still picture shows the same.";
        if (this.options.failed) this.options.failed();
        return;
      }
      this.canvas.addEventListener("webglcontextlost", (event) => {
        event.preventDefault();
        this.readout.textContent = "The browser took the graphics context away; reload the page to turn the clouds again.";
        if (this.options.failed) this.options.failed();
      });
      this.paint = drawing(this.regl);
    }

    /* Whose landmarks are shown: one map's at a time, as the landmarks of two maps are other points of one source. */
    whose(box) {
      const maps = this.scene.maps.map((map, k) => [map, k]).filter(([map]) => map.landmarks && map.landmarks.length);
      if (maps.length < 2) return box;
      const select = this.make("select", { className: "mv-whose", title: "Whose landmarks are shown" },
        ...maps.map(([map, k]) => this.make("option", { value: k, text: map.label })));
      select.onchange = () => { this.state.marked = Number(select.value); box.checked = this.state.landmarks = true; this.changed(); };
      box.parentNode.append(" of ");
      box.parentNode.after(select);
      return box;
    }

    /* Panels: the source, then one per map. A scan alone has one. */
    panels() {
      const list = [{ cloud: 0, map: null, title: this.scene.clouds[0].name, note: this.scene.clouds[0].caption }];
      for (const k of this.state.maps) {
        const map = this.scene.maps[k];
        const onSource = ["error", "confidence"].includes(this.state.color);
        const cloud = onSource ? 0 : map.target;
        list.push({ cloud, map: k, title: `${map.label}${this.turned(cloud) ? ", turned by 180°" : ""}`,
          note: [map.note, onSource ? "" : this.scene.clouds[map.target].caption].filter(Boolean).join(", ") });
      }
      return list;
    }

    layout() {
      const width = this.stage.clientWidth || 600, panels = this.panels();
      const columns = Math.max(1, Math.min(panels.length, Math.floor(width / NARROWEST)));
      const rows = Math.ceil(panels.length / columns), w = width / columns;
      const h = Math.max(220, Math.min(w * 1.15, Math.max(360, 0.66 * window.innerHeight) / Math.min(rows, 2)));
      this.stage.style.height = `${Math.round(h * rows)}px`;
      this.ratio = window.devicePixelRatio || 1;
      for (const canvas of [this.canvas, this.overlay]) {
        const [x, y] = [Math.round(width * this.ratio), Math.round(h * rows * this.ratio)];
        if (canvas.width !== x || canvas.height !== y) { canvas.width = x; canvas.height = y; }
      }
      panels.forEach((p, k) => { p.x = (k % columns) * w; p.y = Math.floor(k / columns) * h; p.w = w; p.h = h; });
      return panels;
    }

    /* ------------------------------------------------------------ colours */

    style(name, otherwise) {
      return getComputedStyle(this.element).getPropertyValue(name).trim() || otherwise;
    }

    rgb(name, otherwise) {
      const probe = document.createElement("canvas").getContext("2d");
      probe.fillStyle = this.style(name, otherwise);
      const text = probe.fillStyle;
      return [1, 3, 5].map((k) => parseInt(text.slice(k, k + 2), 16) / 255);
    }

    /* A number in [0, 1] as three bytes of a colour table. */
    lut(name, value, out, at) {
      const table = this.scene.luts[name], k = 3 * Math.max(0, Math.min(255, Math.round(255 * value)));
      out[at] = table[k]; out[at + 1] = table[k + 1]; out[at + 2] = table[k + 2];
    }

    errorTop() {
      if (this.state.scale === "fixed") return this.scene.errorTop || 10;
      const all = [];
      for (const k of this.state.maps) { const e = this.scene.maps[k].errors; if (e) for (const v of e) if (v >= 0) all.push(v); }
      all.sort((a, b) => a - b);
      return Math.max(all[Math.floor(0.99 * (all.length - 1))] || 1, 0.1);
    }

    fieldOf(cloud) {
      const name = this.state.color.slice(6);
      return cloud.fields.find((f) => f.name === name);
    }

    /* Colours of a panel's points, three bytes each. */
    colors(panel) {
      const cloud = this.scene.clouds[panel.cloud], out = new Uint8Array(3 * cloud.n), mode = this.state.color;
      const absent = this.rgb("--mv-absent", "#b9bec6").map((v) => Math.round(255 * v));
      const plain = this.rgb("--mv-plain", "#7f9fc4").map((v) => Math.round(255 * v));
      const fill = (i, c) => { out[3 * i] = c[0]; out[3 * i + 1] = c[1]; out[3 * i + 2] = c[2]; };
      const map = panel.map === null ? null : this.scene.maps[panel.map];
      if (mode === "error" || mode === "confidence") {
        const shown = map || this.scene.maps[this.state.maps[0]];
        if (!map) for (let i = 0; i < cloud.n; i++) { if (cloud.colors) fill(i, cloud.colors.subarray(3 * i, 3 * i + 3)); else fill(i, plain); }
        else if (mode === "error") {
          const top = this.errorTop();
          for (let i = 0; i < cloud.n; i++) {
            if (!shown.errors || !(shown.errors[i] >= 0)) fill(i, absent); else this.lut("error", shown.errors[i] / top, out, 3 * i);
          }
        } else for (let i = 0; i < cloud.n; i++) {
          if (!shown.confidence) fill(i, absent); else this.lut("confidence", shown.confidence[i] / 255, out, 3 * i);
        }
      } else if (mode.startsWith("field:")) {
        const field = this.fieldOf(cloud);
        for (let i = 0; i < cloud.n; i++) {
          if (field) this.lut(field.lut, field.values[this.frameOf(field) * cloud.n + i] / 255, out, 3 * i); else fill(i, absent);
        }
      } else if (mode === "place") {
        if (!map) for (let i = 0; i < cloud.n; i++) fill(i, cloud.colors.subarray(3 * i, 3 * i + 3));
        else {
          for (let i = 0; i < cloud.n; i++) fill(i, absent);
          const given = this.scene.clouds[0].colors, sums = new Float32Array(4 * cloud.n);
          map.image.forEach((j, i) => {
            if (j < 0) return;
            for (let c = 0; c < 3; c++) sums[4 * j + c] += given[3 * i + c];
            sums[4 * j + 3] += 1;
          });
          for (let j = 0; j < cloud.n; j++) {
            const k = map.fill[j], n = k < 0 ? 0 : sums[4 * k + 3];
            if (n) fill(j, [sums[4 * k] / n, sums[4 * k + 1] / n, sums[4 * k + 2] / n]);
          }
        }
      } else for (let i = 0; i < cloud.n; i++) fill(i, plain);
      return out;
    }

    frameOf(field) { return Math.max(0, Math.min(this.state.frame, (field.frames || []).length - 1)); }

    shown(cloud) {
      const out = new Uint8Array(cloud.n).fill(1), f = this.scene.filter;
      if (f && this.state.threshold !== null) {
        const field = cloud.fields.find((each) => each.name === f.field);
        if (field) for (let i = 0; i < cloud.n; i++) {
          out[i] = field.low + (field.high - field.low) * field.values[i] / 255 >= this.state.threshold - 1e-9 ? 1 : 0;
        }
      }
      return out;
    }

    /* Buffers of what does not change with the camera. */
    upload() {
      if (!this.regl) return;
      const regl = this.regl;
      if (!this.buffers) {
        this.buffers = this.scene.clouds.map((c) => ({
          position: regl.buffer(c.points), normal: regl.buffer(c.normals || new Float32Array(3 * c.n)),
          centers: c.centers ? regl.buffer(c.centers) : null,
        }));
      }
      (this.tints || []).forEach((b) => { b.color.buffer.destroy(); b.shown.destroy(); });
      this.tints = this.panels().map((panel) => {
        const cloud = this.scene.clouds[panel.cloud], shown = this.shown(cloud);
        return { color: { buffer: regl.buffer(this.colors(panel)), normalized: true }, shown: regl.buffer(Float32Array.from(shown)), visible: shown };
      });
      this.controls();
    }

    controls() {
      const field = this.state.color.startsWith("field:") ? this.fieldOf(this.scene.clouds[0]) : null;
      const frames = field && field.frames ? field.frames.length : 0;
      this.sliderLabel.classList.toggle("mv-hidden", frames < 2);
      if (frames > 1) {
        this.slider.max = frames - 1; this.slider.value = this.frameOf(field);
        this.sliderLabel.firstChild.textContent = field.frames[this.frameOf(field)];
      }
      if (this.autoLabel) this.autoLabel.classList.toggle("mv-hidden", this.state.color !== "error");
      if (this.filterLabel) {
        const seen = this.tints.length ? this.tints[0].visible.reduce((a, b) => a + b, 0) : 0;
        this.filterLabel.textContent = `${this.state.threshold.toFixed(2)}, ${seen.toLocaleString("en")} points`;
      }
      this.bar(field);
    }

    /* Scale of the colours below the panels. */
    bar(field) {
      const ends = this.state.color === "error" ? ["error", "0", `${this.errorTop().toFixed(1)} or more`, "error × 100 / √area; grey: no match"]
        : this.state.color === "confidence" ? ["confidence", "0", "1", "confidence"]
        : field ? [field.lut, field.ends[0], field.ends[1], field.label] : null;
      this.legend.textContent = "";
      if (!ends) {
        if (this.state.color === "place") this.legend.textContent = this.scene.maps.length
          ? "A target point has the mean colour of the source points mapped to it; grey: none, and the inside of the surface is dark." : "";
        return;
      }
      const table = this.scene.luts[ends[0]], stops = [];
      for (let k = 0; k <= 16; k++) { const i = 3 * Math.round(255 * k / 16); stops.push(`rgb(${table[i]},${table[i + 1]},${table[i + 2]})`); }
      const strip = this.make("span", { className: "mv-strip" });
      strip.style.background = `linear-gradient(90deg, ${stops.join(",")})`;
      this.legend.append(this.make("span", { text: ends[1] }), strip, this.make("span", { text: ends[2] }), this.make("span", { className: "mv-what", text: ends[3] }));
    }

    /* ------------------------------------------------------------ frames */

    changed(colours = false) { if (colours) this.upload(); this.draw(); this.remember(); }

    from(name) {
      const [axis, angle] = VIEWS[name];
      return { q: product(turn(axis, angle), upright(this.scene.up)), zoom: 1, pan: [0, 0] };
    }

    turned(cloud) { return this.state.behind && Boolean(this.scene.clouds[cloud].behind); }

    /* How a cloud is turned: as all are, or first by half a turn about the axis that points up. */
    rotation(cloud) {
      const half = [0, 0, 0, 0];
      half[1 + this.scene.up] = 1;
      return matrix(this.turned(cloud) ? product(this.camera.q, half) : this.camera.q);
    }

    look(name) {
      this.camera = this.from(name);
      this.viewSelect.value = name;
      this.changed();
    }

    draw() {
      if (this.waiting) return;
      this.waiting = true;
      requestAnimationFrame(() => { this.waiting = false; this.frame(); });
    }

    scaleOf(panel) {
      const s = 0.92 * this.camera.zoom, ratio = panel.w / panel.h;
      return ratio < 1 ? [s, s * ratio] : [s / ratio, s];
    }

    frame() {
      const panels = this.layout(), r = this.ratio;
      this.drawn = panels;
      if (this.regl) {
        const ground = this.rgb("--mv-ground", "#ffffff");
        this.regl.poll();
        this.regl.clear({ color: [...ground, 1], depth: 1 });
        const inside = this.rgb("--mv-inside", "#4d535c");
        panels.forEach((panel, k) => {
          const cloud = this.scene.clouds[panel.cloud], buffer = this.buffers[panel.cloud];
          const box = { x: panel.x * r, y: this.canvas.height - (panel.y + panel.h) * r, width: panel.w * r, height: panel.h * r };
          const size = Math.max(2, cloud.spacing * this.state.size * 0.75 * Math.min(panel.w, panel.h) * this.camera.zoom * r);
          const common = { rotation: this.rotation(panel.cloud), scale: this.scaleOf(panel), pan: this.camera.pan, inside, box, normal: buffer.normal };
          if (this.state.centers && buffer.centers) {
            this.paint({ ...common, position: buffer.centers, color: this.tints[k].color, shown: this.tints[k].shown, size: Math.max(1.5, size / 3), lit: false, count: cloud.n });
          } else {
            this.paint({ ...common, position: buffer.position, color: this.tints[k].color, shown: this.tints[k].shown, size, lit: Boolean(cloud.normals), count: cloud.n });
          }
        });
      }
      this.annotate(panels);
    }

    /* Place of a cloud's point in a panel, in pixels of the page, with its depth. */
    screen(panel, p) {
      const m = this.rotation(panel.cloud), [sx, sy] = this.scaleOf(panel);
      const x = m[0] * p[0] + m[3] * p[1] + m[6] * p[2], y = m[1] * p[0] + m[4] * p[1] + m[7] * p[2];
      const z = m[2] * p[0] + m[5] * p[1] + m[8] * p[2];
      return [panel.x + panel.w * (0.5 + 0.5 * (x + this.camera.pan[0]) * sx), panel.y + panel.h * (0.5 - 0.5 * (y + this.camera.pan[1]) * sy), z];
    }

    point(cloud, i) { const c = this.scene.clouds[cloud]; return [c.points[3 * i], c.points[3 * i + 1], c.points[3 * i + 2]]; }

    annotate(panels) {
      const g = this.overlay.getContext("2d"), r = this.ratio, ink = this.style("--mv-ink", "#1c1f24");
      g.setTransform(r, 0, 0, r, 0, 0);
      g.clearRect(0, 0, this.overlay.width, this.overlay.height);
      g.textBaseline = "top"; g.fillStyle = ink;
      const fit = (text, width) => { while (text.length > 4 && g.measureText(text).width > width) text = text.slice(0, -2).replace(/…?$/, "…"); return text; };
      for (const panel of panels) {
        g.font = "600 13px system-ui, sans-serif"; g.fillText(fit(panel.title, panel.w - 16), panel.x + 8, panel.y + 6);
        g.font = "12px system-ui, sans-serif"; g.globalAlpha = 0.7; g.fillText(fit(panel.note || "", panel.w - 16), panel.x + 8, panel.y + 23); g.globalAlpha = 1;
      }
      if (this.state.landmarks) this.landmarks(g, panels);
      if (this.state.chosen !== null) this.chosen(g, panels);
    }

    ring(g, [x, y], radius, colour, filled = false) {
      g.beginPath(); g.arc(x, y, radius, 0, 2 * Math.PI);
      g.lineWidth = 4; g.strokeStyle = this.style("--mv-ground", "#ffffff"); g.stroke();
      g.lineWidth = 2; g.strokeStyle = colour; g.stroke();
      if (filled) { g.fillStyle = colour; g.fill(); }
    }

    /* Landmarks in a panel: points of its cloud and their colours, equal ones in two panels for one landmark. */
    marks(panel) {
      const map = this.scene.maps[this.state.marked];
      if (!map || !map.landmarks || panel.map !== null && panel.map !== this.state.marked) return [];
      const side = panel.map === null || panel.cloud === 0 && map.target !== 0 ? 0 : 1, count = map.landmarks.length / 2;
      return Array.from({ length: count }, (_, k) => [map.landmarks[2 * k + side], `hsl(${Math.round(360 * k / count)} 75% 45%)`]);
    }

    landmarks(g, panels) {
      for (const panel of panels) {
        for (const [i, hue] of this.marks(panel)) this.ring(g, this.screen(panel, this.point(panel.cloud, i)), 3.5, hue, true);
      }
    }

    /* The chosen source point, its match and its true place in every panel, joined by lines. */
    chosen(g, panels) {
      const i = this.state.chosen, from = this.screen(panels[0], this.point(0, i));
      const right = this.scene.truth ? this.scene.truth[i] : -1;
      for (const panel of panels.slice(1)) {
        const map = this.scene.maps[panel.map], j = map.image[i];
        const where = panel.cloud === 0 && map.target !== 0 ? [0, i] : [map.target, j];
        if (where[1] < 0) continue;
        const to = this.screen(panel, this.point(...where));
        g.beginPath(); g.moveTo(from[0], from[1]); g.lineTo(to[0], to[1]);
        g.setLineDash([5, 4]); g.lineWidth = 1.2; g.strokeStyle = this.style("--mv-match", "#d2452d"); g.stroke(); g.setLineDash([]);
        this.ring(g, to, 6, this.style("--mv-match", "#d2452d"));
        if (right >= 0 && where[0] === map.target) this.ring(g, this.screen(panel, this.point(map.target, right)), 6, this.style("--mv-truth", "#1a8f4c"));
      }
      this.ring(g, from, 6, this.style("--mv-match", "#d2452d"));
      this.tell();
    }

    tell() {
      const i = this.state.chosen, scene = this.scene;
      this.readout.textContent = "";
      if (i === null || !this.regl) return;
      const line = (text) => this.readout.append(this.make("div", { text }));
      const fields = scene.clouds[0].fields.filter((f) => !f.frames).map((f) => `${f.label} ${(f.low + (f.high - f.low) * f.values[i] / 255).toPrecision(3)}`);
      line(`Source point ${i}${fields.length ? `: ${fields.join(", ")}` : ""}`);
      for (const k of this.state.maps) {
        const map = scene.maps[k], words = [map.image[i] < 0 ? "no match" : `target point ${map.image[i]}`];
        if (map.errors && map.errors[i] >= 0) words.push(`error ${map.errors[i].toFixed(2)}`);
        if (map.confidence) words.push(`confidence ${(map.confidence[i] / 255).toFixed(2)}`);
        line(`${map.label}: ${words.join(", ")}`);
      }
      if (scene.truth && scene.truth[i] >= 0) line(`nearest to the true place: target point ${scene.truth[i]} (green ring)`);
    }

    /* ------------------------------------------------------------ hands */

    /* The source point whose own place, or whose match, is hit. */
    hit(x, y) {
      const panel = (this.drawn || []).find((p) => x >= p.x && x < p.x + p.w && y >= p.y && y < p.y + p.h);
      if (!panel) return null;
      const cloud = this.scene.clouds[panel.cloud], visible = this.tints[this.drawn.indexOf(panel)].visible;
      let best = -1, nearest = -Infinity;
      for (let i = 0; i < cloud.n; i++) {
        if (!visible[i]) continue;
        const [px, py, z] = this.screen(panel, this.point(panel.cloud, i)), d = Math.hypot(px - x, py - y);
        if (d < REACH && z - d * 0.02 > nearest) { nearest = z - d * 0.02; best = i; }
      }
      if (best < 0 || panel.map === null || panel.cloud === 0 && this.scene.maps[panel.map].target !== 0) return best < 0 ? null : best;
      const image = this.scene.maps[panel.map].image, goal = this.point(panel.cloud, best);
      let source = null, least = Infinity;
      for (let i = 0; i < image.length; i++) {
        if (image[i] < 0) continue;
        const p = this.point(panel.cloud, image[i]), d = (p[0] - goal[0]) ** 2 + (p[1] - goal[1]) ** 2 + (p[2] - goal[2]) ** 2;
        if (d < least) { least = d; source = i; }
      }
      return source;
    }

    listen() {
      const fingers = new Map(), stage = this.overlay;
      let start = null, span = 0;
      const at = (event) => { const box = stage.getBoundingClientRect(); return [event.clientX - box.left, event.clientY - box.top]; };
      stage.addEventListener("pointerdown", (event) => {
        stage.setPointerCapture(event.pointerId);
        fingers.set(event.pointerId, at(event)); start = at(event); this.moved = 0;
        if (fingers.size === 2) { const [a, b] = [...fingers.values()]; span = Math.hypot(a[0] - b[0], a[1] - b[1]); }
      });
      stage.addEventListener("pointermove", (event) => {
        if (!fingers.has(event.pointerId)) return;
        const before = fingers.get(event.pointerId), now = at(event), dx = now[0] - before[0], dy = now[1] - before[1];
        fingers.set(event.pointerId, now); this.moved += Math.hypot(dx, dy);
        if (fingers.size === 2) {
          const [a, b] = [...fingers.values()], wide = Math.hypot(a[0] - b[0], a[1] - b[1]);
          if (span) this.zoom(wide / span);
          span = wide;
          this.slide(dx / 2, dy / 2);
        } else if (event.shiftKey || event.buttons === 4 || event.buttons === 2) this.slide(dx, dy);
        else this.rotate(0.008 * dx, 0.008 * dy);
      });
      const up = (event) => {
        if (!fingers.delete(event.pointerId)) return;
        if (event.type === "pointerup" && start && this.moved < CLICK) { this.state.chosen = this.hit(...at(event)); this.tell(); this.changed(); }
        else this.remember();
        start = null;
      };
      stage.addEventListener("pointerup", up);
      stage.addEventListener("pointercancel", up);
      stage.addEventListener("contextmenu", (event) => event.preventDefault());
      stage.addEventListener("wheel", (event) => { event.preventDefault(); this.zoom(Math.exp(-0.0015 * event.deltaY)); this.remember(); }, { passive: false });
      stage.addEventListener("keydown", (event) => {
        const step = 0.12, keys = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step] };
        if (keys[event.key]) this.rotate(...keys[event.key]);
        else if (event.key === "+" || event.key === "=") this.zoom(1.15); else if (event.key === "-") this.zoom(1 / 1.15);
        else if (event.key === "Escape") { this.state.chosen = null; this.tell(); this.draw(); } else return;
        event.preventDefault(); this.remember();
      });
      this.resized = new ResizeObserver(() => this.draw());
      this.resized.observe(this.stage);
      this.scheme = window.matchMedia("(prefers-color-scheme: dark)");
      this.rescheme = () => { this.upload(); this.draw(); };
      this.scheme.addEventListener("change", this.rescheme);
    }

    rotate(x, y) {
      this.camera.q = unit(product(product(turn([0, 1, 0], x), turn([1, 0, 0], y)), this.camera.q));
      this.viewSelect.value = ""; this.draw();
    }

    zoom(factor) { this.camera.zoom = Math.max(0.3, Math.min(40, this.camera.zoom * factor)); this.draw(); }

    slide(dx, dy) {
      const panel = this.drawn[0], [sx, sy] = this.scaleOf(panel);
      this.camera.pan[0] += 2 * dx / (panel.w * sx); this.camera.pan[1] -= 2 * dy / (panel.h * sy);
      this.draw();
    }

    save() {
      this.frame();
      const out = document.createElement("canvas"); out.width = this.canvas.width; out.height = this.canvas.height;
      const g = out.getContext("2d"); g.drawImage(this.canvas, 0, 0); g.drawImage(this.overlay, 0, 0);
      out.toBlob((blob) => {
        const link = document.createElement("a"); link.href = URL.createObjectURL(blob);
        link.download = `${this.scene.title.replace(/[^\w.-]+/g, "_")}.png`; link.click();
        setTimeout(() => URL.revokeObjectURL(link.href), 1000);
      });
    }

    /* ------------------------------------------------------------ address */

    remember() {
      if (this.options.hash === false) return;
      const c = this.camera, words = new URLSearchParams(location.hash.slice(1));
      words.set("colour", this.state.color); words.set("q", c.q.map((v) => v.toFixed(3)).join(","));
      words.set("zoom", c.zoom.toFixed(2)); words.set("pan", c.pan.map((v) => v.toFixed(3)).join(","));
      for (const [name, value] of [["point", this.state.chosen], ["frame", this.state.frame || null], ["tau", this.scene.filter ? this.state.threshold : null]]) {
        if (value === null) words.delete(name); else words.set(name, value);
      }
      try { history.replaceState(null, "", `#${words}`); } catch (error) { /* a sandboxed page has no address */ }
    }

    restore() {
      if (this.options.hash === false) return;
      const words = new URLSearchParams(location.hash.slice(1)), numbers = (name, count) => {
        const text = words.get(name);
        const list = text ? text.split(",").map(Number) : [];
        return list.length === count && list.every(Number.isFinite) ? list : null;
      };
      if (this.colorings().some((c) => c.name === words.get("colour"))) this.state.color = this.colourSelect.value = words.get("colour");
      const q = numbers("q", 4), pan = numbers("pan", 2), zoom = numbers("zoom", 1), point = numbers("point", 1), frame = numbers("frame", 1), tau = numbers("tau", 1);
      if (q) { this.camera.q = unit(q); this.viewSelect.value = ""; }
      if (pan) this.camera.pan = pan;
      if (zoom && zoom[0] > 0) this.camera.zoom = Math.max(0.3, Math.min(40, zoom[0]));
      if (words.has("point") && point && point[0] >= 0 && point[0] < this.scene.clouds[0].n) { this.state.chosen = Math.floor(point[0]); this.tell(); }
      if (words.has("frame") && frame) this.state.frame = frame[0];
      if (words.has("tau") && tau && this.filterInput) { this.state.threshold = tau[0]; this.filterInput.value = tau[0]; }
    }

    destroy() {
      if (this.resized) this.resized.disconnect();
      if (this.scheme) this.scheme.removeEventListener("change", this.rescheme);
      if (this.regl) this.regl.destroy();
      this.element.textContent = "";
    }
  }

  return { decode, mount: (element, scene, options) => new View(element, scene, options), View };
})();
if (typeof module !== "undefined") module.exports = MedialView;
