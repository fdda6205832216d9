"""A user of the REST API, shared by the API tests. Every response is validated against api/openapi.yaml."""

from __future__ import annotations

import base64
import hashlib
import re
import time
import uuid

import httpx
import pyotp
import pytest
from api_contract import Contract
from harness import REPO, StackFactory, TestStack
from seeds import PASSWORD, write_person

CONTRACT = Contract(REPO / "api" / "openapi.yaml")
PART = 8 * 1024 * 1024


@pytest.fixture(scope="session")
def api(all_stacks: StackFactory) -> TestStack:
    """Stores, api and edge, once for all API tests, without ingestd, so that queued jobs stay queued."""
    if not hasattr(all_stacks, "api_stack"):
        all_stacks.api_stack = all_stacks.open(only=("postgres", "redis", "api", "edge"))
    return all_stacks.api_stack


@pytest.fixture(scope="module")
def one(api: TestStack) -> "Person":
    """A user that all tests of a file share."""
    return person(api)


@pytest.fixture(scope="module")
def other(api: TestStack) -> "Person":
    """Another user."""
    return person(api)


def client(stack: TestStack) -> httpx.Client:
    """Returns a browser without a user, whose every response is validated against the contract."""
    # The stack has no TLS, and loading the machine's certificates would take longer than most tests.
    return httpx.Client(base_url=stack.url, timeout=30, verify=False, event_hooks={"response": [CONTRACT.check]})


def problem(answer: httpx.Response, status: int, kind: str) -> dict:
    """Returns the problem document, which must have this status and kind."""
    assert answer.status_code == status, f"{answer.status_code} {answer.text}"
    assert answer.headers["content-type"] == "application/problem+json"
    document = answer.json()
    assert document["type"] == f"urn:diaphane:problem:{kind}"
    assert document["status"] == status
    assert document["request_id"] == answer.headers["x-request-id"]
    return document


def forget_attempts(stack: TestStack) -> None:
    """Resets rate limits, because all tests come from one address."""
    stack.psql("DELETE FROM attempts")


def link_token(stack: TestStack, email: str, page: str = "verify") -> str:
    """Returns the token of the newest link to that page mailed to that address."""
    mails = stack.wait_until(lambda: [m for m in stack.mails(email) if f"/{page}#token=" in m.get_content()], what="the mail")
    found = re.search(rf"(\S+)/{page}#token=([0-9a-f]{{64}})\s", mails[-1].get_content())
    assert found and found[1] == stack.url
    return found[2]


class Device:
    """An authenticator app whose user never uses a code twice."""

    STEP = 30

    def __init__(self, secret: str):
        self.totp = pyotp.TOTP(secret)
        self.given = 0

    def code(self) -> str:
        """Returns the next unused code. Waits only for a third one within a minute."""
        while self.given + 1 > time.time() // self.STEP + 1:
            time.sleep(0.2)
        self.given = max(self.given + 1, int(time.time() // self.STEP))
        return self.at(self.given)

    def at(self, step: int) -> str:
        """Returns the code of a 30 s step since 1970."""
        return self.totp.generate_otp(step)


class Person:
    """A signed-in user with an account."""

    def __init__(self, stack: TestStack, email: str | None = None):
        self.stack = stack
        self.email = email or f"person-{uuid.uuid4().hex[:12]}@example.org"
        self.http = client(stack)
        self.csrf = ""
        self.device: Device | None = None

    def sign_up(self) -> "Person":
        forget_attempts(self.stack)
        assert self.http.post("/v1/accounts", json={"email": self.email, "consent": True}).status_code == 202
        token = link_token(self.stack, self.email)
        return self._signed_in(self.shows_password("/v1/accounts/verify", {"token": token, "password": PASSWORD}))

    def is_seeded(self) -> "Person":
        forget_attempts(self.stack)
        _, token, self.csrf = write_person(self.stack.psql, self.email)
        self.http.cookies.set("diaphane", token, domain="localhost.local")
        self.http.headers["X-CSRF-Token"] = self.csrf
        return self

    def sign_in(self) -> "Person":
        given = {"email": self.email, "password": PASSWORD, **({"code": self.device.code()} if self.device else {})}
        return self._signed_in(self.shows_password("/v1/sign-in", given))

    def _signed_in(self, answer: httpx.Response) -> "Person":
        assert answer.status_code == 200, answer.text
        self.csrf = answer.json()["csrf_token"]
        self.http.headers["X-CSRF-Token"] = self.csrf
        return self

    def becomes_administrator(self) -> "Person":
        """Makes this account an administrator with a second factor. Sessions that are signed in become administrators, too."""
        self.stack.psql("UPDATE users SET is_administrator = true WHERE email = %s", self.email)
        if self.device is None:
            self.sets_up_second_factor()
        return self

    def sets_up_second_factor(self) -> list[str]:
        """Returns the recovery codes. Signs out all other browsers of the user."""
        self.begins_second_factor()
        assert self.device
        answer = self.http.post("/v1/me/second-factor/confirm", json={"code": self.device.code()})
        assert answer.status_code == 200, answer.text
        return answer.json()["recovery_codes"]

    def begins_second_factor(self) -> None:
        answer = self.shows_password("/v1/me/second-factor", {"password": PASSWORD})
        assert answer.status_code == 201, answer.text
        self.device = Device(answer.json()["secret"])

    def removes_second_factor(self) -> None:
        assert self.device
        given = {"password": PASSWORD, "code": self.device.code()}
        answer = self.shows_password("/v1/me/second-factor/removal", given)
        assert answer.status_code == 204, answer.text
        self.device = None

    def shows_password(self, path: str, given: dict) -> httpx.Response:
        """Retries while the server rejects password checks because too many are in progress."""
        for _ in range(100):
            answer = self.http.post(path, json=given)
            if answer.status_code != 503:
                break
            time.sleep(0.2)
        return answer

    def is_no_administrator(self) -> None:
        self.stack.psql("UPDATE users SET is_administrator = false WHERE email = %s", self.email)

    @property
    def id(self) -> str:
        return self.http.get("/v1/me").json()["id"]

    def announce(self, size: int, title: str = "", **headers: str) -> httpx.Response:
        return self.http.post("/v1/data-sets", json={"title": title, "bytes": size}, headers=headers)

    def data_set(self, size: int = 1000, title: str = "") -> dict:
        answer = self.announce(size, title)
        assert answer.status_code == 201, answer.text
        return answer.json()

    def patch(self, upload_url: str, offset: int, part: bytes, **headers: str) -> httpx.Response:
        return self.http.patch(upload_url, content=part, headers={
            "Tus-Resumable": "1.0.0", "Upload-Offset": str(offset),
            "Content-Type": "application/offset+octet-stream", **headers})

    def offset(self, upload_url: str) -> int:
        answer = self.http.head(upload_url, headers={"Tus-Resumable": "1.0.0"})
        assert answer.status_code == 200
        return int(answer.headers["upload-offset"])

    def upload(self, data: bytes, part_size: int = PART, title: str = "") -> dict:
        """Uploads a data set completely and returns it."""
        made = self.data_set(len(data), title)
        for start in range(0, len(data), part_size):
            answer = self.patch(made["upload_url"], start, data[start:start + part_size])
            assert answer.status_code == 204, answer.text
        return made["data_set"]


def person(stack: TestStack) -> Person:
    """Returns a signed-in user who did not have to sign up."""
    return Person(stack).is_seeded()


def signed_up(stack: TestStack) -> Person:
    """Returns a signed-in user as the page makes one: with a welcoming mail, and in a browser that is known from then on."""
    return Person(stack).sign_up()


def make_ready(stack: TestStack, data_set_id: str) -> None:
    """Does what ingestd does in the end, as far as the database shows it."""
    stack.psql("""UPDATE data_sets SET state = 'ready', modality = 'CT', size_x = 10, size_y = 20, size_z = 30,
                  spacing_x = 1, spacing_y = 1, spacing_z = 2.5, volume_bytes = 12000, repairs = '{one repair}'
                  WHERE id = %s""", data_set_id)
    stack.psql("DELETE FROM ingest_jobs WHERE data_set_id = %s", data_set_id)
    stack.psql("DELETE FROM uploads WHERE data_set_id = %s", data_set_id)


def ready_without_upload(stack: TestStack, owner: Person) -> str:
    """Returns a data set that is ready although nothing was uploaded. A running ingestd finds nothing to read and refuses
    nothing."""
    data_set = owner.data_set()["data_set"]["id"]
    make_ready(stack, data_set)
    (stack.data_dir / "uploads" / f"{data_set}.tar").unlink(missing_ok=True)
    return data_set


def put_thumbnail(stack: TestStack, data_set_id: str) -> None:
    """Puts a thumbnail where the API keeps those that it rendered (api/scans/thumbnails.cpp)."""
    folder = stack.data_dir / "cache" / "thumbnails" / data_set_id
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "bone.7.jpg"
    file.write_bytes(b"\xff\xd8\xff")
    for path in (file, folder, folder.parent):
        stack.stack.run_as.own(path)


def add_worker(stack: TestStack, name: str, slots: int = 4, seconds: int = 60, address: str = "127.0.0.1:1") -> None:
    """Adds a render worker as its heartbeat would. Nothing listens at the usual address."""
    key = f"diaphane:worker:{name}"
    stack.redis.hset(key, mapping={
        "address": address, "incarnation": uuid.uuid4().hex, "engine": "cpu", "device": "test", "slots": slots,
        "used": 0, "draining": 0, "load": "0", "volumes": "", "epoch": "1"})
    stack.redis.expire(key, seconds)
    stack.redis.sadd("diaphane:workers", name)


def remove_worker(stack: TestStack, name: str) -> None:
    stack.redis.delete(f"diaphane:worker:{name}", f"diaphane:worker:{name}:sessions")


def checksum(algorithm: str, data: bytes) -> str:
    return f"{algorithm} {base64.b64encode(hashlib.new(algorithm, data).digest()).decode()}"
