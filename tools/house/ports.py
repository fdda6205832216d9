"""Ports: the wanted one, or the next that is free."""

from __future__ import annotations

import random
import socket
from typing import Iterable

#: Default ports of one machine (docs/contracts.md), in the order in which they are handed out. Redis and renderd have none: their
#: sockets are files that nobody else can reach.
DEFAULTS = {
    "edge": 8080,
    "api": 8081,
    "stream": 8082,
    "postgres": 8083,
    "api-admin": 8091,
    "ingestd-admin": 8092,
    "renderd-admin": 8093,
    "gateway-admin": 8094,
}


def is_free(port: int) -> bool:
    """Nobody listens on it, on the loopback or on all addresses."""
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
    """No other start of Diaphane on this machine has chosen it: two that look at the same moment both find it free, and
    one of them would fail later. Held by this process until it ends, however it ends (an abstract Unix address)."""
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
    """What was claimed and is needed no more, so that others may have it."""
    for port in given:
        if mark := _claims.pop(port, None):
            mark.close()


def allot(wanted: dict[str, int], free=is_free) -> tuple[dict[str, int], list[str]]:
    """A port for each name, and what to say of those that were taken."""
    given: dict[str, int] = {}
    notes = []
    for name, first in wanted.items():
        # Another name's own default is left to it, as long as there is another choice.
        reserved = {port for other, port in wanted.items() if other != name}
        port = first
        while port in given.values() or (port != first and port in reserved) or not free(port):
            port += 1
            if port > 65535:
                raise OSError(f"no free port for {name} from {first} on")
        if port != first:
            notes.append(f"port {first} ({name}) is taken, using {port}")
        given[name] = port
    return given, notes


def random_free() -> dict[str, int]:
    """For tests and measurements: free ports below the range from which the kernel takes the ports of outgoing connections,
    so that nobody takes one of them while a program that had it is being restarted. Claimed: give_back() when all is stopped."""
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
