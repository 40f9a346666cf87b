// SPDX-License-Identifier: MIT
// The panel beside the picture.
import { choice, make, section, select, slider, toggle } from "./dom.js";
import { namesOfRoles } from "../ntc/index.js";
import { formatBytes, formatRate, measureForms, measurePng } from "./sizes.js";

const KERNELS = [
  ["nearest", "Nearest"], ["bilinear", "Trilinear"], ["cubic", "B-spline"], ["catmull-rom", "Catmull-Rom"],
  ["mitchell", "Mitchell"], ["gaussian", "Gaussian"],
];
const SHAPES = [["sphere", "Sphere"], ["cube", "Cube"], ["plane", "Plane"], ["model", "Model", "Drop a .glb, or a .gltf with its files"]];
const AUTO = (value) => (value < 0 ? "auto" : value);
const TIMES = (value) => `${value}×`;
const PNG = "PNG, mip 0"; // all other forms have all mips
const AUTOMATIC_PNG = 512 * 512; // texels; more only when asked

export class Panel {
  /** @param actions of main.js: open, saveTexture. */
  constructor(root, viewer, actions) {
    this.viewer = viewer;
    this.actions = actions;
    const apply = (key) => (value) => viewer.apply({ [key]: value });
    this.controls = {
      view: choice("View", [["material", "Material"], ["textures", "Textures", "Each texture alone (T)"]], apply("view")),
      shape: choice("Shape", SHAPES, actions.showShape),
      modelMaterial: select("Material", "Which of the model's materials this set takes the place of", apply("modelMaterial")),
      onShape: toggle("On the shape", "On the shape rather than flat", apply("onShape")),
      channel: choice("Channel", [["all", "All"], ["r", "R"], ["g", "G"], ["b", "B"], ["a", "A"]], apply("channel")),
      mip: slider("Mip", "Level of detail ([ and ])", { min: -1, max: 0, step: 1, format: AUTO }, apply("mip")),
      kernel: select("Filter", "Texture filter (F)", apply("kernel")),
      anisotropy: slider("Anisotropy", "Most taps along the footprint", { min: 1, max: 16, step: 1, format: TIMES }, apply("anisotropy")),
      stochastic: choice(
        "Texels per lookup",
        [[true, "One, averaged", "A texel drawn by its weight; frames are averaged (S)"], [false, "All", "All texels of the filter in every frame (S)"]],
        apply("stochastic"),
      ),
      repeat: slider("Repeat", "Texture repeats", { min: 0.25, max: 8, step: 0.25, format: TIMES }, apply("repeat")),
      light: slider("Light", "Turns the studio", { min: -180, max: 180, step: 1, format: (v) => `${v}°` }, apply("light")),
      exposure: slider("Exposure", "", { min: 0.1, max: 4, step: 0.05, format: (v) => v.toFixed(2) }, apply("exposure")),
      flipNormal: toggle("Green points down", "Normal maps made for Direct3D", apply("flipNormal")),
      comparison: choice(
        "Comparison",
        [["decoded", "Decoded"], ["reference", "Reference"], ["split", "Split"], ["difference", "Difference"]], apply("comparison"),
      ),
      gain: slider("Gain", "What the difference is multiplied by", { min: 1, max: 64, step: 1, format: TIMES }, apply("gain")),
      gpu: choice(
        "Decoder", [["auto", "Automatic", "WebGPU on a GPU"], ["webgl", "WebGL 2"], ["webgpu", "WebGPU"]], apply("gpu"),
      ),
      split: slider("Split", "", { min: 0, max: 1, step: 0.005, format: (v) => `${Math.round(v * 100)} %` }, apply("split")),
    };
    this.controls.kernel.setOptions(KERNELS);
    this.title = make("h1");
    this.facts = make("p.facts");
    this.list = make("div.textures");
    this.sizes = make("table.sizes");
    this.decoding = make("p.speed.decoding");
    this.speed = make("p.speed");
    this.psnr = make("p.psnr");
    this.unused = make("p.hint");
    this.build(root);
    viewer.addEventListener("set", () => this.showSet());
    viewer.addEventListener("decoder", () => this.showSpeed());
    viewer.addEventListener("model", () => this.showModel());
    viewer.addEventListener("state", () => this.update());
  }

  build(root) {
    const e = (key) => this.controls[key].element;
    const parts = ["shape", "modelMaterial", "repeat", "light", "exposure", "flipNormal"].map(e);
    this.materialPart = section("Material", ...parts, this.unused);
    const save = make("button.wide", { type: "button", textContent: "Save this texture as PNG", onclick: () => this.actions.saveTexture() });
    this.texturePart = section("Texture", this.list, e("channel"), e("onShape"), save);
    this.hint = make("p.hint", { textContent: "Drop an image to compare with." });
    this.comparePart = section("Reference", this.hint, e("comparison"), e("gain"), e("split"), this.psnr);
    const perLookup = make("div.label", { textContent: "Texels per lookup" });
    const filter = section("Sampling", e("kernel"), perLookup, e("stochastic"), e("anisotropy"), e("mip"));
    root.append(
      make("header", {}, this.title, this.facts), e("view"), this.materialPart, this.texturePart, this.comparePart, filter,
      section("Size", this.sizes), section("Whole textures", e("gpu"), this.decoding, this.speed),
    );
  }

  showSet() {
    const { set, material } = this.viewer;
    const roles = material.userData.ntcRoles;
    const unused = set.textures.filter((texture) => namesOfRoles(roles, texture).length === 0);
    this.unused.textContent = unused.length === 0 ? "" : `Not in the material: ${unused.map(({ name }) => name).join(", ")}`;
    this.title.textContent = set.name;
    const generation = set.generation === 1 ? "" : `, generation ${set.generation}`;
    const network = `${set.networkName} network${generation}`;
    this.facts.textContent = `${set.width} × ${set.height}, ${set.channels} channels, ${set.mips} mips, ${network}`;
    this.controls.mip.setMost(set.mips - 1);
    this.list.replaceChildren(
      ...set.textures.map((texture) =>
        make(
          "button.texture", { type: "button", onclick: () => this.viewer.apply({ view: "textures", texture: texture.name }) },
          make("span", { textContent: texture.name, title: namesOfRoles(roles, texture).join(", ") || "not in the material" }),
          make("small", { textContent: `${texture.channels} × ${texture.format} ${texture.colorSpace}` }),
        ),
      ),
    );
    this.showSizes();
  }

  showSizes() {
    const { set, textures, decoder } = this.viewer;
    const forms = measureForms(set);
    const texels = set.width * set.height;
    const line = (name, bytes, title) => {
      const ratio = bytes / set.fileBytes;
      return make(
        "tr", { title }, make("td", { textContent: name }), make("td", { textContent: formatBytes(bytes) }),
        make("td", { textContent: ((8 * bytes) / texels).toFixed(1) }), make("td", { textContent: `${ratio.toFixed(1)}×` }),
      );
    };
    const png = make("tr", {}, make("td", { textContent: PNG }));
    const measure = async () => {
      png.replaceChildren(make("td", { textContent: PNG }), make("td", { textContent: "…", colSpan: 3 }));
      const bytes = await measurePng(set, decoder);
      if (this.viewer.set === set) png.replaceWith(line(PNG, bytes, "The decoded textures of mip 0 as files of 8 bits a channel"));
    };
    png.append(make("td", { colSpan: 3 }, make("button.link", { type: "button", textContent: "measure", onclick: measure })));
    this.sizes.replaceChildren(
      make("tr", {}, ...["", "Size", "Bits/texel", ""].map((textContent) => make("th", { textContent }))),
      line("NTC file", set.fileBytes, "All textures and mips"),
      line("NTC in memory", textures.bytes, "Latents, weights and constants, as the shader reads them"),
      png,
      line("BC7", forms.bc7, "All textures in BC7, all mips"),
      line("BC as named", forms.named, "The block formats that the file names, all mips"),
      line("Texels", forms.texels, "Uncompressed, all mips"),
    );
    this.measurePng = texels <= AUTOMATIC_PNG ? measure : null;
  }

  showSpeed() {
    const { glDecoder, gpuDecoder, gpuProblem } = this.viewer;
    const decoders = [glDecoder, gpuDecoder].filter((decoder) => decoder);
    this.decoding.textContent = gpuProblem || `${decoders.at(-1).name} decodes for PNG files, PSNR and the pointer.`;
    const measure = async () => {
      const lines = [];
      for (const decoder of decoders) {
        this.speed.replaceChildren(...lines, "measuring…");
        const texels = await decoder.measureSpeed();
        if (this.viewer.glDecoder !== glDecoder || this.viewer.gpuDecoder !== gpuDecoder) return;
        lines.push(make("div", { textContent: `${decoder.name}: ${formatRate(texels)}` }));
      }
      this.speed.replaceChildren(...lines);
    };
    this.speed.replaceChildren(make("button.link", { type: "button", textContent: "measure this device", onclick: measure }));
  }

  /** What may wait for the first picture. */
  afterFirstPicture() {
    const measure = this.measurePng;
    this.measurePng = null;
    return measure?.();
  }

  showModel() {
    this.controls.modelMaterial.setOptions([["", "all"], ...this.viewer.modelMaterials.map((name) => [name, name])]);
  }

  update() {
    const { state, set, stage, texture, reference, references } = this.viewer;
    for (const [key, control] of Object.entries(this.controls)) control.update(state[key]);
    const isTexture = state.view === "textures";
    this.controls.channel.update(state.channel, (value) => "rgba".indexOf(value) < texture.channels);
    this.controls.modelMaterial.element.hidden = !stage.isModel;
    this.materialPart.hidden = isTexture;
    this.texturePart.hidden = this.comparePart.hidden = !isTexture;
    this.hint.hidden = reference !== undefined;
    this.controls.comparison.element.hidden = this.psnr.hidden = reference === undefined;
    this.controls.gain.element.hidden = reference === undefined || state.comparison !== "difference";
    this.controls.split.element.hidden = reference === undefined || state.comparison !== "split";
    [...this.list.children].forEach((button, i) => {
      const { name } = set.textures[i];
      button.classList.toggle("on", name === texture.name);
      button.classList.toggle("compared", references.has(name));
    });
    if (reference) {
      const value = reference.psnr === undefined ? "measuring…" : `${reference.psnr === Infinity ? "∞" : reference.psnr.toFixed(2)} dB`;
      this.psnr.textContent = `${reference.name}: PSNR ${value} (mip 0)`;
    }
  }
}
