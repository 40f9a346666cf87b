// SPDX-License-Identifier: MIT
// What is drawn: a shape or a model under studio light, or a texture flat, each with its camera and controls.
import {
  BoxGeometry, DirectionalLight, DoubleSide, Euler, FrontSide, Group, Mesh, OrthographicCamera, PerspectiveCamera, PlaneGeometry,
  PMREMGenerator, Scene, SphereGeometry, Spherical, Vector3, MOUSE, TOUCH,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { RoomEnvironment } from "three/addons/environments/RoomEnvironment.js";
import { readModel } from "./model.js";

const SHAPES = {
  sphere: { make: () => new SphereGeometry(1, 96, 64), tiles: [4, 2], from: [0, 0.5, 3.2] },
  cube: { make: () => new BoxGeometry(1.3, 1.3, 1.3), tiles: [1, 1], from: [1.7, 1.35, 2.6] },
  plane: { make: () => new PlaneGeometry(2, 2), tiles: [1, 1], from: [0.5, 0.35, 2.6] },
};
const DISTANCE = 3.55;
const TURN = Math.PI / 24; // of a key
const [LEAST_ZOOM, MOST_ZOOM] = [0.2, 256];

/** Shapes of three.js have v upwards; texture sets and glTF downwards. `tiles`: how often the texture is repeated. */
function prepareGeometry(geometry, [u, v]) {
  const uv = geometry.getAttribute("uv");
  for (let i = 0; i < uv.count; i++) uv.setXY(i, uv.getX(i) * u, (1 - uv.getY(i)) * v);
  return geometry;
}

export class Stage {
  constructor(renderer, element, onChange) {
    this.onChange = onChange;
    this.scene = new Scene();
    this.scene.environmentIntensity = 0.75;
    this.scene.environment = new PMREMGenerator(renderer).fromScene(new RoomEnvironment(), 0.04).texture;
    this.key = new DirectionalLight(0xfff4e6, 2.2);
    this.scene.add(this.key);
    this.object = new Group();
    this.scene.add(this.object);
    this.camera = new PerspectiveCamera(38, 1, 0.05, 50);
    this.controls = new OrbitControls(this.camera, element);
    this.flatScene = new Scene();
    this.flat = new Mesh(prepareGeometry(new PlaneGeometry(1, 1), [1, 1]));
    this.flatScene.add(this.flat);
    this.flatCamera = new OrthographicCamera(-1, 1, 1, -1, 0.1, 10);
    this.flatControls = new OrbitControls(this.flatCamera, element);
    Object.assign(this.flatControls, {
      enableRotate: false, zoomToCursor: true, minZoom: LEAST_ZOOM, maxZoom: MOST_ZOOM,
      mouseButtons: { LEFT: MOUSE.PAN, MIDDLE: MOUSE.DOLLY, RIGHT: MOUSE.PAN }, touches: { ONE: TOUCH.PAN, TWO: TOUCH.DOLLY_PAN },
    });
    for (const controls of [this.controls, this.flatControls]) controls.addEventListener("change", onChange);
    this.model = null;
    this.setShape("sphere");
    this.setFlat(false);
    this.setLight(0);
    this.resetCamera();
  }

  setFlat(isFlat) {
    this.isFlat = isFlat;
    this.controls.enabled = !isFlat;
    this.flatControls.enabled = isFlat;
  }

  get view() {
    return this.isFlat ? { scene: this.flatScene, camera: this.flatCamera } : { scene: this.scene, camera: this.camera };
  }

  get isModel() {
    return this.shape === "model" && this.model !== null;
  }

  setShape(name) {
    if (name === this.shape) return;
    this.shape = name;
    this.fillObject();
    this.resetShapeCamera();
  }

  /** A model that is not there yet has a sphere in its place. */
  fillObject() {
    const { make, tiles } = SHAPES[this.shape] ?? SHAPES.sphere;
    this.object.clear();
    this.object.add(this.isModel ? this.model : new Mesh(prepareGeometry(make(), tiles)));
  }

  /** Meshes and their texture coordinates (model.js). @returns names of its materials. */
  async loadModel(bytes, files) {
    const model = await readModel(bytes, files);
    const isAwaited = this.shape === "model" && this.model === null; // with the camera of a link
    this.model = model;
    this.shape = "model";
    this.fillObject();
    if (!isAwaited) this.resetShapeCamera();
    const names = new Set();
    this.eachMesh((mesh) => {
      mesh.userData.own = mesh.material;
      names.add(mesh.material.name || "(unnamed)");
    });
    return [...names];
  }

  eachMesh(visit) {
    this.object.traverse((node) => node.isMesh && visit(node));
  }

  /** `materialName`: of a model, the one whose place is taken; "" for all. */
  setMaterial(material, materialName) {
    const isClosed = this.shape === "sphere" || this.shape === "cube";
    material.side = isClosed && !material.userData.ntcHasHoles ? FrontSide : DoubleSide;
    this.eachMesh((mesh) => {
      const { own } = mesh.userData;
      const isOurs = !own || materialName === "" || materialName === (own.name || "(unnamed)");
      mesh.material = isOurs && mesh.geometry.getAttribute("uv") ? material : own ?? material;
    });
  }

  setFlatMaterial(material, width, height) {
    this.flat.material = material;
    this.flat.scale.set(width / Math.max(width, height), height / Math.max(width, height), 1);
  }

  setLight(degrees) {
    const angle = (degrees * Math.PI) / 180;
    this.scene.environmentRotation = new Euler(0, angle, 0);
    this.key.position.set(Math.sin(angle + 0.9) * 3, 2.6, Math.cos(angle + 0.9) * 3);
  }

  resize(width, height) {
    this.camera.aspect = width / height;
    this.camera.fov = 2 * Math.atan(Math.tan((19 * Math.PI) / 180) * Math.max(1, height / width)) * (180 / Math.PI);
    this.camera.updateProjectionMatrix();
    const half = 0.56 * Math.max(1, height / width);
    Object.assign(this.flatCamera, { left: (-half * width) / height, right: (half * width) / height, top: half, bottom: -half });
    this.flatCamera.updateProjectionMatrix();
  }

  resetShapeCamera() {
    const from = SHAPES[this.shape]?.from ?? [1.6, 0.9, 2.8];
    this.camera.position.set(...from).setLength(DISTANCE);
    this.controls.target.set(0, 0, 0);
    this.controls.update();
  }

  resetCamera() {
    this.resetShapeCamera();
    this.flatCamera.position.set(0, 0, 5);
    this.flatCamera.zoom = 1;
    this.flatCamera.updateProjectionMatrix();
    this.flatControls.target.set(0, 0, 0);
    this.flatControls.update();
  }

  /** Steps to the right and down: around the shape, or of what is flat. */
  turn(right, down) {
    if (this.isFlat) {
      const step = 0.1 / this.flatCamera.zoom;
      this.setCamera([this.flatCamera.position.x + right * step, this.flatCamera.position.y - down * step, this.flatCamera.zoom]);
    } else {
      const { position } = this.camera;
      const at = new Spherical().setFromVector3(position.clone().sub(this.controls.target));
      at.theta += right * TURN;
      at.phi += down * TURN;
      position.setFromSpherical(at.makeSafe()).add(this.controls.target);
      this.controls.update();
    }
    this.onChange();
  }

  zoom(factor) {
    if (this.isFlat) {
      const { x, y } = this.flatCamera.position;
      this.setCamera([x, y, Math.min(Math.max(this.flatCamera.zoom * factor, LEAST_ZOOM), MOST_ZOOM)]);
    } else {
      this.camera.position.sub(this.controls.target).divideScalar(factor).add(this.controls.target);
      this.controls.update();
    }
    this.onChange();
  }

  /** The camera as numbers, and back: for links. */
  getCamera() {
    const round = (x) => +x.toFixed(4);
    const { position } = this.camera;
    if (!this.isFlat) return [...position, ...this.controls.target].map(round);
    return [this.flatCamera.position.x, this.flatCamera.position.y, this.flatCamera.zoom].map(round);
  }

  setCamera(numbers) {
    if (numbers.length === 6) {
      this.camera.position.set(...numbers.slice(0, 3));
      this.controls.target.set(...numbers.slice(3));
      this.controls.update();
    } else if (numbers.length === 3) {
      const [x, y, zoom] = numbers;
      this.flatCamera.position.set(x, y, 5);
      this.flatControls.target.set(x, y, 0);
      this.flatCamera.zoom = zoom;
      this.flatCamera.updateProjectionMatrix();
      this.flatControls.update();
    }
  }
}
