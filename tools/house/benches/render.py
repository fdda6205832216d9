"""The cranium scene by `diaphane-render`: how fast samples come, and how long the picture takes to an error of 5%."""

from __future__ import annotations

import json
import subprocess
import tempfile
from pathlib import Path

from .. import paths
from ..bench import Result, result
from ..bench_volumes import cranium
from ..says import HouseError

ABOUT = "samples per second of the cranium scene by tracking, time to an error of 0.05: on the CPU, and on a GPU where there is one"
PROGRAMS = ("diaphane-render",)

SIZES = {"512 x 512": ("512x512", 1), "1920 x 1080": ("1920x1080", 8)}
# Samples a pixel at 512 x 512: enough that starting is not measured.
SAMPLES = {"cpu": 48, "cuda": 4096}
NO_DEVICE = 69


def measure(quick: bool) -> list[Result]:
    with tempfile.TemporaryDirectory(prefix="diaphane-bench-") as folder:
        volume = cranium() or _without_cranium()
        results = []
        for engine in ("cpu", "cuda"):
            for name, (size, share) in SIZES.items():
                runs = [_render(volume, engine, size, SAMPLES[engine] // share, seed, Path(folder))
                        for seed in range(1, 3 if quick else 6)]
                if None in runs:
                    break
                results += _results(f"{engine}, {name}", runs)
        return results


def _results(name: str, runs: list[dict]) -> list[Result]:
    # The error falls as the square root of the samples.
    to_5_percent = [run["milliseconds"] * (run["estimated_error"] / 0.05) ** 2 for run in runs]
    return [result(f"{name}: samples of pixels", [run["samples_per_second"] / 1e6 for run in runs], "million/s"),
            result(f"{name}: a sample of all pixels", [run["milliseconds"] / run["samples"] for run in runs], "ms"),
            result(f"{name}: to an error of 0.05", to_5_percent, "ms")]


def _without_cranium() -> str:
    raise HouseError("the cranium is measured, and Debian's package invesalius-examples is not installed")


def _render(volume: str, engine: str, size: str, samples: int, seed: int, folder: Path) -> dict | None:
    """The report of one run; nothing when there is no device for the engine."""
    done = subprocess.run(
        [str(paths.build_dir() / "bin" / "diaphane-render"), volume, "--quiet", "--engine", engine, "--size", size,
         "--scene", str(paths.REPO / "tests" / "scenes" / "cranium.json"), "--samples", str(samples),
         "--estimator", "tracking", "--seed", str(seed), "--out", str(folder / "picture.ppm"), "--json", "-"], capture_output=True, text=True)
    if done.returncode == NO_DEVICE and engine == "cuda":
        return None
    if done.returncode != 0:
        raise HouseError(f"diaphane-render ended with {done.returncode}: {done.stderr.strip()}")
    return json.loads(done.stdout)
