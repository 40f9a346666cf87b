// SPDX-License-Identifier: MIT
// The C++ reader (Reader.cpp) as WebAssembly: the same checks and the same messages as in every other program.
import wasm from "openntc:reader.wasm";

const SPACES = ["linear", "sRGB", "HLG"];
const FORMATS = ["UNKNOWN", "UNORM8", "UNORM16", "FLOAT16", "FLOAT32", "UINT32"];
const BLOCKS = ["none", "BC1", "BC2", "BC3", "BC4", "BC5", "BC6H", "BC7"];
const NETWORKS = ["", "small", "medium", "large", "xlarge", "gen2", "gen3"];

let starting = null;

/** The reader does no input or output; whatever else a toolchain's runtime asks for must not be reached. */
async function start() {
  const module = await WebAssembly.compile(wasm);
  const imports = {};
  for (const { module: from, name } of WebAssembly.Module.imports(module)) {
    imports[from] ??= {};
    imports[from][name] =
      name === "emscripten_notify_memory_growth"
        ? () => {}
        : () => {
            throw new Error(`reader: ${name} called`);
          };
  }
  const { exports } = await WebAssembly.instantiate(module, imports);
  exports._initialize();
  return exports;
}

function readText(memory, address, bytes) {
  return new TextDecoder().decode(memory.subarray(address, address + bytes));
}

function describeTexture(memory, words) {
  const [name, nameBytes, firstChannel, channels, format, rgbSpace, alphaSpace, block] = words;
  return {
    name: readText(memory, name, nameBytes),
    firstChannel,
    channels,
    format: FORMATS[format],
    colorSpace: SPACES[rgbSpace],
    alphaColorSpace: SPACES[alphaSpace],
    blockFormat: BLOCKS[block],
  };
}

/**
 * Reads a texture set of any generation with Int8 weights.
 * @param {ArrayBuffer | Uint8Array} file
 * @returns {Promise<object>} width, height, channels, mips, generation, network (number) and networkName, fileBytes, textures, and
 *   constants (624 bytes), weights and latents as shaders read them.
 * @throws {Error} one line: field, value, limit.
 */
export async function openTextureSet(file) {
  starting ??= start();
  const reader = await starting;
  const bytes = file instanceof Uint8Array ? file : new Uint8Array(file);
  const place = reader.ReserveFile(bytes.length) >>> 0;
  if (place === 0) throw new Error(bytes.length === 0 ? "0 bytes: no texture set" : `${bytes.length} bytes: out of memory`);
  new Uint8Array(reader.memory.buffer).set(bytes, place);
  const error = reader.OpenSet() >>> 0;
  const memory = new Uint8Array(reader.memory.buffer);
  if (error !== 0) throw new Error(readText(memory, error, memory.indexOf(0, error) - error));
  const words = new Uint32Array(memory.buffer, reader.GetSet() >>> 0, 13);
  const copy = (at) => memory.slice(words[at], words[at] + words[at + 1]);
  const table = new Uint32Array(memory.buffer, reader.GetTextures() >>> 0, words[6] * 8);
  const textures = Array.from({ length: words[6] }, (_, i) => describeTexture(memory, table.subarray(8 * i, 8 * i + 8)));
  const set = {
    width: words[0],
    height: words[1],
    channels: words[2],
    mips: words[3],
    generation: words[4],
    network: words[5],
    networkName: NETWORKS[words[5]],
    fileBytes: bytes.length,
    textures,
    constants: copy(7),
    weights: copy(9),
    latents: copy(11),
  };
  reader.ReserveFile(0); // gives the memory back
  return set;
}
