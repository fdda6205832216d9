"""Executes the plan of one machine: starts its programs, restarts those that die, and stops them in order."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Callable, Iterable

from . import cluster, datadir, logfiles, plan
from .layout import Layout
from .plan import Program, Settings
from .priority import GroupPriorities, first_cores
from .processes import Identity, boot, end, kill_group, wait_gone
from .ready import is_ready
from .console import CliError
from .users import RunAs

BACKOFF_FIRST, BACKOFF_MOST = 0.1, 2.0   # seconds; doubled at each death, reset after 10 s of life
CONFIG_EXITS = (64, 78)                  # wrong command line or setting, where a restart cannot help
#: Core files would contain deleted data, so no program or child of it writes one.
WITHOUT_CORE_FILES = ("/bin/sh", "-c", 'ulimit -c 0; exec "$0" "$@"')


def _on_cores(count: int) -> tuple[str, ...]:
    return ("/usr/bin/taskset", "-c", ",".join(map(str, first_cores(count)))) if count else ()


def _with_priority(nice: int) -> tuple[str, ...]:
    """Returns the prefix of a command line that sets this CPU priority. Each of the programs replaces itself by the next, so that
    the process stays the same."""
    return ("/usr/bin/nice", "-n", str(nice)) if nice else ()


@dataclass
class Running:
    """A program of the plan and its current process."""

    program: Program
    process: subprocess.Popen | None = None
    identity: Identity | None = None
    should_run: bool = False
    started_at: float = 0.0
    start_at: float = 0.0                # monotonic time at which to restart a dead program
    backoff: float = BACKOFF_FIRST
    restarts: int = 0
    last_exit: int | None = None
    ever_ready: bool = False


@dataclass
class Stack:
    """The running programs of one data directory. Use start() and stop(), or `with`."""

    data: Path
    ports: dict[str, int]
    layout: Layout
    run_as: RunAs = field(default_factory=RunAs)
    engine: str = "auto"
    durable: bool = True
    polite: bool = True                  # programs for which nobody waits get less of the CPU
    only: Iterable[str] | None = None    # names of the programs to run; None: all
    extra_env: dict[str, str] = field(default_factory=dict)
    on_event: Callable[[str], None] = lambda text: None
    log_limit: int = logfiles.LIMIT_BYTES    # of a program's log before it is rotated
    stop_requested: threading.Event = field(default_factory=threading.Event)  # aborts a start in progress

    def __post_init__(self) -> None:
        self.data = Path(self.data).resolve()
        self.running_: dict[str, Running] = {}
        self.guard_ = threading.RLock()
        self.stopping_ = threading.Event()
        self.priorities_ = GroupPriorities()
        self.watcher_: threading.Thread | None = None
        self.lock_: datadir.Lock | None = None
        self.settings: Settings | None = None
        self.serving = False

    # Start and stop

    def start(self, timeout: float = 60.0) -> "Stack":
        """Starts everything and returns when all programs are ready. Otherwise, raises CliError with nothing left running."""
        datadir.prepare(self.data, self.run_as)
        self.lock_ = datadir.Lock(self.data)
        if not self.lock_.take():
            raise CliError(f"Diaphane is already running on {self.data}")
        try:
            self._start(time.monotonic() + timeout)
        except BaseException:
            self.stop()
            raise
        return self

    def _start(self, deadline: float) -> None:
        self._end_leftovers()
        self._make_settings()
        chosen = None if self.only is None else set(self.only)
        programs = [p for p in plan.programs(self.settings) if (chosen is None or p.name in chosen) and not (p.optional and p.missing())]
        self._check_built(programs)
        self.running_ = {p.name: Running(p) for p in programs}
        if "postgres" in self.running_:
            cluster.initialise(self.data, self.run_as, self.data / "secrets" / "postgres-superuser", self.durable)
        self.watcher_ = threading.Thread(target=self._watch, name="supervisor", daemon=True)
        self.watcher_.start()
        for tier in sorted({p.tier for p in programs}):
            names = [p.name for p in programs if p.tier == tier]
            for name in names:
                self.start_program(name)
            for name in names:
                if not self.running_[name].program.optional:
                    self._wait_first_ready(name, deadline)
            if tier == 0 and "postgres" in names:
                superuser = datadir.secret(self.data, "postgres-superuser", self.run_as)
                cluster.make_database(self.ports["postgres"], superuser, self.settings.postgres_password)
                if "api" in self.running_:
                    self.migrate()
        self.serving = True
        self._record()

    def stop(self) -> None:
        """Stops all programs, the edge first and the stores last. May be called at any time and repeatedly.

        This takes at most 5 s, except on a disk that is too busy to sync what Postgres wrote."""
        self.serving = False
        self.stopping_.set()
        if self.watcher_ and self.watcher_ is not threading.current_thread():
            self.watcher_.join(timeout=2)
        with self.guard_:
            entries = list(self.running_.values())
        for tier in sorted({e.program.tier for e in entries}, reverse=True):
            self._stop_tier([e for e in entries if e.program.tier == tier])
        if entries:
            self._record()
        if self.settings and self.settings.sockets and self.settings.sockets != self.data / "run":
            shutil.rmtree(self.settings.sockets, ignore_errors=True)
        if self.lock_:
            self.lock_.drop()
            self.lock_ = None

    def __enter__(self) -> "Stack":
        return self.start()

    def __exit__(self, *_: object) -> None:
        self.stop()

    # One program

    def start_program(self, name: str) -> None:
        with self.guard_:
            entry = self.running_[name]
            entry.should_run = True
            if entry.process is None:
                self._spawn(entry)

    def add_optional(self) -> None:
        """Starts the optional programs whose files were installed after the start."""
        with self.guard_:
            if self.serving:
                for program in plan.programs(self.settings):
                    if program.optional and not program.missing() and program.name not in self.running_:
                        self.running_ = {**self.running_, program.name: Running(program, ever_ready=True)}
                        self.start_program(program.name)

    def stop_program(self, name: str) -> None:
        """Stops the program in order and keeps it stopped until start_program()."""
        with self.guard_:
            entry = self.running_[name]
            entry.should_run = False
        self._stop_tier([entry])
        with self.guard_:
            entry.process = entry.identity = None
            self._record()

    def kill(self, name: str, restart: bool = True) -> int:
        """Sends SIGKILL to simulate a fault. The supervisor restarts the program unless `restart` is false. Returns the pid."""
        with self.guard_:
            entry = self.running_[name]
            entry.should_run = restart
            identity = entry.identity
            if identity is None:
                raise CliError(f"{name} is not running")
            identity.send(signal.SIGKILL)
        wait_gone([identity], 2.0)
        return identity.pid

    def wait_ready(self, name: str, timeout: float = 20.0) -> None:
        """Waits until the program runs and reports that it is ready. Otherwise, raises CliError with the end of its log."""
        deadline = time.monotonic() + timeout
        entry = self.running_[name]
        while True:
            identity = entry.identity
            # The process is compared before and after, because a response from one that was just
            # killed says nothing about its successor.
            if identity and identity.alive() and is_ready(entry.program.ready) and entry.identity == identity:
                entry.ever_ready = True
                return
            if time.monotonic() > deadline:
                raise CliError(f"{name} was not ready after {timeout:.0f} s{self._last_output(name)}")
            time.sleep(0.03)

    def is_ready(self, name: str) -> bool:
        entry = self.running_[name]
        return bool(entry.identity and entry.identity.alive() and is_ready(entry.program.ready))

    @property
    def pids(self) -> dict[str, int]:
        with self.guard_:
            return {name: e.identity.pid for name, e in self.running_.items() if e.identity}

    @property
    def restarts(self) -> dict[str, int]:
        with self.guard_:
            return {name: e.restarts for name, e in self.running_.items()}

    def log_path(self, name: str) -> Path:
        return self.data / "logs" / f"{name}.log"

    # Internals

    def _make_settings(self) -> None:
        for name in ("postgres-superuser", "sample-token", "factor-key", "archive-key"):
            datadir.secret(self.data, name, self.run_as)
        self.settings = Settings(
            data=self.data, ports=self.ports, layout=self.layout, engine=self.engine, durable=self.durable,
            postgres_password=datadir.secret(self.data, "postgres", self.run_as), extra_env=self.extra_env,
            sockets=datadir.socket_folder(self.data, self.run_as))
        template = self.layout.edge / "nginx.conf.in"
        if template.exists():
            conf = self.data / "run" / "nginx.conf"
            conf.write_text(plan.nginx_conf(self.settings, template.read_text(encoding="utf-8")), encoding="utf-8")
            self.run_as.own(conf)

    @staticmethod
    def _check_built(programs: list[Program]) -> None:
        missing = {p.name: p.missing() for p in programs if p.missing()}
        if missing:
            lines = [f"  {name}: {', '.join(map(str, files))}" for name, files in missing.items()]
            raise CliError("files are missing (not built or not installed):\n" + "\n".join(lines))

    def _end_leftovers(self) -> None:
        """Ends processes that a killed supervisor left behind, after verifying the identity of each process or its group."""
        left = datadir.left_running(datadir.read_record(self.data))[::-1]
        if not left:
            return
        self.on_event("Stopping programs left behind by an earlier run: " + ", ".join(name for name, _ in left))
        for name, identity in left:
            end(identity, signal.SIGINT if name == "postgres" else signal.SIGTERM)

    def migrate(self) -> None:
        argv, env = plan.migrate(self.settings)
        done = subprocess.run(argv, env=env, cwd="/", capture_output=True, text=True, timeout=120,
                              **self.run_as.popen())
        if done.returncode != 0:
            raise CliError(f"the database migration failed (exit {done.returncode}):\n"
                             f"{done.stdout}{done.stderr}".rstrip())

    def _nice(self, entry: Running) -> int:
        return entry.program.nice if self.polite else 0

    def _spawn(self, entry: Running) -> None:
        log = self.log_path(entry.program.name)
        handle = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o600)
        self.run_as.own(log)
        try:
            # The program gets a group of its own, so that Ctrl-C in the terminal reaches only the
            # supervisor, which stops everything in order.
            entry.process = subprocess.Popen(
                [*_on_cores(entry.program.cores), *_with_priority(self._nice(entry)), *WITHOUT_CORE_FILES, *entry.program.argv],
                env=dict(entry.program.env), cwd=self.data, stdin=subprocess.DEVNULL, stdout=handle, stderr=handle, start_new_session=True, umask=0o077, **self.run_as.popen())
        finally:
            os.close(handle)
        entry.identity = Identity.of(entry.process.pid)
        entry.started_at = time.monotonic()
        self._record()

    def _watch(self) -> None:
        looked_at_logs = looked_at_priorities = time.monotonic()
        while not self.stopping_.wait(0.02):
            with self.guard_:
                for entry in self.running_.values():
                    self._look_after(entry)
            if time.monotonic() - looked_at_priorities > 0.5:
                looked_at_priorities = time.monotonic()
                self.priorities_.apply([(entry.process.pid, self._nice(entry)) for entry in list(self.running_.values())
                                        if entry.process and self._nice(entry)])
            if time.monotonic() - looked_at_logs > 5:
                looked_at_logs = time.monotonic()
                for name in (*self.running_, "edge"):
                    logfiles.bound(self.log_path(name), self.log_limit)

    def _look_after(self, entry: Running) -> None:
        now = time.monotonic()
        if entry.process is not None and entry.process.poll() is not None:
            entry.last_exit = entry.process.returncode
            if entry.identity and kill_group(entry.identity):
                self.on_event(f"Child processes of {entry.program.name} could not be stopped")
            entry.process = entry.identity = None
            if now - entry.started_at > 10:
                entry.backoff = BACKOFF_FIRST
            entry.start_at = now + entry.backoff
            entry.backoff = min(2 * entry.backoff, BACKOFF_MOST)
            if entry.should_run:
                self.on_event(f"{entry.program.name} exited ({_manner(entry.last_exit)}). Restarting it.")
            self._record()
        if entry.process is None and entry.should_run and now >= entry.start_at and self._may_start(entry):
            entry.restarts += 1
            self._spawn(entry)

    def _may_start(self, entry: Running) -> bool:
        return entry.ever_ready or entry.last_exit not in CONFIG_EXITS

    def _wait_first_ready(self, name: str, deadline: float) -> None:
        entry = self.running_[name]
        while time.monotonic() < deadline and not self.stop_requested.is_set():
            if entry.process is None and entry.last_exit in CONFIG_EXITS:
                raise CliError(f"{name} rejected its configuration (exit {entry.last_exit}){self._last_output(name)}")
            if entry.restarts >= 4:
                raise CliError(f"{name} keeps exiting ({_manner(entry.last_exit)}){self._last_output(name)}")
            if self.is_ready(name):
                entry.ever_ready = True
                return
            time.sleep(0.03)
        if self.stop_requested.is_set():
            raise CliError("stopped before everything was ready", 130)
        raise CliError(f"{name} did not become ready in time{self._last_output(name)}")

    def _stop_tier(self, entries: list[Running]) -> None:
        # The list is copied, because the watcher drops a process as soon as it has ended.
        alive = [(e, e.process, e.identity) for e in entries if e.process and e.identity]
        for entry, _, identity in alive:
            identity.send(entry.program.stop_signal)
        deadline = time.monotonic() + max((e.program.stop_seconds for e, _, _ in alive), default=0)
        for entry, process, identity in alive:
            try:
                process.wait(max(0.0, deadline - time.monotonic()))
            except subprocess.TimeoutExpired:
                self.on_event(f"{entry.program.name} did not stop in time. Killing it.")
                identity.send(signal.SIGKILL)
                process.wait(1)
            # Ends children that a crashed program left behind.
            kill_group(identity)
            entry.identity = None

    def _last_output(self, name: str) -> str:
        text = logfiles.tail(self.log_path(name))
        return f"; last lines of {self.log_path(name)}:\n{text}" if text else ""

    def _record(self) -> None:
        with self.guard_:
            me = Identity.of(os.getpid())
            programs = [
                {"name": e.program.name, "pid": e.identity.pid, "start": e.identity.start, "port": e.program.port,
                 "admin_port": e.program.ready.port if e.program.ready.kind == "http" else None,
                 "restarts": e.restarts}
                for e in self.running_.values() if e.identity]
            datadir.write_record(self.data, {
                "version": 1, "boot": boot(), "url": self.settings.url if self.settings else "", "ready": self.serving,
                "supervisor": {"pid": me.pid, "start": me.start}, "ports": dict(self.ports),
                "sockets": str(self.settings.sockets) if self.settings and self.settings.sockets else None,
                "mail": str(self.data / "mail"), "programs": programs})


def _manner(code: int | None) -> str:
    if code is None:
        return "not started"
    return f"signal {-code}" if code < 0 else f"exit {code}"
