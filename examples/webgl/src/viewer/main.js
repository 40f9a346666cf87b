// SPDX-License-Identifier: MIT
import samples from "openntc:samples";
import { make } from "./dom.js";
import { acceptDrops, chooseFiles, kindOf, saveFile, sortFiles } from "./files.js";
import { SHORTCUTS, listenToKeys } from "./keys.js";
import { makeLink, parseLink } from "./link.js";
import { Panel } from "./panel.js";
import { encodePng, toBytes } from "./png.js";
import { Viewer } from "./viewer.js";

const find = (id) => document.getElementById(id);
const canvas = find("picture");
let viewer;
let awaited = null; // the link whose set is not here yet

function say(text, isError = false) {
  find("message").textContent = text;
  find("message").classList.toggle("error", isError);
}

/** Runs what may fail; errors are said in their own words. */
async function attempt(subject, work) {
  try {
    return await work();
  } catch (error) {
    say(subject ? `${subject}: ${error.message}` : error.message, true);
    return undefined;
  }
}

async function openFile(bytes, name, blob, files) {
  const kind = kindOf(bytes);
  if (!viewer.isCompiling) say("");
  if (kind === "set") await openSet(bytes, name);
  else if (!viewer.set) throw new Error("open a texture set first");
  else if (kind === "model") await viewer.openModel(bytes.buffer, files);
  else await viewer.openReference(blob, name);
}

/** As the link says that waits for it; the first set may have another name. */
async function openSet(bytes, name) {
  const link = awaited && (!viewer.set || awaited.file === name) ? awaited : null;
  await viewer.openSet(bytes, name, link);
  if (link && ["", name].includes(link.file)) awaited = null;
}

/** Shows what a link says. A set that is not here is waited for. */
async function openLink(hash) {
  clearTimeout(linkTimer); // the view before would be written over the link
  const link = parseLink(hash);
  awaited = null;
  if (viewer.set && ["", viewer.set.name].includes(link.file)) return viewer.show(link);
  awaited = link;
  if (samples[link.file]) return openFile(samples[link.file], link.file);
  const text = link.file ? `This link shows ${link.file}: drop that file here.` : "";
  find("wanted").textContent = text;
  return viewer.set && say(text);
}

async function readFile(file) {
  const buffer = await file.arrayBuffer().catch(() => {
    throw new Error("cannot be read: if it is a folder, drop the files in it");
  });
  return { file, bytes: new Uint8Array(buffer) };
}

async function openFiles(chosen) {
  const read = await Promise.all(chosen.map((file) => attempt(file.name, () => readFile(file))));
  const { opened, files } = sortFiles(read.filter((one) => one !== undefined));
  for (const { file, bytes } of opened) await attempt(file.name, () => openFile(bytes, file.name, file, files));
}

const actions = {
  open: (accept = ".ntc,.glb,.gltf,.bin,image/*") => chooseFiles(accept, openFiles),
  /** A model that is not there is asked for. */
  showShape: (shape) =>
    shape === "model" && !viewer.modelMaterials ? actions.open(".glb,.gltf,.bin,image/*") : viewer.apply({ view: "material", shape }),
  copyLink: () =>
    attempt("link", async () => {
      await navigator.clipboard.writeText(location.href);
      say("Link copied.");
    }),
  togglePanel: () => {
    document.body.classList.toggle("wide");
    resize();
  },
  toggleHelp: () => find("help").toggleAttribute("hidden"),
  closeHelp: () => (find("help").hidden = true),
  saveTexture: () =>
    attempt("PNG", async () => {
      const { set, texture, state } = viewer;
      const mip = Math.max(state.mip, 0);
      const texels = await viewer.decoder.decodeMip(mip);
      const png = await encodePng(toBytes(texels, texture), Math.max(set.width >> mip, 1), Math.max(set.height >> mip, 1), texture.channels);
      saveFile(png, `${texture.name}${mip > 0 ? `.${mip}` : ""}.png`);
    }),
};

function resize() {
  const { width, height } = canvas.parentElement.getBoundingClientRect();
  const ratio = Math.min(window.devicePixelRatio, 2);
  viewer.resize(Math.max(1, Math.round(width * ratio)), Math.max(1, Math.round(height * ratio)));
}

let linkTimer = 0;
function updateLink() {
  clearTimeout(linkTimer);
  linkTimer = setTimeout(() => {
    if (viewer.set) history.replaceState(null, "", makeLink(viewer.state, viewer.set.name, viewer.stage.getCamera()));
  }, 250);
}

function buildStartPage() {
  for (const name of Object.keys(samples))
    find("samples").append(
      make("button", { type: "button", textContent: name, onclick: () => attempt(name, () => openFile(samples[name], name)) }),
    );
  find("choose").addEventListener("click", () => actions.open());
  const keyCaps = (keys) => keys.split(" ").map((key) => make("kbd", { textContent: key }));
  const lines = SHORTCUTS.flatMap(([keys, what]) => [make("dt", {}, ...keyCaps(keys)), make("dd", { textContent: what })]);
  find("help").append(make("dl", {}, ...lines));
  find("help").addEventListener("click", actions.toggleHelp);
  find("helpButton").addEventListener("click", actions.toggleHelp);
  find("linkButton").addEventListener("click", actions.copyLink);
  find("openButton").addEventListener("click", () => actions.open());
}

/** The texel under the pointer, as numbers. */
async function showTexel(event) {
  if (!viewer.set || !viewer.stage.isFlat || event.buttons !== 0) return;
  const place = viewer.getTexelAt(event.offsetX / canvas.clientWidth, event.offsetY / canvas.clientHeight);
  if (!place) return say("");
  const { texture, state } = viewer;
  const mip = Math.max(state.mip, 0);
  const [x, y] = [place.x >> mip, place.y >> mip];
  const channels = (await viewer.decoder.decode(mip, x, y, 1, 1)).subarray(texture.firstChannel, texture.firstChannel + texture.channels);
  say(`mip ${mip}, texel ${x}, ${y}: ${[...channels].map((value) => value.toFixed(4)).join("  ")}`);
}

async function start() {
  try {
    viewer = new Viewer(canvas);
  } catch (error) {
    say(`WebGL 2: ${error.message}`, true);
    return;
  }
  window.ntcViewer = viewer;
  const panel = new Panel(find("panel"), viewer, actions);
  viewer.addEventListener("report", ({ detail }) => say(detail.text, detail.isError));
  viewer.addEventListener("set", () => document.body.classList.remove("empty"));
  viewer.addEventListener("compiling", () => say(viewer.isCompiling ? "Compiling the decoder for this device…" : ""));
  viewer.addEventListener("state", updateLink);
  viewer.addEventListener("camera", updateLink);
  viewer.addEventListener("frame", () => {
    find("frames").textContent = `${viewer.frames} frame${viewer.frames === 1 ? "" : "s"}`;
    if (viewer.frames === 1) panel.afterFirstPicture();
  });
  buildStartPage();
  acceptDrops(document.body, openFiles);
  listenToKeys(viewer, actions);
  new ResizeObserver(resize).observe(canvas.parentElement);
  canvas.addEventListener("pointermove", (event) => attempt("", () => showTexel(event)));
  viewer.openFile = openFile;
  resize();
  window.addEventListener("hashchange", ({ newURL }) => attempt("link", () => openLink(new URL(newURL).hash)));
  await attempt("link", () => openLink(location.hash));
}

window.ntcReady = start(); // for tests: when the page can be used

