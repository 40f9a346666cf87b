// SPDX-License-Identifier: MIT
// Keyboard shortcuts.

const SHAPES = ["sphere", "cube", "plane", "model"];
const KERNELS = ["nearest", "bilinear", "cubic", "catmull-rom", "mitchell", "gaussian"];
const COMPARISONS = ["decoded", "reference", "split", "difference"];

const ARROWS = { "←": [-1, 0], "↑": [0, -1], "→": [1, 0], "↓": [0, 1] };
/** Keys of keyboards as the list names them. */
const NAMES = { ArrowLeft: "←", ArrowUp: "↑", ArrowRight: "→", ArrowDown: "↓", "=": "+", "-": "−" };

function next(list, current, step = 1) {
  return list[(list.indexOf(current) + step + list.length) % list.length];
}

/** [keys, what they do, action(viewer, actions, key)] */
export const SHORTCUTS = [
  ["1 2 3 4", "sphere, cube, plane, model", (_, actions, key) => actions.showShape(SHAPES[Number(key) - 1])],
  ["M", "material", (viewer) => viewer.apply({ view: "material" })],
  ["T", "textures; the next one", (viewer) => {
    const names = viewer.set.textures.map(({ name }) => name);
    const isOpen = viewer.state.view === "textures";
    return viewer.apply({ view: "textures", texture: isOpen ? next(names, viewer.state.texture) : viewer.state.texture });
  }],
  ["[ ]", "finer and coarser mip", (viewer, _, key) => viewer.apply({ mip: Math.max(viewer.state.mip + (key === "[" ? -1 : 1), -1) })],
  ["F", "next filter", (viewer) => viewer.apply({ kernel: next(KERNELS, viewer.state.kernel) })],
  ["S", "one texel a frame, or all", (viewer) => viewer.apply({ stochastic: !viewer.state.stochastic })],
  ["D", "compare with the reference", (viewer) =>
    viewer.reference && viewer.apply({ comparison: next(COMPARISONS, viewer.state.comparison) })],
  ["R", "camera as at first", (viewer) => viewer.stage.resetCamera()],
  ["L", "copy a link to this view", (_, actions) => actions.copyLink()],
  ["O", "open files", (_, actions) => actions.open()],
  ["H", "hide the panel", (_, actions) => actions.togglePanel()],
  ["← ↑ → ↓", "turn, or move a flat texture", (viewer, _, key) => viewer.stage.turn(...ARROWS[key])],
  ["+ −", "nearer and farther", (viewer, _, key) => viewer.stage.zoom(key === "+" ? 1.25 : 0.8)],
  ["?", "this list", (_, actions) => actions.toggleHelp()],
];

export function listenToKeys(viewer, actions) {
  window.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.matches("input[type=text], select")) return undefined;
    if (event.key === "Escape") return actions.closeHelp();
    if (event.key.startsWith("Arrow") && event.target.matches("input")) return undefined; // a slider's own
    const key = NAMES[event.key] ?? event.key.toUpperCase();
    const shortcut = SHORTCUTS.find(([keys]) => keys.split(" ").includes(key));
    const needsSet = !["O", "H", "?"].includes(key);
    if (!shortcut || (needsSet && !viewer.set)) return undefined;
    event.preventDefault();
    return shortcut[2](viewer, actions, key);
  });
}
