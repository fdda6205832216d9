"""Decodes a JPEG with the library that renderd encodes it with."""

from __future__ import annotations

import ctypes
import ctypes.util

import numpy

RGB = 0  # TJPF_RGB


def jpeg_pixels(jpeg: bytes) -> numpy.ndarray:
    """Returns rows x columns x (red, green, blue), 0 to 255."""
    turbo = ctypes.CDLL(ctypes.util.find_library("turbojpeg") or "libturbojpeg.so.0")
    turbo.tjInitDecompress.restype = ctypes.c_void_p
    handle = ctypes.c_void_p(turbo.tjInitDecompress())
    try:
        size = ctypes.c_ulong(len(jpeg))
        width, height, chroma, space = (ctypes.c_int() for _ in range(4))
        seen = turbo.tjDecompressHeader3(handle, jpeg, size, ctypes.byref(width), ctypes.byref(height), ctypes.byref(chroma),
                                         ctypes.byref(space))
        assert seen == 0, "not a JPEG"
        pixels = numpy.empty((height.value, width.value, 3), numpy.uint8)
        done = turbo.tjDecompress2(handle, jpeg, size, pixels.ctypes.data_as(ctypes.c_void_p), width, 0, height, RGB, 0)
        assert done == 0, "this is half a JPEG"
        return pixels
    finally:
        turbo.tjDestroy(handle)
