"""From the command to a page that responds, with everything built, and from the stop signal to the end."""

from __future__ import annotations

import time

from .. import users
from ..bench import Result, result
from ..bench_stack import folder, prepared

ABOUT = "time to start (new and existing data directory) and to stop"
PAGE = True


def measure(quick: bool) -> list[Result]:
    cold, warm, stopping = [], [], []
    with folder(users.ordinary_user()) as base:
        for number in range(2 if quick else 5):
            own = base / str(number)
            own.mkdir(mode=0o755)
            for seconds in (cold, warm):
                stack = prepared(own)
                begin = time.monotonic()
                stack.start()
                seconds.append(time.monotonic() - begin)
                begin = time.monotonic()
                stack.stop()
                stopping.append(time.monotonic() - begin)
    return [result("start, new data directory", cold, "s"),
            result("start, existing data directory", warm, "s", at_most=10),
            result("stop", stopping, "s", at_most=5)]
