// SPDX-License-Identifier: MIT
// The viewer's flat view of a texture, a texel for each pixel, against the images of `ntc decode` and the numbers of `ntc sample`.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { decodePng } from "./png.mjs";

/**
 * How far from a half the 255-fold of a number may be where two roundings to 8 bits may differ. Numbers that are shown as stored are those
 * of `ntc sample`: only the product rounds. sRGB is decoded and encoded again: each of the two pow has a relative error of some 2^-17 (3
 * units in the last place of log2, whose results are up to 5, times 2.4, and of exp2 as many as its argument twice, as Vulkan allows), and
 * three.js has 0.41666 for 1 / 2.4, which is 6e-6: all of it is less than 3e-5 of 255.
 */
const SLACK = { raw: 255 * 2 ** -23, encode: 255 * 3e-5 };

/** The address behind # that has the page begin with this view: no other program is compiled. */
export const FLAT_VIEW = "view=textures&kernel=nearest&mip=0";

/** What draws in the page: one frame, unjittered. */
const PREPARE = `
ntcViewer.step = () => {};
window.drawFlat = async (texture, channel, mip, spoil, shift) => {
  const { average, inspect, stage, renderer, set } = ntcViewer;
  ntcViewer.resize(set.width, set.height);
  await ntcViewer.apply({ view: "textures", onShape: false, kernel: "nearest", stochastic: true, texture, channel, mip, comparison: "decoded" });
  stage.setCamera([shift / set.width, 0, 2 * stage.flatCamera.top]); // as wide as the square
  for (const [name, value] of Object.entries(spoil)) inspect.uniforms[name].value = value;
  average.restart(1);
  ntcViewer.textures.uniforms.ntcFrame.value = 0;
  const { scene, camera } = stage.view;
  average.draw(scene, camera, Infinity);
  average.present(ntcViewer.mode);
  const gl = renderer.getContext();
  const pixels = new Uint8Array(4 * set.width * set.height);
  gl.readPixels(0, 0, set.width, set.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  let text = "";
  for (let i = 0; i < pixels.length; i += 4096) text += String.fromCharCode(...pixels.subarray(i, i + 4096));
  return { mode: ntcViewer.mode, pixels: btoa(text) };
}; 0`;

function encodeSrgb(light) {
  return light <= 0.0031308 ? 12.92 * light : 1.055 * light ** (1 / 2.4) - 0.055;
}

/** Which of a texture's channels are shown as red, green and blue; -1: black. */
function getShown(texture, channel) {
  const one = "rgba".indexOf(channel);
  if (one >= 0) return [one, one, one];
  return texture.channels === 1 ? [0, 0, 0] : [0, 1, texture.channels === 2 ? -1 : 2];
}

export class Flat {
  /** @param stored and light, of `ntc sample`: [y][x][16] of mip 0. */
  static async open(browser, bytes, stored, light) {
    await browser.run("ntcReady");
    await browser.run(PREPARE);
    const set = await browser.run(`(async () => {
      const bytes = Uint8Array.from(atob("${bytes.toString("base64")}"), (c) => c.charCodeAt(0));
      await ntcViewer.openFile(bytes, "flat.ntc", new Blob([bytes]));
      const { width, height, textures } = ntcViewer.set;
      return { width, height, textures };
    })()`);
    assert.equal(stored.length, 16 * set.width * set.height);
    return new Flat(browser, set, stored, light);
  }

  constructor(browser, set, stored, light) {
    Object.assign(this, { browser, set, stored, light });
  }

  /** Of what is drawn, numbers of pixels that are not the texel's, and whose distance to `image`, if there is one, is not rounding. */
  async countWrong(texture, channel, { image, spoil = {}, shift = 0 } = {}) {
    const call = `drawFlat(${JSON.stringify(texture.name)}, "${channel}", 0, ${JSON.stringify(spoil)}, ${shift})`;
    const { mode, pixels } = await this.browser.run(call);
    const drawn = Buffer.from(pixels, "base64");
    const { width, height } = this.set;
    const isFloat = texture.format.startsWith("FLOAT");
    let wrong = 0;
    for (let i = 0; i < width * height; i++) {
      const pixel = 4 * ((height - 1 - Math.floor(i / width)) * width + (i % width)); // rows from below
      getShown(texture, channel).forEach((c, color) => {
        const at = 16 * i + texture.firstChannel + c;
        const number = c < 0 ? 0 : isFloat ? encodeSrgb(Math.max(this.light[at], 0)) : this.stored[at];
        const exact = 255 * Math.min(Math.max(number, 0), 1);
        const isNear = Math.abs(drawn[pixel + color] - exact) <= 0.5 + SLACK[mode];
        const isSame = !image || c < 0 || drawn[pixel + color] === image.pixels[image.channels * i + c];
        const isTie = Math.abs((exact % 1) - 0.5) <= SLACK[mode];
        wrong += isNear && (isSame || isTie) ? 0 : 1;
      });
    }
    return wrong;
  }

  /** Every texture, and alpha where there is one. @param decoded folder of `ntc decode`. @returns how many numbers were compared. */
  async check(decoded) {
    const { set } = this;
    let compared = 0;
    for (const texture of set.textures) {
      const image = texture.format === "UNORM8" ? decodePng(readFileSync(join(decoded, `${texture.name}.png`))) : undefined;
      if (image) assert.deepEqual([image.width, image.height, image.channels], [set.width, set.height, texture.channels]);
      for (const channel of texture.channels === 4 ? ["all", "a"] : ["all"]) {
        const wrong = await this.countWrong(texture, channel, { image });
        assert.equal(wrong, 0, `${texture.name}, ${channel}: ${wrong} numbers are not those of the texels`);
        compared += 3 * set.width * set.height;
      }
    }
    return compared;
  }

  /** Faults must be noticed: as many numbers as there are texels. */
  async checkFaults() {
    const { width, height, textures } = this.set;
    const texture = textures.find(({ colorSpace }) => colorSpace === "sRGB");
    const faults = {
      "sRGB taken for light": { spoil: { asLinear: false } },
      "the next channel": { spoil: { shown: [texture.firstChannel + 1, texture.channels] } },
      "a texel aside": { shift: 1 },
    };
    for (const [name, fault] of Object.entries(faults)) {
      const wrong = await this.countWrong(texture, "all", fault);
      assert.ok(wrong > width * height, `${name}: ${wrong} numbers differ`);
    }
  }
}
