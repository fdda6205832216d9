#!/usr/bin/env python3
"""Prints the cost of one sample per pixel of a scene with the general kernel, with those compiled ahead of time, and with the
scene's own kernel: medians of 5 interleaved runs."""

import json
import os
import pathlib
import statistics
import subprocess
import sys

program, volume, report = sys.argv[1:4]
scenes = sys.argv[4:]
PICTURE = pathlib.Path(report).with_suffix(".ppm")
CHOICES = ("general", "ahead-of-time", "exact")


def run(scene, size, samples, choice):
    command = [program, volume, "--scene", scene, "--quiet", "--engine", "cuda", "--samples", str(samples), "--size", size,
               "--out", str(PICTURE), "--json", "-"]
    out = subprocess.run(command, env=os.environ | {"DIAPHANE_KERNELS": choice}, check=True, capture_output=True)
    return json.loads(out.stdout)


results = []
for scene in scenes:
    for size, samples in (("512x512", 1024), ("1920x1080", 256)):
        ms = {choice: [] for choice in CHOICES}
        last = {}
        for _ in range(5):
            for choice in CHOICES:
                last[choice] = run(scene, size, samples, choice)
                ms[choice].append(last[choice]["milliseconds"] / samples)
        for choice in CHOICES:
            kernel = last[choice]["kernel"]
            row = {"scene": pathlib.Path(scene).stem, "size": size, "choice": choice, "variant": kernel["variant"],
                   "registers": kernel["registers"], "local_bytes": kernel["local_bytes"],
                   "compile_ms": kernel["compile_milliseconds"], "from_cache": kernel["from_cache"],
                   "film_bytes": kernel["film_bytes"],
                   "ms": statistics.median(ms[choice]), "least": min(ms[choice]), "most": max(ms[choice])}
            results.append(row)
            print(f"{row['scene']:24} {size:>9} {choice:14} {row['ms']:.4f} ms a sample ({row['least']:.4f} to "
                  f"{row['most']:.4f}), {row['registers']} registers, {row['local_bytes']} bytes local")
PICTURE.unlink(missing_ok=True)
pathlib.Path(report).write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
