"""A running Diaphane for tests: a data directory of its own, free ports, an ordinary user."""

from __future__ import annotations

import email
import email.policy
import os
import shutil
import sys
import tempfile
import time
from email.message import EmailMessage
from pathlib import Path
from typing import Callable, Iterable, TypeVar

REPO = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(REPO / "tools"))

from house import datadir, layout, logfiles, ports, users  # noqa: E402
from house.stack import Stack  # noqa: E402

T = TypeVar("T")


def mails_in(folder: Path, to: str | None = None) -> list[EmailMessage]:
    """The mails of a folder, oldest first; only those to `to` when it is given."""
    files = [f for f in folder.iterdir() if f.suffix == ".eml" and not f.name.startswith(".")]
    files.sort(key=lambda f: (f.stat().st_mtime_ns, f.name))
    mails = [email.message_from_bytes(f.read_bytes(), policy=email.policy.default) for f in files]
    return [m for m in mails if to is None or to in str(m["To"])]


def metrics_at(port: int) -> str:
    """What an admin port tells Prometheus."""
    import httpx

    return httpx.get(f"http://127.0.0.1:{port}/metrics", trust_env=False).raise_for_status().text


class TestStack:
    """The programs of one data directory and the ways in."""

    __test__ = False  # no test class, whatever its name says

    def __init__(self, stack: Stack):
        self.stack = stack
        self.data_dir: Path = stack.data
        self.ports: dict[str, int] = stack.ports
        self.url: str = stack.settings.url
        self.dsn: str = stack.settings.dsn
        self.events: list[str] = []

    # Programs

    @property
    def pids(self) -> dict[str, int]:
        return self.stack.pids

    def kill(self, program: str, restart: bool = True) -> int:
        """kill -9; the supervisor starts the program again unless `restart` is false (then: start(program))."""
        return self.stack.kill(program, restart)

    def stop(self, program: str) -> None:
        """Stops it in order; it stays away until start(program)."""
        self.stack.stop_program(program)

    def start(self, program: str) -> None:
        self.stack.start_program(program)

    def wait_ready(self, *programs: str, timeout: float = 20.0) -> None:
        for program in programs or tuple(self.stack.running_):
            self.stack.wait_ready(program, timeout)

    def wait_until(self, condition: Callable[[], T], timeout: float = 60.0, what: str = "the condition") -> T:
        """The first true value of `condition`; AssertionError after `timeout` seconds."""
        deadline = time.monotonic() + timeout
        while True:
            if value := condition():
                return value
            assert time.monotonic() < deadline, f"{what} did not come true within {timeout} s"
            time.sleep(0.05)

    # Ways in

    def psql(self, query: str, *values: object) -> list[tuple]:
        """Rows of one statement (empty for one that gives none), committed."""
        import psycopg

        with psycopg.connect(self.dsn, autocommit=True) as connection:
            cursor = connection.execute(query, values or None)
            return cursor.fetchall() if cursor.description else []

    @property
    def redis(self):
        """A client of the stack's Redis; answers are str."""
        import redis

        return redis.Redis(unix_socket_path=str(self.stack.settings.socket("redis")), decode_responses=True)

    @property
    def redis_address(self) -> str:
        """As programs take it in their setting `redis`."""
        return self.stack.settings.redis

    def mails(self, to: str | None = None) -> list[EmailMessage]:
        """The mails that were sent, oldest first; only those to `to` when it is given."""
        return mails_in(self.data_dir / "mail", to)

    def metrics(self, program: str) -> str:
        return metrics_at(self.ports[f"{program}-admin"])

    @property
    def sample_token_file(self) -> Path:
        return self.data_dir / "secrets" / "sample-token"

    def log(self, program: str) -> str:
        path = self.stack.log_path(program)
        return path.read_text(encoding="utf-8", errors="replace") if path.exists() else ""

    def log_tails(self) -> dict[str, str]:
        tails = {name: logfiles.tail(self.stack.log_path(name), 40) for name in self.stack.running_}
        return {name: text for name, text in tails.items() if text}


class StackHouse:
    """Makes the stacks of a test run and takes them away again."""

    def __init__(self) -> None:
        self.opened: list[TestStack] = []
        self.folders_: list[Path] = []
        self.run_as = users.ordinary_user()
        self.copies_ = Path(tempfile.mkdtemp(prefix="diaphane-copy-"))
        self.copies_.chmod(0o755)
        self.layout_: layout.Layout | None = None

    def folder(self) -> Path:
        """An empty directory that the ordinary user owns and can reach (pytest's tmp_path is closed to it)."""
        made = Path(tempfile.mkdtemp(prefix="diaphane-test-"))
        self.folders_.append(made)
        self.run_as.own(made)
        return made

    def layout(self) -> layout.Layout:
        if self.layout_ is None:
            self.layout_ = layout.reachable(self.run_as, self.copies_)
        return self.layout_

    def open(self, only: Iterable[str] | None = None, extra_env: dict[str, str] | None = None,
             data_dir: Path | None = None, engine: str = "cpu") -> TestStack:
        data = data_dir or self.folder()
        (data / "secrets").mkdir(mode=0o700, exist_ok=True)
        self.run_as.own(data / "secrets")
        stack = Stack(data=data, ports=ports.random_free(), layout=self.layout(), run_as=self.run_as, engine=engine,
                      durable=False, only=only, extra_env=extra_env or {})
        stack.start()
        running = TestStack(stack)
        stack.on_event = running.events.append
        self.opened.append(running)
        return running

    def shut(self, running: TestStack, keep_data: bool = False) -> None:
        running.stack.stop()
        if running in self.opened:
            self.opened.remove(running)
            ports.give_back(running.ports.values())
        if not keep_data and not os.environ.get("DIAPHANE_KEEP"):
            shutil.rmtree(running.data_dir, ignore_errors=True)

    def close(self) -> None:
        for running in list(self.opened):
            self.shut(running)
        for folder in [] if os.environ.get("DIAPHANE_KEEP") else self.folders_:
            shutil.rmtree(folder, ignore_errors=True)
        shutil.rmtree(self.copies_, ignore_errors=True)


__all__ = ["REPO", "StackHouse", "TestStack", "datadir", "mails_in", "metrics_at"]
