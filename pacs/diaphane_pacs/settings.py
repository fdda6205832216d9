"""The settings file of the gateway, in TOML. Secrets are in files of their own, which it names."""

from __future__ import annotations

import re
import ssl
import tomllib
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from . import limits

MOST_ARCHIVES = 50
MOST_CALLERS = 50
LEAST_SECRET = 32
_AE_TITLE = r"[\x21-\x5b\x5d-\x7e]{1,16}"


class SettingsError(Exception):
    """A mistake in the settings, with the name of the field."""


@dataclass(frozen=True)
class Tls:
    """Files of a connection with TLS. Without `ca`, the certificates of the system are trusted."""

    ca: Path | None = None
    certificate: Path | None = None
    key: Path | None = None

    def client(self) -> ssl.SSLContext:
        context = ssl.create_default_context(cafile=self.ca)
        if self.certificate:
            context.load_cert_chain(self.certificate, self.key)
        return context

    def server(self) -> ssl.SSLContext:
        context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH, cafile=self.ca)
        context.load_cert_chain(self.certificate, self.key)  # type: ignore[arg-type]
        # With `ca`, only devices with a certificate of it may send.
        context.verify_mode = ssl.CERT_REQUIRED if self.ca else ssl.CERT_NONE
        return context


@dataclass(frozen=True)
class WebArchive:
    """A server with DICOMweb."""

    name: str
    title: str
    url: str
    user: str = ""
    secret: str = ""     # the password with a user, otherwise a bearer token, or empty
    tls: Tls = field(default_factory=Tls)
    timeout: float = limits.IDLE_SECONDS     # seconds without a byte


@dataclass(frozen=True)
class DimseArchive:
    """A server with DIMSE, which answers C-FIND, and C-GET or C-MOVE."""

    name: str
    title: str
    host: str
    port: int
    ae_title: str
    own_ae_title: str
    tls: Tls | None = None
    timeout: float = limits.IDLE_SECONDS
    move_to: str = ""    # the AE title of the receiver for C-MOVE; empty for C-GET


@dataclass(frozen=True)
class Receiver:
    """Receives scans by C-STORE from the callers, whose AE titles are mapped to API tokens, and from archives with C-MOVE."""

    port: int
    ae_title: str
    callers: dict[str, str]
    address: str = "127.0.0.1"
    quiet_seconds: float = 5
    tls: Tls | None = None
    movers: frozenset[str] = frozenset()     # AE titles of archives with C-MOVE


@dataclass(frozen=True)
class Settings:
    archives: dict[str, WebArchive | DimseArchive]
    receiver: Receiver | None = None

    @property
    def quiet_seconds(self) -> float:
        """Seconds after which a series that others send is complete."""
        return self.receiver.quiet_seconds if self.receiver else 5


def read(path: Path) -> Settings:
    try:
        return parse(tomllib.loads(path.read_text(encoding="utf-8")), path.parent)
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise SettingsError(f"cannot read {path}: {error}") from error


def read_secret(path: Path, least: int = 1) -> str:
    """Returns the first word of a file."""
    try:
        words = path.read_text(encoding="utf-8").split()
    except (OSError, UnicodeDecodeError) as error:
        raise SettingsError(f"cannot read the secret in {path}") from error
    if len(words) != 1 or len(words[0]) < least:
        raise SettingsError(f"{path} must contain one word of at least {least} characters")
    return words[0]


def parse(data: dict[str, Any], folder: Path) -> Settings:
    """Checks decoded settings. Relative paths are relative to `folder`."""
    top = _Table(data, "", folder)
    receiver = _receiver(top.table("receiver")) if "receiver" in data else None
    archives = [_archive(one, receiver) for one in top.tables("archive", MOST_ARCHIVES)]
    top.finish()
    if receiver:
        receiver = replace(receiver, movers=frozenset(one.ae_title for one in archives if isinstance(one, DimseArchive) and one.move_to))
        if not receiver.callers and not receiver.movers:
            raise SettingsError("receiver.caller: is missing, and no archive has retrieve = \"move\"")
    names = [one.name for one in archives]
    if len(set(names)) < len(names):
        raise SettingsError("archive: two archives have the same name")
    return Settings({one.name: one for one in archives}, receiver)


class _Table:
    """Reads a table strictly: a field that is missing, wrong or unknown is a mistake."""

    def __init__(self, data: Any, where: str, folder: Path):
        if not isinstance(data, dict):
            raise SettingsError(f"{where}: must be a table")
        self._data, self._where, self._folder, self._known = data, where, folder, set[str]()

    def wrong(self, name: str, why: str) -> SettingsError:
        return SettingsError(f"{self._where}{name}: {why}")

    def has(self, name: str) -> bool:
        return name in self._data

    def text(self, name: str, pattern: str, fallback: str | None = None) -> str:
        self._known.add(name)
        value = self._data.get(name, fallback)
        if not isinstance(value, str) or (value != fallback and not re.fullmatch(pattern, value)):
            raise self.wrong(name, "is missing" if value is None else "has an invalid value")
        return value

    def number(self, name: str, low: float, high: float, fallback: float | None = None) -> float:
        self._known.add(name)
        value = self._data.get(name, fallback)
        if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
            raise self.wrong(name, f"must be a number from {low:g} to {high:g}")
        return value

    def path(self, name: str) -> Path | None:
        text = self.text(name, r"[^\0]+", "")
        return self._folder / text if text else None

    def secret(self, name: str, least: int = 1) -> str:
        path = self.path(name)
        return read_secret(path, least) if path else ""

    def table(self, name: str) -> _Table:
        self._known.add(name)
        return _Table(self._data.get(name), f"{self._where}{name}.", self._folder)

    def tables(self, name: str, most: int) -> list[_Table]:
        self._known.add(name)
        found = self._data.get(name, [])
        if not isinstance(found, list) or len(found) > most:
            raise self.wrong(name, f"must be a list of at most {most} tables")
        return [_Table(one, f"{self._where}{name} {number}: ", self._folder) for number, one in enumerate(found, 1)]

    def finish(self) -> None:
        if unknown := sorted(set(self._data) - self._known):
            raise self.wrong(unknown[0], "is not a known field")


def _tls(table: _Table, certificate_needed: bool = False) -> Tls:
    tls = Tls(table.path("ca_file"), table.path("certificate_file"), table.path("key_file"))
    table.finish()
    if bool(tls.certificate) != bool(tls.key) or (certificate_needed and not tls.certificate):
        raise table.wrong("certificate_file", "needs certificate_file and key_file")
    return tls


def _archive(table: _Table, receiver: Receiver | None) -> WebArchive | DimseArchive:
    name, title = table.text("name", r"[a-z0-9_.-]{1,40}"), table.text("title", r"[^\x00-\x1f]{1,80}")
    made: WebArchive | DimseArchive
    timeout = table.number("timeout_seconds", 1, 120, limits.IDLE_SECONDS)
    if table.has("url"):
        url = table.text("url", r"https?://[\x21-\x7e]{1,500}").rstrip("/")
        if urlsplit(url).username or urlsplit(url).query or urlsplit(url).fragment:
            raise table.wrong("url", "must have no user, query or fragment")
        user = table.text("user", r"[^\x00-\x1f:]{1,200}", "")
        secret = table.secret("password_file") if user else table.secret("token_file")
        made = WebArchive(name, title, url, user, secret, _tls(table.table("tls")) if table.has("tls") else Tls(), timeout)
    else:
        moves = table.text("retrieve", r"get|move", "get") == "move"
        if moves and receiver is None:
            raise table.wrong("retrieve", "\"move\" needs [receiver], to which the archive sends")
        made = DimseArchive(name, title, table.text("host", r"[A-Za-z0-9.:_-]{1,253}"), int(table.number("port", 1, 65535)),
                            table.text("ae_title", _AE_TITLE), table.text("own_ae_title", _AE_TITLE, "DIAPHANE"),
                            _tls(table.table("tls")) if table.has("tls") else None, timeout, receiver.ae_title if receiver and moves else "")
    table.finish()
    return made


def _receiver(table: _Table) -> Receiver:
    callers: dict[str, str] = {}
    for one in table.tables("caller", MOST_CALLERS):
        callers[one.text("ae_title", _AE_TITLE)] = one.secret("token_file", LEAST_SECRET)
        one.finish()
    if not all(callers.values()):
        raise table.wrong("caller", "each caller needs ae_title and token_file")
    made = Receiver(int(table.number("port", 1, 65535)), table.text("ae_title", _AE_TITLE, "DIAPHANE"), callers,
                    table.text("address", r"[0-9a-f.:]{2,45}", "127.0.0.1"), table.number("quiet_seconds", 0.2, 120, 5),
                    _tls(table.table("tls"), certificate_needed=True) if table.has("tls") else None)
    table.finish()
    return made
