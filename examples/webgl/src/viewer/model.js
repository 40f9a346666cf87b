// SPDX-License-Identifier: MIT
// Models from the disk: a .glb, or a .gltf with the files that it names.
import { Box3, Group, LoadingManager, Vector3 } from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

const IMAGE = /\.(png|jpe?g|webp|avif|ktx2|basis)$/i;
/** In the place of images that were not dropped: one white texel. */
const WHITE = "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR42mP4DwABAQEAHLCMmQAAAABJRU5ErkJggg==";

/** @param {Map<string, Blob>} files that the model may name, by their names without folders. */
async function parse(bytes, files) {
  const addresses = new Map();
  const manager = new LoadingManager();
  manager.setURLModifier((url) => {
    if (/^(data|blob):/.test(url)) return url;
    const name = decodeURIComponent(url).split(/[\\/]/).at(-1);
    if (!files.has(name)) {
      if (IMAGE.test(name)) return WHITE;
      throw new Error(`the model names ${name}: drop both together`);
    }
    if (!addresses.has(name)) addresses.set(name, URL.createObjectURL(files.get(name)));
    return addresses.get(name);
  });
  try {
    return await new GLTFLoader(manager).parseAsync(bytes, "");
  } finally {
    for (const address of addresses.values()) URL.revokeObjectURL(address);
  }
}

/** The model in a group, two units large and in the middle. @throws what is wrong with it. */
export async function readModel(bytes, files) {
  const file = await parse(bytes, files);
  const scene = file.scene ?? file.scenes[0] ?? new Group(); // glTF need not say which it shows
  const box = new Box3().setFromObject(scene);
  if (box.isEmpty()) throw new Error("model: no mesh");
  const size = box.getSize(new Vector3());
  const holder = new Group();
  scene.position.sub(box.getCenter(new Vector3()));
  holder.add(scene);
  holder.scale.setScalar(2 / Math.max(size.x, size.y, size.z));
  return holder;
}
