"""A turntable as the page orders it: the time that a worker needs, and the size of the video."""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

from ..bench import Result, result
from ..bench_client import Person, Viewer, cranium
from ..bench_stack import running

ABOUT = "a turntable at 720p: time and bytes per picture"

WIDTH, HEIGHT, RATE = 1280, 720, 25


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--frames", type=int, help="pictures of the video (default: 50, with --quick: 10)")
    parser.add_argument("--error", type=float, default=0.05, help="error at which a picture is finished (default: 0.05, which is \"Quick\" in the web page)")


def measure(quick: bool, options: argparse.Namespace) -> list[Result]:
    frames = options.frames or (10 if quick else 50)
    # The session is small and converges quickly, so the video has the device to itself.
    with running(DIAPHANE_MAX_ERROR="0.9") as stack, tempfile.TemporaryDirectory() as folder:
        person = Person(stack)
        data_set = person.upload(cranium(stack, Path(folder)))
        person.wait_ready(data_set)
        viewer = person.viewer(data_set, 160, 90)
        viewer.frame()
        begun = time.monotonic()
        video = viewer.video(turntable(viewer, frames, options.error))
        seconds = time.monotonic() - begun
        viewer.close()
    return [result(f"a turntable of {frames} pictures, {WIDTH} x {HEIGHT}, error {options.error:g}", [seconds], "s"),
            result("time per picture", [seconds / frames], "s"),
            result("file size", [len(video) / 1e6], "MB"),
            result("size per second of video", [len(video) / 1e3 * RATE / frames], "kB")]


def turntable(viewer: Viewer, frames: int, error: float):
    wanted = viewer.messages["ClientMessage"]()
    video = wanted.file.video
    video.path, video.frames, video.frames_per_second, video.width, video.height, video.error = 1, frames, RATE, WIDTH, HEIGHT, error
    return wanted
