// SPDX-License-Identifier: MIT
// The view as the address behind #, so that a link shows it again.

export const DEFAULTS = Object.freeze({
  view: "material", // or "textures"
  shape: "sphere",
  onShape: false, // textures on the shape rather than flat
  texture: "",
  channel: "all",
  mip: -1,
  kernel: "bilinear",
  anisotropy: 1,
  stochastic: true,
  repeat: 1,
  light: 0,
  exposure: 1,
  flipNormal: false,
  comparison: "decoded",
  gain: 8,
  split: 0.5,
  modelMaterial: "",
  gpu: "auto", // what decodes whole textures
});

const ALLOWED = {
  view: ["material", "textures"],
  shape: ["sphere", "cube", "plane", "model"],
  channel: ["all", "r", "g", "b", "a"],
  kernel: ["nearest", "bilinear", "cubic", "catmull-rom", "mitchell", "gaussian"],
  comparison: ["decoded", "reference", "split", "difference"],
  gpu: ["auto", "webgl", "webgpu"],
};
const RANGES = {
  mip: [-1, 15], anisotropy: [1, 16], repeat: [0.25, 16], light: [-180, 180], exposure: [0.05, 16], gain: [1, 64], split: [0, 1],
};

/** What of `text` is a value of this kind; the default where it is none, because links come from anywhere. */
function parse(key, text) {
  const standard = DEFAULTS[key];
  if (ALLOWED[key]) return ALLOWED[key].includes(text) ? text : standard;
  if (typeof standard === "boolean") return text === "1";
  if (typeof standard === "string") return text;
  const value = Number(text);
  const [least, most] = RANGES[key];
  return Number.isFinite(value) ? Math.min(Math.max(value, least), most) : standard;
}

export function parseLink(hash) {
  const entries = new URLSearchParams(hash.replace(/^#/, ""));
  const state = { ...DEFAULTS };
  for (const key of Object.keys(DEFAULTS)) if (entries.has(key)) state[key] = parse(key, entries.get(key));
  const camera = (entries.get("camera") ?? "").split(",").map(Number);
  return { state, file: entries.get("set") ?? "", camera: camera.every(Number.isFinite) ? camera : [] };
}

export function makeLink(state, file, camera) {
  const entries = new URLSearchParams();
  if (file) entries.set("set", file);
  for (const [key, standard] of Object.entries(DEFAULTS))
    if (state[key] !== standard) entries.set(key, typeof standard === "boolean" ? (state[key] ? "1" : "0") : state[key]);
  if (camera.length > 0) entries.set("camera", camera.join(","));
  return `#${entries}`;
}
