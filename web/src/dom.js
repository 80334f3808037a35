// Elements in one expression: h("p", {class: "note"}, "text", child).

export function h(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.flat(Infinity).filter((c) => c !== null && c !== undefined));
  return element;
}

/** Tells of changed sizes one frame later: what is told may change sizes itself, which a browser complains of in the same frame. */
export const sizeObserver = (look) => new ResizeObserver((entries) => requestAnimationFrame(() => look(entries)));

/** Words for screen readers alone. */
export const unseen = (text) => h("span", {class: "unseen"}, text);

/** A button that stays pressed. */
export function toggle(label, pressed, change, attributes = {}) {
  const button = h("button", {type: "button", class: "chip", "aria-pressed": String(pressed), ...attributes}, label);
  button.addEventListener("click", () => {
    const now = button.getAttribute("aria-pressed") !== "true";
    button.setAttribute("aria-pressed", String(now));
    change(now);
  });
  return button;
}

const most = 8; // buttons side by side

/** One of several: buttons of which one is pressed, a list where these would be too many. */
export function choice(label, options, chosen, change) {
  if (options.length > most) return list(label, options, chosen, change);
  const buttons = options.map(({value, text}) =>
    h("button", {type: "button", class: "segment", "data-value": value, "aria-pressed": String(value === chosen)}, text));
  const group = h("div", {class: "segments", role: "group", "aria-label": label}, buttons);
  for (const button of buttons)
    button.addEventListener("click", () => {
      for (const other of buttons) other.setAttribute("aria-pressed", String(other === button));
      change(button.dataset.value);
    });
  return group;
}

function list(label, options, chosen, change) {
  const select = h("select", {"aria-label": label},
    options.map(({value, text}) => h("option", {value, selected: value === chosen}, text)));
  select.addEventListener("change", () => change(select.value));
  return select;
}

/** A value from the style sheet, so that canvases follow the theme. */
export function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}
