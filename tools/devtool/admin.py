"""`./diaphane admin`: manages the administrators of a running instance."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

from . import datadir, paths, supervise
from .layout import of_checkout
from .plan import Settings
from .console import CliError


def run(data: Path, what: str, email: str | None) -> int:
    """Runs `diaphane-api admin` with the database of the instance on `data`. `what` is grant, revoke, reset-2fa or list."""
    if (what == "list") == (email is not None):
        raise CliError("list takes no EMAIL" if email else f"missing argument: EMAIL (./diaphane admin {what} EMAIL)", 64)
    if supervise.running_supervisor(data) is None:
        raise CliError(f"Diaphane is not running on {data}. Start it first: ./diaphane up --detach")
    secret = data / "secrets" / "postgres"
    try:
        password = secret.read_text(encoding="ascii").strip()
    except OSError as error:
        raise CliError(f"cannot read {secret}. Run this command as root or as the user that Diaphane runs as") from error
    settings = Settings(data=data, ports=datadir.read_record(data)["ports"], layout=of_checkout(), postgres_password=password)
    binary = paths.build_dir() / "bin" / "diaphane-api"
    if not binary.exists():
        raise CliError(f"{binary} is missing. Run ./diaphane up to build it")
    arguments = [what] if email is None else [what, email]
    return subprocess.run([str(binary), "admin", *arguments], env={**os.environ, "DIAPHANE_POSTGRES": settings.dsn}).returncode
