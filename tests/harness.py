"""A running Diaphane for tests, with its own data directory, free ports and an ordinary user."""

from __future__ import annotations

import contextlib
import email
import email.policy
import fcntl
import os
import select
import shutil
import subprocess
import sys
import tempfile
import time
from email.message import EmailMessage
from pathlib import Path
from typing import Callable, Iterable, Iterator, TypeVar

REPO = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(REPO / "tools"))

from devtool import datadir, layout, logfiles, ports, users  # noqa: E402
from devtool.plan import POSTGRES_BIN  # noqa: E402
from devtool.stack import Stack  # noqa: E402

T = TypeVar("T")

#: Settings of every stack of a test, which `extra_env` overrides. Background tasks of `api` run ten times as often as they do for
#: users, so that no test waits seconds for the next run. Thumbnails have one sample, because each costs a second of a core.
SETTINGS = {"DIAPHANE_BACKGROUND_MS": "500", "DIAPHANE_STILL_SAMPLES": "1"}


def mails_in(folder: Path, to: str | None = None) -> list[EmailMessage]:
    """Returns the mails in a folder, oldest first, optionally only those to `to`."""
    files = [f for f in folder.iterdir() if f.suffix == ".eml" and not f.name.startswith(".")]
    files.sort(key=lambda f: (f.stat().st_mtime_ns, f.name))
    mails = [email.message_from_bytes(f.read_bytes(), policy=email.policy.default) for f in files]
    return [m for m in mails if to is None or to in str(m["To"])]


def metrics_at(port: int) -> str:
    """Returns the Prometheus metrics of an admin port."""
    import httpx

    return httpx.get(f"http://127.0.0.1:{port}/metrics", trust_env=False, timeout=60).raise_for_status().text


def free_port() -> int:
    """Returns a port for a program that a test starts itself. Unlike one that the kernel chooses (port 0), no outgoing connection of
    another process takes it before the program listens, and no other worker of a parallel run gets it."""
    port, *others = ports.random_free().values()
    ports.give_back(others)
    return port


def files_below(*folders: Path) -> Iterator[Path]:
    """Lists the files of a running stack. Unlike Path.rglob(), it passes over folders that are deleted meanwhile."""
    for folder in folders:
        for place, _, names in os.walk(folder):
            yield from (path for name in names if (path := Path(place, name)).is_file())


def contents_below(*folders: Path) -> Iterator[tuple[Path, bytes]]:
    """Reads the files of a running stack. Passes over files that are deleted meanwhile."""
    for path in files_below(*folders):
        with contextlib.suppress(FileNotFoundError):
            yield path, path.read_bytes()


@contextlib.contextmanager
def one_at_a_time(folder: Path) -> Iterator[None]:
    """Keeps the other workers of a parallel run out of the folder."""
    with (folder / "lock").open("w", encoding="ascii") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def wait_until(condition: Callable[[], T], timeout: float = 60.0, what: str = "the condition") -> T:
    """Returns the first true value of `condition`. Raises AssertionError after `timeout` seconds."""
    deadline = time.monotonic() + timeout
    while True:
        if value := condition():
            return value
        assert time.monotonic() < deadline, f"{what} did not come true within {timeout} s"
        time.sleep(0.05)


class TestStack:
    """The programs of one data directory, and access to them."""

    __test__ = False  # not a test class, despite its name

    def __init__(self, stack: Stack, factory: StackFactory | None = None):
        self.stack = stack
        self.factory = factory
        self.data_dir: Path = stack.data
        self.ports: dict[str, int] = stack.ports
        self.url: str = stack.settings.url
        self.dsn: str = stack.settings.dsn
        self.events: list[str] = []
        self.databases_: list = []

    # Programs

    @property
    def pids(self) -> dict[str, int]:
        return self.stack.pids

    def kill(self, program: str, restart: bool = True) -> int:
        """Sends SIGKILL. The supervisor restarts the program unless `restart` is false, in which case start(program) does."""
        self._leave_database()
        return self.stack.kill(program, restart)

    def stop(self, program: str) -> None:
        """Stops the program in order. It stays down until start(program)."""
        self._leave_database()
        self.stack.stop_program(program)

    def start(self, program: str) -> None:
        self.stack.start_program(program)

    def wait_ready(self, *programs: str, timeout: float = 60.0) -> None:
        for program in programs or tuple(self.stack.running_):
            self.stack.wait_ready(program, timeout)

    wait_until = staticmethod(wait_until)

    # Access

    def psql(self, query: str, *values: object) -> list[tuple]:
        """Runs and commits a statement. Returns its rows, if any."""
        connection = self._database()
        try:
            cursor = connection.execute(query, values or None)
            rows = cursor.fetchall() if cursor.description else []
        except BaseException:
            connection.close()
            raise
        self.databases_.append(connection)
        return rows

    def _database(self):
        """Returns a connection that nobody else uses. They are kept, because making one takes longer than most statements."""
        import psycopg

        with contextlib.suppress(IndexError):    # none is left
            while True:
                kept, readable = self.databases_.pop(), select.poll()
                readable.register(kept.fileno(), select.POLLIN)
                if not readable.poll(0):
                    return kept
                kept.close()    # the server has said something meanwhile: that it ends
        # Prepared statements would fail after a migration.
        return psycopg.connect(self.dsn, autocommit=True, prepare_threshold=None)

    def _leave_database(self) -> None:
        with contextlib.suppress(IndexError):
            while True:
                self.databases_.pop().close()

    @property
    def redis(self):
        """Returns a client of the stack's Redis with str responses."""
        import redis

        return redis.Redis(unix_socket_path=str(self.stack.settings.socket("redis")), decode_responses=True)

    @property
    def redis_address(self) -> str:
        """Returns the address in the form of the programs' setting `redis`."""
        return self.stack.settings.redis

    def mails(self, to: str | None = None) -> list[EmailMessage]:
        """Returns the sent mails, oldest first, optionally only those to `to`."""
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


class StackFactory:
    """Creates the stacks of a test run and removes them. `shared`: a folder that the processes of a parallel run share."""

    def __init__(self, shared: Path | None = None) -> None:
        self.shared_ = shared
        self.opened: list[TestStack] = []
        self.folders_: list[Path] = []
        self.run_as = users.ordinary_user()
        self.copies_ = Path(tempfile.mkdtemp(prefix="diaphane-copy-"))
        self.copies_.chmod(0o755)
        self.layout_: layout.Layout | None = None
        self.cluster_: Path | None = None

    def folder(self) -> Path:
        """Returns an empty directory that the ordinary user owns and can access, unlike pytest's tmp_path."""
        made = Path(tempfile.mkdtemp(prefix="diaphane-test-"))
        self.folders_.append(made)
        self.run_as.own(made)
        return made

    def shared(self) -> Path:
        """Returns the folder for what is made once for all processes of the run."""
        if self.shared_ is None:
            self.shared_ = self.folder()
        return self.shared_

    def layout(self) -> layout.Layout:
        if self.layout_ is None:
            self.layout_ = layout.reachable(self.run_as, self.copies_)
        return self.layout_

    def give_cluster(self, data: Path) -> None:
        """Copies a migrated Postgres cluster with its passwords into a new data directory, because initdb and all migrations take
        seconds."""
        kept = self.cluster()
        if not (data / "secrets").exists():
            (data / "secrets").mkdir(mode=0o700)
            self.run_as.own(data / "secrets")
        for name in ("secrets/postgres", "secrets/postgres-superuser", "postgres"):
            subprocess.run(["cp", "-a", "--reflink=auto", kept / name, data / name], check=True, cwd="/", **self.run_as.popen())

    def cluster(self) -> Path:
        """Returns the data directory of a stopped cluster with the newest schema and no rows, made once for all stacks of a run."""
        if self.cluster_ is None:
            folder = self.shared()
            made, beside = folder / "cluster", folder / "cluster.new"
            with one_at_a_time(folder):
                if not made.exists():
                    shutil.rmtree(beside, ignore_errors=True)
                    beside.mkdir()
                    self.run_as.own(beside)
                    self._make_cluster(beside)
                    beside.rename(made)
            self.cluster_ = made
        return self.cluster_

    def _make_cluster(self, data: Path) -> None:
        given = ports.random_free()
        stack = Stack(data=data, ports=given, layout=self.layout(), run_as=self.run_as, durable=False, only=("postgres",))
        stack.start()
        stack.migrate()
        self._make_small(data, given["postgres"], stack.stop)
        ports.give_back(given.values())

    def _make_small(self, data: Path, port: int, stop: Callable[[], None]) -> None:
        """Stops the cluster and leaves a third of it, because it is copied for each stack: without the databases from which others are
        created, and with a write-ahead log of 1 MB instead of 16."""
        import psycopg

        password = datadir.secret(data, "postgres-superuser", self.run_as)
        with psycopg.connect(host="127.0.0.1", port=port, user="postgres", password=password, dbname="postgres", autocommit=True) as database:
            database.execute("UPDATE pg_database SET datistemplate = false")
            for name in ("template0", "template1"):
                database.execute(f"DROP DATABASE {name}")
            database.execute("CHECKPOINT")
        stop()
        subprocess.run([POSTGRES_BIN / "pg_resetwal", "--wal-segsize=1", "-D", data / "postgres"], check=True, cwd="/", stdout=subprocess.DEVNULL,
                       **self.run_as.popen())

    def open(self, only: Iterable[str] | None = None, extra_env: dict[str, str] | None = None,
             data_dir: Path | None = None, engine: str = "cpu") -> TestStack:
        data = data_dir or self.folder()
        if not any(data.iterdir()) and (only is None or {"postgres", "api"} <= set(only)):
            self.give_cluster(data)
        (data / "secrets").mkdir(mode=0o700, exist_ok=True)
        self.run_as.own(data / "secrets")
        # Several stacks run side by side: the renderer of one must not keep the processor from another's Postgres.
        stack = Stack(data=data, ports=ports.random_free(), layout=self.layout(), run_as=self.run_as, engine=engine,
                      durable=False, polite=False, only=only, extra_env=SETTINGS | (extra_env or {}))
        stack.start(timeout=180)    # several stacks may start at once, on few cores
        running = TestStack(stack, self)
        stack.on_event = running.events.append
        self.opened.append(running)
        return running

    def shut(self, running: TestStack, keep_data: bool = False) -> None:
        running._leave_database()
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


__all__ = ["REPO", "StackFactory", "TestStack", "datadir", "free_port", "mails_in", "metrics_at"]
