"""Sends hostile uploads to a running ingestd, each followed by a valid one, and checks the results."""

from __future__ import annotations

import json
import os
import uuid
from dataclasses import dataclass
from typing import Sequence

import psycopg

from .cases import STOPPED, Case, cases
from .dicom_bytes import bundle, series

#: Limits of a child, which the sandbox and the supervisor enforce (RLIMIT_AS, kill).
MEMORY_MB, SECONDS = 1024, 10
LIMITS = {"DIAPHANE_MEMORY_LIMIT_MB": str(MEMORY_MB), "DIAPHANE_TIME_LIMIT_S": str(SECONDS)}


@dataclass(frozen=True)
class Outcome:
    case: Case
    code: str       # the refusal's code, or "ready"
    text: str
    next_is_ready: bool
    seconds: float
    peak_mb: float

    @property
    def fault(self) -> str:
        """Returns what is wrong with the outcome, or an empty text."""
        if self.code in STOPPED or "memory" in self.text:
            return "it was stopped by the limits, not understood"
        if self.code not in self.case.expected:
            return "another end than expected"
        if self.code != "ready" and not (self.text.endswith(".") and len(self.text) > 15):
            return "no words"
        return "" if self.next_is_ready else "the next upload does not work"


def outcomes(stack, chosen: Sequence[Case] | None = None, good_each: int = 1, timeout: float = 400.0) -> list[Outcome]:
    """`stack`: a harness.TestStack with ingestd, made with LIMITS. A valid upload follows every `good_each` cases."""
    good = Case("", "good", ("ready",), lambda: [bundle(series())])
    chosen = cases() if chosen is None else chosen
    sent: list[tuple[Case, str, str]] = []
    with psycopg.connect(stack.dsn, autocommit=True) as database:
        for begin in range(0, len(chosen), good_each):
            some = [(case, _enqueue(stack, database, case)) for case in chosen[begin:begin + good_each]]
            behind = _enqueue(stack, database, good)
            sent += [(case, bad, behind) for case, bad in some]
    count = "SELECT count(*) FROM data_sets WHERE state IN ('queued', 'building')"
    stack.wait_until(lambda: stack.psql(count) == [(0,)], timeout, "the end of all uploads")
    ends = {str(row[0]): row[1:] for row in
            stack.psql("SELECT id, state, coalesce(refusal_code, ''), coalesce(refusal_text, '') FROM data_sets")}
    costs = _costs(stack.log("ingestd"))
    found = []
    for case, bad, behind in sent:
        state, code, text = ends[bad]
        cost = costs.get(bad, {})
        found.append(Outcome(case, code if state == "refused" else state, text, ends[behind][0] == "ready",
                             cost.get("seconds", 0.0), cost.get("peak_mb", 0.0)))
    return found


def _enqueue(stack, database, case: Case) -> str:
    """Creates the rows and files that `api` leaves after a complete upload."""
    data_set = str(uuid.uuid4())
    path = stack.data_dir / "uploads" / f"{data_set}.tar"
    length = case.write(path)
    owner = path.parent.stat()
    os.chown(path, owner.st_uid, owner.st_gid)
    database.execute("INSERT INTO data_sets (id, state) VALUES (%s, 'queued')", (data_set,))
    database.execute("INSERT INTO uploads (id, data_set_id, length, received, expires_at) VALUES (%s, %s, %s, %s,"
                     " now() + interval '1 hour')", (data_set, data_set, max(length, 1), max(length, 1)))
    database.execute("INSERT INTO ingest_jobs (data_set_id, upload_id) VALUES (%s, %s)", (data_set, data_set))
    return data_set


def _costs(log: str) -> dict[str, dict]:
    lines = (json.loads(line) for line in log.splitlines() if '"ingest_done"' in line)
    return {line["data_set"]: line for line in lines}


def table(found: list[Outcome]) -> str:
    """Returns case, expected and actual result, and cost per line."""
    rows = [("case", "expected", "got", "s", "MB", "")]
    rows += [(f"{o.case.group}: {o.case.name}", " or ".join(o.case.expected), o.code, f"{o.seconds:.2f}", f"{o.peak_mb:.0f}",
              o.fault.upper()) for o in found]
    widths = [max(len(row[n]) for row in rows) for n in range(len(rows[0]))]
    return "\n".join("  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() for row in rows)
