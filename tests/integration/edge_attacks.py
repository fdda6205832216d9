"""Attacks on the edge as data (design: "The edge"). Each is what one hostile connection sends."""

from __future__ import annotations

from dataclasses import dataclass

REFUSED = frozenset({400, 405, 408, 411, 413, 414, 431, 501, 505})


@dataclass(frozen=True)
class Attack:
    """`statuses`: those of all answers on the connection, in order; each of `refused` when empty."""

    name: str
    data: bytes
    answers: int = 1                       # at most
    allowed: frozenset[int] = REFUSED      # each answer's status is one of these
    must_answer: bool = True


def _post(headers: bytes, body: bytes = b"", path: bytes = b"/v1/sign-in") -> bytes:
    return (b"POST " + path + b" HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
            b"Connection: close\r\n" + headers + b"\r\n" + body)


def _get(path: bytes, headers: bytes = b"", method: bytes = b"GET", version: bytes = b"HTTP/1.1") -> bytes:
    return method + b" " + path + b" " + version + b"\r\nHost: localhost\r\nConnection: close\r\n" + headers + b"\r\n"


_CHUNKED = b"Transfer-Encoding: chunked\r\n"
#: Asks for what nothing else asks for: the API counts such requests.
_INNER = b"GET /v1/sessions HTTP/1.1\r\nHost: localhost\r\n\r\n"
#: What a page of one's own may be answered with: an ordinary answer, by way of which nothing is smuggled.
_ORDINARY = REFUSED | {200, 401, 403, 404, 415, 422}


def _chunks() -> list[Attack]:
    sizes = {
        "-1": b"-1", "-2": b"-2", "huge": b"ffffffffffffffff", "huger": b"f" * 400, "no number": b"zz", "empty": b"",
        "plus": b"+5", "0x": b"0x5", "blank": b" 5", "semicolon": b";", "NUL": b"5\0", "tab": b"5\t\t;",
    }
    made = [Attack(f"chunk size {name}, {path.decode()}", _post(_CHUNKED, size + b"\r\nhello\r\n0\r\n\r\n", path),
                   allowed=_ORDINARY)
            for name, size in sizes.items() for path in (b"/v1/sign-in", b"/v1/none", b"/")]
    made += [
        Attack("a chunk longer than it says", _post(_CHUNKED, b"2\r\nhello\r\n0\r\n\r\n")),
        Attack("no end of a chunk", _post(_CHUNKED, b"5\r\nhelloXX0\r\n\r\n")),
        Attack("an endless chunk extension", _post(_CHUNKED, b"5;" + b"x" * 300_000 + b"\r\nhello\r\n0\r\n\r\n"),
               allowed=_ORDINARY),
        Attack("a body of 3 MB in chunks", _post(_CHUNKED, (b"10000\r\n" + b"x" * 65536 + b"\r\n") * 48)),
    ]
    return made


def _lengths() -> list[Attack]:
    values = {"-1": b"-1", "plus": b"+5", "hex": b"0x5", "huge": b"9" * 40, "list": b"5, 5", "blank": b"5 5", "word": b"x",
              "empty": b""}
    made = [Attack(f"Content-Length {name}", _post(b"Content-Length: " + value + b"\r\n", b"hello"), allowed=_ORDINARY)
            for name, value in values.items()]
    made += [
        Attack("two equal Content-Lengths", _post(b"Content-Length: 5\r\nContent-Length: 5\r\n", b"hello")),
        Attack("two different Content-Lengths", _post(b"Content-Length: 5\r\nContent-Length: 0\r\n", _INNER)),
        Attack("Content-Length and chunked", _post(b"Content-Length: 5\r\n" + _CHUNKED, b"0\r\n\r\n" + _INNER)),
        Attack("chunked and Content-Length", _post(_CHUNKED + b"Content-Length: 5\r\n", b"0\r\n\r\n" + _INNER)),
        Attack("a declared body of 9 GB", _post(b"Content-Length: 9663676416\r\n", b"x")),
    ]
    for name, coding in {"gzip": b"gzip", "twice": b"chunked, chunked", "identity": b"identity", "x": b"xchunked",
                         "tab": b"\tchunked", "vertical tab": b"\x0bchunked", "quoted": b'"chunked"'}.items():
        made.append(Attack(f"Transfer-Encoding {name}", _post(b"Transfer-Encoding: " + coding + b"\r\n", b"0\r\n\r\n"),
                           allowed=_ORDINARY))
    made.append(Attack("two Transfer-Encodings", _post(_CHUNKED * 2, b"0\r\n\r\n" + _INNER)))
    made.append(Attack("a folded Transfer-Encoding", _post(b"Transfer-Encoding:\r\n chunked\r\n", b"0\r\n\r\n" + _INNER)))
    return made


def _headers() -> list[Attack]:
    padding = b"X-Padding: " + b"p" * 512 + b"\r\n"
    made = []
    for name, byte in {"TAB": b"\t", "non-ASCII": b"\xe4", "0xff": b"\xff", "DEL": b"\x7f", "NUL": b"\0", "ESC": b"\x1b"}.items():
        for header in (b"Cookie", b"X-CSRF-Token", b"Origin", b"Authorization", b"X-Any", b"Idempotency-Key"):
            made.append(Attack(f"{name} in {header.decode()}",
                               _get(b"/v1/me", header + b": a" + byte + b"b\r\n" + padding + b"X: " + _INNER),
                               answers=2, allowed=_ORDINARY))
    made += [
        Attack("200 KB of headers", _get(b"/v1/me", b"".join(b"X-%d: %s\r\n" % (i, b"x" * 1000) for i in range(200)))),
        Attack("one header of 100 KB", _get(b"/v1/me", b"X: " + b"x" * 100_000 + b"\r\n")),
        Attack("10000 small headers", _get(b"/v1/me", b"".join(b"X-%d: x\r\n" % i for i in range(10_000)))),
        Attack("a folded header", _get(b"/v1/me", b"X: a\r\n b\r\n"), allowed=_ORDINARY),
        Attack("a bare carriage return", _get(b"/v1/me", b"X: a\rY: b\r\n"), allowed=_ORDINARY),
        Attack("line feeds alone", b"GET /v1/me HTTP/1.1\nHost: localhost\nConnection: close\n\n", allowed=_ORDINARY),
        Attack("blank before the colon", _get(b"/v1/me", b"Content-Length : 5\r\n"), allowed=_ORDINARY),
        Attack("no colon", _get(b"/v1/me", b"nonsense\r\n"), allowed=_ORDINARY),
        Attack("two Hosts", _get(b"/v1/me", b"Host: evil.test\r\n")),
        Attack("no Host", b"GET /v1/me HTTP/1.1\r\nConnection: close\r\n\r\n"),
        Attack("method override", _get(b"/v1/me", b"X-HTTP-Method-Override: DELETE\r\n"), allowed=frozenset({401})),
        Attack("a forged address", _get(b"/v1/me", b"X-Forwarded-For: 10.0.0.1\r\nX-Real-IP: 10.0.0.1\r\n"),
               allowed=frozenset({401})),
        Attack("from a page with a name of 260 characters", _post(b"Content-Length: 2\r\nOrigin: https://" + b"a." * 126 + b"test\r\n", b"{}"),
               allowed=frozenset({403})),
        Attack("a forged X-Accel-Redirect", _get(b"/v1/me", b"X-Accel-Redirect: /_cache/\r\n"), allowed=frozenset({401})),
    ]
    return made


def _paths() -> list[Attack]:
    bad = [b"//v1/me", b"//x/v1/me", b"/v1//me", b"///", b"/v1/%2e%2e/me", b"/v1/..%2fme", b"/%2fv1/me", b"/v1/../v1/me",
           b"/v1/./me", b"/v1/me%00", b"/v1/%zz", b"/v1/%", b"/v1/me%", b"/v1/m%65", b"/v1\\me", b"/v1/me?a=%zz", b"/v1/me#a",
           b"/..", b"/.git/config", b"/v1/" + b"a" * 3000, b"/v1/me?" + b"a" * 3000, b"/v1/\xc3\xa4", b"*", b"v1/me", b"",
           b"http://localhost//v1/me", b"/v1/me?a=\x01", b"/assets/../index.html", b"/%5fcache/x"]
    made = [Attack(f"path {path[:40]!r}", _get(path), allowed=REFUSED) for path in bad]
    made += [
        Attack("the internal cache", _get(b"/_cache/thumbnails/x/skin.jpg"), allowed=frozenset({404})),
        Attack("the internal problem", _get(b"/_problem"), allowed=frozenset({404})),
        Attack("the stream without upgrade", _get(b"/stream?ticket=" + b"0" * 64), allowed=frozenset({426})),
        Attack("the stream without a ticket", _get(b"/stream", b"Upgrade: websocket\r\n"), allowed=frozenset({400})),
        Attack("a path of 60 KB", _get(b"/" + b"a" * 60_000)),
    ]
    return made


def _lines() -> list[Attack]:
    made = [Attack(f"method {method[:20]!r}", _get(b"/v1/me", method=method))
            for method in (b"TRACE", b"TRACK", b"CONNECT", b"BREW", b"PUT", b"PROPFIND", b"get", b"G\0T", b"X" * 5000, b"GET\t",
                           b"PRI", b"\xc3\xa4")]
    made += [Attack(f"version {version!r}", _get(b"/v1/me", version=version), must_answer=False)
             for version in (b"HTTP/0.9", b"HTTP/1.2", b"HTTP/2.0", b"HTTP/3", b"HTTP/1.10", b"http/1.1", b"HTTP/", b"HTTP/1.1 X",
                             b"HTTP/999999999999.1")]
    made += [
        Attack("HTTP/0.9", b"GET /v1/me\r\n", must_answer=False),
        Attack("HTTP/0.9 of the page", b"GET /\r\n", must_answer=False),
        Attack("the preface of HTTP/2", b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", must_answer=False),
        Attack("TLS", b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + b"\0" * 100, must_answer=False),
        Attack("zeros", b"\0" * 10_000, must_answer=False),
        Attack("noise", bytes((i * 7919 + 13) % 256 for i in range(20_000)), must_answer=False),
        Attack("empty lines", b"\r\n" * 5000 + _get(b"//v1/me"), must_answer=False),
    ]
    return made


ATTACKS: list[Attack] = [*_chunks(), *_lengths(), *_headers(), *_paths(), *_lines()]
