// What does not fit: tables wider than the window, folded sections on paper.
import {sizeObserver} from "./dom.js";

/** Tables that can be scrolled sideways say so, and can be by keyboard. */
export function hintAtHiddenColumns(document) {
  const look = (box) => {
    const hidden = box.scrollWidth - box.clientWidth > 1;
    box.classList.toggle("cut", hidden);
    if (hidden) box.setAttribute("tabindex", "0");
    else box.removeAttribute("tabindex");
    if (hidden) box.setAttribute("aria-label", box.querySelector("caption")?.textContent ?? "Table");
    box.classList.toggle("at-end", box.scrollLeft + box.clientWidth >= box.scrollWidth - 2);
  };
  const sizes = sizeObserver((entries) => entries.forEach((e) => look(e.target)));
  const watch = () => {
    for (const box of document.querySelectorAll(".table-box:not([data-watched])")) {
      box.dataset.watched = "";
      box.setAttribute("role", "group");
      box.addEventListener("scroll", () => look(box), {passive: true});
      sizes.observe(box);
    }
  };
  watch();
  new MutationObserver(watch).observe(document.querySelector("main"), {childList: true, subtree: true});
}

/** Paper cannot be unfolded: everything is open while the page is printed. */
export function unfoldOnPaper() {
  let opened = [];
  const open = () => {
    opened.push(...[...document.querySelectorAll("details:not([open]):not(.screen-only)")].map((d) => ((d.open = true), d)));
  };
  const close = () => {
    for (const details of opened) details.open = false;
    opened = [];
  };
  addEventListener("beforeprint", open);
  addEventListener("afterprint", close);
  matchMedia("print").addEventListener("change", (e) => (e.matches ? open() : close()));
}
