# SPDX-License-Identifier: MIT
# The script that converts a folder of materials. Argument: the script.
import pathlib
import subprocess
import sys
import tempfile

import numpy

import openntc

try:
    from PIL import Image
except ImportError:
    print("SKIP: python3-pil is not installed")
    sys.exit(0)

SCRIPT = sys.argv[1]


def write(path, array):
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(array).save(path)


def run(*arguments):
    return subprocess.run([sys.executable, SCRIPT, *map(str, arguments), "--steps", "20"], capture_output=True, text=True, check=False)


with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    ramp = numpy.tile(numpy.arange(16, dtype=numpy.uint8) * 16, (16, 1))
    write(folder / "art/wood/Wood_BaseColor.png", numpy.stack([ramp, ramp.T, ramp], axis=2))
    write(folder / "art/wood/Wood_Normal.png", numpy.full((16, 16, 3), (128, 128, 255), numpy.uint8))
    write(folder / "art/wood/Wood_Height.png", ramp.astype(numpy.uint16) * 257)
    write(folder / "art/old/stone/Roughness.png", ramp)
    displacement = ramp.astype(numpy.float32) / 255
    write(folder / "art/old/stone/Displacement.tif", displacement)
    write(folder / "art/wide/Height.tif", ramp.astype(numpy.int32) * 1000)
    write(folder / "art/broken/a.png", ramp)
    write(folder / "art/broken/b.png", ramp[:8])

    first = run(folder / "art", "-o", folder / "sets")
    assert first.returncode == 1, first
    assert "broken: b: 16 x 8: must be 16 x 16" in first.stderr, first.stderr
    assert "wide: Height.tif: 0 to 240000: whole numbers must be 0 to 65535" in first.stderr, first.stderr
    made = sorted(path.relative_to(folder).as_posix() for path in (folder / "sets").rglob("*") if path.is_file())
    assert made == ["sets/old/stone.ntc", "sets/wood.ntc"], made
    wood = openntc.TextureSet(folder / "sets/wood.ntc")
    described = {t.name: (t.channels, t.format, t.color_space) for t in wood.textures}
    assert described == {"Wood_BaseColor": (3, "UNORM8", "sRGB"), "Wood_Normal": (3, "UNORM8", "Linear"),
                         "Wood_Height": (1, "UNORM16", "Linear")}, described
    stone = openntc.TextureSet(folder / "sets/old/stone.ntc")
    assert {t.name: (t.channels, t.format) for t in stone.textures} == {"Displacement": (1, "FLOAT16"), "Roughness": (1, "UNORM8")}
    decoded = stone.texture("Displacement", linear=True)[:, :, 0]
    # 20 steps are not exact, but they tell a ramp from nothing.
    assert decoded[:, 8:].mean() - decoded[:, :8].mean() > 0.1, decoded
    nothing = run(folder / "nowhere", "-o", folder / "sets")
    assert nothing.returncode == 2 and "nowhere: is no folder" in nothing.stderr.splitlines()[-1], nothing.stderr
    assert "Traceback" not in nothing.stderr
    again = run(folder / "art", "-o", folder / "sets")
    assert again.stdout.count("is up to date") == 2, again.stdout
print("ok")
