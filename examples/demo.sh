#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The demo: installs what is missing, builds, and decodes a texture set through a Vulkan compute shader into out/demo/.
#   OPENNTC_SHARED_DIR=DIR  folder with LibNTC's vectors (default ../shared); without it our own bricks are encoded first
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
material="${OPENNTC_SHARED_DIR:-../shared}/conformance/helmet-leather-medium.ntc"
if [[ -f "$material" ]]; then
    echo "decoding LibNTC's texture set $material"
else
    echo "no LibNTC vectors here: making the sample bricks and encoding them for 20 seconds"
    build/release/bin/make_materials "$out/source" 256
    material="$out/bricks.ntc"
    build/release/bin/ntc encode "$out/source/bricks.json" -o "$material" --bits-per-pixel 4 --seconds 20 </dev/null
fi
build/release/bin/ntc decode "$material" --mips --backend vulkan -o "$out" </dev/null

echo "written by a Vulkan compute shader from $material:"
find "$out" -path "$out/source" -prune -o -type f -name '*.png' -print | sort | sed 's/^/  /'
echo "the PNG files are in $out"
