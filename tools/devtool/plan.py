"""The plan of one machine: which programs run, with which settings, in which order. Plain data that starts nothing."""

from __future__ import annotations

import os
import signal
from dataclasses import dataclass, field
from pathlib import Path
from typing import Mapping

from .layout import Layout

POSTGRES_BIN = Path("/usr/lib/postgresql/15/bin")
# Much longer than other programs, because Postgres syncs what it wrote before it ends, which takes many seconds on a busy disk,
# and after a kill the next start has to recover.
POSTGRES_STOP_SECONDS = 20.0

#: Folders of a data directory (docs/contracts.md), besides `postgres`, which initdb creates. `secrets` has mode 0700.
FOLDERS = ("redis", "uploads", "volumes", "cache", "legal", "mail", "scratch", "spool", "run", "logs", "secrets")

#: Variables of the user's environment that are passed to the programs. No others are.
PASSED_ON = ("PATH", "LANG", "TZ", "LD_LIBRARY_PATH", "CUDA_VISIBLE_DEVICES", "NVIDIA_VISIBLE_DEVICES",
             "ASAN_OPTIONS", "TSAN_OPTIONS", "UBSAN_OPTIONS")


@dataclass(frozen=True)
class Ready:
    """How to check that a program is ready: `http` (GET path, 200), `answers` (any HTTP response), `postgres`, `redis` (path of
    its socket)."""

    kind: str
    port: int
    path: str = "/readyz"


@dataclass(frozen=True)
class Program:
    name: str
    argv: tuple[str, ...]
    ready: Ready
    port: int                       # 0: reached over a Unix socket
    tier: int                       # started in ascending order, stopped in descending order
    env: Mapping[str, str] = field(default_factory=dict)
    stop_signal: int = signal.SIGTERM
    stop_seconds: float = 2.8       # killed afterwards; the sum over the tiers without Postgres must stay below 5 s
    requires: tuple[Path, ...] = () # files that must exist before it can start
    nice: int = 0                   # lower CPU priority, so that rendering comes first on few cores
    optional: bool = False          # left out if files are missing, and nothing waits for it
    cores: int = 0                  # runs on that many of the cores; 0: on all

    def missing(self) -> list[Path]:
        return [path for path in self.requires if not path.exists()]


@dataclass(frozen=True)
class Settings:
    data: Path
    ports: Mapping[str, int]
    layout: Layout
    postgres_password: str
    sockets: Path | None = None     # folder of the Unix sockets; None: run/ of the data directory
    engine: str = "auto"
    durable: bool = True            # False: tests accept data loss when the machine (not a program) fails
    extra_env: Mapping[str, str] = field(default_factory=dict)

    @property
    def host(self) -> str:
        return f"localhost:{self.ports['edge']}"

    @property
    def url(self) -> str:
        return f"http://{self.host}"

    @property
    def dsn(self) -> str:
        return f"postgresql://diaphane:{self.postgres_password}@127.0.0.1:{self.ports['postgres']}/diaphane"

    def socket(self, name: str) -> Path:
        """Returns the socket of Redis or renderd. Its folder has mode 0700, so that other users of
        the machine cannot connect."""
        return (self.sockets or self.data / "run") / f"{name}.sock"

    @property
    def redis(self) -> str:
        return f"unix:{self.socket('redis')}"

    @property
    def archives(self) -> Path:
        """Returns the settings of the PACS gateway, which runs only with this file (docs/operate.md)."""
        return self.data / "archives.toml"

    @property
    def socket_dir(self) -> str:
        """Returns the folder of Postgres's socket, or an empty text if the path would be longer than a socket's name may be (107
        bytes)."""
        folder = str(self.data / "run")
        return folder if len(folder) < 80 else ""


def programs(s: Settings) -> list[Program]:
    """Returns all programs in the order of their start."""
    return [_postgres(s), _redis(s), _api(s), _gateway(s), _ingestd(s), _renderd(s), _analysis(s), _pacs(s), _edge(s)]


def _inherited(settings: Settings) -> dict[str, str]:
    kept = {k: v for k, v in os.environ.items() if k in PASSED_ON or k.startswith(("LC_", "DIAPHANE_"))}
    kept.pop("DIAPHANE_BUILD", None)
    return {"LANG": "C.UTF-8", **kept, "HOME": str(settings.data), **settings.extra_env}


def _own(settings: Settings, **values: object) -> dict[str, str]:
    """Returns the environment of one of Diaphane's programs, in which the setting `api_port` becomes DIAPHANE_API_PORT. The
    command line would show passwords to every user of the machine."""
    return _inherited(settings) | {f"DIAPHANE_{k.upper()}": str(v) for k, v in values.items()} | settings.extra_env


def _postgres(s: Settings) -> Program:
    argv = [str(POSTGRES_BIN / "postgres"), "-D", str(s.data / "postgres"), "-p", str(s.ports["postgres"]),
            "-c", "listen_addresses=127.0.0.1", "-c", f"unix_socket_directories={s.socket_dir}",
            "-c", "logging_collector=off", "-c", "max_connections=60", "-c", "log_line_prefix=%m ",
            # Keeps statements, their parameters, and the DETAIL of an error, which quotes rows, out of the log, because they
            # contain users' addresses.
            "-c", "log_min_error_statement=panic", "-c", "log_parameter_max_length_on_error=0",
            "-c", "log_error_verbosity=terse"]
    if not s.durable:
        argv += ["-c", "fsync=off", "-c", "full_page_writes=off"]
    return Program(
        name="postgres", argv=tuple(argv), env=_inherited(s), port=s.ports["postgres"], tier=0,
        ready=Ready("postgres", s.ports["postgres"]), requires=(POSTGRES_BIN / "postgres",),
        stop_signal=signal.SIGINT,   # "fast" shutdown: ends its sessions and loses nothing
        stop_seconds=POSTGRES_STOP_SECONDS,
        nice=10)


def _redis(s: Settings) -> Program:
    argv = ("/usr/bin/redis-server", "--port", "0", "--unixsocket", str(s.socket("redis")), "--unixsocketperm", "600",
            "--dir", str(s.data / "redis"), "--appendonly", "yes", "--save", "", "--daemonize", "no",
            "--maxmemory", "256mb", "--maxmemory-policy", "noeviction")
    return Program(name="redis", argv=argv, env=_inherited(s), port=0, tier=0,
                   ready=Ready("redis", 0, str(s.socket("redis"))), requires=(Path(argv[0]),), stop_seconds=1.3)


def _api(s: Settings) -> Program:
    binary = s.layout.bin / "diaphane-api"
    return Program(
        name="api", argv=(str(binary),), port=s.ports["api"], tier=1, requires=(binary,), nice=5,
        ready=Ready("http", s.ports["api-admin"]),
        env=_own(s, postgres=s.dsn, redis=s.redis, api_port=s.ports["api"],
                 admin_port=s.ports["api-admin"], public_url=s.url,
                 upload_dir=s.data / "uploads", volume_dir=s.data / "volumes", cache_dir=s.data / "cache",
                 mail=f"file:{s.data / 'mail'}", mail_from="Diaphane <diaphane@localhost>",
                 study_analysis_url=f"http://127.0.0.1:{s.ports['analysis']}",
                 archive_url=f"http://127.0.0.1:{s.ports['pacs']}" if s.archives.exists() else "", archive_key=s.data / "secrets" / "archive-key",
                 sample_token=s.data / "secrets" / "sample-token", factor_key=s.data / "secrets" / "factor-key"))


def _gateway(s: Settings) -> Program:
    binary = s.layout.bin / "diaphane-gateway"
    return Program(
        name="gateway", argv=(str(binary),), port=s.ports["stream"], tier=1, requires=(binary,),
        ready=Ready("http", s.ports["gateway-admin"]),
        env=_own(s, redis=s.redis, stream_port=s.ports["stream"],
                 admin_port=s.ports["gateway-admin"], public_url=s.url))


def migrate(s: Settings) -> tuple[list[str], dict[str, str]]:
    """Returns command and environment to migrate the database to the newest schema."""
    argv = [str(s.layout.bin / "diaphane-api"), "migrate", "up", "--migrations", str(s.layout.migrations)]
    return argv, _own(s, postgres=s.dsn)


def _ingestd(s: Settings) -> Program:
    binary = s.layout.bin / "diaphane-ingestd"
    env = _own(s, postgres=s.dsn, upload_dir=s.data / "uploads", volume_dir=s.data / "volumes",
               scratch_dir=s.data / "scratch", export_dir=s.data / "cache" / "exports",
               admin_port=s.ports["ingestd-admin"])
    return Program(
        name="ingestd", argv=(str(binary),), port=s.ports["ingestd-admin"], tier=1, requires=(binary,), nice=10,
        # Uses only some cores, so that others are free for work that a user waits for, like the
        # renderer.
        cores=int(env.get("DIAPHANE_THREADS") or 0), ready=Ready("http", s.ports["ingestd-admin"]), env=env)


def _renderd(s: Settings) -> Program:
    binary = s.layout.bin / "diaphane-renderd"
    return Program(
        name="renderd", argv=(str(binary),), port=0, tier=1, requires=(binary,),
        ready=Ready("http", s.ports["renderd-admin"]),
        env=_own(s, worker_id="local", redis=s.redis, grpc_address=f"unix:{s.socket('renderd')}",
                 advertise=f"unix:{s.socket('renderd')}", admin_port=s.ports["renderd-admin"],
                 volume_dir=s.data / "volumes", engine=s.engine))


def _analysis(s: Settings) -> Program:
    folders = (s.layout.study_libraries, s.layout.studies)
    return Program(
        name="analysis", argv=("/usr/bin/python3", "-m", "diaphane_studies.serve"), port=s.ports["analysis"], tier=1, nice=10, stop_seconds=1,
        requires=(folders[0] / "numpy", folders[1] / "diaphane_studies"), optional=True, ready=Ready("http", s.ports["analysis"]),
        env=_own(s, port=s.ports["analysis"]) | {"PYTHONPATH": os.pathsep.join(map(str, folders)), "PYTHONDONTWRITEBYTECODE": "1", "MPLCONFIGDIR": str(s.data / "cache")})


def _pacs(s: Settings) -> Program:
    folders = (s.layout.pacs_libraries, s.layout.pacs, s.layout.client)
    return Program(
        name="pacs", argv=("/usr/bin/python3", "-m", "diaphane_pacs.serve"), port=s.ports["pacs"], tier=1, nice=5, stop_seconds=1,
        requires=(folders[0] / "pynetdicom", folders[1] / "diaphane_pacs", s.archives), optional=True, ready=Ready("http", s.ports["pacs"]),
        env=_own(s, port=s.ports["pacs"], archives=s.archives, archive_key=s.data / "secrets" / "archive-key", api_url=s.url,
                 spool_dir=s.data / "spool")
        | {"PYTHONPATH": os.pathsep.join(map(str, folders)), "PYTHONDONTWRITEBYTECODE": "1", "TMPDIR": str(s.data / "scratch")})


def nginx_conf(s: Settings, template: str) -> str:
    """Returns the edge's configuration with every @NAME@ replaced."""
    values = {
        "LISTEN": f"127.0.0.1:{s.ports['edge']}", "API_PORT": s.ports["api"], "STREAM_PORT": s.ports["stream"],
        "PACS": f"127.0.0.1:{s.ports['pacs']}", "ARCHIVES": "on" if s.archives.exists() else "off",
        "STATIC_DIR": s.layout.static, "RUN_DIR": s.data / "run", "CACHE_DIR": s.data / "cache", "LEGAL_DIR": s.data / "legal",
        "LOG": s.data / "logs" / "edge.log", "PUBLIC_HOST": s.host,
    }
    return filled(template, values)


def filled(template: str, values: Mapping[str, object]) -> str:
    """Replaces each @NAME@ by its value."""
    for name, value in values.items():
        template = template.replace(f"@{name}@", str(value))
    return template


def _edge(s: Settings) -> Program:
    conf = s.data / "run" / "nginx.conf"
    argv = ("/usr/sbin/nginx", "-c", str(conf), "-p", str(s.data / "run"), "-e", "stderr")
    return Program(name="edge", argv=argv, env=_inherited(s), port=s.ports["edge"], tier=2, stop_seconds=0.7,
                   ready=Ready("answers", s.ports["edge"], "/"), requires=(Path(argv[0]), conf))
