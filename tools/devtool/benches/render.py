"""The cranium scene with `diaphane-render`: samples per second, and the time to a picture with an error of 5%."""

from __future__ import annotations

import json
import subprocess
import tempfile
from pathlib import Path

from .. import paths
from ..bench import Result, result
from ..bench_volumes import cranium
from ..console import CliError

ABOUT = "throughput of the cranium scene by tracking and time to an error of 0.05, on the CPU and on a GPU if present"
PROGRAMS = ("diaphane-render",)

SIZES = {"512 x 512": ("512x512", 1), "1920 x 1080": ("1920x1080", 8)}
# Samples per pixel at 512 x 512, enough to make the start-up time negligible.
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
    # The error is inversely proportional to the square root of the samples.
    to_5_percent = [run["milliseconds"] * (run["estimated_error"] / 0.05) ** 2 for run in runs]
    return [result(f"{name}: throughput", [run["samples_per_second"] / 1e6 for run in runs], "million/s"),
            result(f"{name}: time per pass", [run["milliseconds"] / run["samples"] for run in runs], "ms"),
            result(f"{name}: time to error 0.05", to_5_percent, "ms")]


def _without_cranium() -> str:
    raise CliError("the sample scan is missing: install the Debian package invesalius-examples")


def _render(volume: str, engine: str, size: str, samples: int, seed: int, folder: Path) -> dict | None:
    """Returns the report of one run, or None if the engine has no device."""
    done = subprocess.run(
        [str(paths.build_dir() / "bin" / "diaphane-render"), volume, "--quiet", "--engine", engine, "--size", size,
         "--scene", str(paths.REPO / "tests" / "scenes" / "cranium.json"), "--samples", str(samples),
         "--estimator", "tracking", "--seed", str(seed), "--out", str(folder / "picture.ppm"), "--json", "-"], capture_output=True, text=True)
    if done.returncode == NO_DEVICE and engine == "cuda":
        return None
    if done.returncode != 0:
        raise CliError(f"diaphane-render exited with {done.returncode}: {done.stderr.strip()}")
    return json.loads(done.stdout)
