#!/usr/bin/env python3
"""Prints the mean and the RMS difference, in levels of 255, of two PPM pictures of the same size."""

import math
import sys


def pixels(path):
    with open(path, "rb") as file:
        magic, width, height, most = (file.readline() + file.readline() + file.readline()).split()
        data = file.read()
    if magic != b"P6" or most != b"255" or len(data) != 3 * int(width) * int(height):
        raise SystemExit(f"{path}: not a picture of diaphane-render")
    return data


first, second = (pixels(path) for path in sys.argv[1:3])
if len(first) != len(second):
    raise SystemExit("not of one size")
count = len(first)
mean = sum(a - b for a, b in zip(first, second)) / count
square = sum((a - b) ** 2 for a, b in zip(first, second)) / count
print(f"mean difference {mean:+.4f} levels, RMS {math.sqrt(square):.3f} levels")
