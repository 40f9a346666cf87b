// SPDX-License-Identifier: MIT
// States of the viewer without pictures.
import assert from "node:assert/strict";

/** What an image cannot hold is refused, and an unknown filter. */
export async function checkRefusals(browser, openWide) {
  const message = (work) => browser.run(`(async () => ${work})().then(() => "", (error) => error.message)`);
  await browser.run(openWide); // a set with a texture of more than four channels
  const [name, channels] = await browser.run("[ntcViewer.texture.name, ntcViewer.texture.channels]");
  assert.ok(channels > 4);
  const image = 'new OffscreenCanvas(ntcViewer.set.width, ntcViewer.set.height)';
  assert.equal(
    await message(`{ const image = ${image}; image.getContext("2d"); await ntcViewer.openReference(await image.convertToBlob(), "a.png"); }`),
    `${name}: ${channels} channels: an image has 1 ... 4`,
  );
  assert.equal(await browser.run("ntcViewer.references.size"), 0);
  await browser.run('ntcViewer.apply({ view: "textures" })');
  const save = '[...document.querySelectorAll("button")].find(({ textContent }) => textContent === "Save this texture as PNG").click()';
  const said = await browser.run(`(async () => {
    const message = document.getElementById("message");
    message.textContent = "";
    ${save};
    for (let i = 0; i < 100 && message.textContent === ""; i++) await new Promise((resume) => setTimeout(resume, 50));
    return message.textContent;
  })()`);
  assert.equal(said, `PNG: ${channels} channels: a PNG has 1 ... 4`);
  assert.equal(
    await message('ntcViewer.textures.setFilter({ kernel: "lanczos" })'),
    "kernel: lanczos: one of nearest, bilinear, cubic, catmull-rom, mitchell, gaussian",
  );
  assert.match(await message('ntcViewer.textures.setFilter({ kernel: "constructor" })'), /^kernel: constructor: one of/);
}

/** A program that does not compile leaves the page alive. */
export async function checkFailedCompilation(browser, open) {
  const [message, isCompiling] = await browser.run(`(async () => {
    const { renderer } = ntcViewer;
    const { compileAsync } = renderer;
    renderer.compileAsync = () => Promise.reject(new Error("no such program"));
    const message = await ${open}.then(() => "", (error) => error.message);
    renderer.compileAsync = compileAsync;
    return [message, ntcViewer.isCompiling];
  })()`);
  assert.equal(message, "no such program");
  assert.equal(isCompiling, false, "nothing would be drawn any more");
}
