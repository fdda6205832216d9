"""Series that were received and confirmed, while the gateway is killed, api is unavailable, or the spool is full."""

from __future__ import annotations

import time
from pathlib import Path

import httpx
import phantom
import pytest
from archives import CALLER, open_stack, phantom_folder
from canaries import Search
from pacs_helpers import give_token, radiologist, wait_ready
from test_pacs_receive import changed, scans, storescu, stow

#: Longer than it takes to stop api after a device was told that everything is stored.
QUIET = 4.0


@pytest.fixture(scope="module")
def folder(all_stacks):
    return phantom_folder(all_stacks)


@pytest.fixture
def stack(all_stacks):
    running = open_stack(all_stacks, [], quiet=QUIET)
    yield running
    all_stacks.shut(running)


def test_a_confirmed_series_outlives_kill_9_and_an_outage_of_api(stack, folder):
    who, begun = radiologist(stack), time.time()
    give_token(stack, who, "write archive", stack.caller_token)
    assert storescu(stack, folder).returncode == 0
    stack.stop("api")
    stack.wait_until(lambda: "a received series was not uploaded" in stack.log("pacs"), what="a failed upload")
    stack.kill("pacs", restart=False)
    spool = stack.data_dir / "spool"
    assert spool.stat().st_mode & 0o777 == 0o700 and list(spool.glob("*/series.tar"))
    assert Search(["Phantasia", "Canary"], begun).below(stack.data_dir) == []
    stack.start("pacs")
    stack.start("api")
    stack.wait_ready("api", "pacs")
    stack.wait_until(lambda: scans(who), timeout=90, what="the scan")
    [scan] = scans(who)
    wait_ready(stack, scan["id"])
    assert who.http.get(f"/v1/data-sets/{scan['id']}").json()["volume"]["size"][2] == phantom.SLICES
    stack.wait_until(lambda: not list(spool.glob("*/series.tar")), what="an empty spool")
    assert len(scans(who)) == 1


def test_senders_are_told_when_the_spool_is_full(all_stacks, folder, tmp_path):
    # Series stay in the spool for as long as the test runs.
    stack = open_stack(all_stacks, [], quiet=120, extra_env={"DIAPHANE_SPOOL_MB": "1"})
    try:
        token = give_token(stack, radiologist(stack), "write archive", stack.caller_token)

        def series(number: int) -> Path:
            return changed(folder, tmp_path / str(number), lambda image: setattr(image, "SeriesInstanceUID", f"1.2.3.{number}"))

        def stowed(number: int):
            return stow(stack, token, [path.read_bytes() for path in sorted(series(number).glob("*.dcm"))])

        sizes = sum(path.stat().st_size for path in folder.glob("*.dcm"))
        assert 2 * sizes < 1 << 20 < 3 * sizes, "the third series fits in part"
        assert storescu(stack, series(1)).returncode == 0
        assert stowed(2).status_code == 200
        assert "OutOfResources" in storescu(stack, series(3), CALLER, "DIAPHANE", "-v").stderr.replace(" ", "")
        refused = stowed(4)
        assert refused.status_code == 503 and int(refused.headers["retry-after"]) > 0, refused.text
        assert refused.json() == {"error": "no-room"}
        files = [path.read_bytes() for path in sorted(folder.glob("*.dcm"))]
        assert stow(stack, token, files * 4).status_code == 413, "larger than the whole spool"
        assert 'reason="no-room"' in httpx.get(f"http://127.0.0.1:{stack.ports['pacs']}/metrics", trust_env=False).text
    finally:
        all_stacks.shut(stack)


def test_images_for_which_a_spool_has_no_room_are_named(all_stacks, folder, tmp_path):
    stack = open_stack(all_stacks, [], quiet=120, extra_env={"DIAPHANE_SPOOL_MB": "1"})
    try:
        token = give_token(stack, radiologist(stack), "write archive")
        files = [path.read_bytes() for number in range(3) for path in sorted(changed(
            folder, tmp_path / str(number), lambda image, number=number: setattr(image, "SeriesInstanceUID", f"1.2.3.{number}")).glob("*.dcm"))]
        # Without a length, the gateway cannot know before the body that it does not fit.
        answer = stow(stack, token, files, chunked=True)
        assert answer.status_code == 202, answer.text
        assert {one["00081197"]["Value"][0] for one in answer.json()["00081198"]["Value"]} == {0xA700}
    finally:
        all_stacks.shut(stack)
