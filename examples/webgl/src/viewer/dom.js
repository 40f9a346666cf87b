// SPDX-License-Identifier: MIT
// Elements of the panel.

/** make("div.row", { title: "…" }, child, …) */
export function make(selector, properties = {}, ...children) {
  const [tag, ...classes] = selector.split(".");
  const element = Object.assign(document.createElement(tag), properties);
  element.classList.add(...classes);
  element.append(...children.filter((child) => child !== null));
  return element;
}

export function section(title, ...children) {
  return make("section", {}, make("h2", { textContent: title }), ...children);
}

function row(label, title, control, value = null) {
  return make("label.row", { title }, make("span.name", { textContent: label }), control, value);
}

/** Buttons of which one is on. `options`: [value, text, title]; `label`: what they are about, for those who do not see it. */
export function choice(label, options, onPick) {
  const buttons = options.map(([value, text, title = ""]) =>
    make("button", { type: "button", textContent: text, title, onclick: () => onPick(value) }),
  );
  const element = make("div.choice", { role: "group", ariaLabel: label }, ...buttons);
  const update = (current, available = () => true) =>
    options.forEach(([value], i) => {
      buttons[i].classList.toggle("on", value === current);
      buttons[i].setAttribute("aria-pressed", value === current);
      buttons[i].disabled = !available(value);
    });
  return { element, update };
}

export function slider(label, title, { min, max, step, format = String }, onInput) {
  const input = make("input", { type: "range", min, max, step });
  const shown = make("output");
  input.addEventListener("input", () => onInput(Number(input.value)));
  const update = (value) => {
    input.value = value;
    shown.textContent = format(value);
  };
  const setMost = (most) => (input.max = most);
  return { element: row(label, title, input, shown), update, setMost };
}

export function select(label, title, onPick) {
  const input = make("select");
  input.addEventListener("change", () => onPick(input.value));
  const element = row(label, title, input);
  const setOptions = (options) => input.replaceChildren(...options.map(([value, text]) => make("option", { value, textContent: text })));
  return { element, update: (value) => (input.value = value), setOptions };
}

export function toggle(label, title, onToggle) {
  const input = make("input", { type: "checkbox" });
  input.addEventListener("change", () => onToggle(input.checked));
  return { element: row(label, title, input), update: (value) => (input.checked = value) };
}
