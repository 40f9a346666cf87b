// SPDX-License-Identifier: MIT
// Files from the disk: dropped, or chosen. What they are is said by their first bytes, not by their names.

export function kindOf(bytes) {
  const first = String.fromCharCode(...bytes.subarray(0, 4));
  if (first === "glTF" || isText(bytes)) return "model";
  if (/^(\x89PNG|\xff\xd8\xff|RIFF|GIF8|BM)/.test(first) || String.fromCharCode(...bytes.subarray(4, 8)) === "ftyp") return "image";
  return "set"; // the reader says what is wrong with others
}

/** True of a .gltf, which names other files. */
function isText(bytes) {
  return /^(\xef\xbb\xbf)?\s*\{/.test(String.fromCharCode(...bytes.subarray(0, 64)));
}

/**
 * Which files are opened, and in which order: texture sets first, which models and images belong to. `files`, by name: what comes with a
 * .gltf, which may name all but sets.
 */
export function sortFiles(read) {
  const isSet = ({ file }) => /\.ntc$/i.test(file.name);
  const text = read.find(({ file, bytes }) => !/\.(ntc|bin)$/i.test(file.name) && isText(bytes));
  const files = new Map(text ? read.filter((one) => one !== text && !isSet(one)).map(({ file }) => [file.name, file]) : []);
  const opened = read.filter((one) => !files.has(one.file.name));
  opened.sort((a, b) => (kindOf(b.bytes) === "set") - (kindOf(a.bytes) === "set"));
  return { opened, files };
}

/** Calls `open(files)` for what is dropped on `element`, which has class "dropping" meanwhile. */
export function acceptDrops(element, open) {
  let depth = 0;
  const mark = (change) => {
    depth = change === 0 ? 0 : depth + change;
    element.classList.toggle("dropping", depth > 0);
  };
  element.addEventListener("dragenter", (event) => {
    event.preventDefault();
    mark(1);
  });
  element.addEventListener("dragover", (event) => event.preventDefault());
  element.addEventListener("dragleave", () => mark(-1));
  element.addEventListener("drop", (event) => {
    event.preventDefault();
    mark(0);
    open([...event.dataTransfer.files]);
  });
}

/** Lets the user choose files. */
export function chooseFiles(accept, open) {
  const input = document.createElement("input");
  Object.assign(input, { type: "file", accept, multiple: true });
  input.addEventListener("change", () => open([...input.files]));
  input.click();
}

export function saveFile(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}
