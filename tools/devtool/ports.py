"""Chooses ports: the requested one, or the next free one."""

from __future__ import annotations

import random
import socket
from typing import Iterable

#: Default ports of one machine (docs/contracts.md) in the order of allocation. Redis and renderd use socket files that other
#: users cannot reach.
DEFAULTS = {
    "edge": 8080,
    "api": 8081,
    "stream": 8082,
    "postgres": 8083,
    "api-admin": 8091,
    "ingestd-admin": 8092,
    "renderd-admin": 8093,
    "gateway-admin": 8094,
    "analysis": 8095,
    "pacs": 8096,
}


def is_free(port: int) -> bool:
    """Whether no program listens on the port, on the loopback or on all addresses."""
    for address in ("127.0.0.1", "0.0.0.0"):
        with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind((address, port))
            except OSError:
                return False
    return True


_claims: dict[int, socket.socket] = {}


def claim(port: int) -> bool:
    """Whether no other start of Diaphane on this machine has claimed the port. Two starts that check at the same time both find
    it free, and one would fail later. This process holds the claim until it ends in any way (an abstract Unix address)."""
    if port in _claims:
        return True
    mark = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        mark.bind(f"\0diaphane-port-{port}")
    except OSError:
        mark.close()
        return False
    _claims[port] = mark
    return True


def give_back(given: Iterable[int]) -> None:
    """Releases claimed ports that are no longer needed, so that others can use them."""
    for port in given:
        if mark := _claims.pop(port, None):
            mark.close()


def allot(requested: dict[str, int], free=is_free) -> tuple[dict[str, int], list[str]]:
    """Returns a port for each name, and messages about those that were in use."""
    given: dict[str, int] = {}
    notes = []
    for name, first in requested.items():
        # Leaves another program's default port free as long as there is another choice.
        reserved = {port for other, port in requested.items() if other != name}
        port = first
        while port in given.values() or (port != first and port in reserved) or not free(port):
            port += 1
            if port > 65535:
                raise OSError(f"no free port for {name} at or above {first}")
        if port != first:
            notes.append(f"Port {first} ({name}) is in use. Using {port} instead.")
        given[name] = port
    return given, notes


def random_free() -> dict[str, int]:
    """Returns free ports for tests and measurements, below the range that the kernel uses for outgoing connections, so that none
    is taken while its program restarts. They are claimed: call give_back() when everything is stopped."""
    given: dict[str, int] = {}
    while len(given) < len(DEFAULTS):
        port = random.randrange(15000, 30000)
        if port in _claims or not claim(port):
            continue
        if is_free(port):
            given[list(DEFAULTS)[len(given)]] = port
        else:
            give_back([port])
    return given
