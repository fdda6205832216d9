"""docs/bounds.toml is the only table of limits, from which docs/bounds.md is written. Each row quotes the code that enforces its
limit and names the test that proves it. Every limit in the code is in the table. Every kind of input has all required limits."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from devtool import bounds
from test_named_tests import _cpp, _is_there, _python

REPO = Path(__file__).resolve().parents[2]

#: The dimensions in which each kind of input must be limited, and for whom.
REQUIRED: dict[str, tuple[set[str], set[str]]] = {
    "request body": ({"bytes", "time", "number", "memory", "disk"}, {"request", "address", "total"}),
    "JSON": ({"bytes", "depth", "number"}, {"request"}),
    "tar": ({"bytes", "number", "disk", "time"}, {"request", "account", "total"}),
    "DICOM": ({"bytes", "depth", "number", "time", "memory"}, {"file", "request"}),
    "Protobuf message": ({"bytes", "depth", "number"}, {"connection"}),
    "WebSocket frame": ({"bytes", "number", "time"}, {"connection", "account", "address", "total"}),
    "texture": ({"bytes", "number", "memory"}, {"request", "total"}),
    "environment": ({"bytes", "number", "time", "memory", "disk"}, {"request", "account", "total"}),
    "preset": ({"bytes", "depth", "number"}, {"request", "account", "total"}),
    "recording": ({"bytes", "depth", "number", "time", "disk"}, {"request", "account"}),
    "session": ({"number", "time"}, {"account", "address", "total"}),
    "slot": ({"number", "time"}, {"account", "total"}),
    "job": ({"number", "time", "memory", "disk"}, {"request", "account", "total"}),
    "mail": ({"bytes", "number", "time"}, {"address", "account"}),
    "export": ({"number", "time", "disk"}, {"account", "total"}),
    "log line": ({"bytes", "disk"}, {"request", "total"}),
    "slice": ({"number"}, {"connection"}),
    "video or large picture": ({"bytes", "number", "time"}, {"request", "total"}),
    "stored volume": ({"bytes", "number", "disk"}, {"request", "account"}),
}
DIMENSIONS = {"bytes", "depth", "number", "time", "memory", "disk"}

#: nginx directives that limit something.
DIRECTIVES = ("client_max_body_size", "client_body_timeout", "client_header_timeout", "client_header_buffer_size", "large_client_header_buffers",
              "client_body_buffer_size", "limit_conn", "limit_req", "keepalive_timeout", "keepalive_requests", "worker_connections", "server")

#: Code that reads input: a constant with a name like a limit must be in the table, or in NOT_OF_INPUT with a reason.
SOURCES = ("api/shared", "api/routing", "api/accounts", "api/scans", "api/annotations", "api/presets", "api/environments", "api/sharing", "api/sessions", "api/administration", "api/pacs",
           "api/privacy", "api/stream", "api/http", "common", "scene", "volume", "ingest/pipeline", "ingest/dicom",
           "renderd/serve", "renderd/session", "renderd/scene", "renderd/film", "renderd/encode")
LIMIT = re.compile(r"\bk(?:Max|Most|Largest|Longest|Deepest)\w*(?=\s*[={])")
#: Limits that no outsider can reach, or that describe what is recognised rather than refused.
NOT_OF_INPUT: dict[tuple[str, str], str] = {
    ("ingest/dicom/classify.cpp", "kMostScouts"): "recognises localizers, which are left out",
    ("ingest/dicom/classify.h", "kLargestGap"): "says which gaps are filled in; larger ones are refused in words",
    ("ingest/dicom/classify.h", "kMostMissing"): "says how many slices are filled in",
    ("ingest/dicom/classify.h", "kMostVarying"): "says which spacing is resampled",
    ("common/connect.h", "kMostUnixPath"): "of a socket's address, which whoever runs Diaphane chooses",
    ("renderd/encode/mpeg1_encoder.cpp", "kLargestSide"): "of MPEG-1's format; larger pictures are scaled down",
    ("renderd/scene/exact_tables.cpp", "kMostPieces"): "of a table's format; above it, another method is used",
    ("renderd/scene/grid.h", "kLongestAxis"): "of an acceleration grid that is derived from a bounded volume",
    ("renderd/scene/prepared_scene.cpp", "kMostForward"): "the largest number below 1",
    ("renderd/serve/registry.cpp", "kMostBackoff"): "between two attempts to reach Redis",
    ("renderd/serve/still_service.cpp", "kLongestInBackground"): "rendering time inside the 60 s of a background still",
    ("renderd/session/depth.cpp", "kMostVoxels"): "of one depth query's own walk; above it, coarser steps are taken",
    ("renderd/session/histogram.cpp", "kMostBins"): "of our own answer",
    ("renderd/session/histogram.cpp", "kMostSampled"): "of our own sampling",
    ("renderd/session/link.cpp", "kLongestBusy"): "of an estimate",
    ("renderd/session/quality.cpp", "kMostBytes"): "of our own pictures",
    ("renderd/session/quality.cpp", "kMostFrames"): "of our own pictures",
}


def squeezed(text: str) -> str:
    """Ignores the layout, but not comments after code."""
    return re.sub(r"\s+", " ", text)


ROWS = bounds.limits()


def name(row: bounds.Limit) -> str:
    return f"{row.kind}, {row.dimension}: {row.limit}"


def text_of(file: str) -> str:
    return squeezed((REPO / file).read_text(encoding="utf-8"))


def quoted_in(file: str) -> str:
    return " ".join(squeezed(literal) for row in ROWS for where, literal in row.quotes if where == file)


def test_bounds_page_is_up_to_date():
    assert len(ROWS) > 110
    assert bounds.PAGE.read_text(encoding="utf-8") == bounds.page(), "run ./diaphane bounds"


def test_each_row_quotes_the_code_that_enforces_the_limit():
    wrong = []
    for row in ROWS:
        if not row.quotes:
            wrong.append(f"{name(row)}: no code is quoted that enforces it")
        for file, literal in row.quotes:
            if not (REPO / file).is_file():
                wrong.append(f"{name(row)}: no file {file}")
            elif squeezed(literal) not in text_of(file):
                wrong.append(f"{name(row)}: {file} does not have: {literal}")
    assert not wrong, "\n".join(wrong)


def test_each_row_names_an_existing_test():
    python, cpp = _python(), _cpp()
    wrong = [f"{name(row)}: {row.tests or 'no test is named'}" for row in ROWS
             if not row.tests or not all(_is_there(test.rpartition("/")[2], python | cpp) for test in row.tests)]
    assert not wrong, "\n".join(wrong)


def test_dimensions_are_known():
    assert [name(row) for row in ROWS if row.dimension not in DIMENSIONS] == []


@pytest.mark.parametrize("kind", REQUIRED)
def test_each_kind_of_input_is_bounded_in_every_dimension(kind):
    dimensions, scopes = REQUIRED[kind]
    mine = [row for row in ROWS if row.kind == kind]
    assert dimensions - {row.dimension for row in mine} == set(), f"{kind} is not bounded in these"
    assert scopes - {scope for row in mine for scope in row.scopes} == set(), f"{kind} has no bound for these"


def test_each_limit_of_the_edge_is_in_the_table():
    """Each distinct value of a limiting directive counts: `client_max_body_size 1m` and `client_max_body_size 8388608` are two
    limits."""
    file = "api/edge/nginx.conf.in"
    text = re.sub(r"#.*", "", (REPO / file).read_text(encoding="utf-8"))
    directives = {squeezed(one) for one in re.findall(rf"^\s*((?:{'|'.join(DIRECTIVES)}) [^;{{]+);", text, re.M)}
    directives = {one for one in directives if not one.startswith("server ") or "max_conns" in one}
    quoted = quoted_in(file)
    # of the edge's own responses
    missing = {one for one in directives if one not in quoted and one.replace("server 127.0.0.1:@API_PORT@ ", "") not in quoted} - {"client_max_body_size 0"}
    assert len(directives) > 10 and missing == set()


def test_each_limit_of_request_bodies_is_in_the_table():
    """Limits that the edge's Lua enforces."""
    file = "api/edge/nginx.conf.in"
    text = squeezed((REPO / file).read_text(encoding="utf-8"))
    limits = re.findall(r"\w+ = \{ each = \d+, all = \d+ \}", text) + re.findall(r"local \w+ = [\d.]+", text)
    internal = {"local count_seconds = 3600"}   # how long a count is kept
    assert len(limits) > 6
    assert {one for one in limits if one not in quoted_in(file)} - internal == set()


def test_each_limit_of_the_gateway_is_in_the_table():
    file = "api/stream/hub.h"
    body = re.search(r"struct GatewayLimits \{(.*?)\n\};", (REPO / file).read_text(encoding="utf-8"), re.S)
    fields = re.findall(r"(\w+)(?: = |\{)", re.sub(r"///.*", "", body.group(1)))
    internal = {"attach", "goodbye", "probe", "watch", "links"}   # for workers and Redis, not for viewers
    assert len(fields) > 8
    assert {field for field in fields if not re.search(rf"\b{field}( = |\{{)", quoted_in(file))} - internal == set()


def _limits_in_code() -> set[tuple[str, str]]:
    """Returns file and name."""
    files = [file for folder in SOURCES for file in sorted((REPO / folder).rglob("*")) if file.suffix in (".h", ".cpp") and "test" not in file.stem]
    return {(str(file.relative_to(REPO)), name) for file in files
            for line in file.read_text(encoding="utf-8").splitlines() if "constexpr" in line for name in LIMIT.findall(line)}


def test_each_limit_named_in_the_code_is_in_the_table():
    found = _limits_in_code()
    missing = {f"{file}: {name}" for file, name in found - set(NOT_OF_INPUT) if not re.search(rf"\b{name}\b", quoted_in(file))}
    assert len(found) > 40
    assert not missing, "\n".join(sorted(missing))


def test_every_exception_names_a_limit_in_the_code():
    assert set(NOT_OF_INPUT) - _limits_in_code() == set()
