# SPDX-License-Identifier: MIT
import os
from typing import Callable, Mapping, Optional, Sequence, Tuple, Union

import numpy
from numpy.typing import NDArray

Rect = Tuple[int, int, int, int]

class Error(ValueError): ...

class Texture:
    @property
    def name(self) -> str: ...
    @property
    def first_channel(self) -> int: ...
    @property
    def channels(self) -> int: ...
    @property
    def format(self) -> str: ...
    @property
    def color_space(self) -> str: ...
    @property
    def alpha_color_space(self) -> str: ...

class Progress:
    @property
    def step(self) -> int: ...
    @property
    def steps(self) -> int: ...
    @property
    def fraction(self) -> float: ...
    @property
    def psnr(self) -> float: ...
    @property
    def seconds(self) -> float: ...
    @property
    def seconds_left(self) -> float: ...

class TextureSet:
    path: Optional[str]
    width: int
    height: int
    channels: int
    mips: int
    generation: int
    network: str
    textures: Sequence[Texture]
    def __init__(self, source: Union[str, os.PathLike[str], bytes, bytearray, memoryview]) -> None: ...
    def mip_size(self, mip: int) -> Tuple[int, int]: ...
    def decode(self, mip: int = 0, rect: Optional[Rect] = None, math: str = "int8", linear: bool = False,
               threads: int = 0) -> NDArray[numpy.float32]: ...
    def texture(self, name: str, mip: int = 0, rect: Optional[Rect] = None, math: str = "int8", linear: bool = False,
                threads: int = 0) -> NDArray[numpy.float32]: ...
    def constants(self, first_mip: int = 0, mips: int = 0, weights: str = "int8") -> bytes: ...
    def weights(self, weights: str = "int8") -> bytes: ...
    def latents(self, first_mip: int = 0, mips: int = 0) -> bytes: ...
    def slice(self, rect: Rect, first_mip: int = 0, mips: int = 0, weights: str = "int8") -> Tuple[bytes, bytes]: ...

class Image:
    texels: numpy.ndarray
    srgb: bool
    normal_map: bool
    weight: float
    def __init__(self, texels: numpy.ndarray, srgb: bool = False, normal_map: bool = False, weight: float = 1.0) -> None: ...

class EncodeResult:
    data: bytes
    state: bytes
    psnr: float
    mip_psnr: Sequence[float]
    steps: int
    seconds: float
    kernel: str
    cancelled: bool
    fraction: float
    def save(self, path: Union[str, os.PathLike[str]]) -> None: ...

def encode(textures: Mapping[str, Union[numpy.ndarray, Image]], *, bits_per_pixel: float = 4.0, generation: int = 1,
           network: Optional[str] = None, effort: Optional[str] = None, steps: int = 0, seconds: float = 0.0, seed: int = 1,
           threads: int = 0, fp8: bool = False, compress: bool = False, mips: int = 0, mask: Optional[str] = None,
           progress: Optional[Callable[[Progress], Optional[bool]]] = None,
           resume: Optional[EncodeResult] = None) -> EncodeResult: ...
