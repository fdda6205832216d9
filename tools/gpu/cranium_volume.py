#!/usr/bin/env python3
"""Writes the cranium of Debian's invesalius-examples as a directory of the volume store.

The voxels are mapped before any interpolation, v = round(30000 clamp((HU - 150) / 450, 0, 1)), so that every renderer in a
comparison of this scene (tests/scenes/cranium.json) interpolates the same numbers. With --hounsfield, they stay as they are, for
pictures with presets."""

import argparse
import array
import json
import pathlib
import sys
import tarfile

SOURCE = "/usr/share/doc/invesalius-examples/examples/Cranium.inv3"
SIZE = (256, 256, 108)
SPACING = (0.957, 0.957, 1.5)
PERCENTS = (1, 10, 25, 50, 75, 90, 99, 99.9)


def read_hounsfield(source):
    with tarfile.open(source) as archive:
        member = next(m for m in archive if m.name.endswith("/matrix.dat"))
        voxels = array.array("h", archive.extractfile(member).read())
    if sys.byteorder == "big":
        voxels.byteswap()
    if len(voxels) != SIZE[0] * SIZE[1] * SIZE[2]:
        raise SystemExit(f"{source}: {len(voxels)} voxels, not {SIZE}")
    return voxels


def mapped(voxels):
    # The table is indexed by the value itself, because Python counts negative indices from the end.
    table = [
        round(30000 * min(max((hu - 150) / 450, 0), 1))
        for hu in (i if i < 32768 else i - 65536 for i in range(65536))
    ]
    return array.array("h", map(table.__getitem__, voxels))


def header_of(voxels, modality):
    ordered = sorted(voxels)
    return {
        "format": 1,
        "size": SIZE,
        "spacing": SPACING,
        "direction": [1, 0, 0, 0, 1, 0, 0, 0, 1],
        "modality": modality,
        "minimum": ordered[0],
        "maximum": ordered[-1],
        "percentiles": [ordered[int((len(ordered) - 1) * p / 100)] for p in PERCENTS],
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--hounsfield", action="store_true", help="leave the values unmapped")
    parser.add_argument("--source", default=SOURCE)
    options = parser.parse_args()
    voxels = read_hounsfield(options.source)
    if not options.hounsfield:
        voxels = mapped(voxels)
    header = header_of(voxels, "CT" if options.hounsfield else "OTHER")
    if sys.byteorder == "big":
        voxels.byteswap()
    options.folder.mkdir(parents=True, exist_ok=True)
    (options.folder / "voxels.i16").write_bytes(voxels.tobytes())
    (options.folder / "volume.json").write_text(json.dumps(header, indent=1) + "\n")


main()
