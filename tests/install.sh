#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs the Debian packages that are missing: `tests/install.sh demo` what the demo and plain Vulkan need, `opengl` what
# examples/opengl needs too, `web` what stage web needs more than the others, without an argument what the other stages of the test
# run need. Does nothing, and needs no rights, when everything is there.
set -euo pipefail

packages=(
    cmake ninja-build g++
    rapidjson-dev libexpected-dev libglm-dev          # what users' builds need
    libvulkan-dev libvulkan1 mesa-vulkan-drivers      # harness, and lavapipe
    glslang-tools glslang-dev spirv-tools             # shaders to SPIR-V, validated
    libcli11-dev libpng-dev                           # the command line
    libstb-dev libtinyexr-dev                         # images to encode
    libzstd-dev                                       # KTX2 files, compressed once more
    doctest-dev                                       # tests, built beside it
)
case "${1:-all}" in
    demo) ;;
    # Debian's npm draws in hundreds of packages: node with its own npm is to be there, or the tests say that it is not.
    web) packages+=(emscripten chromium xvfb xauth) ;;
    opengl | all) packages+=(libegl-dev libopengl-dev libgl1-mesa-dri) ;;
    *)
        echo "install.sh: \"$1\": demo, opengl, web or nothing" >&2
        exit 2
        ;;
esac
if [[ "${1:-all}" == all ]]; then
    packages+=(
        vulkan-validationlayers
        gnuplot-nox                                   # charts of `ntc report`
        libglfw3-dev libimgui-dev xvfb xauth          # the renderer's window, and a display for it
        clang-14 libclang-rt-14-dev llvm-14 clang-format clang-tidy
        clang-19 libc++-19-dev libc++abi-19-dev       # LLVM's standard library
        locales                                       # one with a decimal comma
        libx11-dev                                    # a host's macros
        libdeflate-dev                                # what bench_gdeflate compares with
        g++-mingw-w64-x86-64-posix wine64             # Windows builds of the unit tests, and running them
        g++-aarch64-linux-gnu qemu-user-static        # Arm builds of the unit tests, and running them
        ffmpeg openimageio-tools python3-pil          # DDS files read by others (with what they need 410 MB)
    )
    packages+=(meson unifdef fish mandoc)             # packages and completions, as users have them
    packages+=(mkdocs doxygen)                        # the documentation site
    packages+=(pybind11-dev python3-dev python3-numpy) # the Python package
    packages+=(spirv-cross libfilament-tools)         # shader compilers; others are npm's (tests/compilers)
    packages+=(slurm-wlm munge)                       # a cluster of one node for `ntc bake --plan slurm`
    if ! command -v node >/dev/null; then
        packages+=(nodejs)                            # KTX2 files read by ktx-parse, below
    fi
fi

missing=()
for package in "${packages[@]}"; do
    if [[ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true)" != installed ]]; then
        missing+=("$package")
    fi
done
# ktx-parse reads KTX2 files and is no package of Debian's; npm draws in hundreds of packages there, so that it is used where
# it exists, and the test that needs the module says so where it does not.
install_ktx_parse() {
    local folder="$HOME/.cache/openntc"
    if [[ "${1:-all}" == all && ! -d "$folder/node_modules/ktx-parse" ]] && command -v npm >/dev/null; then
        echo "installing from npm: ktx-parse into $folder"
        npm install --silent --no-audit --no-fund --prefix "$folder" ktx-parse@2.0.0 ||
            echo "install.sh: npm: ktx-parse could not be installed; its test will be skipped" >&2
    fi
}

if [[ ${#missing[@]} -eq 0 ]]; then
    install_ktx_parse "$@"
    exit 0
fi

echo "installing from Debian: ${missing[*]}"
as_root=()
if [[ "$(id -u)" -ne 0 ]]; then
    if ! command -v sudo >/dev/null; then
        echo "install.sh: not root and no sudo: install by hand: apt-get install ${missing[*]}" >&2
        exit 1
    fi
    as_root=(sudo)
fi
if ! command -v apt-get >/dev/null; then
    echo "install.sh: no apt-get here: install the equivalents of: ${missing[*]}" >&2
    exit 1
fi
"${as_root[@]}" apt-get update -qq </dev/null
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get install -y -qq --no-install-recommends "${missing[@]}" </dev/null
install_ktx_parse "$@"
