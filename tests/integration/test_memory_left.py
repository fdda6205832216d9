"""What was cut away or uploaded is not in the memory of the programs afterwards."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest
from api_client import person
from cut_helpers import MARK, marked_scan
from stream_helpers import Viewer, open_session
from test_anonymise import ask, loaded, picture, wait_cut
from test_slices import AXIAL, wish

OURS = ("api", "gateway", "ingestd", "renderd")


def copies(pid: int, wanted: bytes) -> int:
    """Returns how often the bytes are in a process's writable memory."""
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


def assert_gone(stack, wanted: bytes, few: int = 0) -> None:
    """Waits until it is gone, since caches are checked once per second. `few`: number of permitted copies in one program."""
    left: list[dict[str, int]] = [{}]

    def gone() -> bool:
        left[0] = {program: n for program, n in holders(stack, wanted).items() if n > few}
        return not left[0]
    try:
        stack.wait_until(gone, what="a memory without it")
    except AssertionError as late:
        raise AssertionError(f"copies in memory: {left[0]}") from late


def holders(stack, wanted: bytes) -> dict[str, int]:
    return {program: n for program in OURS if program in stack.pids and (n := copies(stack.pids[program], wanted))}


@pytest.fixture(scope="module")
def running(all_stacks):
    stack = all_stacks.open(only=("postgres", "redis", "api", "gateway", "edge", "ingestd", "renderd"))
    yield stack
    all_stacks.shut(stack)


@pytest.fixture(scope="module")
def owner(running):
    return person(running)


def test_removed_voxels_are_not_left_in_memory(running, owner):
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
    running.wait_until(lambda: data_set not in loaded(running), what="the worker's copy is let go")
    viewer.leave()
    assert_gone(running, MARK.tobytes())


def test_an_accepted_upload_is_not_left_in_memory(running, owner):
    # In a part of maximum size, and in a last part of a few bytes.
    mark = os.urandom(16)
    data = mark * ((8 << 20) // len(mark)) + mark * 20
    owner.upload(data)
    # cpprest keeps a piece of the last body for each connection that the edge holds open, which cannot be changed from outside.
    assert_gone(running, mark, few=8192 // len(mark))
