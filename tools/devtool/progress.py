"""Estimates how long the Debian packages and the programs of a start still take."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field

#: Seconds that a build step takes on one core, by the first of these texts that is in its description. Estimates start with them
#: and are corrected by the steps that finish.
_STEP_SECONDS = (("Linking", 0.2), ("Generating", 0.1), ("kernel_", 23.0), ("connection.cpp", 23.0), ("admin_server.cpp", 15.0),
                 ("/Unity/", 4.2), (".pb.cc", 4.0), ("Building", 2.5), ("", 0.1))
#: Seconds of finished steps that count as much as the first estimate of the machine's speed.
_TRUST_SECONDS = 15.0
#: Core seconds of compiling the programs that `./diaphane up` starts.
PROGRAMS_CORE_SECONDS = 350.0

_APT_PHASES = {"dlstatus": "downloading", "pmstatus": "unpacking and configuring"}
#: Seconds that unpacking and configuring a Debian package takes, and roughly also its download.
_INSTALL_SECONDS = 0.1

_NINJA_LINE = re.compile(r"^(?:@|\[)(\d+)/(\d+)(?:@|[^\]]*\]) (.*)$")


def step_seconds(description: str) -> float:
    return next(seconds for text, seconds in _STEP_SECONDS if text in description)


def ninja_step(line: str) -> str | None:
    """Returns the description of the step that a status line of Ninja reports, or None for all other output."""
    found = _NINJA_LINE.match(line)
    return found[3] if found else None


def is_work(step: str) -> bool:
    """Returns false for CMake's check for new files, which every build begins with."""
    return not step.startswith("Re-checking globbed directories")


def time_left(seconds: float) -> str:
    if seconds < 10:
        return "a few seconds left"
    if seconds < 55:
        return f"about {math.ceil(seconds / 10) * 10} seconds left"
    minutes = max(1, round(seconds / 60))
    return f"about {minutes} minute{'s' if minutes > 1 else ''} left"


@dataclass
class BuildEstimate:
    """The remaining work of a build. Steps differ in length, so they are weighted, and the measured speed corrects the weights."""

    steps: list[str]
    jobs: int
    _left: dict[str, float] = field(init=False)
    _done_count: int = 0
    _done_seconds: float = 0.0

    def __post_init__(self) -> None:
        self._left = {step: step_seconds(step) for step in self.steps}

    def finish(self, step: str) -> None:
        self._done_count += 1
        self._done_seconds += self._left.pop(step, 0.0)

    def seconds_left(self, elapsed: float) -> float:
        expected_pace = 1.0 / self.jobs
        pace = (elapsed + _TRUST_SECONDS * expected_pace) / (self._done_seconds + _TRUST_SECONDS)
        return pace * sum(self._left.values())

    def text(self, elapsed: float) -> str:
        total = max(len(self.steps), self._done_count)
        return f"{self._done_count} of {total} steps, {time_left(self.seconds_left(elapsed))}"


@dataclass
class AptProgress:
    """The status lines of apt-get's option APT::Status-Fd: lines of `dlstatus:` while it downloads and of `pmstatus:` while it installs."""

    percent: float = 0.0
    doing: str = ""
    files: int = 0
    began: float = 0.0

    def read(self, line: str, now: float) -> bool:
        """Reads a line of output that arrived at `now`, in seconds. Returns false if it does not
        contain a status."""
        kind, *words = line.split(":", 3)
        if kind not in _APT_PHASES or len(words) < 3 or not re.fullmatch(r"\d+(\.\d+)?", words[1]):
            return False
        if self.doing != _APT_PHASES[kind]:
            self.doing, self.began = _APT_PHASES[kind], now
        self.percent = min(100.0, float(words[1]))
        if kind == "dlstatus" and (found := re.search(r" of (\d+)", words[2])):
            self.files = int(found[1])
        return True

    def seconds_left(self, now: float) -> float:
        later = self.files * _INSTALL_SECONDS if self.doing == _APT_PHASES["dlstatus"] else 0.0
        if self.percent < 2:
            return later + self.files * _INSTALL_SECONDS
        return later + (now - self.began) * (100 - self.percent) / self.percent

    def text(self, now: float) -> str:
        return f"{self.doing}, {self.percent:.0f}%, {time_left(self.seconds_left(now))}"


def programs_left(jobs: int) -> str:
    """Describes the time for compiling all programs, before their steps are known."""
    return time_left(PROGRAMS_CORE_SECONDS / jobs).removesuffix(" left")
