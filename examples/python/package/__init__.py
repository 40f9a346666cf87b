# SPDX-License-Identifier: MIT
"""Neural texture compression: texture sets as NumPy arrays, and NumPy arrays as texture sets.

    import openntc
    texture_set = openntc.TextureSet("bricks.ntc")
    base_color = texture_set.texture("BaseColor")              # (height, width, channels), float32
    result = openntc.encode({"BaseColor": openntc.Image(pixels, srgb=True), "Height": height}, bits_per_pixel=4)
    result.save("bricks.ntc")
"""
import collections.abc
import dataclasses
import os
import tempfile

import numpy

from . import _openntc
from ._openntc import Error, Progress, Texture

__all__ = ["EncodeResult", "Error", "Image", "Progress", "Texture", "TextureSet", "encode"]


class TextureSet:
    """A texture set in a file, or in memory: bytes as EncodeResult.data (`path` is None then). Methods that work for long release
    the interpreter's lock, and may be called from threads."""

    def __init__(self, source):
        if isinstance(source, (bytes, bytearray, memoryview)):
            self.path = None
            self._set = _openntc.LoadedSet.of_bytes(bytes(source))
        else:
            self.path = os.fsdecode(source)
            self._set = _openntc.LoadedSet(self.path)
        self.width = self._set.width
        self.height = self._set.height
        self.channels = self._set.channels
        self.mips = self._set.mips
        self.generation = self._set.generation
        self.network = self._set.network
        self.textures = self._set.textures

    def __repr__(self):
        names = ", ".join(texture.name for texture in self.textures)
        return f"<TextureSet {self.width} x {self.height}, {self.channels} channels, {self.mips} mips: {names}>"

    def mip_size(self, mip):
        """(width, height) in texels."""
        return self._set.mip_size(mip)

    def decode(self, mip=0, rect=None, math="int8", linear=False, threads=0):
        """All channels: float32 (height, width, channels), in storage colour space unless `linear`.

        rect: (left, top, width, height) in texels of the mip. math: "int8", "int8_half", "fp8", "fp16" or "fp32"; the last three
        are the slow reference. threads: 0 is all. Results have the bits of every other decoder of the project."""
        return self._set.decode(mip, rect, math, linear, threads)

    def texture(self, name, mip=0, rect=None, math="int8", linear=False, threads=0):
        """The channels of one texture, as decode()."""
        for texture in self.textures:
            if texture.name == name:
                first = texture.first_channel
                return self.decode(mip, rect, math, linear, threads)[:, :, first : first + texture.channels]
        raise KeyError(f"{name}: the set has " + ", ".join(texture.name for texture in self.textures))

    def constants(self, first_mip=0, mips=0, weights="int8"):
        """NtcTextureSetConstants (InferenceConstants.h) for shaders. mips: 0 is all from first_mip on."""
        return self._set.constants(first_mip, mips, weights)

    def weights(self, weights="int8"):
        """The weight buffer for shaders: "int8" or "fp8"."""
        return self._set.weights(weights)

    def latents(self, first_mip=0, mips=0):
        """The latent buffer for shaders, for constants() of the same mips."""
        return self._set.latents(first_mip, mips)

    def slice(self, rect, first_mip=0, mips=0, weights="int8"):
        """(constants, latents) of a rectangle in texels of first_mip and of the mips below it."""
        return self._set.slice(first_mip, mips, rect, weights)


@dataclasses.dataclass
class Image:
    """One texture to encode. texels: (height, width) or (height, width, channels); bool, uint8 and uint16 are stored as they are,
    floats are linear light of any range (stored as HLG). srgb: integers hold sRGB colours. normal_map: integers hold (n + 1) / 2,
    and mips become unit vectors. weight: of errors in training, 0 to 1000000; 0 leaves the texture out of it."""

    texels: numpy.ndarray
    srgb: bool = False
    normal_map: bool = False
    weight: float = 1.0


class EncodeResult:
    """A texture set in memory (`data`), or of a cancelled run the `state` to resume from."""

    def __init__(self, outcome):
        self.data = outcome.data
        self.state = outcome.state
        self.psnr = outcome.psnr
        self.mip_psnr = outcome.mip_psnr
        self.steps = outcome.steps
        self.seconds = outcome.seconds
        self.kernel = outcome.kernel
        self.cancelled = outcome.cancelled
        self.fraction = outcome.fraction

    def save(self, path):
        """Writes the file under a temporary name, synced, and renames it: all of it, or what was there before."""
        if self.cancelled:
            raise Error("save: the run was cancelled: there is no file, but a state to resume from")
        folder, name = os.path.split(os.path.abspath(os.fspath(path)))
        handle, temporary = tempfile.mkstemp(prefix=f".{name}.", dir=folder)
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(self.data)
                file.flush()
                os.fsync(file.fileno())
            os.chmod(temporary, 0o666 & ~_umask())
            os.replace(temporary, path)
        except BaseException:
            os.unlink(temporary)
            raise


def _umask():
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _prepare(name, image):
    if not isinstance(name, str):
        raise Error(f"textures: {name!r}: names must be strings")
    image = image if isinstance(image, Image) else Image(numpy.asarray(image))
    texels = numpy.asarray(image.texels)
    if texels.ndim == 2:
        texels = texels[:, :, numpy.newaxis]
    if texels.ndim != 3:
        raise Error(f"{name}: {texels.ndim} dimensions: must be height x width, or height x width x channels")
    kinds = {"bool": (8, 1), "uint8": (8, 255), "uint16": (16, 65535)}
    bits, scale = kinds.get(texels.dtype.name, (32, 1))
    if bits == 32 and texels.dtype.kind != "f":
        raise Error(f"{name}: {texels.dtype}: must be bool, uint8, uint16 or a float")
    if bits == 32 and (image.srgb or image.normal_map):
        raise Error(f"{name}: floats are linear light: sRGB colours and normal maps are uint8 or uint16")
    with numpy.errstate(over="ignore"):  # what becomes infinite is refused, with its place
        values = texels.astype(numpy.float32) / numpy.float32(scale)
    return (name, values, bits, image.srgb, image.normal_map, image.weight)


def encode(textures, *, bits_per_pixel=4.0, generation=1, network=None, effort=None, steps=0, seconds=0.0, seed=1,
           threads=0, fp8=False, compress=False, mips=0, mask=None, progress=None, resume=None):
    """Trains a texture set from {name: array or Image}, up to 16 channels of one size, and returns an EncodeResult.

    effort ("fast", "normal", "best"), or steps, or seconds; None is "normal". network, of generation 1: "small", "medium" (None),
    "large" or "xlarge". Limits are those of `ntc encode`. mips: 0 is the full chain. mask: name of a texture of one channel whose
    exact 0 and 1 are kept. progress: called with a Progress a few times a second; False cancels, and an exception ends the
    run and is raised here, as Ctrl+C is. resume: the EncodeResult of a cancelled run of the same textures and settings."""
    if not isinstance(textures, collections.abc.Mapping):
        raise Error(f"textures: {type(textures).__name__}: must be a dictionary of names and arrays")
    if resume is not None and not isinstance(resume, EncodeResult):
        raise Error(f"resume: {type(resume).__name__}: must be an EncodeResult")
    if progress is not None and not callable(progress):
        raise Error(f"progress: {type(progress).__name__}: must be a function")
    prepared = [_prepare(name, image) for name, image in textures.items()]
    mask_channel, channel = -1, 0
    for name, texels, *_ in prepared:
        if name == mask:
            if texels.shape[2] != 1:
                raise Error(f"mask: {mask}: {texels.shape[2]} channels: must be a texture of 1")
            mask_channel = channel
        channel += texels.shape[2]
    if mask is not None and mask_channel < 0:
        raise Error(f"mask: {mask}: the textures are " + ", ".join(textures))
    settings = {"bits_per_pixel": bits_per_pixel, "generation": generation, "network": network, "effort": effort, "steps": steps,
                "seconds": seconds, "seed": seed, "threads": threads, "fp8": fp8, "compress": compress, "mips": mips,
                "mask_channel": mask_channel, "resume_fraction": resume.fraction if resume else 0.0}
    return EncodeResult(_openntc.encode(prepared, settings, progress, resume.state if resume else b""))
