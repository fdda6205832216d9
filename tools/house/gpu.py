"""Whether CUDA finds a device here: asked of the driver itself, as the programs do."""

from __future__ import annotations

import ctypes
from typing import Callable


def absence(load: Callable[[str], object] = ctypes.CDLL) -> str:
    """Why there is none, in words; empty when there is one. `load` (tests) gives the driver's library."""
    try:
        driver = load("libcuda.so.1")
    except OSError:
        return "no driver of NVIDIA's is installed (libcuda.so.1)"
    if code := driver.cuInit(0):
        return f"NVIDIA's driver does not start (CUDA error {code})"
    count = ctypes.c_int(0)
    if code := driver.cuDeviceGetCount(ctypes.byref(count)):
        return f"NVIDIA's driver does not answer (CUDA error {code})"
    return "" if count.value > 0 else "NVIDIA's driver finds no device"
