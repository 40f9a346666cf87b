// SPDX-License-Identifier: MIT
// A page in Chromium, driven through its debugging pipe: no server, no port, no package.
import { spawn } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

const FLAGS = [
  "--no-sandbox", "--no-first-run", "--disable-background-networking", "--disable-extensions", "--disable-dev-shm-usage", "--hide-scrollbars",
  "--force-device-scale-factor=1", "--disable-gpu-watchdog", "--ignore-gpu-blocklist", "--mute-audio", "--remote-debugging-pipe",
];
/** Mesa's llvmpipe is many times as fast as SwiftShader, and needs a display. */
export const DRIVERS = {
  llvmpipe: ["--use-gl=angle", "--use-angle=gl-egl"],
  swiftshader: ["--headless=new", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
};
/** Chromium's Dawn has SwiftShader alone on a machine without a GPU, and only when told so. */
const WEBGPU = ["--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader"];

export class Browser {
  constructor(program, driver, width, height) {
    this.profile = mkdtempSync(join(tmpdir(), "ntc-webgl-"));
    const command = [program, ...FLAGS, ...WEBGPU, ...DRIVERS[driver], `--user-data-dir=${this.profile}`, `--window-size=${width},${height}`, "about:blank"];
    if (driver === "llvmpipe") command.unshift("xvfb-run", "-a", "-s", `-screen 0 ${width}x${height + 200}x24`);
    this.child = spawn(command[0], command.slice(1), { stdio: ["ignore", "ignore", "pipe", "pipe", "pipe"], detached: true });
    this.errors = "";
    this.child.stderr.on("data", (data) => (this.errors += data));
    this.waiting = new Map();
    this.logs = [];
    this.last = 0;
    this.ended = new Promise((resolve) => this.child.on("exit", resolve));
    let rest = Buffer.alloc(0);
    this.child.stdio[4].on("data", (data) => {
      rest = Buffer.concat([rest, data]);
      for (let end = rest.indexOf(0); end >= 0; end = rest.indexOf(0)) {
        this.receive(JSON.parse(rest.subarray(0, end).toString()));
        rest = rest.subarray(end + 1);
      }
    });
  }

  receive(message) {
    if (message.method === "Runtime.consoleAPICalled")
      this.logs.push(`${message.params.type}: ${message.params.args.map((a) => a.value ?? a.description).join(" ")}`);
    if (message.method === "Runtime.exceptionThrown") this.logs.push(`exception: ${message.params.exceptionDetails.exception?.description}`);
    const resolve = this.waiting.get(message.id);
    this.waiting.delete(message.id);
    resolve?.(message);
  }

  /** What the page has logged that is an error or a warning. */
  getComplaints() {
    return this.logs.filter((line) => /^(error|exception|warning)/.test(line));
  }

  async call(method, params = {}, session = this.session) {
    const id = ++this.last;
    this.child.stdio[3].write(`${JSON.stringify({ id, method, params, sessionId: session })}\0`);
    const ended = this.ended.then(() => ({ error: { message: `the browser has ended: ${this.errors.slice(-2000)}` } }));
    const answer = await Promise.race([new Promise((resolve) => this.waiting.set(id, resolve)), ended]);
    if (answer.error) throw new Error(`${method}: ${answer.error.message}`);
    return answer.result;
  }

  async open(address, width, height) {
    const { targetInfos } = await this.call("Target.getTargets", {}, undefined);
    const { targetId } = targetInfos.find(({ type }) => type === "page");
    this.session = (await this.call("Target.attachToTarget", { targetId, flatten: true }, undefined)).sessionId;
    await this.call("Runtime.enable");
    await this.call("Page.enable");
    await this.call("Emulation.setDeviceMetricsOverride", { width, height, deviceScaleFactor: 1, mobile: false });
    await this.go(address);
  }

  async go(address) {
    await this.call("Page.navigate", { url: address });
    await this.run("new Promise((done) => document.readyState === 'complete' ? done() : addEventListener('load', done))");
  }

  /** The value of an expression or promise in the page. */
  async run(expression) {
    const { result, exceptionDetails } = await this.call("Runtime.evaluate", { expression, awaitPromise: true, returnByValue: true });
    if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
    return result.value;
  }

  /** A key of the keyboard, by its name in DOM events. */
  async press(key) {
    const text = key.length === 1 ? key : undefined;
    for (const type of ["keyDown", "keyUp"]) await this.call("Input.dispatchKeyEvent", { type, key, text: type === "keyDown" ? text : undefined });
  }

  /** Files dropped in the middle of the page. */
  async drop(files) {
    const data = { items: [], files, dragOperationsMask: 1 };
    for (const type of ["dragEnter", "dragOver", "drop"]) await this.call("Input.dispatchDragEvent", { type, x: 200, y: 150, data });
  }

  async screenshot(path) {
    const { data } = await this.call("Page.captureScreenshot", { format: "png" });
    writeFileSync(path, Buffer.from(data, "base64"));
  }

  async close() {
    await this.call("Browser.close", {}, undefined).catch(() => {});
    await Promise.race([this.ended, new Promise((resume) => setTimeout(resume, 3000))]);
    try {
      process.kill(-this.child.pid); // what is left of its group
    } catch {
      // nothing
    }
    try {
      rmSync(this.profile, { recursive: true, force: true, maxRetries: 5, retryDelay: 200 });
    } catch (error) {
      console.log(`${this.profile} stays: ${error.message}`); // not in the place of what the test has to say
    }
  }
}
