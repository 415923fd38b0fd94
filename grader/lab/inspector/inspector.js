// The pixel inspector: a picture to choose a pixel in, a view of the scene, and a table of rays.
// Everything drawn comes from the kernel; nothing is asked from elsewhere.

const MOST_ZOOM = 16;
const TURN = 0.12; // radians, for one press of an arrow key
const LIT = 3; // width of the ray whose row is under the mouse
const THEME = ["data-jp-theme-name", "data-jp-theme-light"]; // of the page's body: the ink changes with them
const GREY = "#808080"; // seen on light ground and on dark
const STYLE = `
.mrt-inspector{font-family:var(--jp-content-font-family,sans-serif);color:var(--jp-content-font-color1,#222);container-type:inline-size}
.mrt-views{display:flex;flex-wrap:wrap;gap:.6em;align-items:flex-start}
.mrt-view{flex:1 1 18em;min-width:0;max-width:100%;position:relative}
.mrt-port{overflow:auto;max-height:26em;border:1px solid #808080}
.mrt-port canvas,.mrt-space{display:block}
.mrt-port canvas{image-rendering:pixelated;cursor:crosshair}
.mrt-space{width:100%;box-sizing:border-box;touch-action:none;cursor:grab;border:1px solid #808080;background:var(--jp-layout-color0,#fff)}
.mrt-inspector canvas:focus-visible{outline:3px solid #0072b2;outline-offset:-3px}
.mrt-bar{display:flex;gap:.5em;align-items:center;min-height:2em}
.mrt-bar button{min-width:2em;min-height:2em}
@media (pointer:coarse){.mrt-bar button{min-width:44px;min-height:44px}}
.mrt-rays td,.mrt-rays th{padding:.15em .6em .15em 0;overflow-wrap:break-word}
.mrt-rays tr.mrt-lit{outline:2px solid #0072b2;background:rgba(0,114,178,.15)}
@container (max-width:46em){
.mrt-rays thead{display:none}
.mrt-rays tr{display:block;padding:.3em 0}
.mrt-rays th,.mrt-rays td{display:inline-block}
.mrt-rays th{display:block}
.mrt-rays td:empty{display:none}
.mrt-rays td::before{content:attr(data-column) "\\00a0: "}
}
`;

function bytes(text) {
  return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
}

// The picture: a click or the arrow keys choose a pixel; hovering tells what is there.
function pictureView(model, say) {
  const canvas = element("canvas", { tabIndex: 0, className: "mrt-picture" });
  canvas.setAttribute("role", "application");
  const port = element("div", { className: "mrt-port" }, canvas);
  const pen = canvas.getContext("2d", { willReadFrequently: true });
  const source = element("canvas", {});
  let zoom = 1;
  let things = null;

  const load = async () => {
    const scene = model.get("scene");
    canvas.setAttribute("aria-label", scene.picture_label);
    const packed = bytes(scene.things);
    things = packed.length ? new Uint16Array(packed.buffer) : null;
    const drawn = await createImageBitmap(new Blob([bytes(scene.picture)], { type: "image/png" }));
    source.width = scene.width;
    source.height = scene.height;
    source.getContext("2d", { willReadFrequently: true }).drawImage(drawn, 0, 0);
    draw();
  };

  const draw = () => {
    const { width, height } = model.get("scene");
    const [i, j] = model.get("pixel");
    canvas.width = width * zoom;
    canvas.height = height * zoom;
    canvas.style.maxWidth = zoom > 1 ? "none" : "100%";
    pen.imageSmoothingEnabled = false;
    pen.drawImage(source, 0, 0, canvas.width, canvas.height);
    const [x, y] = [(i + 0.5) * zoom, (height - j - 0.5) * zoom];
    for (const [color, radius] of [["#fff", 7], ["#000", 9]]) {
      pen.strokeStyle = color;
      pen.lineWidth = 2;
      pen.beginPath();
      pen.arc(x, y, Math.max(radius, zoom), 0, 2 * Math.PI);
      pen.stroke();
    }
  };

  const choose = (i, j) => {
    const { width, height } = model.get("scene");
    const clamp = (value, most) => Math.min(Math.max(value, 0), most - 1);
    model.set("pixel", [clamp(i, width), clamp(j, height)]);
    model.save_changes();
  };

  // CSS may shrink the canvas: positions are taken in shares of its size.
  const place = (event) => {
    const box = canvas.getBoundingClientRect();
    const { width, height } = model.get("scene");
    const i = Math.floor(((event.clientX - box.left) / box.width) * width);
    const j = height - 1 - Math.floor(((event.clientY - box.top) / box.height) * height);
    return [i, j];
  };

  const hover = (event) => {
    const scene = model.get("scene");
    const [i, j] = place(event);
    if (i < 0 || j < 0 || i >= scene.width || j >= scene.height) return;
    const row = scene.height - 1 - j;
    const [r, g, b] = source.getContext("2d").getImageData(i, row, 1, 1).data;
    const name = things ? scene.names[things[j * scene.width + i]] : "";
    say(`(${i}, ${j}) ${name} (${[r, g, b].map((level) => (level / 255).toFixed(2)).join(", ")})`);
  };

  const scale = (factor) => {
    zoom = Math.min(Math.max(zoom * factor, 1), MOST_ZOOM);
    draw();
    const { height } = model.get("scene");
    const [i, j] = model.get("pixel");
    port.scrollLeft = i * zoom - port.clientWidth / 2;
    port.scrollTop = (height - j) * zoom - port.clientHeight / 2;
  };

  canvas.addEventListener("click", (event) => {
    canvas.focus({ preventScroll: true });
    choose(...place(event));
  });
  canvas.addEventListener("mousemove", hover);
  canvas.addEventListener("mouseleave", () => say(""));
  canvas.addEventListener("keydown", (event) => {
    const [i, j] = model.get("pixel");
    const step = event.shiftKey ? 10 : 1;
    const moves = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step] };
    if (moves[event.key]) choose(i + moves[event.key][0], j + moves[event.key][1]);
    else if (event.key === "+" || event.key === "=") scale(2);
    else if (event.key === "-") scale(0.5);
    else return;
    event.preventDefault();
    event.stopPropagation(); // JupyterLab has its own use of these keys
  });
  return { canvas, port, load, draw, scale };
}

// The scene in space, by a parallel projection that dragging and the arrow keys turn.
function spaceView(model, pick) {
  const canvas = element("canvas", { tabIndex: 0, className: "mrt-space" });
  canvas.setAttribute("role", "application");
  canvas.setAttribute("aria-label", model.get("scene").space_label);
  const pen = canvas.getContext("2d");
  let [yaw, pitch] = model.get("scene").view;
  let scale = 1;
  let lit = null;
  let drag = null;
  let ink = "";
  let drawn = []; // the rays as they stand on the canvas: row, x0, y0, x1, y1

  const project = ([x, y, z]) => {
    const [a, b, c] = model.get("seen").middle;
    const [dx, dy, dz] = [x - a, y - b, z - c];
    const right = dx * Math.cos(yaw) - dz * Math.sin(yaw);
    const away = dx * Math.sin(yaw) + dz * Math.cos(yaw);
    const unit = (canvas.height / 4.5) * scale;
    const up = dy * Math.cos(pitch) - away * Math.sin(pitch);
    return [canvas.width / 2 + right * unit, canvas.height / 2 - up * unit, dy * Math.sin(pitch) + away * Math.cos(pitch), unit];
  };

  const path = (points) => {
    pen.beginPath();
    for (const point of points) pen.lineTo(...project(point).slice(0, 2));
    pen.stroke();
  };

  const draw = () => {
    const { spheres, lines, rays } = model.get("seen");
    ink = getComputedStyle(canvas).color;
    const colors = { ...model.get("scene").colors, camera: ink };
    canvas.width = Math.max(canvas.clientWidth, 200) * (window.devicePixelRatio || 1);
    canvas.height = canvas.width * 0.75;
    drawn = [];
    if (!rays.length) return;
    pen.lineWidth = 1;
    pen.strokeStyle = GREY;
    lines.forEach(path);
    const far = spheres.map((each) => [project(each)[2], each]).sort((one, other) => one[0] - other[0]);
    for (const [, [x, y, z, radius, color]] of far) {
      const [px, py, , unit] = project([x, y, z]);
      pen.beginPath();
      pen.arc(px, py, radius * unit, 0, 2 * Math.PI);
      pen.globalAlpha = 0.55;
      pen.fillStyle = color;
      pen.fill();
      pen.globalAlpha = 1;
      pen.strokeStyle = GREY;
      pen.stroke();
    }
    for (const [row, kind, start, end] of rays) {
      pen.strokeStyle = colors[kind];
      pen.lineWidth = 2 * (row === lit ? LIT : 1);
      pen.setLineDash(kind === "hidden" ? [6, 5] : []);
      path([start, end]);
      drawn.push([row, ...project(start).slice(0, 2), ...project(end).slice(0, 2)]);
    }
    pen.setLineDash([]);
  };

  const nearest = (event) => {
    const ratio = canvas.width / canvas.clientWidth;
    const [x, y] = [event.offsetX * ratio, event.offsetY * ratio];
    let best = [8 * ratio, null];
    for (const [row, x0, y0, x1, y1] of drawn) {
      const [dx, dy] = [x1 - x0, y1 - y0];
      const share = Math.min(Math.max(((x - x0) * dx + (y - y0) * dy) / (dx * dx + dy * dy || 1), 0), 1);
      const away = Math.hypot(x - x0 - share * dx, y - y0 - share * dy);
      if (away < best[0]) best = [away, row];
    }
    return best[1];
  };

  const turn = (by, tilt) => {
    yaw += by;
    pitch = Math.min(Math.max(pitch + tilt, -1.5), 1.5);
    draw();
  };
  const grow = (factor) => {
    scale = Math.min(Math.max(scale * factor, 0.2), 20);
    draw();
  };

  canvas.addEventListener("pointerdown", (event) => {
    drag = [event.clientX, event.clientY];
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointerup", () => {
    drag = null;
  });
  canvas.addEventListener("pointerleave", () => pick(null));
  canvas.addEventListener("pointermove", (event) => {
    if (!drag) {
      pick(nearest(event));
      return;
    }
    turn((drag[0] - event.clientX) / 100, (event.clientY - drag[1]) / 100);
    drag = [event.clientX, event.clientY];
  });
  canvas.addEventListener("keydown", (event) => {
    const turns = { ArrowLeft: [TURN, 0], ArrowRight: [-TURN, 0], ArrowUp: [0, TURN], ArrowDown: [0, -TURN] };
    if (turns[event.key]) turn(...turns[event.key]);
    else if (event.key === "+" || event.key === "=") grow(1.25);
    else if (event.key === "-") grow(0.8);
    else return;
    event.preventDefault();
    event.stopPropagation();
  });
  const light = (row) => {
    if (row === lit) return;
    lit = row;
    draw();
  };
  const follow = () => {
    if (getComputedStyle(canvas).color !== ink) draw();
  };
  return { canvas, draw, light, follow };
}

// A folded one is drawn when it is first unfolded: before, it has no width.
function render({ model, el }) {
  const title = model.get("fold");
  if (!title) return inspector(model, el);
  const inside = element("div", {});
  const details = element("details", {}, element("summary", { textContent: title }), inside);
  let stop = null;
  details.addEventListener("toggle", () => {
    if (details.open && !stop) stop = inspector(model, inside);
  });
  el.append(details);
  return () => {
    if (stop) stop();
  };
}

// Draws the inspector in an element; returns what ends it.
function inspector(model, el) {
  const scene = model.get("scene");
  const told = element("div", { className: "mrt-told" });
  told.setAttribute("aria-live", "polite");
  const hovered = element("span", { className: "mrt-hover" });
  const say = (text) => {
    hovered.textContent = text;
  };
  const pick = (row) => {
    for (const each of told.querySelectorAll("tr[data-row]")) {
      each.classList.toggle("mrt-lit", each.dataset.row === row);
    }
    space.light(row);
  };
  const picture = pictureView(model, say);
  const space = spaceView(model, pick);
  const button = (text, label, act) => {
    const made = element("button", { type: "button", textContent: text, onclick: act });
    made.setAttribute("aria-label", label);
    return made;
  };
  const bar = element(
    "div",
    { className: "mrt-bar" },
    button("+", scene.zoom_in, () => picture.scale(2)),
    button("\u2212", scene.zoom_out, () => picture.scale(0.5)),
    hovered,
  );
  const views = element(
    "div",
    { className: "mrt-views" },
    element("div", { className: "mrt-view" }, picture.port, bar),
    element("div", { className: "mrt-view" }, space.canvas),
  );
  const root = element("div", { className: "mrt-inspector" }, element("style", { textContent: STYLE }), views, told);

  const write = () => {
    told.innerHTML = model.get("seen").html;
    told.dataset.pixel = model.get("seen").pixel.join(",");
    space.draw();
  };
  told.addEventListener("mouseover", (event) => {
    const row = event.target.closest("tr[data-row]");
    pick(row ? row.dataset.row : null);
  });
  told.addEventListener("mouseleave", () => pick(null));
  model.on("change:seen", write);
  model.on("change:pixel", picture.draw);
  model.on("change:scene", picture.load);
  const sizes = new ResizeObserver(space.draw);
  const themes = new MutationObserver(space.follow);
  el.append(root);
  picture.load();
  write();
  sizes.observe(views);
  themes.observe(document.body, { attributes: true, attributeFilter: THEME });
  return () => {
    sizes.disconnect();
    themes.disconnect();
  };
}

export default { render };
