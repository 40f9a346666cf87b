#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The demo: installs what is missing, builds, and decodes the shipped sample material through a Vulkan compute shader
# into out/demo/. It ends by saying how to encode images of one's own.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

out="out/demo"
bash tests/install.sh demo
log="build/demo.log"
mkdir -p build
echo "building (log: $log)"
if ! { cmake --preset release && cmake --build --preset release --parallel "$(nproc)" --target demo_tools; } \
    >"$log" 2>&1 </dev/null; then
    tail -n 40 "$log" >&2
    exit 1
fi

rm -rf "$out"
mkdir -p "$out"
material="examples/materials/data/bricks.ntc"
build/release/bin/ntc decode "$material" --mips --backend vulkan -o "$out" </dev/null

echo "written by a Vulkan compute shader from $material:"
find "$out" -type f -name '*.png' | sort | sed 's/^/  /'
echo "the PNG files are in $out"
cat <<'TEXT'

To encode a material of your own:
  build/release/bin/ntc encode albedo.png normal.png roughness.png -o material.ntc --bits-per-pixel 4 --effort fast
or the source images of this one:
  build/release/bin/make_materials out/demo/source 256
  build/release/bin/ntc encode out/demo/source/bricks.json -o out/demo/bricks.ntc --bits-per-pixel 4 --seconds 20
  build/release/bin/ntc compare out/demo/bricks.ntc out/demo/source/bricks.json
TEXT
