// Light or dark: as the system says until the reader chooses. Canvases are told, and paper is always light.
import {h} from "./dom.js";

const system = matchMedia("(prefers-color-scheme: dark)");
const listeners = new Set();
let chosen = null;
let printing = false;

function apply() {
  const dark = !printing && (chosen ? chosen === "dark" : system.matches);
  document.documentElement.dataset.theme = dark ? "dark" : "light";
  for (const listener of listeners) listener();
}

export function onTheme(listener) {
  listeners.add(listener);
}

export const isPrinting = () => printing;

export function startTheme() {
  system.addEventListener("change", apply);
  addEventListener("beforeprint", () => ((printing = true), apply()));
  addEventListener("afterprint", () => ((printing = false), apply()));
  apply();
}

export function themeButton() {
  const button = h("button", {type: "button", class: "quiet", "aria-label": "Dark theme", title: "Light or dark"});
  const show = () => {
    const dark = document.documentElement.dataset.theme === "dark";
    button.setAttribute("aria-pressed", String(dark));
    button.textContent = dark ? "Light" : "Dark";
  };
  button.addEventListener("click", () => {
    chosen = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
    apply();
  });
  onTheme(show);
  show();
  return button;
}
