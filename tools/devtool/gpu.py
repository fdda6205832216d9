"""Checks whether CUDA finds a device with the driver that the programs use."""

from __future__ import annotations

import ctypes
from pathlib import Path
from typing import Callable


def absence(load: Callable[[str], object] = ctypes.CDLL) -> str:
    """Returns the reason why there is no device, or an empty text if there is one. `load` (for tests) returns the driver's
    library."""
    try:
        driver = load("libcuda.so.1")
    except OSError:
        return "the NVIDIA driver is not installed (libcuda.so.1 was not found)"
    if code := driver.cuInit(0):
        return f"the NVIDIA driver failed to initialise (CUDA error {code})"
    count = ctypes.c_int(0)
    if code := driver.cuDeviceGetCount(ctypes.byref(count)):
        return f"the NVIDIA driver failed to list its devices (CUDA error {code})"
    return "" if count.value > 0 else "the NVIDIA driver found no device"


def is_plugged_in(devices: Path = Path("/sys/bus/pci/devices")) -> bool:
    """Whether the machine has an NVIDIA display or compute device, with or without a driver."""
    for device in devices.glob("*"):
        try:
            vendor, kind = ((device / name).read_text(encoding="ascii").strip() for name in ("vendor", "class"))
        except OSError:
            continue
        if vendor == "0x10de" and kind.startswith("0x03"):
            return True
    return False
