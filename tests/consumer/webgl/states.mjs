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

const entriesOf = (hash) => Object.fromEntries(new URLSearchParams(hash.replace("#", "")));

/** Waits until an expression of the page is true. */
async function waitFor(browser, expression) {
  for (let i = 0; i < 100; i++) {
    if (await browser.run(expression)) return;
    await new Promise((resume) => setTimeout(resume, 50));
  }
  assert.fail(`not within five seconds: ${expression}`);
}

const MESSAGE = 'document.getElementById("message").textContent';
const QUIET = "ntcViewer.compile = async () => {}, ntcViewer.step = () => {}, 0"; // nothing is drawn

/** Files are opened one after the other: the link's view waits for its set and for its model. @param open of page_test.mjs. */
export async function checkModelLink(browser, openLink, open, file, model) {
  const link = "#set=mine.ntc&view=textures&onShape=1&shape=model&light=30&modelMaterial=square&camera=1,0.5,2,0.1,0,0";
  await openLink(browser, link);
  await browser.run(QUIET);
  assert.equal(await browser.run('document.getElementById("wanted").textContent'), "This link shows mine.ntc: drop that file here.");
  await browser.run(open(file, "mine.ntc"));
  assert.equal(await browser.run(MESSAGE), "This link shows a model: drop it here.");
  assert.equal(await browser.run("ntcViewer.stage.isModel"), false);
  const checkView = async () => {
    await waitFor(browser, 'location.hash.includes("texture=")');
    await new Promise((resume) => setTimeout(resume, 400)); // until the address is the view
    const { texture, ...rest } = entriesOf(await browser.run("location.hash"));
    assert.equal(texture, await browser.run("ntcViewer.texture.name"));
    assert.deepEqual(rest, entriesOf(link));
  };
  await checkView();
  await browser.run(open(model, "model.glb"));
  assert.equal(await browser.run("ntcViewer.stage.isModel"), true);
  await checkView();
}

/** A link in the page that is open, also just after a change; a reference keeps its comparison; another set is waited for. */
export async function checkOtherLinks(browser, open, file) {
  const camera = "0.1,0.2,2";
  await browser.run(`ntcViewer.apply({ light: 77 }), location.hash = "#set=mine.ntc&view=textures&comparison=split&split=0.25&camera=${camera}", 0`);
  await waitFor(browser, 'ntcViewer.state.comparison === "split"');
  assert.deepEqual(await browser.run("[ntcViewer.state.light, ntcViewer.state.split, ntcViewer.stage.getCamera().join()]"), [0, 0.25, camera]);
  const drop = `(async () => {
    const image = new OffscreenCanvas(ntcViewer.set.width, ntcViewer.set.height);
    image.getContext("2d");
    await ntcViewer.openReference(await image.convertToBlob(), "a.png");
    return [ntcViewer.state.comparison, ntcViewer.state.split, ntcViewer.stage.getCamera().join()];
  })()`;
  assert.deepEqual(await browser.run(drop), ["split", 0.25, camera]);
  await browser.run('ntcViewer.apply({ comparison: "decoded" })');
  assert.deepEqual(await browser.run(drop), ["difference", 0.25, camera]);

  await browser.run('ntcViewer.apply({ gain: 3 }), location.hash = "#set=other.ntc&shape=cube&camera=2,1,2,0,0,0", 0');
  await waitFor(browser, `${MESSAGE} === "This link shows other.ntc: drop that file here."`);
  await new Promise((resume) => setTimeout(resume, 400)); // in which the view would be written over the link
  assert.match(await browser.run("location.hash"), /other\.ntc/);
  assert.equal(await browser.run("ntcViewer.state.view"), "textures");
  await browser.run("ntcViewer.apply({ light: 10 })");
  await browser.run(open(file, "other.ntc"));
  assert.deepEqual(
    await browser.run("[ntcViewer.state.view, ntcViewer.state.shape, ntcViewer.state.light, ntcViewer.stage.getCamera().join()]"),
    ["material", "cube", 0, "2,1,2,0,0,0"],
  );
}
