// SPDX-License-Identifier: MIT
// The 624 bytes of NtcTextureSetConstants (openntc/InferenceConstants.h) as the value of a uniform of that struct.

const ENCODING = [
  "numFeatures", "quantBits", "logElementsPerUint", "padding0", "addressMask", "dataMask", "quantizedScale", "quantizedBias",
];
const GRID = ["dataOffset", "imageWidthHeight", "sliceLeftTop", "sliceWidthHeight"];
const MIP = ["neuralMip", "positionLod", "positionScale", "padding0"];
const REST = [
  "networkWeightOffset0", "networkWeightOffset1", "networkWeightOffset2", "networkWeightOffset3",
  "imageWidth", "imageHeight", "imageMips", "networkScaleBiasOffset",
  "validChannelMask", "channelColorSpaces", "padding0", "padding1",
];
const UNSIGNED = new Set(["addressMask", "dataMask", ...GRID, "validChannelMask", "channelColorSpaces"]);
const REAL = new Set(["positionLod", "positionScale"]);

export function makeConstants(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  let at = 0;
  const readStruct = (names) => {
    const value = {};
    for (const name of names) {
      if (REAL.has(name)) value[name] = view.getFloat32(at, true);
      else value[name] = UNSIGNED.has(name) ? view.getUint32(at, true) : view.getInt32(at, true);
      at += 4;
    }
    return value;
  };
  const readArray = (count, names) => Array.from({ length: count }, () => readStruct(names));
  return {
    highResEncoding: readStruct(ENCODING),
    lowResEncoding: readStruct(ENCODING),
    highResNeuralMips: readArray(8, GRID),
    lowResNeuralMips: readArray(8, GRID),
    colorMips: readArray(16, MIP),
    ...readStruct(REST),
  };
}
