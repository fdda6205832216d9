"""What was cut away, or was uploaded, is not in the memory of the programs afterwards."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest
from api_client import person
from cut_help import MARK, marked_scan
from stream_help import Viewer, open_session
from test_anonymise import ask, loaded, picture, wait_cut
from test_slices import AXIAL, wish

OURS = ("api", "ingestd", "renderd")


def copies(pid: int, wanted: bytes) -> int:
    """How often the bytes are in the memory of a process that it can write to."""
    found = 0
    with open(f"/proc/{pid}/maps") as maps, open(f"/proc/{pid}/mem", "rb", buffering=0) as memory:
        for line in maps:
            at = re.match(r"([0-9a-f]+)-([0-9a-f]+) rw", line)
            if not at:
                continue
            begin, end = (int(part, 16) for part in at.groups())
            overlap = b""
            for start in range(begin, end, 1 << 24):
                try:
                    part = overlap + os.pread(memory.fileno(), min(1 << 24, end - start), start)
                except OSError:
                    break
                found += part.count(wanted)
                overlap = part[-(len(wanted) - 1):]
    return found


def holders(stack, wanted: bytes) -> dict[str, int]:
    return {program: n for program in OURS if program in stack.pids and (n := copies(stack.pids[program], wanted))}


@pytest.fixture(scope="module")
def running(stack_house):
    stack = stack_house.open(only=("postgres", "redis", "api", "edge", "ingestd", "renderd"))
    yield stack
    stack_house.shut(stack)


@pytest.fixture(scope="module")
def owner(running):
    return person(running)


def test_voxels_that_were_cut_away_are_in_no_memory(running, owner):
    data_set, content = marked_scan(running, owner)
    picture(running, owner, data_set)
    _, url = open_session(owner, data_set)
    viewer = Viewer(running.url, url)
    for index in range(32):
        wish(viewer, (AXIAL, index), taken=index)
        viewer.until("slice")
    viewer.frame()
    assert "renderd" in holders(running, MARK.tobytes()), "the search would find nothing anyway"

    assert ask(owner, data_set, content).status_code == 202
    wait_cut(running, owner, data_set)
    running.wait_until(lambda: data_set not in loaded(running), 10, "the worker's copy is let go")
    viewer.leave()
    running.wait_until(lambda: not holders(running, MARK.tobytes()), 20, "a memory without what was cut away")


def test_an_upload_is_in_no_memory_once_it_was_taken(running, owner):
    # Eight bytes in a row that nothing else makes, all over a part of the largest size, and in the last few bytes.
    mark = os.urandom(16)
    data = mark * ((8 << 20) // len(mark)) + mark * 20
    owner.upload(data)
    running.wait_until(lambda: not holders(running, mark), 20, "a memory without the upload")
