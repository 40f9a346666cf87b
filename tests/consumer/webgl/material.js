// SPDX-License-Identifier: MIT
// What material_test.mjs runs in the page: the material of openntc-three.js beside three.js's own with the decoded texels as textures,
// both on the same square under the same lights: the middle half of each side, a texel for each pixel.
import {
  DataTexture, DirectionalLight, EquirectangularReflectionMapping, FloatType, Mesh, MeshStandardMaterial, OrthographicCamera, PlaneGeometry,
  RGBAFormat, Scene, Vector2, WebGLRenderTarget, WebGLRenderer,
} from "three";
import { NtcTextures, guessRoles, makeNtcMaterial, openTextureSet } from "/openntc-three.js";

/** Where three.js reads what, by the names of the sample: not by the module's own table. */
const SLOTS = {
  BaseColor: "map", Normal: "normalMap", Roughness: "roughnessMap", Metalness: "metalnessMap", Occlusion: "aoMap", Emissive: "emissiveMap",
};

async function load(path) {
  return new Uint8Array(await (await fetch(path)).arrayBuffer());
}

function makeTexture(values, width, height) {
  const texture = new DataTexture(values, width, height, RGBAFormat, FloatType);
  texture.needsUpdate = true;
  return texture;
}

/** A texture of the set: one channel in all four, else alpha 1 where it has none. */
function extract(texels, { firstChannel, channels }) {
  const values = new Float32Array(texels.length / 4);
  for (let i = 0; i < values.length / 4; i++)
    for (let c = 0; c < 4; c++) {
      const channel = channels === 1 ? 0 : c;
      values[4 * i + c] = channel < channels ? texels[16 * i + firstChannel + channel] : 1;
    }
  return values;
}

function makeExpected(set, texels, isPacked) {
  const maps = {};
  for (const texture of set.textures) {
    const values = extract(texels, texture);
    if (isPacked && texture.name === "Normal")
      for (let i = 0; i < values.length; i += 4) {
        const [x, y] = [0, 1].map((c) => 2 * values[i + c] - 1);
        values[i + 2] = 0.5 * Math.sqrt(Math.max(1 - x * x - y * y, 0)) + 0.5;
      }
    if (SLOTS[texture.name]) maps[SLOTS[texture.name]] = makeTexture(values, set.width, set.height);
  }
  return new MeshStandardMaterial({
    ...maps, roughness: 1, metalness: 1, emissive: maps.emissiveMap ? 0xffffff : 0, alphaTest: 0.5,
    normalScale: new Vector2(1, -1), // as GLTFLoader sets it where v runs down and there are no tangents
  });
}

/** A light from the side, and surroundings that differ in every direction. */
function makeScene() {
  const scene = new Scene();
  const light = new DirectionalLight(0xffe8d0, 2);
  light.position.set(2, 1, 1.5);
  const colors = Float32Array.from({ length: 4 * 8 }, (_, i) => (i % 4 === 3 ? 1 : 0.2 + ((i * 7) % 11) / 8));
  scene.environment = makeTexture(colors, 4, 2);
  scene.environment.mapping = EquirectangularReflectionMapping;
  const plane = new PlaneGeometry(2, 2);
  const uv = plane.getAttribute("uv");
  for (let i = 0; i < uv.count; i++) uv.setY(i, 1 - uv.getY(i));
  const mesh = new Mesh(plane);
  scene.add(light, mesh);
  return { scene, mesh };
}

function replaceText(material, from, to) {
  const before = material.onBeforeCompile;
  material.onBeforeCompile = (shader) => {
    before(shader);
    if (!shader.fragmentShader.includes(from)) throw new Error(`the shader has no ${from}`);
    shader.fragmentShader = shader.fragmentShader.replace(from, to);
  };
  const key = material.customProgramCacheKey();
  material.customProgramCacheKey = () => `${key} ${to}`;
}

/** The material as it is, and with faults. */
const FORMS = {
  sound: (textures) => makeNtcMaterial(textures),
  "two channels of the normal": (textures, roles) => makeNtcMaterial(textures, { roles: { ...roles, normalChannels: 2 } }),
  "roughness and metalness swapped": (textures, roles) =>
    makeNtcMaterial(textures, { roles: { ...roles, roughness: roles.metalness, metalness: roles.roughness } }),
  "no occlusion": (textures, roles) => makeNtcMaterial(textures, { roles: { ...roles, occlusion: undefined } }),
  "no emission": (textures, roles) => makeNtcMaterial(textures, { roles: { ...roles, emissive: undefined } }),
  "green of the normal turned round": (textures) => {
    const material = makeNtcMaterial(textures);
    material.userData.ntcNormalSign.value *= -1;
    return material;
  },
  "sRGB taken for light": (textures) => {
    const material = makeNtcMaterial(textures);
    replaceText(material, "ntcSampleAt(vUv, true)", "ntcSampleAt(vUv, false)");
    return material;
  },
};

window.tests = {
  open: async (path, expected) => {
    const renderer = new WebGLRenderer();
    const set = await openTextureSet(await load(path));
    const textures = new NtcTextures(set, renderer.capabilities.maxTextureSize);
    textures.setFilter({ kernel: "nearest", mip: 0 });
    const texels = new Float32Array((await load(expected)).buffer);
    const target = new WebGLRenderTarget(set.width / 2, set.height / 2, { type: FloatType });
    Object.assign(window, { renderer, set, textures, texels, target, ...makeScene() });
    return set.textures.map(({ name }) => name);
  },
  /** @returns {Float32Array} light of every pixel, [y][x][4]; alpha is 0 where nothing was drawn. */
  draw: (material) => {
    mesh.material = material;
    renderer.setRenderTarget(target);
    renderer.setClearColor(0, 0);
    renderer.clear();
    renderer.render(scene, new OrthographicCamera(-0.5, 0.5, 0.5, -0.5, -1, 1));
    const { width, height } = target;
    const pixels = new Float32Array(4 * width * height);
    renderer.readRenderTargetPixels(target, 0, 0, width, height, pixels);
    material.dispose();
    return pixels;
  },
  /** How far a form of the material is from three.js's own: the largest difference, and how many pixels have more than `allowed`. */
  compare: (form, allowed) => {
    const ours = tests.draw(FORMS[form](textures, guessRoles(set.textures)));
    const theirs = tests.draw(makeExpected(set, texels, form === "two channels of the normal"));
    let largest = 0, beyond = 0, drawn = 0;
    for (let i = 0; i < ours.length; i += 4) {
      const difference = Math.max(...[0, 1, 2, 3].map((c) => Math.abs(ours[i + c] - theirs[i + c])));
      largest = Math.max(largest, difference);
      beyond += difference > allowed ? 1 : 0;
      drawn += theirs[i + 3] > 0 ? 1 : 0;
    }
    return { largest, beyond, drawn, pixels: ours.length / 4 };
  },
};
