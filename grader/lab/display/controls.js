// Names what ipywidgets leaves without one: the handles of the sliders that stand beside it.

const TRIES = 100; // frames

function name(box) {
  const sliders = [...box.querySelectorAll(".widget-inline-hbox")];
  for (const each of sliders) {
    const label = each.querySelector(".widget-label");
    for (const handle of each.querySelectorAll(".noUi-handle")) {
      handle.setAttribute("aria-label", label.textContent);
    }
  }
}

export default {
  render({ el }) {
    el.style.display = "none";
    const look = (left) => {
      const box = el.closest(".widget-vbox");
      if (box) name(box);
      if (left && !box?.querySelector(".noUi-handle[aria-label]")) {
        requestAnimationFrame(() => look(left - 1));
      }
    };
    look(TRIES);
  },
};
