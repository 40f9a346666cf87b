// SPDX-License-Identifier: MIT
import { BufferGeometry, Camera, Float32BufferAttribute, Mesh, Scene } from "three";

/** A triangle that covers the target, drawn with a ShaderMaterial. */
export class FullScreenPass {
  static VERTEX = `
varying vec2 vUv;
void main() {
  vUv = position.xy * 0.5 + 0.5;
  gl_Position = vec4(position.xy, 0.0, 1.0);
}`;

  constructor(material) {
    this.material = material;
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new Float32BufferAttribute([-1, -1, 0, 3, -1, 0, -1, 3, 0], 3));
    this.mesh = new Mesh(geometry, material);
    this.mesh.frustumCulled = false;
    this.scene = new Scene();
    this.scene.add(this.mesh);
    this.camera = new Camera();
  }

  render(renderer, target) {
    const before = renderer.getRenderTarget();
    const autoClear = renderer.autoClear;
    renderer.autoClear = false;
    renderer.setRenderTarget(target);
    renderer.render(this.scene, this.camera);
    renderer.setRenderTarget(before);
    renderer.autoClear = autoClear;
  }

  dispose() {
    this.mesh.geometry.dispose();
    this.material.dispose();
  }
}
