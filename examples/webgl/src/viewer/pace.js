// SPDX-License-Identifier: MIT
// How much to draw at once, from how long the device took before: WebGL's fences say when it was done.

const STEP = 80; // ms for a band of rows
const MOTION = 40; // ms for a frame while something moves
const PATIENCE = 250; // ms for a frame after which a coarse one comes first
const FIRST_ROWS = 32;
const LEAST_ROWS = 4;
const SCALES = [1, 0.5, 0.25, 0.125];

export class Pace {
  constructor(gl) {
    this.gl = gl;
    this.fence = null;
    this.perPixel = 0; // ms
  }

  /** Notes that so many pixels were given to the device. */
  begin(pixels) {
    this.fence = this.gl.fenceSync(this.gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    this.gl.flush();
    this.pixels = pixels;
    this.since = performance.now();
  }

  /** True if all that was given to it is done. */
  isReady() {
    if (this.fence === null) return true;
    if (this.gl.clientWaitSync(this.fence, 0, 0) === this.gl.TIMEOUT_EXPIRED) return false;
    this.gl.deleteSync(this.fence);
    this.fence = null;
    const measured = (performance.now() - this.since) / this.pixels;
    this.perPixel = this.perPixel === 0 ? measured : this.perPixel + 0.3 * (measured - this.perPixel);
    return true;
  }

  getRows(width) {
    if (this.perPixel === 0) return FIRST_ROWS;
    return Math.max(LEAST_ROWS, Math.floor(STEP / (this.perPixel * width)));
  }

  /** True if a frame of so many pixels takes long, or nobody knows yet. */
  isSlow(pixels) {
    return this.perPixel === 0 || pixels * this.perPixel > PATIENCE;
  }

  /** The part of each side that a frame of so many pixels has while something moves. */
  getScale(pixels) {
    if (this.perPixel === 0) return SCALES.at(-1);
    return SCALES.find((scale) => pixels * scale * scale * this.perPixel <= MOTION) ?? SCALES.at(-1);
  }
}
