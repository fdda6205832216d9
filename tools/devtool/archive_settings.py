"""The settings file of the PACS gateway that `./diaphane up --archive NAME=URL` writes."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Sequence

from . import datadir
from .console import CliError
from .users import RunAs

#: Recognises a file that may be replaced.
MARK = "# Written by ./diaphane up --archive. Remove this line to keep your changes.\n"


def from_options(archives: Sequence[str]) -> str:
    """Returns the file for NAME=URL options, or an empty text without options. Raises CliError for an invalid one."""
    return MARK + "".join(map(_archive, archives)) if archives else ""


def _archive(option: str) -> str:
    name, _, url = option.partition("=")
    dimse = re.fullmatch(r"dicom://([!-?A-~]{1,16})@([A-Za-z0-9._-]+):(\d{1,5})", url)
    if not re.fullmatch(r"[a-z0-9_.-]{1,40}", name) or not (dimse or re.fullmatch(r"https?://[!-~]+", url)):
        raise CliError(f"--archive: invalid value '{option}' (expected NAME=https://HOST/dicom-web or NAME=dicom://AE_TITLE@HOST:PORT; "
                       "a name has only a-z, 0-9, '_', '.' and '-')")
    fields: dict[str, object] = {"name": name, "title": name}
    fields |= {"ae_title": dimse[1], "host": dimse[2], "port": int(dimse[3])} if dimse else {"url": url}
    return "[[archive]]\n" + "".join(f"{key} = {json.dumps(value)}\n" for key, value in fields.items())


def write(data: Path, text: str, run_as: RunAs) -> None:
    """Writes archives.toml. Raises CliError instead of replacing a file that a user wrote."""
    path = data / "archives.toml"
    if path.exists() and not path.read_text(encoding="utf-8", errors="replace").startswith(MARK):
        raise CliError(f"{path} exists already. Add the archive there, and leave out --archive")
    # A folder with nothing but this file would not be known as a data directory.
    datadir.prepare(data, run_as)
    path.write_text(text, encoding="utf-8")
    path.chmod(0o600)
    run_as.own(path)
