#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Converts a folder of materials to texture sets, as an add-on of Blender or a pipeline script would.

    python3 convert_materials.py TEXTURES -o SETS --bits-per-pixel 4

Every folder of TEXTURES that holds images is one material, and becomes SETS/its/path.ntc. What an image is follows from the end of
its name: Wood_BaseColor.png is colour in sRGB, Wood_Normal.png a normal map, anything else data; floats (TIFF) are linear. Materials that are already there
and newer than their images are left alone. `ntc bake` does more of this (several at a time, resumable); this shows how to do it
in Python.
"""
import argparse
import pathlib
import re
import sys

import numpy
from PIL import Image as Picture

import openntc

COLORS = re.compile(r"(base_?colou?r|albedo|diffuse|colou?r|emissive|emission)$", re.IGNORECASE)
NORMALS = re.compile(r"(normal|nrm|nor(_?(gl|dx))?)$", re.IGNORECASE)
ENDINGS = {".png", ".jpg", ".jpeg", ".tga", ".tif", ".tiff", ".bmp"}


def read_image(path):
    """Texels as they are stored, and what they mean."""
    with Picture.open(path) as picture:
        if picture.mode == "F":  # linear light, or heights, of any range
            return openntc.Image(numpy.asarray(picture))
        if picture.mode.startswith("I"):  # 16 bits
            texels = numpy.asarray(picture.convert("I"))
            if texels.min() < 0 or texels.max() > 65535:
                raise ValueError(f"{path.name}: {texels.min()} to {texels.max()}: whole numbers must be 0 to 65535")
            texels = texels.astype(numpy.uint16)
        else:
            texels = numpy.asarray(picture.convert("L" if picture.mode in ("1", "L") else "RGBA" if "A" in picture.mode else "RGB"))
    is_normal_map = bool(NORMALS.search(path.stem))
    if is_normal_map and texels.ndim == 3:
        texels = texels[:, :, :3]
    return openntc.Image(texels, srgb=bool(COLORS.search(path.stem)), normal_map=is_normal_map)


def find_materials(folder):
    """(folder, images) of every folder below `folder` that holds images."""
    for place in sorted([folder, *(path for path in folder.rglob("*") if path.is_dir())]):
        images = sorted(path for path in place.iterdir() if path.suffix.lower() in ENDINGS)
        if images:
            yield place, images


def convert(images, output, arguments):
    def show(progress):
        if sys.stderr.isatty():
            print(f"\r{output.name}: {100 * progress.fraction:3.0f} %, {progress.psnr:.1f} dB, {progress.seconds_left:.0f} s left ",
                  end="", file=sys.stderr)

    textures = {path.stem: read_image(path) for path in images}
    result = openntc.encode(textures, bits_per_pixel=arguments.bits_per_pixel, effort=arguments.effort, steps=arguments.steps,
                            progress=show)
    output.parent.mkdir(parents=True, exist_ok=True)
    result.save(output)
    return result


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("textures", type=pathlib.Path)
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True)
    parser.add_argument("--bits-per-pixel", type=float, default=4.0)
    parser.add_argument("--effort", choices=("fast", "normal", "best"), help="normal")
    parser.add_argument("--steps", type=int, default=0, help="instead of an effort")
    arguments = parser.parse_args()
    if not arguments.textures.is_dir():
        parser.error(f"{arguments.textures}: is no folder")
    failures = 0
    for folder, images in find_materials(arguments.textures):
        name = folder.relative_to(arguments.textures)
        output = arguments.output / (name if name.name else pathlib.Path(arguments.textures.resolve().name))
        output = output.with_name(output.name + ".ntc")
        if output.exists() and output.stat().st_mtime >= max(path.stat().st_mtime for path in images):
            print(f"{output}: is up to date")
            continue
        try:
            result = convert(images, output, arguments)
        except (ValueError, OSError) as error:
            failures += 1
            print(f"{folder}: {error}", file=sys.stderr)
            continue
        print(f"{output}: {len(images)} textures, {result.psnr:.2f} dB, {len(result.data)} bytes, {result.seconds:.1f} s")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
