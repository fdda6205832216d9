"""`./diaphane mutants`: puts random small faults into the product and counts those that the tests
notice.

Each job works in its own copy of the sources and of their build, below build/mutants/. The first
copy is never changed: it gives the usual times of the tests, and the files that a mutant has
changed in another copy are restored from it."""

from __future__ import annotations

import concurrent.futures
import json
import math
import os
import shutil
import threading
import time
from collections import Counter
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Iterator

from . import build, install, mutations
from .console import CliError, say, step
from .console import progress as show_progress
from .mutant_areas import AREAS, PRODUCT, lines
from .mutant_judges import Page, Programs, Tools, Tree
from .mutations import Mutant

#: Share of the mutants that the tests must kill.
LEAST_KILLED = 0.8


@dataclass
class Result:
    mutant: Mutant
    #: killed, timeout or survived. Not counted: invalid (does not compile) and equivalent (compiles
    #: to the same program).
    outcome: str
    killer: str = ""
    seconds: float = 0.0

    @property
    def counts(self) -> bool:
        return self.outcome in ("killed", "timeout", "survived")

    @property
    def killed(self) -> bool:
        return self.outcome in ("killed", "timeout")


@dataclass(frozen=True)
class Options:
    count: int = 300
    seed: int = 1
    areas: tuple[str, ...] = PRODUCT
    jobs: int = 1
    json: Path | None = None
    #: Time after which no more mutants are started.
    end: float = math.inf
    deep: bool = False


# A run

@dataclass
class Run:
    options: Options
    kinds: dict[str, Programs | Page | Tools]
    draws: Iterator[Mutant]
    results: list[Result] = field(default_factory=list)
    started: int = 0
    guard: threading.Lock = field(default_factory=threading.Lock)

    def next(self) -> Mutant | None:
        """Returns the next mutant, or None once those that count and those that are being tested
        are enough. The mutants that count are therefore the first of the draw, however many jobs
        there are and however long each takes."""
        with self.guard:
            decided = sum(not result.counts for result in self.results)
            if self.started - decided >= self.options.count or time.monotonic() > self.options.end:
                return None
            if (mutant := next(self.draws, None)) is not None:
                self.started += 1
            return mutant

    def work(self, tree: Tree) -> None:
        while True:
            mutant = self.next()
            if mutant is None:
                if not self.may_get_more():
                    return
                time.sleep(0.5)
                continue
            result = self.test(tree, mutant)
            with self.guard:
                self.results.append(result)
                counted = [one for one in self.results if one.counts]
                write(self.options, self.results)
            show_progress(f"{len(counted)} of {self.options.count} mutants, {sum(one.killed for one in counted)} killed")

    def may_get_more(self) -> bool:
        """Whether a mutant that is being tested may turn out not to count."""
        with self.guard:
            return time.monotonic() <= self.options.end and self.started > len(self.results)

    def test(self, tree: Tree, mutant: Mutant) -> Result:
        kind, file, began = self.kinds[mutant.area], tree.root / mutant.file, time.monotonic()
        text, times = file.read_text(encoding="utf-8"), file.stat()
        file.write_text(mutant.apply(text), encoding="utf-8")
        try:
            outcome, killer = kind.judge(tree, mutant)
        finally:
            file.write_text(text, encoding="utf-8")
            os.utime(file, ns=(times.st_atime_ns, times.st_mtime_ns))
            kind.restore(tree)
        return Result(mutant, outcome, killer, time.monotonic() - began)


def command(count: int, seed: int, areas: list[str] | None, jobs: int | None, minutes: float | None, deep: bool, json: Path | None) -> int:
    if unknown := [area for area in areas or () if area not in AREAS]:
        raise CliError(f"unknown area '{unknown[0]}'; choose one of: {', '.join(AREAS)}", 64)
    return run(Options(count, seed, tuple(dict.fromkeys(areas or PRODUCT)), jobs or default_jobs(), json and json.resolve(),
                       time.monotonic() + minutes * 60 if minutes else math.inf, deep))


def default_jobs() -> int:
    """Returns three quarters of the usual jobs, because a mutant of a header compiles many files at
    once."""
    return max(1, build.jobs() * 3 // 4)


def run(options: Options, may_install: bool = True) -> int:
    # tools/gpu/mutants.sh chooses the areas itself, because its machine has fewer libraries.
    if "DIAPHANE_MUTANTS_CMAKE" not in os.environ:
        install.ensure("test", may_install)
    base = Tree(0)
    step("Copying the sources")
    base.fill()
    programs = Programs(base, options.areas, options.deep)
    kinds: dict[str, Programs | Page | Tools] = {}
    for area in options.areas:
        kinds[area] = programs if AREAS[area].programs else Page(base, options.deep) if area == "page" else Tools()
    # The page's end-to-end tests also need the programs.
    for kind in {programs, *kinds.values()} if options.deep else set(kinds.values()):
        kind.prepare()
    drawn = lines(options.areas, base.root)
    step(f"Testing {options.count} mutants of {len(drawn)} lines in {options.jobs} copies")
    trees = [Tree(number) for number in range(1, options.jobs + 1)]
    done = Run(options, kinds, mutations.draw(drawn, options.seed))
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        list(pool.map(lambda tree: tree.copy_of(base), trees))
        list(pool.map(done.work, trees))
    for tree in trees:
        shutil.rmtree(tree.root)
    if isinstance(page := kinds.get("page"), Page):
        page.close()
    write(options, done.results)
    say(table(done.results))
    return 0 if is_enough(done.results) else 1


# Results

def is_enough(results: list[Result]) -> bool:
    counted = [result for result in results if result.counts]
    return bool(counted) and sum(result.killed for result in counted) >= LEAST_KILLED * len(counted)


def interval(killed: int, total: int, z: float = 1.96) -> tuple[float, float]:
    """Returns Wilson's 95% interval of a share."""
    if total == 0:
        return 0.0, 1.0
    share, square = killed / total, z * z / total
    middle = (share + square / 2) / (1 + square)
    half = z / (1 + square) * math.sqrt(share * (1 - share) / total + square / (4 * total))
    return max(0.0, middle - half), min(1.0, middle + half)


def summary(results: list[Result]) -> dict[str, dict]:
    areas: dict[str, dict] = {}
    for area in (*dict.fromkeys(result.mutant.area for result in results), "all"):
        outcomes = Counter(result.outcome for result in results if area in (result.mutant.area, "all"))
        killed = outcomes["killed"] + outcomes["timeout"]
        total = killed + outcomes["survived"]
        areas[area] = {"killed": killed, "total": total, "interval": interval(killed, total), "timeout": outcomes["timeout"],
                       "invalid": outcomes["invalid"], "equivalent": outcomes["equivalent"]}
    return areas


def write(options: Options, results: list[Result]) -> None:
    if options.json is None:
        return
    mutants = [{**asdict(result.mutant), "diff": result.mutant.diff(), "outcome": result.outcome, "killer": result.killer, "seconds": round(result.seconds, 1)}
               for result in results]
    options.json.parent.mkdir(parents=True, exist_ok=True)
    fresh = options.json.with_suffix(".part")
    fresh.write_text(json.dumps({"seed": options.seed, "areas": summary(results), "mutants": mutants}, indent=1), encoding="utf-8")
    fresh.replace(options.json)


def table(results: list[Result]) -> str:
    rows = [f"{'area':<10} {'killed':>6} {'total':>5}   rate  95% interval   not counted: invalid, equivalent"]
    for area, found in summary(results).items():
        low, high = found["interval"]
        rate = f"{found['killed'] / found['total']:6.1%}" if found["total"] else "     –"
        rows.append(f"{area:<10} {found['killed']:>6} {found['total']:>5} {rate}  {low:5.1%} to {high:5.1%}  {found['invalid']:>11}, {found['equivalent']}")
    survivors = sorted((result.mutant for result in results if result.outcome == "survived"), key=lambda mutant: (mutant.file, mutant.line))
    for mutant in survivors:
        rows += [f"survived: {mutant.file}:{mutant.line}", f"  - {mutant.before.strip()}", f"  + {mutant.after.strip()}"]
    return "\n".join(rows)
