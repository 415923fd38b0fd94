"""How JupyterLab's page looks: contrasts of all that is drawn, and what goes beyond its edge."""

from __future__ import annotations

from typing import Any

TEXT, LINES = 4.5, 3.0  # the least contrasts, of WCAG 2.1
THEMES = ("JupyterLab Light", "JupyterLab Dark")
# Whether the notebook stands on dark ground.
GROUND = """(dark) => { const style = getComputedStyle(document.querySelector(".jp-Notebook"));
  return parseInt(style.backgroundColor.slice(4)) < 64 === dark; }"""
# The contrasts of the texts of the outputs that are drawn, and of the lines beside them.
CONTRAST = """() => {
  const paint = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
  const rgba = (color) => {
    paint.clearRect(0, 0, 1, 1);
    paint.fillStyle = color;
    paint.fillRect(0, 0, 1, 1);
    const [r, g, b, a] = paint.getImageData(0, 0, 1, 1).data;
    return a ? [r, g, b, a / 255] : [0, 0, 0, 0];
  };
  const over = ([r, g, b, a], below) => [r, g, b].map((each, k) => a * each + (1 - a) * below[k]);
  const ground = (node) => {
    if (!node) return [255, 255, 255];
    const own = rgba(getComputedStyle(node).backgroundColor);
    return own[3] === 1 ? own.slice(0, 3) : over(own, ground(node.parentElement));
  };
  const light = (color) => {
    const [r, g, b] = color.map((each) => each / 255)
      .map((each) => (each <= 0.03928 ? each / 12.92 : ((each + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const contrast = (one, other) => {
    const [low, high] = [light(one), light(other)].sort((a, b) => a - b);
    return (high + 0.05) / (low + 0.05);
  };
  const texts = [], lines = [];
  for (const each of document.querySelectorAll(".jp-OutputArea-output *")) {
    const style = getComputedStyle(each);
    const below = ground(each);
    const own = [...each.childNodes].filter((child) => child.nodeType === 3);
    const words = own.map((child) => child.textContent).join("").trim();
    if (words && each.tagName !== "STYLE" && each.offsetParent) {
      texts.push([contrast(over(rgba(style.color), below), below), words.slice(0, 40)]);
    }
    if (parseFloat(style.borderLeftWidth) >= 1 && each.tagName !== "BUTTON" && each.offsetParent) {
      const edge = over(rgba(style.borderLeftColor), ground(each.parentElement));
      lines.push([contrast(edge, ground(each.parentElement)), each.outerHTML.slice(0, 80)]);
    }
  }
  const drawn = (each, what) => { // a colour of a drawing, as it is seen on what is below
    const style = getComputedStyle(each);
    const color = style[what].startsWith("rgb") ? rgba(style[what]) : [0, 0, 0, 0];
    return [...color.slice(0, 3), color[3] * style[`${what}Opacity`] * style.opacity];
  };
  const below = (word) => { // what a word of a drawing stands on
    word.scrollIntoView({ block: "center" });
    const box = word.getBoundingClientRect();
    const found = document.elementsFromPoint(box.x + box.width / 2, box.y + box.height / 2)
      .filter((each) => each.closest(".mrt-drawing g")
        && (each.closest(".mrt-patch") || !each.closest(".mrt-text"))); // a word may have its own
    return found.reverse().reduce((color, each) => over(drawn(each, "fill"), color), ground(word));
  };
  for (const each of document.querySelectorAll(".mrt-drawing .mrt-text:has(use)")) {
    if (!each.getClientRects().length) continue; // folded away
    const behind = below(each), ink = drawn(each.querySelector("use"), "fill");
    texts.push([contrast(over(ink, behind), behind), each.outerHTML.slice(0, 200)]);
  }
  for (const each of document.querySelectorAll(".mrt-drawing .mrt-line2d path:not(defs *)")) {
    const line = drawn(each, "stroke"), behind = ground(each);
    if (each.closest("[clip-path]") && each.closest(".mrt-xtick, .mrt-ytick")) continue; // a grid
    if (line[3] && !each.closest(".mrt-axes")?.querySelector("image")) {
      lines.push([contrast(over(line, behind), behind), each.outerHTML.slice(0, 80)]);
    }
  }
  return { texts, lines };
}"""
# What goes beyond the screen's right edge, or has a scroll bar below it: the page, the notebook,
# its texts and code, and all that cells show; of a drawing its edge. Below 320 pixels (WCAG 1.4.10)
# formulas and tables may have a bar of their own.
BEYOND = """() => [...document.querySelectorAll(
  "html, .jp-WindowedPanel-outer, .jp-RenderedMarkdown, .jp-RenderedMarkdown table, .cm-scroller,"
  + " .jp-OutputArea-output, .jp-OutputArea-output *:not(svg *, option)")]
  .filter((each) => !each.closest(".jp-FileEditor, details:not([open]) > :not(summary)"))
  .filter((each) => each.clientWidth)
  .filter((each) => window.innerWidth >= 320 || each.matches("html, .jp-WindowedPanel-outer")
    || !each.closest("table, mjx-container") && !each.querySelector("table, mjx-container"))
  .filter((each) => each.getBoundingClientRect().right > window.innerWidth + 1
    || each.scrollWidth > each.clientWidth + 1
      && ["auto", "scroll"].includes(getComputedStyle(each).overflowX))
  .map((each) => `${each.tagName} ${each.className} ${each.textContent}`.slice(0, 100))"""


def turn(page: Any, theme: str) -> None:
    """Choose a theme in the menu, as a person does."""
    page.click(".lm-MenuBar-itemLabel:text-is('Settings')")
    page.hover(".lm-Menu-itemLabel:text-is('Theme')")
    page.click(f".lm-Menu-itemLabel:text-is('{theme}')")
    page.wait_for_function(GROUND, arg="Dark" in theme)
