"""Users and scans written straight into a stack, for tests that are about neither signing up nor ingest. That takes
milliseconds instead of half a second for a user, and of many seconds for a scan."""

from __future__ import annotations

import hashlib
import io
import os
import pickle
import shutil
import tarfile
import time
import uuid
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, NamedTuple

import httpx

from harness import TestStack, one_at_a_time

PASSWORD = "a long and quiet password"
#: Passwords and their stored forms. argon2id reads its cost from the stored form: these need 8 KiB and one pass, where the API
#: itself always writes 19 MiB and two (PasswordHasher.*), so that a test checks a password in microseconds.
HASHES = {
    PASSWORD: "$argon2id$v=19$m=8,t=1,p=1$ZGlhcGhhbmU$JzFtYkBIOZk564ihS0Pwa5JWY3mYWd8FSwztqpWbae4",
    "three blind mice run": "$argon2id$v=19$m=8,t=1,p=1$ZGlhcGhhbmU$yC5OPTFqRIlT2cdGv3b63nYSaQMc6fzL1vg0xsIS/uM",
}


#: The default of the setting `consent-version`.
PRIVACY_NOTICE = "2026-11-27"


class Seeded(NamedTuple):
    """A signed-in user: the id, the cookie's value, and the CSRF token."""

    id: str
    token: str
    csrf: str


def write_person(psql: Callable[..., Any], email: str, role: str = "", password: str = PASSWORD, consents: bool = False) -> Seeded:
    """Writes a signed-in user to the database as signing up would. `role`: "unverified", "administrator", or any other text.
    `consents`: to recordings."""
    made, token, csrf = str(uuid.uuid4()), os.urandom(32).hex(), os.urandom(32).hex()
    psql("""WITH made AS (
              INSERT INTO users (id, email, email_key, password_hash, verified_at, is_administrator, recording_consent_at, consent_version, consent_at)
              VALUES (%s, %s, lower(%s), %s, CASE WHEN %s THEN now() END, %s, CASE WHEN %s THEN now() END, %s, now()) RETURNING id)
            INSERT INTO web_sessions (token_hash, user_id, csrf_token, expires_at)
            SELECT %s, id, %s, now() + interval '14 days' FROM made""",
         made, email, email, HASHES[password], role != "unverified", role == "administrator", consents, PRIVACY_NOTICE, stored(token), csrf)
    return Seeded(made, token, csrf)


def stored(token: str) -> str:
    """Returns the form in which the database has a token."""
    return hashlib.blake2b(token.encode(), digest_size=32).hexdigest()


#: What ingest and `head` write about a scan.
COLUMNS = ("modality", "size_x", "size_y", "size_z", "spacing_x", "spacing_y", "spacing_z", "repairs", "volume_bytes", "head")
LOOKS = ("skin", "muscle", "vessels", "bone", "through", "dense", "airways", "brain")


@dataclass
class Scan:
    """A scan that ingest has built once, kept to be copied: its row, its volume, and its pictures."""

    row: tuple
    volume: Path
    pictures: Path


#: The scans of a run by the folder of their files. The first stack that needs one has it built by its ingestd. It is kept beside
#: this folder, from where all processes of the run take it if they share the folder.
_built: dict[Path, Scan] = {}


def give_scan(stack: TestStack, email: str, folder: Path, title: str) -> str:
    """Gives the user with this address a ready scan of this folder. Returns its id."""
    if folder not in _built:
        kept = folder.with_name(f"{folder.name}-built")
        kept.mkdir(exist_ok=True)
        with one_at_a_time(kept):
            if not (kept / "row").exists():
                row = _build(stack, folder, kept)
                (kept / "row").write_bytes(pickle.dumps(row))
        _built[folder] = Scan(pickle.loads((kept / "row").read_bytes()), kept / "volume", kept / "pictures")
    scan, made = _built[folder], str(uuid.uuid4())
    _place(stack, scan.volume, stack.data_dir / "volumes" / made)
    _place(stack, scan.pictures, stack.data_dir / "cache" / "thumbnails" / made)
    stack.psql(f"INSERT INTO data_sets (id, owner_id, title, state, {', '.join(COLUMNS)}) "
               f"SELECT %s, id, %s, 'ready'{', %s' * len(COLUMNS)} FROM users WHERE email = %s", made, title, *scan.row, email)
    return made


def _place(stack: TestStack, kept: Path, to: Path) -> None:
    run_as = stack.stack.run_as
    if not to.parent.exists():
        to.parent.mkdir(mode=0o700)
        run_as.own(to.parent)
    shutil.copytree(kept, to)
    for path in (to, *to.iterdir()):
        run_as.own(path)


def _build(stack: TestStack, folder: Path, kept: Path) -> tuple:
    """Has the stack build the scan, copies its volume and pictures to `kept`, and returns its row."""
    person, made = write_person(stack.psql, f"seed-{uuid.uuid4().hex[:12]}@example.org"), str(uuid.uuid4())
    upload = stack.data_dir / "uploads" / f"{made}.tar"
    upload.write_bytes(bundle([file.read_bytes() for file in sorted(folder.iterdir())]))
    stack.stack.run_as.own(upload)
    stack.psql("INSERT INTO data_sets (id, owner_id, state) VALUES (%s, %s, 'queued')", made, person.id)
    stack.psql("INSERT INTO uploads (id, data_set_id, length, received, expires_at) VALUES (%s, %s, %s, %s, now() + interval '1 hour')",
               made, made, upload.stat().st_size, upload.stat().st_size)
    stack.psql("INSERT INTO ingest_jobs (data_set_id, upload_id) VALUES (%s, %s)", made, made)
    stack.psql("NOTIFY ingest_jobs")
    # Ready, and the upload deleted, which is the last that ingest does.
    stack.wait_until(lambda: stack.psql("SELECT 1 FROM data_sets WHERE id = %s AND state = 'ready'", made) and not upload.exists(), 120, "the seeded scan")
    _have_pictures(stack, person, made)
    for name, source in (("volume", stack.data_dir / "volumes" / made), ("pictures", stack.data_dir / "cache" / "thumbnails" / made)):
        shutil.rmtree(kept / name, ignore_errors=True)
        shutil.copytree(source, kept / name)
    columns = ", ".join("head::text" if name == "head" else name for name in COLUMNS)
    [row] = stack.psql(f"SELECT {columns} FROM data_sets WHERE id = %s", made)
    return row


def _have_pictures(stack: TestStack, person: Seeded, made: str) -> None:
    """Has the worker render the picture of each look."""
    with httpx.Client(base_url=stack.url, cookies={"diaphane": person.token}, timeout=60, trust_env=False) as http:
        for look in LOOKS:
            path = f"/v1/data-sets/{made}/thumbnails/{look}"
            stack.wait_until(lambda path=path: http.get(path).status_code == 200 or time.sleep(0.2), 120, f"the picture of {look}")


def bundle(files: list[bytes]) -> bytes:
    """Returns the tar that a browser creates from the files of a series (docs/contracts.md, "Upload bundle")."""
    out = io.BytesIO()
    with tarfile.open(fileobj=out, mode="w", format=tarfile.USTAR_FORMAT) as tar:
        for number, data in enumerate(files, 1):
            info = tarfile.TarInfo(f"{number:05d}.dcm")
            info.size = len(data)
            tar.addfile(info, io.BytesIO(data))
    return out.getvalue()
