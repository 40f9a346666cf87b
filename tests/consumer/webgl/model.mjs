// SPDX-License-Identifier: MIT

/** One square with texture coordinates and a material, in a scene that is not said to be the default; its buffer is named by `uri`. */
function makeParts(uri, rest = {}) {
  const positions = [-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0];
  const normals = [0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1];
  const uvs = [0, 1, 1, 1, 1, 0, 0, 0];
  const numbers = Buffer.from(Float32Array.from([...positions, ...normals, ...uvs]).buffer);
  const indices = Buffer.from(Uint16Array.of(0, 1, 2, 0, 2, 3).buffer);
  const binary = Buffer.concat([numbers, indices]);
  const view = (byteOffset, byteLength) => ({ buffer: 0, byteOffset, byteLength });
  const document = {
    asset: { version: "2.0" },
    scenes: [{ nodes: [0] }],
    nodes: [{ mesh: 0 }],
    materials: [{ name: "square" }],
    ...rest,
    meshes: [{ primitives: [{ attributes: { POSITION: 0, NORMAL: 1, TEXCOORD_0: 2 }, indices: 3, material: 0 }] }],
    buffers: [{ byteLength: binary.length, uri }],
    bufferViews: [view(0, 48), view(48, 48), view(96, 32), view(128, 12)],
    accessors: [
      { bufferView: 0, componentType: 5126, count: 4, type: "VEC3", min: [-1, -1, 0], max: [1, 1, 0] },
      { bufferView: 1, componentType: 5126, count: 4, type: "VEC3" },
      { bufferView: 2, componentType: 5126, count: 4, type: "VEC2" },
      { bufferView: 3, componentType: 5123, count: 6, type: "SCALAR" },
    ],
  };
  return { document, binary };
}

/** As a .gltf that names NAME.bin, and an image that there is not. */
export function makeModelFiles(name) {
  const materials = [{ name: "square", pbrMetallicRoughness: { baseColorTexture: { index: 0 } } }];
  const { document, binary } = makeParts(`${name}.bin`, { materials, textures: [{ source: 0 }], images: [{ uri: "textures/missing.png" }] });
  return { text: JSON.stringify(document), binary };
}

/** As a .glb. */
export function makeModel() {
  const { document, binary } = makeParts(undefined);
  const text = JSON.stringify(document);
  const json = Buffer.from(text.padEnd(Math.ceil(text.length / 4) * 4));
  const chunk = (bytes, type) => Buffer.concat([Buffer.from(Uint32Array.of(bytes.length, type).buffer), bytes]);
  const body = Buffer.concat([chunk(json, 0x4e4f534a), chunk(binary, 0x004e4942)]);
  return Buffer.concat([Buffer.from("glTF"), Buffer.from(Uint32Array.of(2, 12 + body.length).buffer), body]);
}
