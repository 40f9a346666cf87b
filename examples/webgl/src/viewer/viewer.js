// SPDX-License-Identifier: MIT
// The viewer without its panel: a texture set, what is shown of it, and the loop that draws.
import { NeutralToneMapping, Vector3, WebGLRenderer } from "three";
import { NtcDecoder, NtcTextures, makeNtcMaterial, openTextureSet } from "../ntc/index.js";
import { FrameAverage } from "./average.js";
import { InspectMaterial } from "./inspect.js";
import { makeGpuDecoder } from "./gpu.js";
import { DEFAULTS } from "./link.js";
import { Pace } from "./pace.js";
import { loadReference, measurePsnr } from "./reference.js";
import { Stage } from "./stage.js";

const FRAMES = 256; // then the picture stands still
const STILL_AFTER = 160; // ms without a change

export class Viewer extends EventTarget {
  constructor(canvas) {
    super();
    this.canvas = canvas;
    this.renderer = new WebGLRenderer({ canvas, antialias: false, depth: false, powerPreference: "high-performance" });
    if (!this.renderer.extensions.has("EXT_color_buffer_float")) throw new Error("EXT_color_buffer_float: not on this device");
    this.renderer.toneMapping = NeutralToneMapping;
    this.average = new FrameAverage(this.renderer);
    this.pace = new Pace(this.renderer.getContext());
    this.stage = new Stage(this.renderer, canvas, () => this.touch(true));
    this.state = { ...DEFAULTS };
    this.references = new Map();
    this.mode = "lit";
    this.changedAt = -Infinity;
    this.isDirty = false;
    this.compiling = 0;
    this.renderer.debug.onShaderError = (gl, program, vertex, fragment) =>
      this.report(`shader: ${(gl.getShaderInfoLog(fragment) || gl.getProgramInfoLog(program) || "refused").split("\n")[0]}`, true);
    canvas.addEventListener("webglcontextlost", () => this.report("the browser took the device away: load the page again", true));
    const tick = () => {
      requestAnimationFrame(tick);
      this.step();
    };
    requestAnimationFrame(tick);
  }

  report(text, isError = false) {
    this.dispatchEvent(new CustomEvent("report", { detail: { text, isError } }));
  }

  announce(what) {
    this.dispatchEvent(new Event(what));
  }

  /** Opens a texture set and shows it as `link` says (parseLink), or as the one before. @throws what the reader has to say. */
  async openSet(bytes, name, link = null) {
    const set = await openTextureSet(bytes);
    const textures = new NtcTextures(set, this.renderer.capabilities.maxTextureSize);
    this.closeSet();
    this.set = { ...set, name };
    Object.assign(this.state, link?.state);
    this.textures = textures;
    this.material = makeNtcMaterial(textures);
    this.inspect = new InspectMaterial(textures);
    this.glDecoder = new NtcDecoder(this.renderer, textures);
    await this.chooseDecoder();
    this.compiled = "";
    this.announce("set");
    if (link) await this.show(link);
    else await this.apply(this.modelMaterials ? { modelMaterial: this.findModelMaterial() } : {});
  }

  /** Shows the view of a link. A model that is not there yet is waited for. */
  async show({ state, camera }) {
    this.stage.setShape(state.shape); // before its camera, which would be reset
    this.stage.resetCamera();
    this.stage.setCamera(camera);
    await this.apply(state);
    if (state.shape === "model" && !this.stage.isModel) this.report("This link shows a model: drop it here.");
  }

  /** What decodes whole textures, by the state: WebGPU or WebGL 2. */
  async chooseDecoder() {
    const { set } = this;
    let chosen = null;
    this.gpuProblem = "";
    try {
      chosen = await makeGpuDecoder(set, this.state.gpu);
    } catch (error) {
      this.gpuProblem = error.message;
    }
    if (this.set !== set) return chosen?.dispose(); // another one was opened meanwhile
    this.gpuDecoder?.dispose();
    this.gpuDecoder = chosen;
    return this.announce("decoder");
  }

  get decoder() {
    return this.gpuDecoder ?? this.glDecoder;
  }

  closeSet() {
    for (const part of [this.textures, this.material, this.inspect, this.glDecoder, this.gpuDecoder]) part?.dispose();
    this.gpuDecoder = null;
    for (const { texture } of this.references.values()) texture.dispose();
    this.references.clear();
  }

  /** @param {Map<string, Blob>} files that the model may name. */
  async openModel(bytes, files = new Map()) {
    const names = await this.stage.loadModel(bytes, files);
    const { view, shape, modelMaterial } = this.state;
    const isAwaited = shape === "model" && !this.modelMaterials; // by a link
    const isNamed = isAwaited && ["", ...names].includes(modelMaterial);
    this.modelMaterials = names;
    this.compiled = "";
    this.announce("model");
    await this.apply({
      view: isAwaited ? view : "material", shape: "model", modelMaterial: isNamed ? modelMaterial : this.findModelMaterial(),
    });
  }

  /** The model's material that the set is named after; "" where there is none. */
  findModelMaterial() {
    const own = this.set.name.replace(/\.ntc$/i, "").toLowerCase();
    return this.modelMaterials?.find((name) => name.toLowerCase() === own) ?? "";
  }

  /** An image to compare a texture with: the one whose name its own contains, or the one that is shown. */
  async openReference(blob, name) {
    const reference = await loadReference(blob, name, this.set);
    const lower = name.toLowerCase();
    const named = this.set.textures.filter((texture) => lower.includes(texture.name.toLowerCase()));
    const texture = named.sort((a, b) => b.name.length - a.name.length)[0] ?? this.texture;
    if (texture.channels > 4) throw new Error(`${texture.name}: ${texture.channels} channels: an image has 1 ... 4`);
    this.references.get(texture.name)?.texture.dispose();
    this.references.set(texture.name, reference);
    const { comparison } = this.state;
    await this.apply({ view: "textures", texture: texture.name, comparison: comparison === "decoded" ? "difference" : comparison });
    reference.psnr = await measurePsnr(this.renderer, this.decoder, texture, reference);
    this.announce("state");
    return reference.psnr;
  }

  get texture() {
    const { textures } = this.set;
    return textures.find(({ name }) => name === this.state.texture) ?? textures[0];
  }

  get reference() {
    return this.references.get(this.texture.name);
  }

  /** Changes some of the state (link.js) and shows it. */
  async apply(changes) {
    const isOtherGpu = changes.gpu !== undefined && changes.gpu !== this.state.gpu;
    Object.assign(this.state, changes);
    const { state, stage } = this;
    if (!this.set || this.set.textures.length === 0) return;
    if (isOtherGpu) await this.chooseDecoder();
    state.texture = this.texture.name;
    state.mip = Math.min(state.mip, this.set.mips - 1);
    if ("rgba".indexOf(state.channel) >= this.texture.channels) state.channel = "all";
    stage.setShape(state.shape);
    const isTexture = state.view === "textures";
    const isFlat = isTexture && !state.onShape;
    stage.setFlat(isFlat);
    stage.setLight(state.light);
    const isDifference = isTexture && this.reference !== undefined && state.comparison === "difference"; // of texels, not of filters
    this.textures.setFilter({
      ...state,
      repeat: isFlat ? 1 : state.repeat,
      kernel: isDifference ? "nearest" : state.kernel,
      mip: isDifference ? Math.max(state.mip, 0) : state.mip,
    });
    this.material.userData.ntcNormalSign.value = state.flipNormal ? 1 : -1;
    this.renderer.toneMappingExposure = state.exposure;
    this.mode = "lit";
    if (isTexture)
      this.mode = this.inspect.show(this.texture, state.channel, {
        ...state, reference: this.reference, splitAt: state.split * this.average.width,
      });
    if (isFlat) stage.setFlatMaterial(this.inspect, this.set.width, this.set.height);
    else stage.setMaterial(isTexture ? this.inspect : this.material, state.modelMaterial);
    this.announce("state");
    await this.compile();
    this.touch(false);
  }

  /** Compiles what is shown before it is drawn, so that the page can say so meanwhile. */
  async compile() {
    const { scene, camera } = this.stage.view;
    const { view, shape, onShape, modelMaterial } = this.state;
    const wanted = [this.textures.filterKey, view, onShape, shape, modelMaterial].join();
    if (wanted === this.compiled) return;
    this.compiled = wanted;
    this.compiling++;
    this.announce("compiling");
    try {
      this.renderer.setRenderTarget(this.average.frame); // programs depend on where they draw to
      const compiled = this.renderer.compileAsync(scene, camera);
      this.renderer.setRenderTarget(null);
      await compiled;
    } finally {
      this.compiling--;
      this.announce("compiling");
    }
  }

  get isCompiling() {
    return this.compiling > 0;
  }

  /** The texel of mip 0 at a place of the flat view, 0 … 1 from the upper left; null beside the texture. */
  getTexelAt(x, y) {
    const { flat, flatCamera } = this.stage;
    const at = new Vector3(2 * x - 1, 1 - 2 * y, 0).unproject(flatCamera);
    const u = at.x / flat.scale.x + 0.5, v = 0.5 - at.y / flat.scale.y;
    if (u < 0 || v < 0 || u >= 1 || v >= 1) return null;
    return { x: Math.floor(u * this.set.width), y: Math.floor(v * this.set.height) };
  }

  resize(width, height) {
    this.renderer.setSize(width, height, false);
    this.average.resize(width, height);
    this.stage.resize(width, height);
    if (this.inspect) this.inspect.uniforms.splitAt.value = this.state.split * width;
    this.touch(false);
  }

  /** Something changed: begin again; `isMotion` if more is to be expected at once. */
  touch(isMotion) {
    this.isDirty = true;
    if (isMotion) {
      this.changedAt = performance.now();
      this.announce("camera");
    }
  }

  step() {
    if (!this.set || this.isCompiling || !this.pace.isReady()) return;
    const { average, pace } = this;
    const isMoving = performance.now() - this.changedAt < STILL_AFTER;
    if (this.isDirty) {
      const pixels = average.width * average.height;
      average.restart(isMoving || pace.isSlow(pixels) ? pace.getScale(pixels) : 1);
      this.isDirty = false;
    } else if (!isMoving && average.partWidth < average.width && average.frames > 0) average.restart(1);
    if (average.frames >= FRAMES) return;
    this.textures.uniforms.ntcFrame.value = average.frames; // so that the same view is the same picture
    const { scene, camera } = this.stage.view;
    const { pixels, complete } = average.draw(scene, camera, isMoving ? Infinity : pace.getRows(average.partWidth));
    if (complete) {
      average.present(this.mode);
      this.announce("frame");
    }
    pace.begin(pixels);
  }

  /** Resolves when `frames` frames at full size have been averaged. */
  async waitForFrames(frames) {
    const { average } = this;
    const isWhole = () => !this.isDirty && !this.isCompiling && average.partWidth === average.width;
    const done = () => isWhole() && average.frames >= Math.min(frames, FRAMES);
    while (!done()) await new Promise((resume) => requestAnimationFrame(resume));
  }

  get frames() {
    return this.average.frames;
  }
}
