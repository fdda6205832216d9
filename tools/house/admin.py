"""`./diaphane admin`: who is an administrator, on the machine that runs it."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

from . import datadir, paths, supervise
from .layout import of_checkout
from .plan import Settings
from .says import HouseError


def run(data: Path, what: str, email: str | None) -> int:
    """`what`: grant, revoke, forget-factor (of `email`) or list. Done by diaphane-api with the database of what runs on `data`."""
    if (what == "list") == (email is not None):
        raise HouseError("list takes no address" if email else f"{what} whom? ./diaphane admin {what} EMAIL", 64)
    if supervise.running_supervisor(data) is None:
        raise HouseError(f"nothing runs on {data}; start it first: ./diaphane up --detach")
    secret = data / "secrets" / "postgres"
    try:
        password = secret.read_text(encoding="ascii").strip()
    except OSError as error:
        raise HouseError(f"{secret} cannot be read: be root, or the user that Diaphane runs as") from error
    settings = Settings(data=data, ports=datadir.read_record(data)["ports"], layout=of_checkout(), postgres_password=password)
    binary = paths.build_dir() / "bin" / "diaphane-api"
    if not binary.exists():
        raise HouseError(f"{binary} is not built")
    words = [what] if email is None else [what, email]
    return subprocess.run([str(binary), "admin", *words], env={**os.environ, "DIAPHANE_POSTGRES": settings.dsn}).returncode
