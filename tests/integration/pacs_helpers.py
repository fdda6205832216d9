"""Users of archives, and what they do."""

from __future__ import annotations

import hashlib
import uuid
from datetime import datetime, timedelta, timezone

from api_client import Person, person
from archives import new_token, open_stack, phantom_folder
from harness import StackFactory, TestStack, wait_until
from ingest_helpers import state
from lying_archive import SERIES, STUDY, LyingArchive


def give_token(stack: TestStack, who: Person, scopes: str, token: str = "") -> str:
    """Gives the user a token and returns it."""
    token = token or new_token()
    now = datetime.now(timezone.utc)
    stack.psql("INSERT INTO api_tokens (id, user_id, token_hash, name, scopes, created_at, expires_at) VALUES (%s, %s, %s, 'test', %s, %s, %s)",
               str(uuid.uuid4()), user_id(stack, who), hashlib.blake2b(token.encode(), digest_size=32).hexdigest(), scopes, now, now + timedelta(days=1))
    return token


def user_id(stack: TestStack, who: Person) -> str:
    return str(stack.psql("SELECT id FROM users WHERE email = %s", who.email)[0][0])


def radiologist(stack: TestStack) -> Person:
    """Returns a user with access to the archives."""
    made = person(stack)
    stack.psql("UPDATE users SET archive_access = true WHERE email = %s", made.email)
    return made


def fetched(who: Person, archive: str, study: str, series: str, title: str = "Head", seconds: float = 120) -> dict:
    """Starts a fetch and returns its end."""
    answer = who.http.post(f"/v1/archives/{archive}/fetches", json={"study": study, "series": series, "title": title})
    assert answer.status_code == 202, answer.text
    return fetch_end(who, archive, answer.json()["id"], seconds)


def fetch_end(who: Person, archive: str, fetch: str, seconds: float = 120) -> dict:
    def ended() -> dict | None:
        shown = who.http.get(f"/v1/archives/{archive}/fetches/{fetch}").json()
        return shown if shown["state"] in ("done", "failed", "cancelled") else None

    return wait_until(ended, seconds, "the end of the fetch")


def audit(stack: TestStack, action: str) -> list[dict]:
    return [row[0] for row in stack.psql("SELECT details FROM audit_log WHERE action = %s ORDER BY id", action)]


def archive_ways(factory: StackFactory) -> None:
    """Lets every operation of the archives succeed."""
    with LyingArchive(phantom_folder(factory)) as honest:
        stack = open_stack(factory, [{"name": "honest", "title": "Archive", "url": honest.url("honest")}])
        try:
            who, path = radiologist(stack), "/v1/archives/honest"
            who.http.get("/v1/archives")
            who.http.post(f"{path}/studies", json={"patient_name": "Phantasia"})
            who.http.post(f"{path}/series", json={"study": STUDY})
            end = fetched(who, "honest", STUDY, SERIES)
            assert end["state"] == "done"
            who.http.delete(f"{path}/fetches/{end['id']}")
            who.http.post("/v1/archive-receipts", json={"via": "stow", "study": STUDY})
        finally:
            factory.shut(stack)


def wait_ready(stack, data_set: str) -> None:
    """Waits for the end of ingest, also of a scan that is still being uploaded."""
    stack.wait_until(lambda: state(stack, data_set)[0] not in ("uploading", "queued", "building"), timeout=90, what="the end of ingest")
    assert state(stack, data_set)[0] == "ready"
