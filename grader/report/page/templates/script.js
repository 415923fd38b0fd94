"use strict";
/* The page can be read without this: it adds a slider and a blinking to pictures, and a few buttons. */
(() => {
  const make = (name, properties, ...children) => {
    const element = Object.assign(document.createElement(name), properties);
    element.append(...children);
    return element;
  };

  for (const pictures of document.querySelectorAll(".pictures")) {
    const expected = pictures.querySelector(".expected img");
    const got = pictures.querySelector(".got img");
    if (!expected || !got) continue;
    const top = make("img", { src: got.src, alt: "" });
    const slider = make("input", { type: "range", min: 0, max: 100, value: 50 });
    const button = make("button", { type: "button", textContent: pictures.dataset.blink });
    const show = (share) => { top.style.clipPath = `inset(0 0 0 ${share}%)`; };
    let timer = 0;
    const blink = (on) => {
      clearInterval(timer);
      timer = 0;
      slider.disabled = on;
      button.setAttribute("aria-pressed", String(on));
      let whole = false;
      if (on) timer = setInterval(() => { whole = !whole; show(whole ? 0 : 100); }, 600);
      else show(slider.value);
    };
    slider.addEventListener("input", () => show(slider.value));
    button.addEventListener("click", () => blink(!timer));
    blink(false);
    const stage = make("div", { className: "stage" }, make("img", { src: expected.src, alt: "" }), top);
    const label = make("label", {}, pictures.dataset.slider, slider);
    pictures.append(make("div", { className: "compare" }, stage, label, button));
  }

  for (const box of document.querySelectorAll(".copied")) {
    const button = make("button", { type: "button", textContent: box.dataset.copy });
    button.addEventListener("click", async () => {
      const code = box.querySelector("code");
      try {
        await navigator.clipboard.writeText(code.textContent.trimStart());
        button.textContent = box.dataset.done;
      } catch {
        getSelection().selectAllChildren(code); /* the person copies it */
      }
    });
    box.prepend(button);
  }

  const exercises = [...document.querySelectorAll(".exercise")];
  const all = document.querySelector(".all");
  if (all) {
    const button = make("button", { type: "button" });
    const name = () => { button.textContent = exercises.every((each) => each.open) ? all.dataset.close : all.dataset.open; };
    button.addEventListener("click", () => {
      const open = !exercises.every((each) => each.open);
      for (const each of exercises) each.open = open;
      name();
    });
    name();
    all.append(button);
  }

  /* A link to an exercise opens it; printing opens everything. */
  const follow = () => {
    const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
    if (target instanceof HTMLDetailsElement) target.open = true;
  };
  addEventListener("hashchange", follow);
  follow();
  addEventListener("beforeprint", () => {
    for (const each of document.querySelectorAll("details")) each.open = true;
  });
})();
