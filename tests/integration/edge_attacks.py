"""Attacks on the edge as data (design: "The edge"): what hostile connections send instead of, or around, a well-formed request.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

#: Statuses with which the edge refuses a malformed request.
REFUSED = frozenset({400, 405, 408, 411, 413, 414, 426, 431, 501, 505})


@dataclass(frozen=True)
class Request:
    """A well-formed request. `headers` excludes Host, Connection and lengths."""

    method: bytes
    path: bytes
    headers: tuple[tuple[bytes, bytes], ...] = ()
    body: bytes = b""
    #: The edge reads the body first, so that a malformed body is refused. Bodies to pages are discarded.
    reads_body: bool = True
    body_limit: int = 1 << 20

    def line(self) -> bytes:
        return self.method + b" " + self.path + b" HTTP/1.1\r\n"

    def own(self) -> bytes:
        return b"".join(name + b": " + value + b"\r\n" for name, value in self.headers)

    def length(self) -> bytes:
        return b"Content-Length: %d\r\n" % len(self.body) if self.body or self.method in (b"POST", b"PATCH") else b""

    def data(self, extra: bytes = b"", close: bool = True) -> bytes:
        connection = b"Connection: close\r\n" if close and not self._upgrades() else b""
        return self.line() + b"Host: localhost\r\n" + connection + self.own() + self.length() + extra + b"\r\n" + self.body

    def framed(self, framing: bytes, body: bytes) -> bytes:
        """Returns the request with another framing and body."""
        connection = b"" if self._upgrades() else b"Connection: close\r\n"
        return self.line() + b"Host: localhost\r\n" + connection + self.own() + framing + b"\r\n" + body

    def _upgrades(self) -> bool:
        return any(name == b"Connection" for name, _ in self.headers)


@dataclass(frozen=True)
class Attack:
    """`refused`: every response has a status in REFUSED. Otherwise, it may also be the response to the request itself."""

    kind: str
    name: str
    data: bytes
    refused: bool = False
    answers: int = 1                       # maximum number
    must_answer: bool = True
    only: frozenset[int] = frozenset()     # if not empty, the status of each response is one of these
    page: bool = False                     # the attacked address may be one of the page
    leaves: str = ""                       # "close" or "reset": leaves without reading a response


#: A request without a session, which the API counts under its own name.
INNER = b"GET /v1/sessions HTTP/1.1\r\nHost: localhost\r\n\r\n"
_CHUNKED = b"Transfer-Encoding: chunked\r\n"
_BYTES = {"TAB": b"\t", "non-ASCII": b"\xe4", "0xff": b"\xff", "DEL": b"\x7f", "NUL": b"\0", "ESC": b"\x1b"}


_NOISE = bytes((i * 7919 + 13) % 256 for i in range(20_000))
_MANY_HEADERS = b"".join(b"X-%d: x\r\n" % i for i in range(10_000))
_LARGE_HEADERS = b"".join(b"X-%d: %s\r\n" % (i, b"x" * 1000) for i in range(200))
_COOKIES = b"".join(b"Cookie: a%d=b\r\n" % i for i in range(200))
_RANGES = b",".join(b"%d-%d" % (i, i) for i in range(0, 2000, 2))[:7000]
_FULL_CHUNK = b"10000\r\n" + b"x" * 65536 + b"\r\n"


def chunk(body: bytes) -> bytes:
    return b"%x\r\n" % len(body) + body + b"\r\n0\r\n\r\n" if body else b"0\r\n\r\n"


def _chunks(one: Request) -> list[Attack]:
    body = one.body or b"hello"
    sizes = {
        "-1": b"-1", "-2": b"-2", "huge": b"f" * 16, "huger": b"f" * 400, "no number": b"zz", "empty": b"", "plus": b"+5", "0x": b"0x5",
        "blank": b" 5", "semicolon": b";", "NUL": b"5\0", "larger by one than its 64 bits": b"1" + b"0" * 16,
    }
    made = [Attack("chunks", f"chunk size {name}", one.framed(_CHUNKED, size + b"\r\n" + body + b"\r\n0\r\n\r\n"), one.reads_body)
            for name, size in sizes.items()]
    made += [
        Attack("chunks", "a chunk longer than it says", one.framed(_CHUNKED, b"2\r\n" + body + b"\r\n0\r\n\r\n"), one.reads_body),
        Attack("chunks", "no end of a chunk", one.framed(_CHUNKED, b"%x\r\n" % len(body) + body + b"XX0\r\n\r\n"), one.reads_body),
        Attack("chunks", "a body beyond the limit in chunks", one.framed(_CHUNKED, _FULL_CHUNK * (one.body_limit // 65536 + 2)), one.reads_body),
        Attack("chunks", "an endless chunk extension", one.framed(_CHUNKED, b"5;" + b"x" * 300_000 + b"\r\nhello\r\n0\r\n\r\n")),
        Attack("chunks", "its body in chunks", one.framed(_CHUNKED, chunk(one.body))),
        Attack("chunks", "tabs behind a chunk's size", one.framed(_CHUNKED, b"%x\t\t;\r\n" % len(body) + body + b"\r\n0\r\n\r\n")),
        Attack("chunks", "headers behind the last chunk", one.framed(_CHUNKED, chunk(one.body)[:-2] + b"X-CSRF-Token: x\r\nHost: y\r\n\r\n")),
    ]
    return made


def _lengths(one: Request) -> list[Attack]:
    values = {"-1": b"-1", "plus": b"+5", "hex": b"0x5", "huge": b"9" * 40, "list": b"5, 5", "blank": b"5 5", "word": b"x", "empty": b""}
    made = [Attack("lengths", f"Content-Length {name}", one.framed(b"Content-Length: " + value + b"\r\n", one.body or b"hello"), True)
            for name, value in values.items()]
    behind = b"0\r\n\r\n" + INNER
    made += [
        Attack("lengths", "two equal Content-Lengths", one.framed(b"Content-Length: 5\r\n" * 2, b"hello"), True),
        Attack("lengths", "two different Content-Lengths", one.framed(b"Content-Length: 5\r\nContent-Length: 0\r\n", INNER), True),
        Attack("lengths", "Content-Length and chunked", one.framed(b"Content-Length: 5\r\n" + _CHUNKED, behind), True),
        Attack("lengths", "chunked and Content-Length", one.framed(_CHUNKED + b"Content-Length: 5\r\n", behind), True),
        Attack("lengths", "a declared body of 9 GB", one.framed(b"Content-Length: 9663676416\r\n", b"x"), one.reads_body),
        Attack("lengths", "two Transfer-Encodings", one.framed(_CHUNKED * 2, behind), True),
        Attack("lengths", "a folded Transfer-Encoding", one.framed(b"Transfer-Encoding:\r\n chunked\r\n", behind), True),
        Attack("lengths", "a request where its body would be", one.framed(b"Content-Length: 0\r\n", INNER)),
        Attack("lengths", "a request behind the last chunk", one.framed(_CHUNKED, behind)),
    ]
    for name, coding in {"gzip": b"gzip", "twice": b"chunked, chunked", "x": b"xchunked", "tab": b"\tchunked", "vertical tab": b"\x0bchunked",
                         "quoted": b'"chunked"', "identity": b"identity"}.items():
        made.append(Attack("lengths", f"Transfer-Encoding {name}", one.framed(b"Transfer-Encoding: " + coding + b"\r\n", behind), True))
    return made


def _headers(one: Request) -> list[Attack]:
    # Wherever the listener cuts it, a request line with an unknown method would follow.
    hidden = b"X: " + b"P" * 700 + b" /v1/sessions HTTP/1.1\r\nY: b\r\n"
    # The listener cuts after what it reads at once: 512 bytes, or up to twice the largest request on its connection. This attack
    # is therefore larger than all others. It is only sent where its byte would pass through an edge that forwards headers.
    long_hidden = b"".join(b"X%d: " % n + b"P" * 7000 + b" /v1/sessions HTTP/1.1\r\n" for n in range(3))
    made = [Attack("headers", f"{name} in one more {header.decode()}", one.data(header + b": a" + byte + b"b\r\n" +
                   (long_hidden if header == b"X-Any" and name in ("TAB", "non-ASCII", "0xff", "ESC") else hidden)))
            for name, byte in _BYTES.items()
            for header in (b"Cookie", b"X-CSRF-Token", b"Origin", b"Authorization", b"X-Any", b"Idempotency-Key")]
    for number, (header, value) in enumerate(one.headers):
        for name, byte in _BYTES.items():
            for where, text in (("before", byte + value), ("behind", value + byte), ("in the middle of", value[:9] + byte + value[9:])):
                headers = (*one.headers[:number], (header, text), *one.headers[number + 1:])
                made.append(Attack("own headers", f"{name} {where} its {header.decode()}", replace(one, headers=headers).data(hidden)))
    bad = {
        "200 KB of headers": _LARGE_HEADERS, "one header of 100 KB": b"X: " + b"x" * 100_000 + b"\r\n",
        "10000 small headers": _MANY_HEADERS, "two Hosts": b"Host: evil.test\r\n",
    }
    made += [Attack("headers", name, one.data(extra), True) for name, extra in bad.items()]
    odd = {
        "a folded header": b"X: a\r\n b\r\n", "a bare carriage return": b"X: a\rY: b\r\n", "blank before the colon": b"Content-Length : 5\r\n",
        "no colon": b"nonsense\r\n", "no name": b": x\r\n", "a NUL in a name": b"X\0: y\r\n", "a name of 8000 bytes": b"x" * 8000 + b": y\r\n",
        "an empty cookie": b"Cookie:\r\n", "200 cookies": _COOKIES,
    }
    made += [Attack("headers", name, one.data(extra)) for name, extra in odd.items()]
    made += [
        Attack("headers", "line feeds alone", one.data().replace(b"\r\n", b"\n") if not one.body else one.data()[:-len(one.body)].replace(b"\r\n", b"\n") + one.body),
        Attack("headers", "no Host", one.data().replace(b"Host: localhost\r\n", b""), True),
        Attack("headers", "another Host", one.data().replace(b"Host: localhost\r\n", b"Host: evil.test\r\n")),
        Attack("headers", "a Host with a path", one.data().replace(b"Host: localhost\r\n", b"Host: evil.test/x@localhost\r\n")),
    ]
    return made


def _forged(one: Request) -> list[Attack]:
    """Headers that claim a false origin or client to a proxy."""
    from_elsewhere = frozenset({403}) if one.method in (b"POST", b"PATCH", b"DELETE") else frozenset()
    long_name = b"https://" + b"a." * 126 + b"test"
    made = [Attack("forged", f"from the page {name}", one.data(b"Origin: " + origin + b"\r\n"), only=from_elsewhere)
            for name, origin in {"evil.test": b"https://evil.test", "null": b"null", "of 260 characters": long_name}.items()
            if all(header != b"Origin" for header, _ in one.headers)]
    lines = {
        "method override": b"X-HTTP-Method-Override: DELETE\r\nX-HTTP-Method: DELETE\r\nX-Method-Override: DELETE\r\n",
        "an address": b"X-Forwarded-For: 10.0.0.1\r\nX-Real-IP: 10.0.0.1\r\nForwarded: for=10.0.0.1\r\nTrue-Client-IP: 10.0.0.1\r\n",
        "another path": b"X-Original-URL: /v1/admin/users\r\nX-Rewrite-URL: /v1/admin/users\r\n", "another host": b"X-Forwarded-Host: evil.test\r\n",
        "X-Accel-Redirect": b"X-Accel-Redirect: /_cache/\r\nX-Sendfile: /etc/passwd\r\n", "a request id": b"X-Request-Id: " + b"0" * 32 + b"\r\n",
        "hop by hop": b"Connection: X-CSRF-Token, Cookie, Origin\r\n", "upgrade to h2c": b"Upgrade: h2c\r\nHTTP2-Settings: AAMAAABkAAQCAAAAAAIAAAAA\r\n",
        "upgrade to a stream": b"Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n",
        "a coding of its body": b"Content-Encoding: gzip\r\n", "a trailer": b"TE: trailers\r\nTrailer: X-CSRF-Token\r\n",
        "1000 ranges": b"Range: bytes=" + _RANGES + b"\r\n",
        "another session before": b"Cookie: diaphane=" + b"0" * 64 + b"\r\n", "a session under https": b"Cookie: __Host-diaphane=" + b"0" * 64 + b"\r\n",
        "the operator's token": b"Authorization: Bearer " + b"0" * 64 + b"\r\n", "a name and a password": b"Authorization: Basic YTpi\r\n",
        "a key that is none": b"Idempotency-Key: a b\r\n", "a version that is none": b"If-Match: W/\"x\", *\r\n",
        "a length of an upload": b"Upload-Length: 99999999999999999999\r\nUpload-Offset: 18446744073709551615\r\n",
        "lines in an upload's title": b"Upload-Metadata: title YQ==,title YQ==,\xc3\xa4\r\n",
        "another form of body": b"Content-Type: multipart/form-data; boundary=" + b"x" * 200 + b"\r\n",
    }
    made += [Attack("forged", name, one.data(extra)) for name, extra in lines.items()]
    made.append(Attack("forged", "expect", one.data(b"Expect: 100-continue\r\n"), answers=2))
    return made


def _paths(one: Request) -> list[Attack]:
    path, _, query = one.path.partition(b"?")
    rest = b"?" + query if query else b""
    segments = path.split(b"/")
    last = segments[-1] or b"x"
    bad = {
        "two slashes first": b"/" + path, "something before two slashes": b"//x" + path, "two slashes last": b"/".join([*segments[:-1], b"", last]),
        "an encoded slash first": b"/%2f" + path[1:], "an encoded slash last": b"/".join(segments[:-1]) + b"%2f" + last,
        "an encoded letter": b"/".join(segments[:-1]) + b"/%%%02x" % last[0] + last[1:], "up and down": b"/v1/.." + path, "a dot": b"/." + path,
        "up at the end": path + b"/..", "an encoded way up": path + b"/%2e%2e/x", "a parameter with a way up": b"/v1/..;" + path, "a NUL": path + b"%00",
        "a NUL as it is": path + b"\0", "no hexadecimal": path + b"%zz", "half an escape": path + b"%", "a backslash": path + b"\\x",
        "a part behind #": path + b"#a", "a semicolon": path + b";a=b", "a TAB": path + b"\tx", "an umlaut": path + b"\xc3\xa4", "Latin-1": path + b"\xe4",
        "no slash": path[1:], "nothing": b"", "an asterisk": b"*", "3000 bytes more": path + b"/" + b"a" * 3000, "60 KB": b"/" + b"a" * 60_000,
        "another scheme with two slashes": b"http://localhost/" + path, "a hidden file": b"/.git/config", "the internal cache": b"/%5fcache/x",
        "a drive": b"/C:" + path, "a dotted segment": path + b"/.x",
    }
    made = [Attack("paths", name, replace(one, path=text + rest).data(), True) for name, text in bad.items()]
    queries = {"no hexadecimal": b"a=%zz", "half an escape": b"a=%4", "brackets": b"a[b]=1", "a control byte": b"a=\x01", "3000 bytes": b"a" * 3000,
               "quotes": b"a=\"<x>\"", "a backslash": b"a=\\", "non-ASCII": b"a=\xc3\xa4", "a bar": b"a=b|c", "a caret and a grave": b"a=^`"}
    made += [Attack("paths", f"a query with {name}", replace(one, path=path + b"?" + text).data(), True) for name, text in queries.items()]
    odd = {"one more slash": path + b"/" + rest, "in capitals": path.upper() + rest, "one more segment": path + b"/x" + rest, "an empty query": path + b"?",
           "an unknown parameter": path + b"?a=1", "a parameter twice": path + b"?limit=1&limit=2", "a limit beyond all": path + b"?limit=" + b"9" * 40,
           "an encoded NUL in a query": path + b"?cursor=%00%ff%0d%0a", "a method in the query": path + b"?_method=DELETE",
           "another site's address": b"http://evil.test" + path + rest}
    made += [Attack("paths", name, replace(one, path=text).data(), page=name.startswith(("one more", "in capitals"))) for name, text in odd.items()]
    return made


def _lines(one: Request) -> list[Attack]:
    made = [Attack("lines", f"method {method[:20]!r}", replace(one, method=method).data(), True)
            for method in (b"TRACE", b"TRACK", b"CONNECT", b"BREW", b"PROPFIND", one.method.lower(), b"G\0T", b"X" * 5000, one.method + b"\t",
                           b"PRI", b"\xc3\xa4")]
    for version in (b"HTTP/0.9", b"HTTP/2.0", b"HTTP/3", b"http/1.1", b"HTTP/", b"HTTP/1.1 X", b"HTTP/999999999999.1"):
        made.append(Attack("lines", f"version {version.decode()}", one.data().replace(b"HTTP/1.1", version, 1), True, must_answer=False))
    for version in (b"HTTP/1.2", b"HTTP/1.10", b"HTTP/1.0"):
        made.append(Attack("lines", f"version {version.decode()}", one.data().replace(b"HTTP/1.1", version, 1), must_answer=False))
    made += [
        Attack("lines", "HTTP/0.9", one.method + b" " + one.path + b"\r\n", True, must_answer=False),
        Attack("lines", "HTTP/1.0 without a Host", one.data().replace(b"HTTP/1.1", b"HTTP/1.0", 1).replace(b"Host: localhost\r\n", b"")),
        Attack("lines", "the preface of HTTP/2", b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + one.data(), True, must_answer=False),
        Attack("lines", "TLS", b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + b"\0" * 100 + one.data(), True, must_answer=False),
        Attack("lines", "zeros", b"\0" * 10_000 + one.data(), True, must_answer=False),
        Attack("lines", "noise", _NOISE + one.data(), True, must_answer=False),
        Attack("lines", "blanks in the line", one.data().replace(b" ", b"  ", 1)),
        Attack("lines", "empty lines first", b"\r\n" * 5000 + one.data(), must_answer=False),
    ]
    return made


def _pipelines(one: Request) -> list[Attack]:
    broken = b"GET //x HTTP/1.1\r\nHost: localhost\r\n\r\n"
    kept = one.data(close=False)
    return [
        Attack("pipelines", "behind one that is refused", broken + one.data(), answers=2),
        Attack("pipelines", "behind twenty that are refused", broken * 20 + one.data(), answers=21),
        Attack("pipelines", "before one that is refused", kept + broken.replace(b"\r\n\r\n", b"\r\nConnection: close\r\n\r\n"), answers=2),
        Attack("pipelines", "twice", kept + one.data(), answers=2),
        Attack("pipelines", "before half of one", kept + b"POST /v1/sign-in HTTP/1.1\r\nHost: localhost\r\nX: " + b"\0\r\n\r\n", answers=2),
        Attack("pipelines", "with more bytes than it said", one.data() + b"0\r\n\r\n" * 3),
    ]


def _departures(one: Request) -> list[Attack]:
    whole = one.data()
    line, head = len(one.line()), len(whole) - len(one.body)
    stages = {"at its first byte": 1, "in its line": line // 2, "behind its line": line, "in its headers": (line + head) // 2, "before its end": len(whole) - 1}
    made = [Attack("departures", f"gone {name}, {how}", whole[:length], True, must_answer=False, leaves=how)
            for name, length in stages.items() for how in ("close", "reset")]
    made += [Attack("departures", f"gone without an answer, {how}", whole, must_answer=False, leaves=how) for how in ("close", "reset")]
    return made


def attacks_on(one: Request) -> list[Attack]:
    """Returns all attacks except `slow`."""
    return [*_chunks(one), *_lengths(one), *_headers(one), *_forged(one), *_paths(one), *_lines(one), *_pipelines(one), *_departures(one)]


def slow(one: Request) -> tuple[bytes, bytes]:
    """Returns headers and a body to send at one byte per second: what is sent at once, and what is then dripped for each."""
    body = b"Content-Length: 1000\r\n"
    return one.data()[:-len(one.body) - 2 or None], one.framed(body, b"")
