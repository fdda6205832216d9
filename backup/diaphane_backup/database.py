"""Postgres by its own programs: dumps, restores, and the lock that keeps files while they are copied."""

from __future__ import annotations

import os
import shlex
import subprocess
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from urllib.parse import parse_qsl, unquote, urlsplit

from .errors import BackupError

#: api deletes no files while another connection holds this lock (DataSetRepository::disposals).
LOCK = 4711820932
#: Environment variables of libpq for the parameters of a connection. The password must not be in the arguments of a program.
_VARIABLES = {
    "host": "PGHOST", "hostaddr": "PGHOSTADDR", "port": "PGPORT", "user": "PGUSER", "password": "PGPASSWORD", "dbname": "PGDATABASE",
    "sslmode": "PGSSLMODE", "sslrootcert": "PGSSLROOTCERT", "sslcert": "PGSSLCERT", "sslkey": "PGSSLKEY", "sslcrl": "PGSSLCRL",
    "connect_timeout": "PGCONNECT_TIMEOUT", "application_name": "PGAPPNAME", "options": "PGOPTIONS", "channel_binding": "PGCHANNELBINDING",
    "gssencmode": "PGGSSENCMODE", "krbsrvname": "PGKRBSRVNAME", "target_session_attrs": "PGTARGETSESSIONATTRS", "passfile": "PGPASSFILE"}
#: Rows that must not come back: sign-ins and links in mails that may have been withdrawn, and mails that have been sent.
_FORGOTTEN = ("web_sessions", "email_tokens", "mail_queue", "idempotency_keys", "attempts")


def variables(text: str) -> dict[str, str]:
    """Returns the environment variables for a connection string of libpq, either a URL or `key=value` pairs.

    Raises BackupError for one that is malformed or has an unknown parameter.
    """
    if text.startswith(("postgresql://", "postgres://")):
        try:
            url = urlsplit(text)
            named = {"host": url.hostname or "", "port": str(url.port or ""), "user": unquote(url.username or ""),
                     "password": unquote(url.password or ""), "dbname": unquote(url.path.removeprefix("/"))}
        except ValueError as error:
            raise BackupError("the URL of the database is invalid") from error
        if "," in url.netloc:
            raise BackupError("the URL of the database names several hosts; name the primary")
        given = {**{name: value for name, value in named.items() if value}, **dict(parse_qsl(url.query, keep_blank_values=True))}
    else:
        try:
            parts = [part.partition("=") for part in shlex.split(text)]
        except ValueError as error:
            raise BackupError("the connection string of the database is invalid") from error
        if not parts or any(not equals for _, equals, _ in parts):
            raise BackupError("the connection string of the database is invalid")
        given = {name: value for name, _, value in parts}
    if unknown := sorted(set(given) - set(_VARIABLES)):
        raise BackupError(f"the connection string of the database has unknown parameters: {', '.join(unknown)}")
    return {_VARIABLES[name]: value for name, value in given.items()}


class Database:
    """A database of Diaphane. `programs` is the folder of pg_dump, pg_restore and psql; without one, PATH is searched."""

    def __init__(self, connection: str, programs: Path | None = None):
        environment = os.environ if programs is None else {**os.environ, "PATH": f"{programs}:{os.environ.get('PATH', '')}"}
        self._env: Mapping[str, str] = {**environment, **variables(connection)}

    def dump(self, into: Path) -> None:
        """Writes a dump of one moment. Raises BackupError."""
        self._run("pg_dump", "--format=custom", "--no-owner", "--no-privileges", f"--file={into}")

    def restore(self, dump: Path) -> None:
        """Replaces everything in the database by a dump, in one transaction. Raises BackupError, after which nothing has changed."""
        replace = ["psql", "--no-psqlrc", "--quiet", "--single-transaction", "--set=ON_ERROR_STOP=1",
                   "--command=DROP SCHEMA public CASCADE; CREATE SCHEMA public", "--file=-"]
        write = ["pg_restore", "--exit-on-error", "--no-owner", "--no-privileges", "--file=-", str(dump)]
        with subprocess.Popen(write, env=self._env, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as script:
            done = subprocess.run(replace, env=self._env, stdin=script.stdout, capture_output=True, text=True)
        if done.returncode != 0 or script.returncode != 0:
            raise BackupError(f"the database cannot be restored: {_reason(done.stderr)}")

    def has_users(self) -> bool:
        exists = self.ask("SELECT to_regclass('public.users') IS NOT NULL") == "t"
        return exists and self.ask("SELECT EXISTS (SELECT FROM users)") == "t"

    def forget_sign_ins(self) -> None:
        """Deletes what must not come back from a backup, so that users sign in again."""
        self.ask(";".join(f"DELETE FROM {table}" for table in _FORGOTTEN))

    def data_sets(self) -> set[str]:
        """Returns the IDs of all scans."""
        return set(self.ask("SELECT id FROM data_sets").split())

    def ask(self, query: str) -> str:
        """Returns the rows of a query, one per line. Raises BackupError."""
        return self._run("psql", "--no-psqlrc", "--quiet", "--no-align", "--tuples-only", "--set=ON_ERROR_STOP=1", f"--command={query}").strip()

    @contextmanager
    def files_kept(self) -> Iterator[None]:
        """While it lasts, no file of a scan is deleted. If this process dies, the connection ends, and with it the lock.

        Raises BackupError if another backup runs.
        """
        command = ["psql", "--no-psqlrc", "--quiet", "--no-align", "--tuples-only", "--set=ON_ERROR_STOP=1"]
        with subprocess.Popen(command, env=self._env, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as holder:
            assert holder.stdin and holder.stdout
            try:
                holder.stdin.write(f"SELECT pg_try_advisory_lock({LOCK});\n")
                holder.stdin.flush()
                answer = holder.stdout.readline().strip()
                if answer != "t":
                    raise BackupError("another backup is running" if answer == "f" else "the database does not answer")
                yield
                if holder.poll() is not None:
                    raise BackupError("the connection to the database was lost, so files may have been deleted meanwhile")
            except BrokenPipeError as error:
                raise BackupError("the database does not answer") from error
            finally:
                holder.kill()

    def _run(self, program: str, *arguments: str) -> str:
        done = subprocess.run([program, *arguments], env=self._env, stdin=subprocess.DEVNULL, capture_output=True, text=True)
        if done.returncode != 0:
            raise BackupError(f"{program} failed: {_reason(done.stderr)}")
        return done.stdout


def _reason(text: str) -> str:
    """Returns the first line, because later ones may quote rows."""
    return (text.strip().splitlines() or ["no output"])[0]
