#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The demo: installs what is missing, builds, and decodes a texture set through a Vulkan compute shader into out/demo/.
#   OPENNTC_SHARED_DIR=DIR  folder with LibNTC's vectors (default ../shared); without it a set is synthesised
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
    material="$out/synthesised.ntc"
    build/release/bin/synthesize demo "$material"
    echo "no LibNTC vectors here: decoding a synthesised texture set (random latents and weights), $material"
fi
build/release/bin/ntc decode "$material" --mips --backend vulkan -o "$out" </dev/null

echo "written by a Vulkan compute shader from $material:"
find "$out" -type f -name '*.png' | sort | sed 's/^/  /'
echo "$(find "$out" -type f -name '*.png' | wc -l) PNG files are in $out"
