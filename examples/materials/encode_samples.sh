#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Makes the shipped sample texture sets again: examples/materials/encode_samples.sh BIN [DIR]
#   BIN  folder of the programs make_materials and ntc, for example build/release/bin
#   DIR  where to write (default: data/ beside this script)
# Files are equal byte for byte on machines whose encoder picks the same kernel (docs/encoder.md).
set -euo pipefail
bin="$(cd "${1:?usage: encode_samples.sh BIN [DIR]}" && pwd)"
out="${2:-$(dirname "${BASH_SOURCE[0]}")/data}"
mkdir -p "$out"
source="$(mktemp -d)"
trap 'rm -rf "$source"' EXIT

"$bin/make_materials" "$source" 256
for name in bricks grille; do
    "$bin/ntc" encode "$source/$name.json" -o "$out/$name.ntc" --bits-per-pixel 4 --steps 6000 --seed 1
done
