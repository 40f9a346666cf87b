// SPDX-License-Identifier: MIT
// node page_test.mjs PAGE DOCUMENTATION NTC CHROMIUM DRIVER PICTURES SET…: the viewer in a browser. Of every set all outputs of every texel and mip have
// the bits of `ntc sample`; the reader's errors are those of `ntc info`; PSNR is what it should be; links give the same picture again;
// files that are dropped are opened; the page of DOCUMENTATION draws and says a texel. Says how fast it decodes.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { existsSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { basename, dirname, join } from "node:path";
import { pathToFileURL } from "node:url";
import { Browser } from "./browser.mjs";
import { makeModel, makeModelFiles } from "./model.mjs";
import { countDifferentWords, sampleMip, sampleTexels } from "./samples.mjs";
import { withSite } from "./site.mjs";
import { checkFailedCompilation, checkModelLink, checkOtherLinks, checkRefusals } from "./states.mjs";

const [page, documentation, ntc, chromium, driver, pictures, ...sets] = process.argv.slice(2);
const [WIDTH, HEIGHT] = [620, 400];
mkdirSync(pictures, { recursive: true });

const open = (file, name = basename(file), content = readFileSync(file)) => `(async () => {
  const bytes = Uint8Array.from(atob(${JSON.stringify(content.toString("base64"))}), (c) => c.charCodeAt(0));
  await ntcViewer.openFile(bytes, ${JSON.stringify(name)}, new Blob([bytes]));
  return { width: ntcViewer.set.width, height: ntcViewer.set.height, mips: ntcViewer.set.mips, network: ntcViewer.set.networkName };
})()`;
const decodeMip = (mip) => `ntcViewer.decoder.decodeMip(${mip}).then((texels) => new Promise((done) => {
  const reader = new FileReader();
  reader.onload = () => done(reader.result.slice(reader.result.indexOf(",") + 1));
  reader.readAsDataURL(new Blob([texels]));
}))`;

async function compareBits(browser, file) {
  const set = await browser.run(open(file));
  let words = 0;
  for (let mip = 0; mip < set.mips; mip++) {
    const [width, height] = [Math.max(set.width >> mip, 1), Math.max(set.height >> mip, 1)];
    const bytes = Buffer.from(await browser.run(decodeMip(mip)), "base64");
    const drawn = new Float32Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
    const different = countDifferentWords(drawn, sampleMip(ntc, file, mip, width, height));
    assert.equal(different, 0, `${file}: mip ${mip}: ${different} of ${drawn.length} numbers differ`);
    words += drawn.length;
  }
  console.log(`${basename(file)}: ${set.network}: ${words} numbers, none different`);
}

/** WebGPU decodes whole textures when the state says so, by itself only on GPUs; SwiftShader is none. */
async function checkWebGpu(browser, file) {
  await browser.run(open(file));
  assert.equal(await browser.run("ntcViewer.decoder.name"), "WebGL 2");
  await browser.run('ntcViewer.apply({ gpu: "webgpu" })');
  const name = await browser.run("ntcViewer.decoder.name");
  if (name === "WebGL 2") return console.log("SKIP: consumer_webgl: this Chromium has no WebGPU adapter");
  assert.match(name, /^WebGPU/);
  await compareBits(browser, file);
  await browser.run('ntcViewer.apply({ gpu: "webgl" })');
  assert.equal(await browser.run("ntcViewer.decoder.name"), "WebGL 2");
  await browser.run('ntcViewer.apply({ gpu: "auto" })');
  return undefined;
}

/** Without WebGPU the page says why, and WebGL 2 decodes. */
async function checkWithoutWebGpu(browser) {
  const { identifier } = await browser.call("Page.addScriptToEvaluateOnNewDocument", {
    source: 'Object.defineProperty(navigator, "gpu", { value: undefined })',
  });
  await openLink(browser, "#set=bricks.ntc&gpu=webgpu");
  const message = await browser.run("document.querySelector('.decoding').textContent");
  assert.equal(message, "WebGPU: this browser has no adapter; WebGL 2 decodes");
  assert.equal(await browser.run("ntcViewer.decoder.name"), "WebGL 2");
  await browser.call("Page.removeScriptToEvaluateOnNewDocument", { identifier });
}

/** A file cut short is refused in the words of `ntc info`, and what was open stays open. */
async function checkErrors(browser, file) {
  const short = join(pictures, "short.ntc");
  writeFileSync(short, readFileSync(file).subarray(0, 900));
  const told = spawnSync(ntc, ["info", short]).stderr.toString();
  const message = await browser.run(`${open(short)}.then(() => "opened", (error) => error.message)`);
  assert.ok(message.length > 10 && told.includes(message), `the page: ${message}; ntc: ${told}`);
  assert.equal(await browser.run("ntcViewer.set.name"), basename(file));
}

/** PSNR against an even grey, and by hand. */
async function checkPsnr(browser, file) {
  const set = await browser.run(open(file));
  const psnr = await browser.run(`(async () => {
    const canvas = new OffscreenCanvas(ntcViewer.set.width, ntcViewer.set.height);
    const context = canvas.getContext("2d");
    context.fillStyle = "rgb(128, 128, 128)";
    context.fillRect(0, 0, canvas.width, canvas.height);
    return ntcViewer.openReference(await canvas.convertToBlob({ type: "image/png" }), "grey " + ntcViewer.texture.name + ".png");
  })()`);
  const { firstChannel, channels } = await browser.run("({ ...ntcViewer.texture })");
  const texels = sampleMip(ntc, file, 0, set.width, set.height);
  let sum = 0;
  for (let i = 0; i < texels.length; i += 16)
    for (let c = firstChannel; c < firstChannel + channels; c++) sum += (texels[i + c] - 128 / 255) ** 2;
  const expected = -10 * Math.log10(sum / (set.width * set.height * channels));
  // 128/255 is rounded to binary32 on the device: a relative error of 2^-24 in numbers up to about 1.
  assert.ok(Math.abs(psnr - expected) < 1e-4, `PSNR ${psnr}, expected ${expected}`);
  const refusal = await browser.run(`(async () => {
    const canvas = new OffscreenCanvas(3, 5);
    canvas.getContext("2d");
    return ntcViewer.openReference(await canvas.convertToBlob(), "small.png").then(() => "", (error) => error.message);
  })()`);
  assert.equal(refusal, `small.png: 3 x 5: the texture set has ${set.width} x ${set.height}`);
}

/** An image of one grey as a file. */
async function writeGrey(browser, path, width, height) {
  const text = await browser.run(`(async () => {
    const canvas = new OffscreenCanvas(${width}, ${height});
    const context = canvas.getContext("2d");
    context.fillStyle = "rgb(128, 128, 128)";
    context.fillRect(0, 0, canvas.width, canvas.height);
    const bytes = new Uint8Array(await (await canvas.convertToBlob({ type: "image/png" })).arrayBuffer());
    return btoa(String.fromCharCode(...bytes));
  })()`);
  writeFileSync(path, Buffer.from(text, "base64"));
}

async function openLink(browser, hash) {
  await browser.go("about:blank");
  await browser.go(`${pathToFileURL(page)}${hash}`);
  await browser.run("ntcReady");
}

/** The picture that is shown after some frames: width, height, and pixels as the characters of a string. */
async function readPicture(browser, frames, name) {
  await browser.run(`ntcViewer.waitForFrames(${frames})`);
  await browser.screenshot(join(pictures, `${name}.png`));
  return browser.run(`(() => {
    ntcViewer.average.present(ntcViewer.mode);
    const gl = ntcViewer.renderer.getContext();
    const pixels = new Uint8Array(4 * gl.drawingBufferWidth * gl.drawingBufferHeight);
    gl.readPixels(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    return { width: gl.drawingBufferWidth, height: gl.drawingBufferHeight, pixels: [...pixels].map((v) => String.fromCharCode(v)).join("") };
  })()`);
}

/** The standard deviation of red in the middle rows, between two parts of the width. */
function spread(picture, x0, x1) {
  let sum = 0, squares = 0, count = 0;
  for (let y = Math.floor(0.2 * picture.height); y < 0.8 * picture.height; y++)
    for (let x = Math.floor(x0 * picture.width); x < x1 * picture.width; x++) {
      const v = picture.pixels.charCodeAt(4 * (y * picture.width + x));
      sum += v;
      squares += v * v;
      count++;
    }
  return Math.sqrt(squares / count - (sum / count) ** 2);
}

async function drawLink(browser, hash, frames, name) {
  await openLink(browser, hash);
  return readPicture(browser, frames, name);
}

async function checkLinks(browser) {
  const lit = "#set=bricks.ntc&shape=plane";
  const first = await drawLink(browser, lit, 2, "material");
  assert.ok(spread(first, 0.3, 0.7) > 8, "the middle of the picture is empty");
  await browser.run("ntcViewer.stage.setCamera([0.9, 0.4, 2.2, 0.1, 0, 0])");
  await browser.run("new Promise((resume) => setTimeout(resume, 600))");
  const hash = await browser.run("location.hash");
  assert.match(hash, /set=bricks\.ntc.*camera=0\.9/);
  await checkCoarse(browser);
  const turned = await drawLink(browser, hash, 2, "link");
  const again = await drawLink(browser, hash, 2, "link");
  assert.ok(turned.pixels !== first.pixels, "another camera gave the same picture");
  assert.ok(turned.pixels === again.pixels, "the same link gave two pictures");
  assert.equal(await browser.run("location.hash"), hash);
}

/** Until the page says what is expected, or for a minute, with what it says instead. */
async function waitFor(browser, condition) {
  for (let i = 0; i < 600 && !(await browser.run(`!!(${condition})`)); i++) await new Promise((resume) => setTimeout(resume, 100));
  assert.ok(await browser.run(`!!(${condition})`), `${condition}; the page: ${await readMessage(browser)}`);
}

function readMessage(browser) {
  return browser.run('document.getElementById("message").textContent');
}

/** Files dropped by the mouse, all at once and in an order that does not work by itself; then an image. */
async function checkDrops(browser, file) {
  await openLink(browser, "");
  const [model, grey] = ["model.glb", "grey.png"].map((name) => join(pictures, name));
  writeFileSync(model, makeModel());
  await browser.drop([model, file]);
  await waitFor(browser, "ntcViewer.stage.isModel && !ntcViewer.isCompiling");
  const set = await browser.run("({ ...ntcViewer.set, latents: 0, weights: 0, constants: 0 })");
  assert.equal(set.name, basename(file));
  const lit = await readPicture(browser, 1, "model");
  assert.ok(spread(lit, 0.3, 0.7) > 8, "the model is not there");

  await writeGrey(browser, grey, set.width, set.height);
  await browser.drop([grey]);
  await waitFor(browser, "ntcViewer.reference?.psnr");
  await browser.run('ntcViewer.apply({ comparison: "split", split: 0.5 })');
  const split = await readPicture(browser, 1, "split");
  assert.ok(spread(split, 0.35, 0.48) > 8, "the left half is not the texture");
  assert.equal(spread(split, 0.52, 0.65), 0, "the right half is not the reference");
}

/** Drops files, and waits for what the page says of them. */
async function dropAndRead(browser, files, expected) {
  await browser.drop(files);
  await waitFor(browser, `${expected}.test(document.getElementById("message").textContent)`);
}

/** A .gltf is opened with the files that it names, on the material that the set is named after; what is missing is said. */
async function checkDroppedFiles(browser, file) {
  const [text, binary, set] = ["square.gltf", "square.bin", "square.ntc"].map((name) => join(pictures, name));
  const model = makeModelFiles("square");
  writeFileSync(text, model.text);
  writeFileSync(binary, model.binary);
  writeFileSync(set, readFileSync(file));
  await dropAndRead(browser, [pictures], /cannot be read: if it is a folder, drop the files in it$/);
  await dropAndRead(browser, [text], /^square\.gltf: the model names square\.bin: drop both together$/);
  await browser.run('ntcViewer.apply({ view: "material", shape: "plane", modelMaterial: "" })');
  await browser.drop([binary, text, set]);
  await waitFor(browser, "ntcViewer.stage.isModel && !ntcViewer.isCompiling");
  assert.deepEqual(await browser.run("[ntcViewer.set.name, ntcViewer.state.modelMaterial]"), ["square.ntc", "square"]);
}

/** Keys turn the shape and open the list of them, which fits into a narrow page and is closed by Escape. */
async function checkKeys(browser) {
  const place = () => browser.run("ntcViewer.stage.getCamera()");
  await browser.run('document.getElementById("picture").focus()');
  const before = await place();
  await browser.press("ArrowRight");
  assert.notDeepEqual(await place(), before);
  await browser.press("ArrowLeft");
  assert.deepEqual(await place(), before);
  await browser.call("Emulation.setDeviceMetricsOverride", { width: 360, height: 640, deviceScaleFactor: 1, mobile: false });
  await browser.press("?");
  const fits = await browser.run(`(() => {
    const [inner, outer] = ["#help", "main"].map((name) => document.querySelector(name).getBoundingClientRect());
    return inner.height > 0 && inner.top >= outer.top && inner.bottom <= outer.bottom && inner.left >= 0 && inner.right <= outer.right;
  })()`);
  assert.ok(fits, "the list of keys is cut off");
  await browser.press("Escape");
  assert.ok(await browser.run('document.getElementById("help").hidden'));
  await browser.call("Emulation.setDeviceMetricsOverride", { width: WIDTH, height: HEIGHT, deviceScaleFactor: 1, mobile: false });
}

/** On a slow device a coarse picture comes first. */
async function checkCoarse(browser) {
  const widths = await browser.run(`(async () => {
    const widths = [];
    const note = () => widths.push(ntcViewer.average.partWidth);
    ntcViewer.addEventListener("frame", note);
    ntcViewer.pace.perPixel = 1; // ms
    ntcViewer.touch(false);
    await ntcViewer.waitForFrames(1);
    ntcViewer.removeEventListener("frame", note);
    return [widths[0], widths.at(-1), ntcViewer.average.width];
  })()`);
  assert.equal(widths[1], widths[2]);
  assert.ok(widths[0] <= widths[2] / 4, `the first picture has ${widths[0]} of ${widths[2]} pixels a row`);
}

/** A texture of smoothness is the inverse of one of roughness. */
async function checkSmoothness(browser, file) {
  const renamed = Buffer.from(readFileSync(file).toString("latin1").replaceAll("Roughness", "Smoothnes"), "latin1");
  await browser.run(open(file, "renamed.ntc", renamed));
  const { smoothness, roughness } = await browser.run("ntcViewer.material.userData.ntcRoles");
  assert.ok(smoothness > 0 && roughness === undefined);
  const smooth = await readPicture(browser, 1, "smoothness");
  await browser.run(open(file));
  const rough = await readPicture(browser, 1, "roughness");
  assert.notEqual(smooth.pixels, rough.pixels);
}

/** A set with holes on a cube: its camera shows three sides, and what is behind is seen through them. */
async function checkHoles(browser) {
  const cube = await drawLink(browser, "#set=grille.ntc&shape=cube", 1, "cube");
  assert.ok(spread(cube, 0.3, 0.7) > 8, "the cube is not there");
  assert.equal(await browser.run("ntcViewer.material.side"), 2); // three.js's DoubleSide
  assert.ok((await browser.run("ntcViewer.stage.camera.position.x")) > 1, "the cube has another shape's camera");
}

/** The picture of a screenshot, by the page itself. */
async function readScreenshot(browser, name) {
  const path = join(pictures, `${name}.png`);
  await browser.screenshot(path);
  return browser.run(`(async () => {
    const bytes = Uint8Array.from(atob("${readFileSync(path).toString("base64")}"), (c) => c.charCodeAt(0));
    const image = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    const canvas = new OffscreenCanvas(image.width, image.height);
    const context = canvas.getContext("2d");
    context.drawImage(image, 0, 0);
    const { data, width, height } = context.getImageData(0, 0, image.width, image.height);
    return { width, height, pixels: [...data].map((v) => String.fromCharCode(v)).join("") };
  })()`);
}

/** The page that docs/engines/webgl.md shows, beside the module and the sample as that page says. */
async function checkDocumented(browser, file) {
  const text = readFileSync(documentation, "utf8");
  const block = /```html\n([^]*?)```/.exec(text)[1];
  const modules = join(dirname(page), "../examples/webgl");
  const read = (path) => {
    if (path === "/index.html") return block;
    const from = { "/openntc-three.js": join(dirname(page), "openntc-three.js"), [`/${basename(file)}`]: file }[path] ?? join(modules, path);
    return existsSync(from) ? readFileSync(from) : undefined;
  };
  await withSite(read, async (address) => {
    await browser.go(address);
    const isEmpty = (picture) => spread(picture, 0.1, 0.6) <= 8;
    let picture = await readScreenshot(browser, "documented");
    for (let i = 0; i < 60 && isEmpty(picture); i++) {
      await new Promise((resume) => setTimeout(resume, 500));
      picture = await readScreenshot(browser, "documented");
    }
    assert.ok(!isEmpty(picture), "the page of docs/engines/webgl.md stays empty");
    const texel = () => browser.run('document.getElementById("texel").textContent');
    for (let i = 0; i < 600 && (await texel()) === ""; i++) await new Promise((resume) => setTimeout(resume, 100));
    assert.equal(await texel(), sampleTexels(ntc, file, ["0 10 20"]).join(" "));
  });
}

async function saySpeed(browser, file) {
  await browser.run(open(file));
  const device = await browser.run(`(() => {
    const gl = ntcViewer.renderer.getContext();
    return gl.getParameter(gl.getExtension("WEBGL_debug_renderer_info")?.UNMASKED_RENDERER_WEBGL ?? gl.RENDERER);
  })()`);
  const texels = await browser.run("ntcViewer.decoder.measureSpeed()");
  console.log(`${basename(file)}: WebGL 2: ${(texels / 1e6).toFixed(2)} million texels a second on ${device}`);
}

const browser = new Browser(chromium, driver, WIDTH, HEIGHT);
try {
  await browser.open(pathToFileURL(page).href, WIDTH, HEIGHT);
  await browser.run("ntcReady");
  await browser.run("ntcViewer.step = () => {}, 0"); // numbers alone: nothing is drawn
  await checkFailedCompilation(browser, open(sets[0]));
  await browser.run("ntcViewer.compile = async () => {}, 0");
  for (const file of sets) await compareBits(browser, file);
  await checkErrors(browser, sets.at(-1));
  await checkRefusals(browser, open(sets.find((file) => basename(file) === "gen2.ntc")));
  await checkWebGpu(browser, sets[1]);
  await checkPsnr(browser, sets[0]);
  await saySpeed(browser, sets[0]);
  const model = join(pictures, "model.glb");
  writeFileSync(model, makeModel());
  await checkModelLink(browser, openLink, open, sets[1], model);
  await checkOtherLinks(browser, open, sets[2]);
  if (driver === "llvmpipe") { // minutes on SwiftShader
    await checkLinks(browser);
    await checkHoles(browser);
    await checkWithoutWebGpu(browser);
    await checkDrops(browser, sets[0]);
    await checkDroppedFiles(browser, sets[0]);
    await checkKeys(browser);
    await checkSmoothness(browser, sets[0]);
    await checkDocumented(browser, sets[0]);
  }
  assert.deepEqual(browser.getComplaints(), []);
} catch (error) {
  console.error(browser.logs.join("\n"));
  throw error;
} finally {
  await browser.close();
}
