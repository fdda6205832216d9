"""The private Postgres cluster of a data directory."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

from .plan import POSTGRES_BIN
from .console import CliError
from .users import RunAs

#: Creates the programs' role. It is not a superuser, so an attacker in `api` still cannot read
#: files or run programs through Postgres.
_ROLE = """
\\getenv password DIAPHANE_PASSWORD
SELECT format('CREATE ROLE diaphane LOGIN PASSWORD %L', :'password')
  WHERE NOT EXISTS (SELECT FROM pg_roles WHERE rolname = 'diaphane') \\gexec
SELECT 'CREATE DATABASE diaphane OWNER diaphane'
  WHERE NOT EXISTS (SELECT FROM pg_database WHERE datname = 'diaphane') \\gexec
"""


def initialise(data: Path, run_as: RunAs, superuser_password_file: Path, durable: bool) -> None:
    """Runs initdb once. The cluster is created under another name and renamed, so that it is either complete or absent."""
    cluster, beside = data / "postgres", data / "postgres.new"
    if cluster.exists():
        return
    shutil.rmtree(beside, ignore_errors=True)
    command = [str(POSTGRES_BIN / "initdb"), "-D", str(beside), "-U", "postgres", "--auth=scram-sha-256",
               f"--pwfile={superuser_password_file}", "-E", "UTF8", "--locale=C.UTF-8"]
    if not durable:
        command.append("--no-sync")
    done = subprocess.run(command, cwd="/", capture_output=True, text=True, **run_as.popen())
    if done.returncode != 0:
        raise CliError(f"initdb failed:\n{done.stdout}{done.stderr}")
    beside.rename(cluster)


def make_database(port: int, superuser_password: str, password: str) -> None:
    """Creates the programs' role and database if they are missing."""
    env = {"PATH": os.environ.get("PATH", ""), "PGPASSWORD": superuser_password, "DIAPHANE_PASSWORD": password}
    command = [str(POSTGRES_BIN / "psql"), "-qtAX", "-v", "ON_ERROR_STOP=1", "-h", "127.0.0.1", "-p", str(port),
               "-U", "postgres", "-d", "postgres"]
    done = subprocess.run(command, input=_ROLE, env=env, cwd="/", capture_output=True, text=True)
    if done.returncode != 0:
        raise CliError(f"cannot create the database: {done.stderr.strip()}")
