// A picture that follows the student's files: everything shown comes from the kernel.

const STYLE = `
.mrt-live{font-family:var(--jp-content-font-family,sans-serif);color:var(--jp-content-font-color1,#222);display:flex;flex-wrap:wrap;gap:.8em;align-items:flex-start}
.mrt-live figure{margin:0;flex:0 1 auto;min-width:0;max-width:100%}
.mrt-live img{display:block;max-width:100%;height:auto;image-rendering:pixelated;cursor:crosshair;background:#808080}
.mrt-live img:focus-visible{outline:3px solid #0072b2;outline-offset:-3px}
.mrt-live figcaption{min-height:1.5em}
.mrt-live-told{flex:1 1 16em;min-width:0;overflow-wrap:anywhere}
`;

function render({ model, el }) {
  const [width, height] = model.get("size");
  const picture = element("img", { tabIndex: 0, width, height });
  const state = element("span", {});
  const told = element("div", { className: "mrt-live-told" });
  told.setAttribute("aria-live", "polite");
  const caption = element("figcaption", {}, state, element("br", {}), model.get("help"));
  el.append(
    element(
      "div",
      { className: "mrt-live" },
      element("style", { textContent: STYLE }),
      element("figure", {}, picture, caption),
      told,
    ),
  );

  const ask = (i, j) => {
    const [, , before] = model.get("asked");
    model.set("asked", [i, j, (before || 0) + 1]);
    model.save_changes();
  };
  // CSS may shrink the picture: positions are taken in shares of its size.
  picture.addEventListener("click", (event) => {
    const box = picture.getBoundingClientRect();
    const share = (value, most) => Math.min(Math.max(Math.floor(value * most), 0), most - 1);
    const i = share((event.clientX - box.left) / box.width, width);
    ask(i, height - 1 - share((event.clientY - box.top) / box.height, height));
  });
  picture.addEventListener("keydown", (event) => {
    if (event.key !== "Enter") return;
    event.preventDefault();
    event.stopPropagation(); // JupyterLab has its own use of it
    ask(Math.floor(width / 2), Math.floor(height / 2));
  });

  const draw = () => {
    const content = model.get("picture");
    picture.hidden = !content;
    if (content) picture.src = `data:image/png;base64,${content}`;
    picture.alt = model.get("words");
  };
  const tell = () => {
    state.textContent = model.get("state");
    told.innerHTML = model.get("html");
  };
  model.on("change:picture change:words", draw);
  model.on("change:state change:html", tell);
  draw();
  tell();
}

export default { render };
