"""The effect of an attack on ordinary users: the time from an input to the frame that shows it, and failed requests.

Calm and attack phases alternate in one run on one stack. The attackers run at the lowest CPU priority, so the comparison shows
the cost of the programs' work and not that of the attackers themselves."""

from __future__ import annotations

import argparse
import json
import os
import random
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path

from .. import paths
from ..bench import Result, percentile
from ..bench_client import Person, Viewer, cranium
from ..bench_stack import running
from ..console import CliError, say

ABOUT = "how attacks by 250 connections, guests of a link and ten accounts slow ordinary users (--attack)"
PROGRAMS = ("diaphane-api", "diaphane-gateway", "diaphane-ingestd", "diaphane-renderd", "diaphane-sample")

MOST_RATIO = 1.5
WIDTH, HEIGHT = 160, 90
ATTACKS = ("crowd", "guests", "accounts")


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--attack", choices=ATTACKS, action="append", help="only this attack (repeatable; default: all at once)")
    parser.add_argument("--seconds", type=float, help="seconds per phase (default: 20, with --quick: 5)")
    parser.add_argument("--repeats", type=int, help="number of pairs of a calm and an attacked phase (default: 3, with --quick: 1)")
    parser.add_argument("--engine", choices=("auto", "cpu", "cuda"), default="auto", help="engine of the renderer (default: auto)")
    parser.add_argument("--threads", type=int, default=max(1, len(os.sched_getaffinity(0)) // 2),
                        help="threads of the renderer on the CPU (default: half of the cores, because the attackers share the machine)")


@dataclass
class Phase:
    """The experience of the ordinary users during one phase."""

    delays_ms: list[float] = field(default_factory=list)
    requests: int = 0
    failures: list[str] = field(default_factory=list)


class Ordinary(threading.Thread):
    """A user who drags the picture and opens pages now and then. Records into `phase`, the current
    phase."""

    def __init__(self, person: Person, data_set: str, seed: int):
        super().__init__(daemon=True)
        self.person, self.data_set, self.chance = person, data_set, random.Random(seed)
        self.phase: Phase | None = None
        self.ended = threading.Event()
        self.viewer: Viewer | None = None
        self.lock = threading.Lock()

    def run(self) -> None:
        next_request = time.monotonic()
        while not self.ended.is_set():
            try:
                self.viewer = self.viewer or self.person.viewer(self.data_set, WIDTH, HEIGHT)
                self._drag(self.viewer)
            except Exception as failed:  # noqa: BLE001 - for the user, any error is a failure
                self._note(failure=f"stream: {type(failed).__name__} {failed}"[:200])
                self.viewer = None
                time.sleep(0.2)
            if time.monotonic() >= next_request:
                next_request = time.monotonic() + 1
                self._ask()

    def _drag(self, viewer: Viewer) -> None:
        scene = viewer.config.scene
        scene.camera.eye.x += self.chance.uniform(-5, 5)
        seq = viewer.send_scene(scene)
        begin = time.monotonic()
        while viewer.frame(timeout=20).input_seq < seq:
            pass
        self._note(delay_ms=1e3 * (time.monotonic() - begin))
        time.sleep(self.chance.uniform(0.1, 0.3))

    def _ask(self) -> None:
        path = self.chance.choice(("/v1/me", "/v1/data-sets", "/v1/sessions", f"/v1/data-sets/{self.data_set}"))
        try:
            answer = self.person.http.get(path)
            self._note(requests=1, failure="" if answer.status_code == 200 else f"{path}: {answer.status_code}")
        except Exception as failed:  # noqa: BLE001 - the same
            self._note(requests=1, failure=f"{path}: {type(failed).__name__}")

    def _note(self, delay_ms: float | None = None, requests: int = 0, failure: str = "") -> None:
        with self.lock:
            if self.phase is None:
                return
            if delay_ms is not None:
                self.phase.delays_ms.append(delay_ms)
            self.phase.requests += requests
            if failure:
                self.phase.failures.append(failure)


def measure(quick: bool, options: argparse.Namespace) -> list[Result]:
    people_count, connections, guests, accounts = (3, 40, 4, 2) if quick else (10, 250, 16, 10)
    seconds, repeats = options.seconds or (5 if quick else 20), options.repeats or (1 if quick else 3)
    attacks = tuple(options.attack or ATTACKS)
    slots = str(4 * (people_count + accounts + 1))
    with running(options.engine, DIAPHANE_SLOTS=slots, DIAPHANE_THREADS=str(options.threads)) as stack, tempfile.TemporaryDirectory() as folder:
        owner = Person(stack, "127.0.4.1")
        data_set = owner.upload(cranium(stack, Path(folder)))
        owner.wait_ready(data_set)
        people = [Person(stack, f"127.0.1.{number + 1}") for number in range(people_count)]
        attackers = [Person(stack, f"127.0.3.{number + 1}") for number in range(accounts)] if "accounts" in attacks else []
        for person in (*people, *attackers):
            owner.http.post(f"/v1/data-sets/{data_set}/people", json={"email": person.email, "may": "view"}).raise_for_status()
        presenter = owner.http.post("/v1/sessions", json={"data_set_id": data_set}).raise_for_status().json()
        shown = Viewer(stack.settings.url, presenter["stream_url"], WIDTH, HEIGHT, address=owner.address)
        plan = {
            "url": stack.settings.url, "address": "127.0.2.1", "seconds": seconds, "data_set": data_set,
            "live_link": owner.http.post(f"/v1/sessions/{presenter['session_id']}/links").raise_for_status().json()["token"],
            "share_link": owner.http.post(f"/v1/data-sets/{data_set}/links", json={"hours": 1}).raise_for_status().json()["token"],
            "connections": connections if "crowd" in attacks else 0, "guests": guests if "guests" in attacks else 0,
            "accounts": [{"cookies": dict(one.http.cookies), "headers": {"X-CSRF-Token": one.http.headers["X-CSRF-Token"]},
                          "address": one.address} for one in attackers],
        }
        file = Path(folder) / "attack.json"
        file.write_text(json.dumps(plan), encoding="utf-8")
        ordinary = [Ordinary(person, data_set, number) for number, person in enumerate(people)]
        for person in ordinary:
            person.start()
        time.sleep(2 if quick else 5)
        before = dict(stack.pids)
        calm, attacked, answers = [], [], {}
        for number in range(repeats):
            calm.append(_phase(ordinary, seconds))
            attack = subprocess.Popen([sys.executable, "-m", "devtool.benches.support.abuse_clients", str(file)], cwd=paths.TOOLS, stdout=subprocess.PIPE,
                                      text=True, start_new_session=True, env={**os.environ, "PYTHONPATH": str(paths.TOOLS)})
            try:
                time.sleep(1)    # until the attack has begun
                attacked.append(_phase(ordinary, seconds - 1))
                said, _ = attack.communicate(timeout=60)
                if attack.returncode != 0 or not said:
                    raise CliError("the attackers failed, so nothing was attacked")
            finally:
                attack.kill()
            for what, count in json.loads(said).items():
                answers[what] = answers.get(what, 0) + count
            say(f"  {number + 1}: calm {_p95(calm[-1]):.0f} ms, attacked {_p95(attacked[-1]):.0f} ms, {len(attacked[-1].failures)} failures")
            time.sleep(1 if quick else 5)
        for person in ordinary:
            person.ended.set()
        shown.close()
        ended = [name for name, pid in before.items() if stack.pids.get(name) != pid]
    if not all(phase.delays_ms for phase in (*calm, *attacked)):
        raise CliError("a phase produced no frames, so there is nothing to compare")
    for what, count in sorted(answers.items()):
        say(f"    {what:<44} {count}")
    return results_of(calm, attacked, ended)


def _phase(people: list[Ordinary], seconds: float) -> Phase:
    phase = Phase()
    for person in people:
        with person.lock:
            person.phase = phase
    time.sleep(seconds)
    for person in people:
        with person.lock:
            person.phase = None
    return phase


def _p95(phase: Phase) -> float:
    return percentile(phase.delays_ms, 95) if phase.delays_ms else float("inf")


def results_of(calm: list[Phase], attacked: list[Phase], ended: list[str]) -> list[Result]:
    """Returns the results. Each ratio compares the two phases of one pair."""
    ratios = [_p95(under) / _p95(before) for before, under in zip(calm, attacked, strict=True)]
    spread = statistics.stdev(ratios) if len(ratios) > 1 else 0.0
    ratio = statistics.median(ratios)
    failures = [failure for phase in attacked for failure in phase.failures]
    before = [failure for phase in calm for failure in phase.failures]
    for failure in sorted(set(failures + before)):
        say(f"    failed: {failure} ({(failures + before).count(failure)} times)")
    results = []
    for name, phases in (("calm", calm), ("under attack", attacked)):
        p95s = [_p95(phase) for phase in phases]
        results.append(Result(f"{name}: input to frame, p95", statistics.median(p95s), "ms", statistics.stdev(p95s) if len(p95s) > 1 else 0.0,
                              runs=len(p95s)))
        results.append(Result(f"{name}: requests of ordinary users", sum(phase.requests for phase in phases), ""))
    return [*results, Result("p95 under attack / calm", ratio, "", spread, MOST_RATIO, ratio <= MOST_RATIO, len(ratios)),
            Result("failed requests of ordinary users", len(failures) + len(before), "", 0, 0, not failures and not before),
            Result("programs that exited", len(ended), "", 0, 0, not ended)]
