// SPDX-License-Identifier: MIT
// node read_ktx2.mjs MODULE FILE…: what ktx-parse, the module at MODULE, finds in KTX2 files, as JSON, a line for each.
import fs from 'node:fs';
import { pathToFileURL } from 'node:url';

const { read } = await import(pathToFileURL(process.argv[2]).href);
for (const path of process.argv.slice(3)) {
    const file = read(fs.readFileSync(path));
    console.log(JSON.stringify({
        vkFormat: file.vkFormat,
        typeSize: file.typeSize,
        width: file.pixelWidth,
        height: file.pixelHeight,
        depth: file.pixelDepth,
        layers: file.layerCount,
        faces: file.faceCount,
        scheme: file.supercompressionScheme,
        descriptor: file.dataFormatDescriptor[0],
        keyValue: file.keyValue,
        levels: file.levels.map((level) => ({
            uncompressedBytes: level.uncompressedByteLength,
            hex: Buffer.from(level.levelData).toString('hex'),
        })),
    }));
}
